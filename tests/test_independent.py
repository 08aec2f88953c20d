"""Independent robots in one controller move as each would alone: nothing that one does is felt by another."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, reduce
from operator import add, rshift

import numpy as np
import pytest

from tasks import (
    AtMost,
    BoxLimit,
    Controller,
    JointLimits,
    OrientationTask,
    PinocchioRobot,
    PositionTask,
    PostureTask,
    load_robot,
)
from tasks.rows.part import Part

pin = pytest.importorskip("pinocchio")

DT = 0.005


def joined(arms: Sequence[str], floating: bool = False) -> PinocchioRobot:
    """These arms side by side, on the ground or on a body that flies; their joints and frames are numbered."""
    whole = pin.Model()
    if floating:
        whole.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
        whole.addBodyFrame("base", 1, pin.SE3.Identity(), 0)
    for i, arm in enumerate(arms):
        model = own(arm).model.copy()
        for frame in model.frames:
            frame.name = f"{i}_{frame.name}"
        for j, name in enumerate(model.names):
            model.names[j] = f"{i}_{name}"
        root = whole.getFrameId("base") if floating else 0
        whole = pin.appendModel(whole, model, root, pin.SE3(np.eye(3), np.array([0.0, 2.0 * i, 0.0])))
    return PinocchioRobot(whole, name="side by side", acceleration_limit=30.0)


@cache
def own(arm: str) -> PinocchioRobot:
    """One of them."""
    lock = ["panda_finger_joint1"] if arm == "panda" else []
    return load_robot(arm, lock=lock)


TIPS = {"panda": "panda_hand_tcp", "ur5": "tool0", "ur3": "tool0"}


class Case:
    """What one arm is asked for: its targets in its own axes, gains, and where it is."""

    def __init__(self, arm: str, seed: int, far: float, order: str, kind: str = "arm") -> None:
        rng, self.arm, self.kind = np.random.default_rng(seed), arm, kind
        robot = own(arm)
        low, high = robot.position_limit
        self.q = np.clip(robot.home + rng.normal(0.0, 0.3, robot.nv), low + 0.01, high - 0.01)
        if kind == "limit":  # two joints at the ends of their ranges, and one at its full speed
            self.q[:2] = (low + 1e-3)[:2]
        self.v = rng.normal(0.0, 0.2, robot.nv)
        if kind == "limit":
            self.v[2] = 0.99 * robot.velocity_limit[2]
        here = robot.at(self.q, self.v).frame(TIPS[arm])
        way = rng.normal(size=3)
        self.position, self.rotation = here.position + far * way / np.linalg.norm(way), here.rotation
        self.home, self.gains = robot.home, (rng.uniform(5.0, 20.0, 2) if order == "velocity" else [8.0, 6.0])

    def levels(self, i: int | None) -> list[list[Part]]:
        """The parts of its levels, as robot number i, or alone."""
        robot, off = own(self.arm), np.zeros(3)
        prefix = "" if i is None else f"{i}_"
        if i is not None:
            off = np.array([0.0, 2.0 * i, 0.0])
        frame, first, second = prefix + TIPS[self.arm], *self.gains
        position = PositionTask(self.position + off, frame=frame, gain=first, name=prefix + "position")
        turn = OrientationTask(self.rotation, frame=frame, gain=second, name=prefix + "turn")
        joints = [prefix + name for name in robot.joint_names]
        posture = PostureTask(self.home, joints=joints, gain=1.0, name=prefix + "posture")
        if self.kind == "posture":
            return [[posture]]
        if self.kind == "short":
            return [[position], [posture]]
        if self.kind == "guard":
            low = AtMost(PositionTask([self.position[2] - 0.1], frame=frame, mask="z", gain=5.0, name=prefix + "low"))
            return [[low], [position], [turn], [posture]]
        if self.kind == "box":
            box = BoxLimit(off - 2.0, off + 0.6, frame=frame, gain=5.0, name=prefix + "box")
            return [[position], [box], [turn], [posture]]
        return [[position], [turn], [posture]]


def stacked(levels: Sequence[Sequence[Part]]):
    return reduce(rshift, [JointLimits(), *(reduce(add, parts) for parts in levels)])


def beside(cases: Sequence[Case]) -> list[list[Part]]:
    """The levels of all of them, each beside that of the same number."""
    each = [case.levels(i) for i, case in enumerate(cases)]
    return [
        [part for levels in each for part in levels[k : k + 1] for part in part] for k in range(max(map(len, each)))
    ]


def placed(robot: PinocchioRobot, cases: Sequence[Case], names: Sequence[Sequence[str]]) -> list[np.ndarray]:
    """Where the joints of each arm are among those of the robot."""
    return [np.array([robot.joint_names.index(f"{i}_{name}") for name in own]) for i, own in enumerate(names)]


FAR = {"in reach": 0.02, "out of reach": 1.5}
PAIRS = {
    "both in reach": [("panda", "in reach", "arm"), ("panda", "in reach", "arm")],
    "one out of reach": [("panda", "in reach", "arm"), ("panda", "out of reach", "arm")],
    "both out of reach": [("ur5", "out of reach", "arm"), ("panda", "out of reach", "arm")],
    "one at its limits": [("panda", "in reach", "arm"), ("panda", "in reach", "limit")],
    "out of reach beside one at its limits": [("panda", "out of reach", "arm"), ("ur5", "in reach", "limit")],
    "three": [("panda", "out of reach", "arm"), ("ur5", "in reach", "arm"), ("ur3", "out of reach", "limit")],
    "fewer levels": [("panda", "out of reach", "arm"), ("ur5", "out of reach", "short")],
    "a posture alone": [("panda", "out of reach", "arm"), ("ur5", "in reach", "posture")],
    "a guard above": [("panda", "out of reach", "arm"), ("ur5", "out of reach", "guard")],
    "a guard between": [("panda", "out of reach", "arm"), ("ur5", "out of reach", "box")],
}


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("damping", ["curvature", None])
@pytest.mark.parametrize("said", PAIRS)
def test_arms_side_by_side_move_as_each_alone(said: str, damping: str | None, order: str) -> None:
    for seed in range(4):
        asked = PAIRS[said]
        cases = [Case(arm, 10 * seed + i, FAR[far], order, kind) for i, (arm, far, kind) in enumerate(asked)]
        robot = joined([arm for arm, _, _ in asked])
        where = placed(robot, cases, [own(arm).joint_names for arm, _, _ in asked])
        q, v = np.zeros(robot.nv), np.zeros(robot.nv)
        for case, at in zip(cases, where, strict=True):
            q[at], v[at] = case.q, case.v
        together = Controller(robot, stacked(beside(cases)), dt=DT, damping=damping, order=order)
        step = together(q, v)
        assert step.solution.certify().ok
        found = step.v if order == "velocity" else step.a
        for case, at in zip(cases, where, strict=True):
            alone = own(case.arm)
            alone.acceleration_limit = np.full(alone.nv, 30.0)
            answer = Controller(alone, stacked(case.levels(None)), dt=DT, damping=damping, order=order)(case.q, case.v)
            expected = answer.v if order == "velocity" else answer.a
            np.testing.assert_allclose(found[at], expected, atol=1e-6 * max(1.0, np.abs(expected).max()))


def parts_of(robot: PinocchioRobot, stack) -> int:
    """How many independent components the controller sees."""
    return Controller(robot, stack, dt=DT)._now.solver._blocks.size


def test_arms_on_one_body_and_arms_that_a_row_joins_are_one() -> None:
    arms = ("ur5", "ur5")
    standing, flying = joined(arms), joined(arms, floating=True)
    each = [[PositionTask(np.ones(3), frame=f"{i}_tool0", gain=5.0, name=f"{i}")] for i in range(2)]
    both = PositionTask(np.zeros(3), frame="0_tool0", relative_to="1_tool0", gain=5.0)
    assert parts_of(standing, stacked(each)) == 2
    assert parts_of(flying, stacked(each)) == 1
    assert parts_of(standing, stacked([*each, [both]])) == 1
    assert parts_of(joined((*arms, "ur3")), stacked([each[0] + each[1]])) == 2 + 6  # no row joins those of the third


def test_a_joint_that_no_task_with_a_curvature_moves_is_left_strict() -> None:
    """It follows its posture as if it were alone, however the arm beside it is damped."""
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    frame = "panda_link4"  # which the last three joints do not move
    q = np.array([0.1, 0.2, 0.1, -0.3, 0.4, 1.0, 0.2])
    posture = PostureTask(robot.home, gain=2.0)
    far = PositionTask([2.0, 0.0, 0.4], frame=frame, gain=20.0)
    step = Controller(robot, JointLimits() >> far >> posture, dt=DT)(q, 0.1 * np.ones(7))
    assert step.relaxed
    np.testing.assert_allclose(step.v[4:], 2.0 * (robot.home - q)[4:], atol=1e-9)
