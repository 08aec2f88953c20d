"""Rotations: vectors and matrices are each other's inverse at every angle, and what is none is refused."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import example, given

from hqp import InvalidInput
from tasks.base.rotations import about, cross, exp, from_quaternion, from_rpy, log, perpendicular, rotation_matrix
from tasks.targets.turns import FixedRotation, Turn, as_rotation

PI = np.pi
AXES = [
    np.eye(3)[0],
    np.eye(3)[1],
    np.eye(3)[2],
    -np.eye(3)[1],
    np.array([1, 1, 0]) / np.sqrt(2),
    np.ones(3) / np.sqrt(3),
]
ANGLES = [0.0, 5e-324, 1e-300, 1e-160, 1e-16, 1e-9, 9.9e-5, 1e-4, 1.01e-4, 0.1, 1.0, PI / 2, 2.0, 3.0]
NEAR_PI = [PI - d for d in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0)]

axes = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array).filter(lambda x: np.linalg.norm(x) > 1e-3)
axes = axes.map(lambda x: x / np.linalg.norm(x))
angles = st.one_of(st.floats(0.0, PI), st.sampled_from(ANGLES + NEAR_PI), st.floats(-16, 0).map(lambda x: PI - 10**x))


def is_rotation(R):
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=2e-15)
    assert np.linalg.det(R) > 0.0


@given(axes, angles)
@example(np.array([0.0, 0.0, 1.0]), PI)
def test_exp_and_log_are_inverse(axis, angle):
    vector = angle * axis
    R = exp(vector)
    is_rotation(R)
    back = log(R)
    assert np.linalg.norm(back) <= PI + 1e-15
    if angle < PI - 1e-7:
        np.testing.assert_allclose(back, vector, rtol=0.0, atol=4e-15)
    else:  # either sign, once the two are nearer than round-off
        assert min(np.abs(back - vector).max(), np.abs(back + vector).max()) < 4e-15 + 2 * (PI - angle)
    np.testing.assert_allclose(exp(back), R, atol=4e-15)


@pytest.mark.parametrize("axis", AXES, ids=lambda a: str(a.round(2).tolist()))
def test_at_the_hard_angles(axis):
    for angle in ANGLES + NEAR_PI:
        R = exp(angle * axis)
        back = log(R)
        np.testing.assert_allclose(np.linalg.norm(back), angle, rtol=1e-14, atol=4e-15 if angle > 1e-4 else 1e-30)
        if angle < PI - 1e-13:
            np.testing.assert_allclose(back, angle * axis, rtol=1e-14, atol=4e-15)
        np.testing.assert_allclose(exp(back), R, atol=4e-15)


@given(axes, st.floats(1e-9, 1e-3))
def test_small_angles_keep_all_their_digits(axis, angle):
    """From the series to the quotients without a step: relative to the angle, not to one."""
    np.testing.assert_allclose(log(exp(angle * axis)), angle * axis, rtol=1e-9, atol=1e-15 * angle + 1e-16 * angle)


@given(axes, st.floats(-20.0, 20.0))
def test_a_vector_longer_than_half_a_turn_is_the_same_rotation(axis, angle):
    np.testing.assert_allclose(exp(angle * axis), exp((angle + 2 * PI) * axis), atol=2e-14)
    assert np.linalg.norm(log(exp(angle * axis))) <= PI + 1e-15


@given(axes, angles)
def test_agrees_with_pinocchio(axis, angle):
    R = exp(angle * axis)
    np.testing.assert_allclose(R, pin.exp3(angle * axis), atol=4e-15)
    if angle < PI - 1e-2:  # nearer to half a turn Pinocchio's own loses digits
        np.testing.assert_allclose(log(R), pin.log3(R), atol=1e-11)


def test_log_is_good_where_its_matrix_is_off_by_round_off():
    rng = np.random.default_rng(4)
    for _ in range(300):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        R = exp(rng.choice([1e-9, 1e-3, 1.0, 3.0, PI]) * axis)
        np.testing.assert_allclose(exp(log(R + 1e-15 * rng.uniform(-1, 1, (3, 3)))), R, atol=2e-14)


@given(axes, angles, st.floats(1e-3, 1e3), st.sampled_from([1.0, -1.0]))
def test_a_quaternion_of_any_length_and_sign(axis, angle, length, sign):
    x, y, z = np.sin(angle / 2) * axis
    q = sign * length * np.array([x, y, z, np.cos(angle / 2)])
    R = from_quaternion(*q)
    is_rotation(R)
    np.testing.assert_allclose(R, exp(angle * axis), atol=4e-15)
    np.testing.assert_allclose(R, pin.Quaternion(q / np.linalg.norm(q)).toRotationMatrix(), atol=4e-15)


@given(*[st.floats(-2 * PI, 2 * PI)] * 3)
def test_roll_pitch_and_yaw_are_those_of_a_urdf(roll, pitch, yaw):
    R = from_rpy(roll, pitch, yaw)
    np.testing.assert_allclose(R, pin.rpy.rpyToMatrix(roll, pitch, yaw), atol=2e-15)
    np.testing.assert_allclose(R, exp([0, 0, yaw]) @ exp([0, pitch, 0]) @ exp([roll, 0, 0]), atol=4e-15)
    for axis, angle in enumerate((roll, pitch, yaw)):
        np.testing.assert_allclose(about(axis, angle), exp(angle * np.eye(3)[axis]), atol=4e-15)


@given(axes)
def test_two_perpendicular_axes_complete_a_right_handed_frame(axis):
    is_rotation(np.vstack([axis, perpendicular(axis)]).T)
    columns = np.arange(6.0).reshape(3, 2)
    np.testing.assert_allclose(cross(axis, columns), np.cross(axis, columns.T).T, atol=1e-14)


def test_a_rotation_is_made_exact():
    R = exp([0.3, -0.2, 0.9])
    for off in (0.0, 1e-12, 3e-7):
        given = R + off * np.array([[1, -1, 1], [1, 1, -1], [-1, 1, 1]]) / 3
        mine = rotation_matrix(given, "R")
        is_rotation(mine)
        np.testing.assert_allclose(mine, R, atol=2 * off + 1e-15)
        assert not mine.flags.writeable


NAN = np.full((3, 3), np.nan)


@pytest.mark.parametrize(
    ("value", "named"),
    [
        (np.ones((3, 3)), "is no rotation: R\\^T R differs from the identity by 3"),
        (2 * np.eye(3), "is no rotation"),
        (np.zeros((3, 3)), "is no rotation"),
        (exp([0.1, 0.2, 0.3]) + 1e-5, "is no rotation"),
        (np.diag([1.0, 1.0, -1.0]), "is a reflection, not a rotation: its determinant is -1"),
        (-np.eye(3), "is a reflection"),
        (NAN, r"\[0, 0\] = nan must be finite"),
        (np.diag([1.0, np.inf, 1.0]), r"\[1, 1\] = inf must be finite"),
    ],
)
def test_refuses_what_is_no_rotation(value, named):
    for make in (
        lambda: rotation_matrix(value, "R"),
        lambda: FixedRotation(value),
        lambda: Turn(value, np.eye(3), 1.0),
        lambda: Turn(np.eye(3), value, 1.0),
        lambda: as_rotation(value, "hand"),
        lambda: as_rotation(lambda t: (value, np.zeros(3), np.zeros(3)), "hand"),
    ):
        with pytest.raises(InvalidInput, match=named):
            make()


@pytest.mark.parametrize("value", [np.eye(2), np.eye(4), [1.0, 0.0, 0.0], 1.0, "up", None])
def test_refuses_shapes_and_strings(value):
    with pytest.raises(
        InvalidInput, match=r"R has shape .* matrix of shape \(3, 3\)|R is not an array of real numbers"
    ):
        rotation_matrix(value, "R")


@pytest.mark.parametrize(
    ("value", "named"),
    [
        ((0, 0, 0, 0), r"quaternion \(x, y, z, w\) is zero; it must have a direction"),
        ((0, np.nan, 0, 1), r"quaternion \(x, y, z, w\)\[1\] = nan must be finite"),
        ((np.inf, 0, 0, 1), r"\[0\] = inf must be finite"),
    ],
)
def test_refuses_quaternions_that_are_none(value, named):
    with pytest.raises(InvalidInput, match=named):
        from_quaternion(*value)


@given(axes, angles, axes, st.floats(0.1, 3.0))
def test_a_turn_goes_the_shortest_way(axis, angle, other, t):
    """Its angular velocity and acceleration are its derivatives; it begins and ends where it should."""
    start, end = exp(other), exp(angle * axis) @ exp(other)
    turn, h = Turn(start, end, 3.2), 1e-5
    np.testing.assert_allclose(turn(-1.0)[0], start, atol=4e-15)
    np.testing.assert_allclose(turn(4.0)[0], end, atol=2e-14)
    R, omega, change = turn(t)
    is_rotation(R)
    rate = log(turn(t + h)[0] @ turn(t - h)[0].T) / (2 * h)
    np.testing.assert_allclose(omega, rate, atol=1e-8)
    np.testing.assert_allclose(change, (turn(t + h)[1] - turn(t - h)[1]) / (2 * h), atol=1e-8)
    assert np.linalg.norm(log(R @ start.T)) <= angle + 1e-12
