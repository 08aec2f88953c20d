"""Paths through singularities, the methods compared on them, and the result of one run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hqp import DampingRule, ErrorDamping, ManipulabilityDamping, NumericalFiltering, SingularValueDamping
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
    Record,
    Robot,
    Stack,
    Task,
    load_robot,
    quintic,
)

#: The joint speed that the methods with limits keep, and that a level adds at most where its error damps it [rad/s].
FASTEST = 2.0
#: lambda_0 of all rules and beta of the filtering, its lambda, and epsilon, in [m] or [1].
DAMPING, LITTLE, SMALLEST = 0.2, 0.05, 0.2
#: w_0, of what the manipulability is at the start.
SHARE = 0.5


@dataclass(frozen=True)
class Scene:
    """A robot, its start, and a position task above an orientation task that it cannot always meet."""

    name: str
    robot: Robot
    start: np.ndarray
    tasks: Callable[[], tuple[Task, Task]]
    duration: float

    def thresholds(self) -> tuple[float, float]:
        """w_0 of both tasks."""
        above, below = self.tasks()
        first, second = Reconstructed(above, 1.0), Reconstructed(below, 1.0, above=above)
        return SHARE * first.measure(self.robot, self.start), SHARE * second.measure(self.robot, self.start)


#: From a scene to a stack of its two tasks.
Method = Callable[[Scene], Stack]


@dataclass(frozen=True)
class Run:
    """One method on one path: its record, and the largest reported residual norm of each damped task."""

    method: str
    record: Record
    reported: dict[str, float]

    @property
    def speed(self) -> float:
        """Largest joint speed [rad/s]; infinite for a run that diverged."""
        stopped = self.record.stopped
        return np.inf if stopped is not None and stopped.diverged else float(np.abs(self.record.v).max())

    @property
    def jump(self) -> float:
        """Largest change of a joint speed from tick to tick, after the first [rad/s], a measure of chatter."""
        return float(np.abs(np.diff(self.record.v[1:], axis=0)).max())

    def errors(self, task: str) -> np.ndarray:
        """Norms of the task's error [m], [rad], tick by tick."""
        errors = next(values for name, values in self.record.errors.items() if name.endswith(task))
        return np.linalg.norm(errors, axis=1)


def _strict(scene: Scene) -> Stack:
    above, below = scene.tasks()
    return above >> below


def _damped(rule: DampingRule | float) -> Method:
    def method(scene: Scene) -> Stack:
        above, below = scene.tasks()
        return Damped(above, rule) >> Damped(below, rule)

    return method


def _limited(method: Method) -> Method:
    return lambda scene: JointLimits(JointVelocityLimit(FASTEST)) >> method(scene)


def _reconstructed(scene: Scene) -> Stack:
    """Kim, Marani, Chung and Yuh (2006)."""
    above, below = scene.tasks()
    first, second = scene.thresholds()
    return Reconstructed(above, first) >> Reconstructed(below, second, above=above)


def _by_manipulability(scene: Scene) -> Stack:
    """Nakamura and Hanafusa (1986), with the thresholds of `_reconstructed`."""
    first, second = (
        Damped(task, ManipulabilityDamping(DAMPING, threshold))
        for task, threshold in zip(scene.tasks(), scene.thresholds(), strict=True)
    )
    return first >> second


def _decoupled(scene: Scene) -> Stack:
    """Chiaverini (1997)."""
    above, below = scene.tasks()
    return Damped(above, DAMPING) >> JointMotion(below, damping=DAMPING)


METHODS: dict[str, Method] = {
    "strict": _strict,
    "strict, limits": _limited(_strict),
    "fixed damping": _damped(DAMPING),
    "fixed, limits": _limited(_damped(DAMPING)),
    "by manipulability": _by_manipulability,
    "by singular value": _damped(SingularValueDamping(DAMPING, SMALLEST)),
    "filtering": _damped(NumericalFiltering(LITTLE, DAMPING, SMALLEST)),
    "by error": _damped(ErrorDamping(FASTEST)),
    "Chiaverini": _decoupled,
    "Kim": _reconstructed,
    "default": _strict,
    "default, limits": _limited(_strict),
}
#: The methods that leave damping to the controller; of the others it damps nothing.
DEFAULTS: dict[str, Literal["curvature"]] = {"default": "curvature", "default, limits": "curvature"}


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
        turn = OrientationTask(float(goal[0]) if planar else goal, gain=2.0, name="orientation")
        return PositionTask(path, gain=2.0, name="position"), turn

    return Scene(name, robot, start, tasks, 2.0 * len(ends) + 1.0)
