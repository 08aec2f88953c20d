"""Targets over time: what stands still, and what is a trajectory at all."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import Fixed, Line, PositionTask, PostureTask, Trajectory


def test_a_scalar_target_is_one_row():
    assert isinstance(Fixed(0.5), Trajectory)
    np.testing.assert_array_equal(Fixed(0.5)(3.0)[0], [0.5])


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (
            lambda: PositionTask(lambda t: (["a", "b"], [0, 0], [0, 0]), gain=1.0),
            r"target\(0.0\) is not an array of real",
        ),
        (lambda: PostureTask(lambda t: (), gain=1.0), r"target\(0.0\) gives shapes \[\]"),
        (lambda: Fixed([[1.0]]), r"shape \(1, 1\)"),
        (
            lambda: PositionTask([1.0], gain=1.0),
            r"PositionTask 'position': target has shape \(1,\); it must be \(2,\) or \(3,\)",
        ),
        (lambda: PositionTask([1.0, np.inf], gain=1.0), r"target\[1\] = inf"),
        (lambda: PositionTask(Line([0.0], [1.0], 1.0), gain=1.0), r"target has shape \(1,\)"),
        (lambda: PositionTask(lambda t: 1 / 0, gain=1.0), r"target\(0.0\) raised ZeroDivisionError"),
        (lambda: PositionTask(lambda t: (np.zeros(2),), gain=1.0), r"target\(0.0\) gives shapes"),
    ],
)
def test_refuses_targets_that_are_none(make, named):
    with pytest.raises(InvalidInput, match=named):
        make()
