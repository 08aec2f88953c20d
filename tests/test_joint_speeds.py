"""Joints that are frozen, and joints with a wanted speed: exact, at every order, and said in words."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    Controller,
    Freeze,
    JointLimits,
    JointVelocityTask,
    Line,
    PlanarArm,
    PositionTask,
    PostureTask,
    Stack,
    load_robot,
    simulate,
    solve_ik,
)

PANDA = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=20.0)
REACH = PositionTask([0.5, 0.3, 0.4], gain=3.0)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_frozen_joints_do_not_move_and_the_others_reach(order) -> None:
    held = ["panda_joint1", "panda_joint3"]
    stack = (
        JointLimits() >> Freeze(held) >> PositionTask([0.5, 0.0, 0.4], gain=3.0) >> PostureTask(PANDA.home, gain=1.0)
    )
    record = simulate(Controller(PANDA, stack, order=order, dt=0.01), PANDA.home, duration=4.0)
    columns = [PANDA.joint_names.index(name) for name in held]
    assert (record.q[:, columns] == PANDA.home[columns]).all()
    assert np.abs(record.errors["position"][-1]).max() < 1e-3


def test_a_joint_in_motion_stops_within_a_tick() -> None:
    step = Controller(PlanarArm([0.5, 0.5]), Freeze([1]), order="acceleration", dt=0.01)([0.3, 0.4], [0.5, -0.2])
    np.testing.assert_allclose(-0.2 + 0.01 * step.a[1], 0.0, atol=1e-15)


def test_all_but_a_group() -> None:
    g1 = load_robot("g1")
    arm = [name for name in g1.joint_names if name.startswith("left_") and ("shoulder" in name or "elbow" in name)]
    hand = g1.at(g1.home, np.zeros(g1.nv)).frame("left_rubber_hand").position
    goal = PositionTask(hand + np.array([0.05, 0.05, 0.1]), frame="left_rubber_hand", gain=3.0)
    v = Controller(g1, JointLimits() >> Freeze(all_but=arm) >> goal, dt=0.01)(g1.home).v
    moving = np.isin(g1.joint_names, arm)
    assert (v[~moving] == 0.0).all()
    assert np.abs(v[moving]).min() > 1e-6


def test_inverse_kinematics_leaves_frozen_joints_where_they_are() -> None:
    found = solve_ik(
        PANDA, JointLimits() >> Freeze(["panda_joint1"]) >> PositionTask([0.5, 0.1, 0.4], gain=1.0), seed=1
    )
    assert found.q[0] == PANDA.home[0]


def test_explanations_name_the_frozen_joint() -> None:
    frozen = Freeze(["panda_joint1", "panda_joint2", "panda_joint4", "panda_joint6"])
    step = Controller(PANDA, frozen >> REACH, dt=0.01)(PANDA.home)
    assert "frozen joints" in str(step.solution.explain()).splitlines()[1]
    first, *_ = Controller(PANDA, frozen >> REACH, dt=0.01).describe()
    assert [label.row for label in first.rows] == ["panda_joint1", "panda_joint2", "panda_joint4", "panda_joint6"]
    assert not first.python


def test_joints_turn_at_their_speeds() -> None:
    stack = JointLimits() >> JointVelocityTask([0.2], joints=["panda_joint1"]) >> PostureTask(PANDA.home, gain=2.0)
    for order in "velocity", "acceleration":
        record = simulate(Controller(PANDA, stack, order=order, dt=0.01), PANDA.home, duration=1.0)
        np.testing.assert_allclose(record.v[-1, 0], 0.2, rtol=1e-9)
        np.testing.assert_allclose(record.errors["joint velocity"][-1], 0.0, atol=1e-9)


def test_a_gain_takes_speeds_up_smoothly_and_follows_a_trajectory() -> None:
    arm, way = PlanarArm([0.5, 0.5]), Line([0.0, 0.1], [0.5, -0.2], 1.0)
    task = JointVelocityTask(way, gain=4.0)
    v = np.array([0.2, 0.3])
    a = Controller(arm, Stack(task), order="acceleration", dt=0.01)([0.1, 0.2], v, t=0.4).a
    speed, rate, _ = way(0.4)
    np.testing.assert_allclose(a, rate + 4.0 * (speed - v), rtol=1e-12)
    np.testing.assert_allclose(Controller(arm, Stack(task), dt=0.01)([0.1, 0.2], v, t=0.4).v, speed, rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Freeze(), "all_but="),
        (lambda: Freeze([0], all_but=[1]), "all_but="),
        (lambda: Freeze([1.5]), "must be a name or a number"),
        (lambda: Controller(PANDA, Stack(Freeze(["panda_joint_1"])), dt=0.01), "did you mean 'panda_joint1'"),
        (lambda: Controller(PANDA, Stack(Freeze(all_but=range(7))), dt=0.01), "name one"),
        (lambda: Controller(PANDA, Stack(Freeze([0])), order="acceleration", dt=None), "needs the tick"),
        (lambda: JointVelocityTask([np.nan]), "finite"),
        (lambda: JointVelocityTask(0.1, gain=0.0), "positive"),
        (lambda: Controller(PANDA, Stack(JointVelocityTask([0.1, 0.2])), dt=0.01), "must be one number, or (7,)"),
        (
            lambda: Controller(PANDA, Stack(JointVelocityTask(0.1, gain=500.0)), order="acceleration", dt=0.01),
            "at most 200",
        ),
    ],
)
def test_what_is_wrong_is_refused_in_words(make, words: str) -> None:
    with pytest.raises(InvalidInput) as refusal:
        make()
    assert words in str(refusal.value)
