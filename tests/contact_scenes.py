"""A humanoid and a quadruped that stand, and their rows at a few states.

Run as a program it writes the rows of all kinds of parts of contacts to a file: in an interpreter of its own, to
compare with the rows of this one.
"""

from __future__ import annotations

import sys
from functools import cache
from typing import NamedTuple

import numpy as np

from tasks import (
    AtMost,
    CapturePointTask,
    CenterOfMassTask,
    CenterOfPressureTask,
    Contact,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    Loop,
    MomentumTask,
    OrientationTask,
    PinocchioRobot,
    PostureTask,
    Stack,
    SupportLimit,
    Surface,
    TorqueTask,
    load_robot,
)
from tasks.rows.part import Order

DT = 2e-3
SOLE = [(x, y, -0.03) for x in (-0.05, 0.12) for y in (-0.03, 0.03)]
FEET = "left_ankle_roll_link", "right_ankle_roll_link"
BENT = {"hip_pitch_joint": -0.3, "knee_joint": 0.6, "ankle_pitch_joint": -0.3}


class Scene(NamedTuple):
    """A robot that stands, and what it is to keep."""

    robot: PinocchioRobot
    q: np.ndarray
    com: np.ndarray
    up: np.ndarray
    feet: tuple[Contact, ...]

    @property
    def v(self) -> np.ndarray:
        return np.zeros(self.robot.nv)

    @property
    def limits(self) -> Stack:
        """The motion equation, the contacts and the limits."""
        standing = Dynamics() + self.feet[0]
        for foot in self.feet[1:]:
            standing = standing + foot
        return standing >> JointTorqueLimit() + JointLimits()

    def rest(self, pelvis: str = "pelvis") -> Stack:
        """What stands below the task in question."""
        return OrientationTask(self.up, frame=pelvis, gain=8.0) >> PostureTask(self.q, gain=4.0) + ForceTask(
            weight=1e-2
        )


@cache
def g1() -> PinocchioRobot:
    return load_robot("g1", acceleration_limit=200.0)


def humanoid(**options: object) -> Scene:
    """A G1 on both soles."""
    robot = g1()
    q = robot.configuration({f"{side}_{joint}": angle for side in ("left", "right") for joint, angle in BENT.items()})
    state = robot.at(q, np.zeros(robot.nv))
    kinds = {"points": SOLE, "friction": 0.6, **options}
    if kinds.pop("rectangle", False):
        kinds.pop("points")
        kinds |= {"plane": (0.17, 0.06), "centre": (0.035, 0.0, -0.03)}
    feet = tuple(Contact(frame, name=frame.split("_")[0], **kinds) for frame in FEET)  # type: ignore[arg-type]
    return Scene(robot, q, state.center_of_mass.position.copy(), state.frame("pelvis").rotation.copy(), feet)


def talos() -> Scene:
    """A Talos on both soles, on bent legs."""
    robot = load_robot("talos", acceleration_limit=200.0)
    q = np.array(robot.home)
    state = robot.at(q, np.zeros(robot.nv))
    soles = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]
    feet = tuple(Contact(f"{side}_sole_link", points=soles, friction=0.6, name=side) for side in ("left", "right"))
    return Scene(robot, q, state.center_of_mass.position.copy(), state.frame("base_link").rotation.copy(), feet)


def quadruped() -> Scene:
    """A Go2 on four points."""
    robot = load_robot("go2", acceleration_limit=500.0)
    q = np.array(robot.home)
    state = robot.at(q, np.zeros(robot.nv))
    feet = tuple(Contact(f"{leg}_foot", friction=0.6) for leg in ("FL", "FR", "RL", "RR"))
    return Scene(robot, q, state.center_of_mass.position.copy(), state.frame("base").rotation.copy(), feet)


def advanced(robot: PinocchioRobot, q: np.ndarray, v: np.ndarray, a: np.ndarray, dt: float = DT) -> tuple:
    """The state after a tick in which a holds."""
    return robot.integrate(q, dt * v + 0.5 * dt * dt * a), v + dt * a


def moved(scene: Scene, seed: int = 0, share: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A state near that of standing, in motion."""
    rng = np.random.default_rng(seed)
    robot = scene.robot
    way, v = 0.05 * share * rng.standard_normal(robot.nv), 0.3 * share * rng.standard_normal(robot.nv)
    return robot.integrate(scene.q, way), v


def stacks() -> dict[str, tuple[PinocchioRobot, Order, Stack]]:
    """All kinds of parts of contacts, at the orders that they know."""
    scene, sole = humanoid(), humanoid(rectangle=True, wrench=True, faces=6)
    left, right = scene.feet
    moving = Surface(_sway, None)
    slipping = Contact(FEET[0], line=0.1, centre=(0.0, 0.0, -0.03), friction=0.5, surface=moving, may_slip=True)
    hands = Loop("left_rubber_hand", "right_rubber_hand", at=(0.1, 0.0, 0.0), turns=False)
    push = Dynamics({"torso_link": [60.0, 0.0, 10.0, 1.0, 2.0, 3.0]})
    balance = SupportLimit() >> CapturePointTask(scene.com[:2], gain=3.0) + AtMost(MomentumTask(gain=2.0))
    forces = ForceTask([100.0], contact=left) + CenterOfPressureTask([0.02, 0.0], right) + TorqueTask(1.0, weight=0.1)
    whole = scene.limits >> balance >> forces >> scene.rest()
    com = CenterOfMassTask(scene.com, gain=5.0)
    return {
        "points": (scene.robot, "acceleration", whole),
        "wrenches": (scene.robot, "acceleration", sole.limits >> CenterOfPressureTask([0.0, 0.0], sole.feet[0])),
        "slipping": (scene.robot, "acceleration", push + slipping + hands >> JointTorqueLimit() >> com),
        "velocity": (scene.robot, "velocity", left + right + hands >> SupportLimit() >> com),
    }


def _sway(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A platform that goes to and fro."""
    w, way = 3.0, np.array([0.05, 0.02, 0.01])
    return way * np.sin(w * t), way * w * np.cos(w * t), -way * w * w * np.sin(w * t)


def rows() -> dict[str, np.ndarray]:
    """A, lower and upper of every stack, at three states."""
    found = {}
    for name, (robot, order, stack) in stacks().items():
        built = stack.build(robot, order, DT)
        numbers = []
        for seed in range(3):
            q, v = moved(humanoid(), seed)
            filled = built.fill(robot.at(q, v), 0.1 * seed)
            numbers.append(np.concatenate([filled.dense().ravel(), filled.lower, filled.upper]))
        found[name] = np.stack(numbers)
    return found


if __name__ == "__main__":
    np.savez(sys.argv[1], **rows())
