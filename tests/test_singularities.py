"""Classical remedies for singularities."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import Controller, JointMotion, OrientationTask, PlanarArm, PositionTask, Reconstructed
from tasks.robots.manipulability import manipulability

ARM = PlanarArm([0.5, 0.5, 0.5])
STILL = np.zeros(3)
ALMOST = np.array([0.3, 0.05, 0.04])


def tip(goal: object = (2.0, 0.3)) -> PositionTask:
    return PositionTask(goal, gain=2.0, name="tip")


def turn() -> OrientationTask:
    return OrientationTask(-0.5, gain=2.0)


@pytest.mark.parametrize("factor", [0.01, 0.1, 1.0])
def test_a_damped_joint_motion_is_bounded(factor):
    """x = J^T (J J^T + lambda^2 I)^-1 h, and ||x|| <= ||h|| / 2 lambda."""
    for bend in 0.0, 1e-6, 1e-2, 0.5:
        q = np.array([0.3, bend, bend])
        J, h = ARM.jacobian(q)[:2], 2.0 * (np.array([2.0, 0.3]) - ARM.pose(q)[:2])
        x = Controller(ARM, JointMotion(tip(), damping=factor))(q, STILL).v
        np.testing.assert_allclose(x, J.T @ np.linalg.solve(J @ J.T + factor**2 * np.eye(2), h), atol=1e-9)
        assert np.linalg.norm(x) <= np.linalg.norm(h) / (2 * factor) * (1 + 1e-9)


def test_joint_motions_refuse_and_tell_their_damping():
    with pytest.raises(InvalidInput, match=r"'joint motion of tip': damping = -1\.0 must not be negative"):
        JointMotion(tip(), damping=-1.0)
    assert repr(JointMotion(tip(), damping=0.1)).endswith(", damping=0.1)")


def falls(q: np.ndarray, v: np.ndarray, measure) -> float:
    """How fast a measure changes along v."""
    return (measure(q + 1e-7 * v) - measure(q - 1e-7 * v)) / 2e-7


def test_a_reconstructed_task_is_slowed_as_its_measure_is():
    """w' = (w / w_0)^2 w'_exact; and nothing else of the task is changed."""

    def measure(q: np.ndarray) -> float:
        return float(manipulability(ARM.jacobian(q)[:2]))

    exact = Controller(ARM, tip(), damping=None)(ALMOST, STILL).v
    w, threshold = measure(ALMOST), 0.3
    slowed = Controller(ARM, Reconstructed(tip(), threshold), damping=None)(ALMOST, STILL).v
    expected = (w / threshold) ** 2 * falls(ALMOST, exact, measure)
    assert w < threshold
    assert falls(ALMOST, slowed, measure) == pytest.approx(expected, rel=1e-4)
    assert np.linalg.norm(slowed) < 0.5 * np.linalg.norm(exact)
    J = ARM.jacobian(ALMOST)[:2]
    slope = np.array([falls(ALMOST, axis, measure) for axis in np.eye(3)])
    changed, n = J @ (exact - slowed), np.linalg.pinv(J).T @ slope
    assert abs(changed @ n) == pytest.approx(np.linalg.norm(changed) * np.linalg.norm(n), rel=1e-6)


def test_below_another_task_it_allows_for_that_tasks_motion():
    above, threshold = tip(), 0.8
    below = Reconstructed(turn(), threshold, above=above)
    q = np.array([1.0, -0.3, 0.1])
    w = below.measure(ARM, q)
    assert w < threshold
    exact = Controller(ARM, above >> turn(), damping=None)(q, STILL).v
    slowed = Controller(ARM, above >> below, damping=None)(q, STILL).v
    ratio = falls(q, slowed, lambda q: below.measure(ARM, q)) / falls(q, exact, lambda q: below.measure(ARM, q))
    assert ratio == pytest.approx((w / threshold) ** 2, rel=1e-3)
    np.testing.assert_allclose(ARM.jacobian(q)[:2] @ slowed, ARM.jacobian(q)[:2] @ exact, atol=1e-9)


def test_above_the_threshold_it_is_the_task_itself():
    q = np.array([0.3, 1.0, 0.8])
    plain, same = (Controller(ARM, task, damping=None)(q, STILL).v for task in (tip(), Reconstructed(tip(), 1e-3)))
    np.testing.assert_array_equal(plain, same)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Reconstructed("tip", 0.1), "task must be a Task, not a str"),
        (lambda: Reconstructed(tip(), 0.1, above=3), "above must be a Task, not a int"),
        (lambda: Reconstructed(tip(), 0.0), "Reconstructed 'tip': threshold"),
        (lambda: Controller(ARM, Reconstructed(tip(), 0.1), order="acceleration"), "takes order = 'velocity'"),
    ],
)
def test_refusals(make, message):
    with pytest.raises(InvalidInput, match=message):
        make()


def test_it_tells_what_it_is_and_leaves_bad_numbers_to_the_solver():
    task = Reconstructed(turn(), 0.5, above=tip())
    assert repr(task).startswith("Reconstructed(OrientationTask(")
    assert repr(task).count("above=") == 1
    assert not Controller(ARM, tip() >> task)([np.nan, 0.0, 0.0], STILL).ok
