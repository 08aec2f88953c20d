"""The planar arm: every derivative against finite differences, for arms of one to eight links."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from hqp import InvalidInput
from tasks import PlanarArm

EPS = 1e-6


@st.composite
def moving_arms(draw):
    n = draw(st.integers(1, 8))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    return PlanarArm(rng.uniform(0.1, 1.0, n)), rng.uniform(-4, 4, n), rng.uniform(-3, 3, n)


many = settings(max_examples=40, deadline=None)


@many
@given(moving_arms())
def test_jacobian_is_the_derivative_of_the_pose(case):
    arm, q, _ = case
    steps = EPS * np.eye(arm.nq)
    J = np.column_stack([(arm.pose(q + step) - arm.pose(q - step)) / (2 * EPS) for step in steps])
    np.testing.assert_allclose(arm.jacobian(q), J, atol=1e-8)


@many
@given(moving_arms())
def test_jacobian_dot_is_the_time_derivative_of_the_jacobian(case):
    arm, q, v = case
    Jdot = (arm.jacobian(q + EPS * v) - arm.jacobian(q - EPS * v)) / (2 * EPS)
    np.testing.assert_allclose(arm.jacobian_dot(q, v), Jdot, atol=1e-7)


@many
@given(moving_arms())
def test_the_state_agrees_with_the_methods(case):
    arm, q, v = case
    state = arm.at(q, v)
    np.testing.assert_allclose(state.pose, arm.pose(q), atol=1e-14)
    np.testing.assert_allclose(state.points, arm.points(q), atol=1e-14)
    np.testing.assert_allclose(state.jacobian, arm.jacobian(q), atol=1e-14)
    np.testing.assert_allclose(state.twist, arm.jacobian(q) @ v, atol=1e-12)
    np.testing.assert_allclose(state.drift, arm.jacobian_dot(q, v) @ v, atol=1e-11)


@many
@given(moving_arms())
def test_points_are_a_chain_of_the_links(case):
    arm, q, _ = case
    points = arm.points(q)
    assert points.shape == (arm.nq + 1, 2)
    np.testing.assert_array_equal(points[0], [0, 0])
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), arm.lengths, rtol=1e-12)
    np.testing.assert_allclose(points[-1], arm.pose(q)[:2], atol=1e-14)


@many
@given(moving_arms())
def test_a_whole_record_at_once_is_one_after_the_other(case):
    arm, q, v = case
    qs, vs = q + np.arange(6.0).reshape(2, 3, 1), v * np.arange(6.0).reshape(2, 3, 1)
    for ask, values in (arm.points, [qs]), (arm.pose, [qs]), (arm.jacobian, [qs]), (arm.jacobian_dot, [qs, vs]):
        together = ask(*values)
        assert together.shape[:2] == (2, 3)
        for i in np.ndindex(2, 3):
            np.testing.assert_allclose(together[i], ask(*(value[i] for value in values)), atol=1e-12)


def test_an_arm_by_hand():
    x, y, phi = PlanarArm([2.0, 1.0]).pose([np.pi / 2, -np.pi / 2])
    assert (x, y, phi) == pytest.approx((1.0, 2.0, 0.0), abs=1e-15)


def test_phi_is_the_unwrapped_sum():
    assert PlanarArm([1.0, 1.0]).pose([3.0, 4.0])[2] == 7.0


@pytest.mark.parametrize(
    ("lengths", "named"),
    [
        ([0.5, 0.0], "link 1: length = 0.0 m must be positive"),
        ([0.5, 0.5, -1.0], "link 2: length = -1.0"),
        ([np.nan], "link 0: length = nan"),
        ([np.inf, 1.0], "link 0: length = inf"),
        ([1.0, 1e200], r"link 1: length = 1e\+200 m must be positive and at most 1e\+15"),
        ([], "at least one"),
        (0.5, "at least one"),
        (["long"], "not an array of real numbers"),
    ],
)
def test_refuses_links_that_are_none(lengths, named):
    with pytest.raises(InvalidInput, match=named):
        PlanarArm(lengths)


@pytest.mark.parametrize("limits", [{"velocity_limit": [1.0, 2.0]}, {"acceleration_limit": [1.0, 0.0, 1.0]}])
def test_refuses_limits_that_are_none(limits):
    with pytest.raises(InvalidInput, match=r"PlanarArm.*(velocity|acceleration) limit"):
        PlanarArm([1, 1, 1], **limits)


def test_refuses_q_and_v_of_the_wrong_length():
    arm = PlanarArm([1, 1, 1])
    with pytest.raises(InvalidInput, match=r"q has shape \(2,\).*\(..., 3\), one number a joint"):
        arm.pose([0, 0])
    with pytest.raises(InvalidInput, match=r"v has shape \(4,\)"):
        arm.at([0, 0, 0], [0, 0, 0, 0])
    with pytest.raises(InvalidInput, match=r"q has shape \(2, 3\).*takes \(3,\), one number a joint"):
        arm.at(np.zeros((2, 3)), np.zeros((2, 3)))
    with pytest.raises(InvalidInput, match=r"v has shape \(3,\); it must be that of q, \(2, 3\)"):
        arm.jacobian_dot(np.zeros((2, 3)), np.zeros(3))


@pytest.mark.parametrize("q", ["a", None, [1j, 0, 0], {}, [[0], [0, 0]]])
def test_refuses_q_and_v_that_are_no_numbers(q):
    arm = PlanarArm([1, 1, 1])
    for ask in (arm.points, arm.pose, arm.jacobian, lambda q: arm.at(q, [0, 0, 0])):
        with pytest.raises(InvalidInput, match="q is not an array of real numbers"):
            ask(q)
    with pytest.raises(InvalidInput, match="v is not an array of real numbers"):
        arm.jacobian_dot([0, 0, 0], q)


def test_a_name_is_a_string():
    with pytest.raises(InvalidInput, match="name of an arm = 5 is a int; it must be a str"):
        PlanarArm([1.0], name=5)
