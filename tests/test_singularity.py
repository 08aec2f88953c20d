"""Away from singularities: the joints climb the gradient of the manipulability, and the task above does not feel it."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import Controller, JointVelocityLimit, ManipulabilityTask, PlanarArm, PositionTask, simulate

ARM = PlanarArm([0.6, 0.5, 0.4])
STILL = np.zeros(3)


def test_two_links():
    """w = l1 l2 |sin q2| (Eq. 2.2)."""
    arm = PlanarArm([0.7, 0.4])
    climb = ManipulabilityTask(PositionTask([0.5, 0.1], gain=1.0), gain=1.0)
    for q2 in (-2.0, -0.3, 0.2, 1.0, np.pi / 2, 3.0):
        expected = [0.0, 0.7 * 0.4 * np.cos(q2) * np.sign(np.sin(q2))]
        np.testing.assert_allclose(climb.gradient(arm, np.array([0.4, q2])), expected, atol=1e-9)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_the_law(order):
    task = ManipulabilityTask(PositionTask([0.5, 0.1], gain=1.0), gain=3.0)
    q, v = np.array([0.3, -0.8, 0.5]), np.array([0.1, 0.2, -0.4])
    x = Controller(ARM, task, order=order, damping=None)(q, v).solution.x
    climb = task.gradient(ARM, q)  # by differences, where the rows have the closed form
    np.testing.assert_allclose(x, 3.0 * climb if order == "velocity" else 9.0 * climb - 6.0 * v, atol=1e-8)


def test_the_task_above_does_not_feel_it_and_the_arm_bends():
    tip = PositionTask(ARM.pose([0.2, 0.15, -0.1])[:2], gain=5.0)
    stack = JointVelocityLimit(2.0) >> tip >> ManipulabilityTask(tip, gain=2.0)
    record = simulate(Controller(ARM, stack, dt=0.02, damping=None), [0.2, 0.15, -0.1], duration=6.0)
    w = ARM.manipulability(record.q)
    assert w[-1] > 1.1 * w[0]
    assert np.all(np.diff(w) > -1e-6)
    assert np.linalg.norm(record.errors["position"], axis=1).max() < 1e-3  # the chord of a tick is no arc
    # At the end nothing is left to climb: the gradient lies in the row space of the task.
    J = ARM.jacobian(record.q[-1])[:2]
    left = ManipulabilityTask(tip, gain=1.0).gradient(ARM, record.q[-1]) @ (np.eye(3) - np.linalg.pinv(J) @ J)
    assert np.abs(left).max() < 1e-3


def test_refusals_name_the_task():
    tip = PositionTask([0.5, 0.1], gain=1.0)
    for wrong, message in (
        (lambda: ManipulabilityTask("no", gain=1.0), "ManipulabilityTask takes a Task, not a str"),
        (lambda: ManipulabilityTask(tip, gain=0.0), "ManipulabilityTask 'manipulability of position': gain"),
        (lambda: ManipulabilityTask(tip, gain=1.0, weight=-1.0), "'manipulability of position': weight"),
    ):
        with pytest.raises(InvalidInput, match=message):
            wrong()
    assert repr(ManipulabilityTask(tip, gain=2.0)) == "ManipulabilityTask(PositionTask([0.5, 0.1], gain=1), gain=2)"


def test_numbers_that_are_not_finite_are_for_the_solver_to_report():
    tip = PositionTask([0.5, 0.1], gain=1.0)
    step = Controller(ARM, tip >> ManipulabilityTask(tip, gain=1.0))([np.nan, 0.0, 0.0], STILL)
    assert not step.ok
