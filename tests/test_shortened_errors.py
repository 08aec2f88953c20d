"""A cap on the error of a task, and coming to rest at a target by a deceleration: laws, at both orders."""

from __future__ import annotations

import numpy as np
import pytest
from asking import asked

from hqp import InvalidInput
from tasks import (
    AtLeast,
    Controller,
    JointCouplingTask,
    PlanarArm,
    PoseTask,
    PositionTask,
    PostureTask,
    Stack,
    load_robot,
    simulate,
    solve_ik,
)

ARM = PlanarArm([1.0, 1.0])
STATE = ARM.at([0.3, 0.8], [0.0, 0.0])
HERE = STATE.frame().position[:2]
PANDA = load_robot("panda", lock=["panda_finger_joint1"])
K, ZETA = 3.0, 0.8
LAW = {"gain": K, "damping_ratio": ZETA}


def length(order: str) -> float:
    """What the law makes of an error of length 1."""
    return {"velocity": K, "acceleration": K**2, "displacement": 1.0}[order]


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_cap_shortens_the_error_and_keeps_its_direction(order) -> None:
    way = np.array([0.3, -0.4])
    _, h = asked(PositionTask(HERE + way, cap=0.1, **LAW), STATE, 0.0, order)
    np.testing.assert_allclose(h, length(order) * 0.1 * way / 0.5, rtol=1e-9)
    _, h = asked(PositionTask(HERE + 0.1 * way, cap=0.1, **LAW), STATE, 0.0, order)
    np.testing.assert_allclose(h, length(order) * 0.1 * way, rtol=1e-9)
    _, h = asked(PositionTask(HERE + way, cap=[0.1, 0.1], **LAW), STATE, 0.0, order)
    np.testing.assert_allclose(h, length(order) * 0.1 * way / 0.4, rtol=1e-9)


def test_a_pose_has_a_cap_for_each_unit() -> None:
    state = PANDA.at(PANDA.home)
    T = state.transform()
    T[0, 3] += 0.5
    _, h = asked(PoseTask(T, cap=[0.1] * 3 + [0.5] * 3, gain=2.0), state, 0.0, "velocity")
    np.testing.assert_allclose(h, [0.2, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-12)


def test_the_error_that_is_told_and_the_one_of_inverse_kinematics_are_whole() -> None:
    task = PositionTask(HERE + np.array([0.3, -0.4]), cap=0.1, deceleration=0.1, **LAW)
    np.testing.assert_allclose(task.error(STATE, 0.0), [0.3, -0.4], rtol=1e-9)
    _, h = asked(task, STATE, 0.0, "displacement")
    np.testing.assert_allclose(h, [0.3, -0.4], rtol=1e-9)
    assert solve_ik(ARM, Stack(PositionTask([0.5, 1.2], cap=0.01, gain=1.0)), seed=0).reached


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_it_comes_to_rest_by_the_deceleration(order) -> None:
    """Along a joint, which has no inertia in the way: fast at first, never braking by more, and there in the end."""
    a, dt = 0.5, 0.002
    task = PostureTask([3.0, 0.0], gain=10.0, deceleration=a)
    record = simulate(Controller(ARM, Stack(task), order=order, dt=dt, damping=None), [0.0, 0.0], duration=6.5)
    d, v = 3.0 - record.q[:, 0], record.v[:, 0]
    speed = 10.0 if order == "velocity" else 5.0
    far = d > 2.0 * a / speed**2
    begun = record.t > 1.5  # at acceleration order it has to come to speed first
    late = 0.02 if order == "velocity" else 1.2 * a / 20.0  # the speed follows what is asked for at the rate 2 zeta K
    np.testing.assert_allclose(v[far & begun], np.sqrt(2.0 * a * (d[far & begun] - 0.5 * a / speed**2)), atol=late)
    most = 1.02 if order == "velocity" else 1.3  # where the parabola ends the speed is still ahead
    assert -np.diff(v)[record.t[1:] > 1.0].min() / dt < most * a
    assert abs(d[-1]) < 1e-3
    assert d.min() > -1e-6


def test_a_deceleration_leaves_short_ways_alone() -> None:
    task = JointCouplingTask({0: 1.0}, 0.3 + 0.01, gain=K, deceleration=1.0)
    _, h = asked(task, STATE, 0.0, "velocity")
    np.testing.assert_allclose(h, K * 0.01, rtol=1e-9)


def test_both_together_and_feed_forwards_are_not_shortened() -> None:
    def target(t: float):
        return HERE + np.array([1.0, 0.0]), np.array([0.0, 0.7]), np.zeros(2)

    _, h = asked(PositionTask(target, cap=0.5, deceleration=0.02, gain=1.0), STATE, 0.0, "velocity")
    end = 0.02
    np.testing.assert_allclose(h, [np.sqrt(2.0 * 0.02 * (1.0 - 0.5 * end)), 0.7], rtol=1e-9)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PositionTask(HERE, gain=1.0, cap=0.0), "cap"),
        (lambda: PositionTask(HERE, gain=1.0, cap=[0.1, 0.1, 0.1]), "cap has shape (3,)"),
        (lambda: PositionTask(HERE, gain=1.0, deceleration=-1.0), "deceleration"),
        (lambda: PositionTask(HERE, gain=1.0, deceleration=[1.0, 1.0]), "must be one number"),
        (lambda: Controller(ARM, Stack(AtLeast(PositionTask(HERE, gain=1.0, cap=0.1))), dt=0.01), "must be None"),
        (lambda: Controller(PANDA, Stack(PostureTask(PANDA.home, gain=1.0, cap=[0.1, 0.1])), dt=0.01), "(7,)"),
    ],
)
def test_what_is_wrong_is_refused_in_words(make, words: str) -> None:
    with pytest.raises(InvalidInput) as refusal:
        make()
    assert words in str(refusal.value)
