"""Damping: rows of stillness beside a task are damped least squares."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hqp import InvalidInput
from tasks import Controller, Damping, JointVelocityLimit, OrientationTask, PlanarArm, PositionTask

ARM = PlanarArm([0.5, 0.4, 0.3])
#: Away from stretched arms, where a row of the Jacobian can vanish.
angles = st.lists(st.floats(0.2, 2.0), min_size=3, max_size=3).map(np.array)


@given(q=angles, damping=st.floats(0.05, 2.0), order=st.sampled_from(["velocity", "acceleration"]))
def test_a_damped_task_is_damped_least_squares(q, damping, order):
    """``x = J^T (J J^T + lambda^2 I)^-1 h``."""
    task = PositionTask([0.7, 0.2], gain=2.0)
    controller = Controller(ARM, task + Damping(damping), order=order, backend="pseudoinverse")
    step = controller(q, np.zeros(3))
    J = ARM.jacobian(q)[:2]
    e = np.array([0.7, 0.2]) - ARM.pose(q)[:2]
    h = 2.0 * e if order == "velocity" else 4.0 * e
    x = J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(2), h)
    np.testing.assert_allclose(step.v if order == "velocity" else step.a, x, rtol=1e-7, atol=1e-9)


@given(q=angles)
def test_damping_below_does_not_touch_what_is_above(q):
    stack = JointVelocityLimit(1.0) >> PositionTask([0.7, 0.2], gain=1.0)
    free = stack >> OrientationTask(0.5, gain=1.0)
    damped = stack >> OrientationTask(0.5, gain=1.0) + Damping(0.3)
    steps = [Controller(ARM, s, dt=0.01, damping=None)(q, np.zeros(3)) for s in (free, damped)]
    residuals = [step.solution.levels[1].residual_norm for step in steps]
    assert residuals[0] == pytest.approx(residuals[1], abs=1e-7)
    assert steps[1].solution.certify().ok


def test_repr_and_refusals():
    assert repr(OrientationTask(0.0, gain=1.0) + Damping(0.1)) == "OrientationTask([0.0], gain=1) + Damping(0.1)"
    for wrong in -1.0, np.nan, [0.1, -0.5]:
        with pytest.raises(InvalidInput, match="Damping 'damping': weight"):
            Damping(wrong)
    with pytest.raises(InvalidInput, match=r"weight has shape \(2,\); it must be one number, or \(3,\)"):
        Controller(ARM, PositionTask([0.7, 0.2], gain=1.0) + Damping([0.1, 0.2]))
