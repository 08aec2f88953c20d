"""Damping by curvature on a base that floats: hands that are in reach whatever the body does stay as near as strict.

And a body below them arrives without swings.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tasks import (
    CenterOfMassTask,
    Controller,
    JointLimits,
    OrientationTask,
    PinocchioRobot,
    PoseTask,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
)

pin = pytest.importorskip("pinocchio")

DT, SIDES = 0.005, ("left", "right")
#: Until the hands are where they swing [s].
SETTLED = 2.0


@cache
def flying_arms(arm: str) -> PinocchioRobot:
    """Two arms on a body that flies."""
    body = pin.Model()
    joint = body.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    body.appendBodyToJoint(joint, pin.Inertia.FromBox(10.0, 0.8, 0.4, 0.2), pin.SE3.Identity())
    body.addBodyFrame("base", joint, pin.SE3.Identity(), body.addJointFrame(joint))
    for side, x in zip(SIDES, (0.3, -0.3), strict=True):
        model = load_robot(arm).model.copy()
        for frame in model.frames:
            frame.name = f"{side}_{frame.name}"
        for i, name in enumerate(model.names):
            model.names[i] = f"{side}_{name}"
        body = pin.appendModel(body, model, body.getFrameId("base"), pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])))
    return PinocchioRobot(body, name="flying arms")


def swing(middle: np.ndarray, size: list[float], rate: float):
    """About a point, with velocity and acceleration."""
    size = np.asarray(size)

    def target(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        s, c = np.sin(rate * t), np.cos(rate * t)
        return middle + size * s, rate * size * c, -(rate**2) * size * s

    return target


def rms(errors: np.ndarray) -> float:
    """Root mean square of their lengths."""
    return float(np.sqrt((errors**2).sum(axis=1).mean()))


@pytest.mark.parametrize(
    ("arm", "hands", "body", "rate", "gain"),
    [
        ("ur3", [0.0, 0.1, 0.0], [0.0, 0.0, 0.3], 2.0, 5.0),
        ("ur3", [0.05, 0.0, 0.1], [0.0, 0.2, 0.0], 1.5, 10.0),
        ("ur5", [0.0, 0.1, 0.1], [0.2, 0.0, 0.2], 1.0, 5.0),
    ],
)
def test_hands_of_a_body_that_flies_are_as_near_as_strict(
    arm: str, hands: list[float], body: list[float], rate: float, gain: float
) -> None:
    robot = flying_arms(arm)
    bend = {"shoulder_lift_joint": -1.0, "shoulder_pan_joint": 1.0, "elbow_joint": 1.0}
    q = robot.configuration({f"{side}_{name}": angle for side in SIDES for name, angle in bend.items()})
    start, off = robot.at(q), []
    for damping in "curvature", None:
        tasks = [
            PoseTask(
                swing(start.frame(f"{side}_tool0").position, hands, rate),
                start.frame(f"{side}_tool0").rotation,
                frame=f"{side}_tool0",
                gain=gain,
                name=side,
            )
            for side in SIDES
        ]
        flies = PoseTask(swing(np.zeros(3), body, rate), np.eye(3), frame="base", gain=gain, name="body")
        stack = JointLimits() >> tasks[0] + tasks[1] >> flies >> PostureTask(q, gain=1.0)
        record = simulate(Controller(robot, stack, dt=DT, damping=damping), q, duration=4.0)
        since = round(SETTLED / DT)
        off.append(
            [max(rms(np.asarray(record.errors[name])[since:, :3]) for name in names) for names in (SIDES, ["body"])]
        )
    assert off[0][0] <= 1.1 * off[1][0] + 1e-5
    assert off[0][1] <= 1.5 * off[1][1] + 1e-3


@pytest.mark.parametrize(("arm", "dt"), [("ur5", 0.005), ("ur3", 0.005), ("ur5", 0.01)])
def test_a_body_below_hands_arrives_without_swings_from_straight_arms(arm: str, dt: float) -> None:
    robot = flying_arms(arm)
    q = robot.configuration({})
    start = robot.at(q)
    hands = [
        PoseTask(start.frame(f"{side}_tool0").position, start.frame(f"{side}_tool0").rotation, frame=f"{side}_tool0",
                 gain=5.0, name=side)
        for side in SIDES
    ]  # fmt: skip
    up = 0.2 if arm == "ur5" else 0.1
    flies = PoseTask(np.array([0.0, 0.0, up]), np.eye(3), frame="base", gain=5.0, name="body")
    stack = JointLimits() >> hands[0] + hands[1] >> flies >> PostureTask(q, gain=1.0)
    record = simulate(Controller(robot, stack, dt=dt), q, duration=5.0)
    far = np.linalg.norm(np.asarray(record.errors["body"])[:, :3], axis=1)
    assert far[round(3.0 / dt) :].max() < 0.06 * far[0]


@pytest.mark.parametrize("robot", ["g1", "talos"])
def test_a_humanoid_that_squats_in_reach_follows_as_closely_as_strict(robot: str) -> None:
    robot, feet, wrists, base, height = {
        "g1": (load_robot("g1"), "{}_ankle_roll_link", "{}_wrist_yaw_link", "pelvis", 0.05),
        "talos": (load_robot("talos"), "{}_sole_link", "gripper_{}_base_link", "base_link", 0.04),
    }[robot]
    start, off = robot.at(robot.home), []
    middle = start.center_of_mass.position - [0.0, 0.0, 1.6 * height]
    for damping in "curvature", None:
        stand = [PoseTask.hold(start, frame=feet.format(side), gain=100.0, name=side) for side in SIDES]
        squat = CenterOfMassTask(swing(middle, [0.0, 0.0, height], np.pi), gain=10.0)
        hands = [
            PositionTask(start.frame(frame).position - [0.1, 0.0, 0.1], frame=frame, gain=3.0, name=frame)
            for frame in map(wrists.format, SIDES)
        ]
        upright = OrientationTask(start.frame(base).rotation, frame=base, gain=5.0)
        stack = JointLimits() >> stand[0] + stand[1] >> squat >> upright >> hands[0] + hands[1]
        stack = stack >> PostureTask(robot.home, gain=1.0)
        record = simulate(Controller(robot, stack, dt=DT, damping=damping), robot.home, duration=3.0)
        off.append(np.linalg.norm(record.errors[squat.name][round(1.0 / DT) :], axis=1).max())
    assert off[0] <= off[1] + 2e-4


def test_a_humanoid_whose_ankles_stop_as_it_squats_lags_only_where_strict_jumps() -> None:
    """Without a task of its pelvis its waist takes over, at once in the strict stack."""
    robot, height = load_robot("g1"), 0.05
    start = robot.at(robot.home)
    middle = start.center_of_mass.position - [0.0, 0.0, 1.6 * height]
    off, jerks = [], []
    for damping in "curvature", None:
        stand = [PoseTask.hold(start, frame=f"{side}_ankle_roll_link", gain=100.0, name=side) for side in SIDES]
        squat = CenterOfMassTask(swing(middle, [0.0, 0.0, height], np.pi), gain=10.0)
        hands = [
            PositionTask(start.frame(frame).position - [0.1, 0.0, 0.1], frame=frame, gain=3.0, name=frame)
            for frame in map("{}_wrist_yaw_link".format, SIDES)
        ]
        stack = JointLimits() >> stand[0] + stand[1] >> squat >> hands[0] + hands[1]
        stack = stack >> PostureTask(robot.home, gain=1.0)
        record = simulate(Controller(robot, stack, dt=DT, damping=damping), robot.home, duration=3.0)
        late = np.linalg.norm(record.errors[squat.name], axis=1)[round(1.0 / DT) :]
        off.append([late.max(), late[round(1.0 / DT) :].max()])
        jerks.append(rms(np.diff(record.v[round(1.0 / DT) :], n=2, axis=0) / DT**2))
    assert off[0][0] <= off[1][0] + 0.01  # while the ankles stand at their ends
    assert off[0][1] <= off[1][1] + 2e-4  # and not a second later
    assert jerks[0] <= 0.3 * jerks[1]
