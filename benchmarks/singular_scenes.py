"""Ways through singularities, and the methods that are to survive them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hqp import DampingRule, FixedDamping, ManipulabilityDamping, NumericalFiltering, SingularValueDamping
from tasks import (
    Chain,
    Damped,
    JointLimits,
    JointMotion,
    JointVelocityLimit,
    Line,
    OrientationTask,
    PlanarArm,
    PositionTask,
    Reconstructed,
    Robot,
    Stack,
    Task,
    load_robot,
    quintic,
)

#: The joint speed that `strict, limits` keeps [rad/s].
FASTEST = 2.0
#: lambda_0 of all rules, epsilon, and beta of the filtering, in [m] or [1]; w_0 in [m^3] and the like.
DAMPING, SMALLEST, EXTRA, MANIPULABILITY = 0.1, 0.2, 0.2, 0.02


@dataclass(frozen=True)
class Scene:
    """A robot, where it starts, and a position task above an orientation task which it cannot always meet."""

    name: str
    robot: Robot
    start: np.ndarray
    tasks: Callable[[], tuple[Task, Task]]
    duration: float


#: From the two tasks to a stack.
Method = Callable[[Task, Task], Stack]


def _damped(rule: DampingRule) -> Method:
    return lambda above, below: Damped(above, rule) >> Damped(below, rule)


METHODS: dict[str, Method] = {
    "strict": lambda above, below: above >> below,
    "strict, limits": lambda above, below: JointLimits(JointVelocityLimit(FASTEST)) >> above >> below,
    "fixed damping": _damped(FixedDamping(DAMPING)),
    "by manipulability": _damped(ManipulabilityDamping(DAMPING, MANIPULABILITY)),
    "by singular value": _damped(SingularValueDamping(DAMPING, SMALLEST)),
    "filtering": _damped(NumericalFiltering(0.1 * DAMPING, EXTRA, SMALLEST)),
    "Chiaverini": lambda above, below: Damped(above, DAMPING) >> JointMotion(below, damping=DAMPING),
    "Kim": lambda above, below: (
        Reconstructed(above, MANIPULABILITY) >> Reconstructed(below, MANIPULABILITY, above=above)
    ),
}


def scenes() -> list[Scene]:
    """A planar arm that is stretched, and one whose two tasks conflict; a UR5's wrist; a Panda's elbow."""
    arm = PlanarArm([0.5, 0.5, 0.5])
    bent, turned = np.array([0.9, -1.2, -0.5]), np.array([1.2, -1.9, 0.7])
    ur5, wrist = load_robot("ur5"), np.array([0.0, -1.2, 1.6, -0.45, -0.4, 0.0])
    panda = load_robot("panda")
    return [
        _scene("planar arm, stretched", arm, bent, [0.45, 0.15], there_and_back=True),
        _scene("planar arm, conflict", arm, turned, [0.35, 0.45], there_and_back=True),
        _scene("UR5, wrist", ur5, wrist, [-0.1, 0.4, 0.0], there_and_back=False),
        _scene("Panda, elbow", panda, panda.home, [0.45, 0.1, 0.0], there_and_back=True),
    ]


def _scene(name: str, robot: Robot, start: np.ndarray, way: object, *, there_and_back: bool) -> Scene:
    state = robot.at(start, np.zeros(robot.nv))
    planar = isinstance(robot, PlanarArm)
    here = np.asarray(state.frame().position)[: 2 if planar else 3]
    there = here + np.asarray(way)
    ends = [(here, there), (there, here)][: 2 if there_and_back else 1]
    path = Chain([Line(*pair, duration=2.0, timing=quintic) for pair in ends])
    goal = state.frame().rotation

    def tasks() -> tuple[Task, Task]:
        turn = OrientationTask(float(goal[0]) if planar else goal, gain=5.0, name="orientation")
        return PositionTask(path, gain=5.0, name="position"), turn

    return Scene(name, robot, start, tasks, 2.0 * len(ends) + 1.0)
