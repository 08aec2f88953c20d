"""What singular values tell of a task: the laws of Yoshikawa's measure, the ellipse and the degrees."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from hqp import InvalidInput
from tasks import PlanarArm, manipulability, task_degrees, velocity_ellipse

ARM = PlanarArm([0.7, 0.7, 0.3])


@st.composite
def jacobians(draw, least=1):
    m = draw(st.integers(1, 4))
    n = draw(st.integers(max(m, least), 7))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    return rng.standard_normal((m, n)) * 10.0 ** rng.uniform(-2, 2)


@given(jacobians())
def test_the_measure_is_the_root_of_the_determinant(J):
    assert manipulability(J) == pytest.approx(np.sqrt(np.linalg.det(J @ J.T)), rel=1e-6)


@given(st.floats(-7, 7), st.floats(-7, 7))
def test_two_links(q1, q2):
    """Eq. 2.2."""
    arm = PlanarArm([0.7, 0.4])
    assert arm.manipulability([q1, q2]) == pytest.approx(0.7 * 0.4 * abs(np.sin(q2)), abs=1e-15)


def test_two_links_are_best_at_a_right_angle():
    q2 = np.linspace(0.0, np.pi, 181)
    w = PlanarArm([0.7, 0.4]).manipulability(np.stack([0.3 + q2, q2], axis=-1))
    assert w.shape == (181,)
    assert np.argmax(w) == 90
    np.testing.assert_allclose(w[[0, 90, 180]], [0.0, 0.7 * 0.4, 0.0], atol=1e-15)


@given(jacobians())
def test_the_half_axes_multiply_to_the_measure(J):
    ellipse = velocity_ellipse(J)
    assert np.prod(ellipse.half_axes) == pytest.approx(float(manipulability(J)), rel=1e-12)
    assert np.all(np.diff(ellipse.half_axes) <= 0)
    np.testing.assert_allclose(ellipse.directions.T @ ellipse.directions, np.eye(len(J)), atol=1e-13)


@given(jacobians(), st.integers(0, 10**6))
def test_the_ellipse_is_where_joint_velocities_of_norm_one_lead(J, seed):
    ellipse = velocity_ellipse(J)
    v = np.random.default_rng(seed).standard_normal((J.shape[1], 50))
    v /= np.linalg.norm(v, axis=0)
    inside = np.linalg.norm((ellipse.directions.T @ J @ v) / ellipse.half_axes[:, None], axis=0)
    assert inside.max() <= 1 + 1e-9
    if J.shape[0] == J.shape[1]:
        np.testing.assert_allclose(inside, 1.0, rtol=1e-6)
    # And the tips of its axes are reached, by joint velocities of least norm.
    tips = np.linalg.pinv(J) @ (ellipse.directions * ellipse.half_axes)
    np.testing.assert_allclose(np.linalg.norm(tips, axis=0), 1.0, rtol=1e-9)


def test_one_link_moves_its_tip_along_a_circle_only():
    arm = PlanarArm([0.5])
    assert arm.manipulability([0.0]) == 0.0
    assert arm.manipulability(np.zeros((4, 1))).tolist() == [0.0] * 4
    ellipse = velocity_ellipse(arm.jacobian([0.0])[:2])
    np.testing.assert_allclose(ellipse.half_axes, [0.5, 0.0])
    np.testing.assert_allclose(np.abs(ellipse.directions), [[0, 1], [1, 0]], atol=1e-15)


@given(jacobians(), st.integers(0, 4))
def test_the_degrees_add_up_to_the_joints(J, lost):
    """At regular and at singular poses."""
    m, n = J.shape
    rank = max(m - lost, 0)
    J[rank:] = np.arange(1.0, m - rank + 1)[:, None] * J[:rank].sum(axis=0)
    degrees = task_degrees(J)
    assert (degrees.manipulability, degrees.redundancy) == (rank, n - rank)


@pytest.mark.parametrize(
    ("q", "rows", "degrees"),
    [
        ([0.4, -1.0, 0.5], slice(0, 2), (2, 1)),  # regular
        ([0.4, 0.0, 0.0], slice(0, 2), (1, 2)),  # stretched
        ([0.4, np.pi, 0.0], slice(0, 2), (1, 2)),  # folded
        ([0.4, 0.0, 0.0], slice(2, 3), (1, 2)),  # the orientation is always free to turn
        ([0.4, -1.0, 0.5], slice(0, 3), (3, 0)),
        ([0.4, 0.0, 0.5], slice(0, 3), (2, 1)),
    ],
)
def test_the_degrees_of_an_arm(q, rows, degrees):
    found = task_degrees(ARM.jacobian(q)[rows])
    assert (found.manipulability, found.redundancy) == degrees


def test_the_tolerance_says_what_counts_as_stretched():
    J = ARM.jacobian([0.0, 1e-4, 0.0])[:2]
    assert task_degrees(J).manipulability == 2
    assert task_degrees(J, tolerance=1e-3).manipulability == 1


def test_a_whole_record_at_once_is_one_after_the_other():
    q = np.random.default_rng(1).uniform(-3, 3, (4, 5, 3))
    J = ARM.jacobian(q)[..., :2, :]
    ellipse, degrees, w = velocity_ellipse(J), task_degrees(J), ARM.manipulability(q)
    assert w.shape == degrees.redundancy.shape == (4, 5)
    assert (ellipse.half_axes.shape, ellipse.directions.shape) == ((4, 5, 2), (4, 5, 2, 2))
    for i in np.ndindex(4, 5):
        assert w[i] == pytest.approx(float(manipulability(J[i])), rel=1e-12)
        np.testing.assert_allclose(ellipse.half_axes[i], velocity_ellipse(J[i]).half_axes, rtol=1e-12)
        assert degrees.manipulability[i] == task_degrees(J[i]).manipulability


@pytest.mark.parametrize("ask", [manipulability, velocity_ellipse, task_degrees])
@pytest.mark.parametrize(
    ("J", "named"),
    [
        ([1.0, 2.0], r"J has shape \(2,\); it must be \(..., rows of the task, joints\)"),
        ([[1.0, np.nan]], r"J\[0, 1\] = nan must be finite"),
        ([["a", 1.0]], "J is not an array of real numbers"),
    ],
)
def test_refuses_what_is_no_jacobian(ask, J, named):
    with pytest.raises(InvalidInput, match=named):
        ask(J)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-9, np.nan, "a", True])
def test_refuses_a_tolerance_that_is_none(tolerance):
    with pytest.raises(InvalidInput, match="tolerance = "):
        task_degrees(np.eye(2), tolerance)
