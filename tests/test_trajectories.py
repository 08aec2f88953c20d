"""Targets over time: timing laws and paths against finite differences, and the thesis's own formula."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import Fixed, Line, PositionTask, PostureTask, Trajectory, cubic


def test_cubic_is_eq_3_26_from_rest_to_rest():
    for u in np.linspace(0.0, 0.99, 12):
        assert cubic(u) == pytest.approx((3 * u**2 - 2 * u**3, 6 * u - 6 * u**2, 6 - 12 * u))
    assert cubic(-0.1) == (0.0, 0.0, 0.0)
    assert cubic(1.0) == cubic(7.0) == (1.0, 0.0, 0.0)
    assert cubic(0.0)[1] == 0.0
    assert cubic(1 - 1e-12)[1] == pytest.approx(0.0, abs=1e-10)


def test_no_time_is_no_place():
    """NaN must not pass for the end of the path."""
    assert np.isnan(cubic(np.nan)).all()
    assert all(np.isnan(part).all() for part in Line([0.0, 1.0], [2.0, 5.0], 3.0)(np.nan))


def test_line_derivatives_are_those_of_its_position():
    line, h = Line([1.0, 0.7], [0.3, 0.0], 60.0), 1e-4
    for t in (1.0, 17.0, 42.0, 59.0):
        _, velocity, acceleration = line(t)
        before, after = line(t - h), line(t + h)
        np.testing.assert_allclose(velocity, (after[0] - before[0]) / (2 * h), atol=1e-9)
        np.testing.assert_allclose(acceleration, (after[1] - before[1]) / (2 * h), atol=1e-9)


def test_line_rests_at_its_ends():
    line = Line([0.0, 1.0], [2.0, 5.0], 3.0)
    for t, place in ((-1.0, [0.0, 1.0]), (3.0, [2.0, 5.0]), (9.0, [2.0, 5.0])):
        position, velocity, acceleration = line(t)
        np.testing.assert_array_equal(position, place)
        assert not velocity.any()
        assert not acceleration.any()


def test_a_scalar_target_is_one_row():
    assert isinstance(Fixed(0.5), Trajectory)
    np.testing.assert_array_equal(Fixed(0.5)(3.0)[0], [0.5])


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Line([0, 0], [1, 1], 0.0), "duration = 0.0 s must be positive"),
        (lambda: Line([0, 0], [1, 1], np.inf), "duration = inf"),
        (lambda: Line([0, 0], [1, 1, 1], 1.0), r"start has shape \(2,\), end \(3,\)"),
        (lambda: Line([0, np.nan], [1, 1], 1.0), r"start\[1\] = nan"),
        (lambda: Line([0, 0], [1, 1], 1e300), r"duration = 1e\+300 s must be positive and at most 1e\+15"),
        (lambda: Line([0, 0], [1, 1], 1.0, timing=3), "timing = 3 is a int; it must be a function"),
        (
            lambda: PositionTask(lambda t: (["a", "b"], [0, 0], [0, 0]), gain=1.0),
            r"target\(0.0\) is not an array of real",
        ),
        (lambda: PostureTask(lambda t: (), gain=1.0), r"target\(0.0\) gives shapes \[\]"),
        (lambda: Fixed([[1.0]]), r"shape \(1, 1\)"),
        (lambda: PositionTask([1.0], gain=1.0), r"PositionTask 'position': target has shape \(1,\); it must be \(2,\)"),
        (lambda: PositionTask([1.0, np.inf], gain=1.0), r"target\[1\] = inf"),
        (lambda: PositionTask(Line([0.0], [1.0], 1.0), gain=1.0), "position, velocity and acceleration, each"),
        (lambda: PositionTask(lambda t: 1 / 0, gain=1.0), r"target\(0.0\) raised ZeroDivisionError"),
        (lambda: PositionTask(lambda t: (np.zeros(2),), gain=1.0), r"target\(0.0\) gives shapes"),
    ],
)
def test_refuses_targets_that_are_none(make, named):
    with pytest.raises(InvalidInput, match=named):
        make()
