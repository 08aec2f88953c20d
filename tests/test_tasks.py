"""Tasks: their rows obey the control laws of Eq. 4.5 and 4.7, at both orders."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from asking import asked
from hypothesis import given, settings

import hqp
from hqp import InvalidInput
from tasks import Controller, JointMotion, Line, OrientationTask, PlanarArm, PositionTask, PostureTask, Task, simulate

ARM = PlanarArm([0.5, 0.4, 0.3, 0.2])
RNG = np.random.default_rng(7)
TASKS = [
    PositionTask([0.6, 0.2], gain=[2.0, 3.0]),
    PositionTask(Line([0.2, 0.1], [0.8, 0.3], 2.0), gain=1.5, damping_ratio=0.7),
    OrientationTask(0.4, gain=3.0),
    PostureTask([0.1, -0.2, 0.3, 0.4], gain=1.0),
]
tasks = pytest.mark.parametrize("task", TASKS, ids=repr)


class ElbowHeight(Task):
    """A user's own task, as small as it gets: the height of the first joint's end."""

    rows = 1

    def error(self, state, t):
        return 0.2 - state.points[1, 1:]

    def jacobian(self, state):
        return np.array([[state.points[1, 0], 0.0, 0.0, 0.0]])

    def drift(self, state):
        return -state.points[1, 1:] * state.v[0] ** 2


@tasks
def test_jacobian_and_drift_are_derivatives_of_the_error(task):
    h = 1e-5
    for _ in range(20):
        q, v, a = RNG.uniform(-2, 2, (3, 4))
        states = [ARM.at(q + s * v + s * s / 2 * a, v + s * a) for s in (-h, 0.0, h)]
        # With the target held still, e_dot = -J v and e_ddot = -J a - Jdot v.
        before, now, after = (task.error(state, 1.0) for state in states)
        state = states[1]
        np.testing.assert_allclose((after - before) / (2 * h), -task.jacobian(state) @ v, atol=1e-7)
        second = (after - 2 * now + before) / h**2
        np.testing.assert_allclose(second, -task.jacobian(state) @ a - task.drift(state), atol=1e-4)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.1, 50.0), st.floats(0.2, 2.0))
def test_rows_are_the_two_control_laws(seed, gain, zeta):
    rng = np.random.default_rng(seed)
    path = Line([0.2, 0.1], [0.8, 0.3], 2.0)
    task = PositionTask(path, gain=gain, damping_ratio=zeta)
    q, v = rng.uniform(-2, 2, (2, 4))
    t = rng.uniform(0, 2)
    state = ARM.at(q, v)
    (xd, xd_dot, xd_ddot), J = path(t), ARM.jacobian(q)[:2]
    e, e_dot = xd - ARM.pose(q)[:2], xd_dot - J @ v

    rows, h = asked(task, state, t, "velocity")
    np.testing.assert_allclose(rows, J, atol=1e-14)
    np.testing.assert_allclose(h, xd_dot + gain * e, rtol=1e-10, atol=1e-12)
    _, h = asked(task, state, t, "acceleration")
    expected = xd_ddot - ARM.jacobian_dot(q, v)[:2] @ v + 2 * zeta * gain * e_dot + gain**2 * e
    np.testing.assert_allclose(h, expected, rtol=1e-9, atol=1e-9)


def test_the_gains_of_the_thesis():
    """20 and 100 per minute, 100 and 2500: c1 = 2 K and c2 = K^2 with K = 10 and 50 per minute."""
    arm, v = PlanarArm([1.0, 1.0]), np.array([0.3, 0.1])
    for K, c1, c2 in ((10.0, 20.0, 100.0), (50.0, 100.0, 2500.0)):
        state = arm.at(np.array([0.2, 0.3]), v)
        _, h = asked(OrientationTask(0.7, gain=K), state, 0.0, "acceleration")
        np.testing.assert_allclose(h, -c1 * 0.4 + c2 * (0.7 - 0.5))


@pytest.mark.parametrize("gain", [0.5, 2.0])
def test_velocity_order_reduces_the_error_at_rate_K(gain):
    stack = PositionTask([0.7, 0.3], gain=gain) >> OrientationTask(0.5, gain=2 * gain)
    controller = Controller(ARM, stack, dt=1e-3, backend="pseudoinverse")
    record = simulate(controller, [0.4, 0.5, -0.3, 0.2], duration=1.0, certify=0)
    for name, rate in (("position", gain), ("orientation", 2 * gain)):
        error = record.errors[name]
        expected = error[0] * np.exp(-rate * record.t)[:, None]
        np.testing.assert_allclose(error, expected, atol=3e-3 * np.abs(error[0]).max())


@pytest.mark.parametrize("zeta", [0.5, 1.0, 1.5])
def test_acceleration_order_follows_eq_4_5(zeta):
    K = 3.0
    stack = PositionTask([0.7, 0.3], gain=K, damping_ratio=zeta) >> OrientationTask(0.5, gain=K, damping_ratio=zeta)
    controller = Controller(ARM, stack, order="acceleration", dt=1e-3, backend="pseudoinverse")
    record = simulate(controller, [0.4, 0.5, -0.3, 0.2], duration=1.0, certify=0)
    roots = np.roots([1.0, 2 * zeta * K, K**2]).astype(complex)
    if zeta == 1.0:
        shape = (1 + K * record.t) * np.exp(-K * record.t)
    else:  # e(0) = 1, e_dot(0) = 0
        weights = np.array([-roots[1], roots[0]]) / (roots[0] - roots[1])
        shape = np.real(np.exp(np.outer(record.t, roots)) @ weights)
    for error in record.errors.values():
        np.testing.assert_allclose(error, shape[:, None] * error[0], atol=4e-3 * np.abs(error[0]).max())


def test_a_task_of_ones_own():
    controller = Controller(ARM, ElbowHeight(gain=2.0), order="acceleration", dt=1e-3, backend="pseudoinverse")
    record = simulate(controller, [0.9, 0.5, -0.3, 0.2], duration=5.0, certify=0)
    assert abs(ARM.points(record.q[-1])[1, 1] - 0.2) < 1e-3
    assert record.errors["elbowheight"].shape == (5001, 1)


def test_eq_4_8_is_the_hierarchy_with_joint_motion():
    tip, phi = PositionTask([0.6, 0.2], gain=2.0), OrientationTask(1.0, gain=3.0)
    formula = Controller(ARM, tip >> phi, order="acceleration", backend="pseudoinverse:joint")
    stack = Controller(ARM, tip >> JointMotion(phi), order="acceleration", backend="pseudoinverse")
    qp = Controller(ARM, tip >> JointMotion(phi), order="acceleration", damping=None)
    for _ in range(20):
        q, v = RNG.uniform(-2, 2, (2, 4))
        J1, J2 = ARM.jacobian(q)[:2], ARM.jacobian(q)[2:]
        h1, h2 = (asked(task, ARM.at(q, v), 0.0, "acceleration")[1] for task in (tip, phi))
        eq_4_8 = np.linalg.pinv(J1) @ h1 + (np.eye(4) - np.linalg.pinv(J1) @ J1) @ np.linalg.pinv(J2) @ h2
        for controller in (formula, stack, qp):
            np.testing.assert_allclose(controller(q, v).a, eq_4_8, rtol=1e-9, atol=1e-9)
        assert stack(q, v).solution.certify().ok


@pytest.mark.parametrize("task", [PositionTask([0.6, 0.2], gain=2.0), OrientationTask(1.0, gain=3.0)], ids=repr)
def test_joint_motion_is_what_the_task_does_alone(task):
    for order in ("velocity", "acceleration"):
        q, v = RNG.uniform(-2, 2, (2, 4))
        alone = Controller(ARM, task, order=order, backend="pseudoinverse")(q, v).solution.x
        motion = Controller(ARM, JointMotion(task), order=order, backend="pseudoinverse")(q, v).solution.x
        np.testing.assert_allclose(motion, alone, rtol=1e-10, atol=1e-12)


def test_joint_motion_of_a_singular_task_stays_bounded():
    straight = PlanarArm([1.0, 1.0])
    controller = Controller(straight, JointMotion(PositionTask([3.0, 0.0], gain=1.0)), backend="pseudoinverse")
    for angle in (0.0, 0.7, 1.9):  # stretched out: round-off alone keeps J from rank one
        assert np.abs(controller([angle, 0.0], [0.0, 0.0]).v).max() < 3.0


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: PositionTask([1, 0], gain=0.0), r"PositionTask 'position': gain = 0.0 1/s must be positive"),
        (lambda: PositionTask([1, 0], gain=[1.0, -2.0]), r"gain\[1\] = -2.0 1/s"),
        (lambda: PositionTask([1, 0], gain=np.nan, name="hand"), "PositionTask 'hand': gain = nan"),
        (lambda: PositionTask([1, 0], gain=[1.0, 1.0, 1.0]), r"gain has shape \(3,\)"),
        (lambda: OrientationTask(0.0, gain=1.0, weight=-1.0), "weight = -1.0 must not be negative"),
        (lambda: OrientationTask(0.0, gain=1.0, weight=[1.0, 1.0]), r"weight has shape \(2,\)"),
        (lambda: OrientationTask(0.0, gain=1.0, damping_ratio=-1.0), "damping ratio = -1.0"),
        (lambda: OrientationTask(0.0, gain=1.0, damping_ratio=[1.0]), "damping ratio has shape"),
        (lambda: OrientationTask([0.0, 1.0], gain=1.0), r"target has shape \(2,\); it must be \(3, 3\), or \(1,\)"),
        (lambda: PositionTask([1, 0], gain=1e200), r"gain = 1e\+200 1/s must be positive and at most 1e\+15"),
        (lambda: PositionTask([1, 0], gain=[1.0, 1e16]), r"gain\[1\] = 1e\+16 1/s must be positive and at most 1e\+15"),
        (lambda: PositionTask([1, 0], gain=1.0, name=5), "name of a PositionTask = 5 is a int; it must be a str"),
        (lambda: JointMotion("no"), "JointMotion takes a Task, not a str"),
    ],
)
def test_refuses_numbers_that_mean_nothing(make, named):
    with pytest.raises(InvalidInput, match=named):
        make()


def test_refuses_what_does_not_fit_the_robot():
    with pytest.raises(InvalidInput, match=r"PostureTask 'posture': target has shape \(3,\); the robot takes \(4,\)"):
        Controller(ARM, PostureTask([0, 0, 0], gain=1.0), backend="pseudoinverse")
    with pytest.raises(InvalidInput, match=r"ElbowHeight 'elbowheight': jacobian has shape \(1, 4\).*\(1, 2\)"):
        Controller(PlanarArm([1, 1]), ElbowHeight(gain=1.0), backend="pseudoinverse")
    with pytest.raises(NotImplementedError, match="Task must define error"):
        Controller(ARM, Task(gain=1.0), backend="pseudoinverse")


@pytest.mark.parametrize("rows", [-1, 0, 2.0, True, "2"])
def test_a_task_has_a_positive_number_of_rows(rows):
    strange = type("StrangeTask", (ElbowHeight,), {"rows": rows})
    with pytest.raises(InvalidInput, match=r"StrangeTask 'strange': rows = .* must be an integer of at least 1"):
        strange(gain=1.0)


ILL_SHAPED = {
    "error": (lambda self, state, t: np.zeros(2), r"error has shape \(2,\); with this robot it must be \(1,\)"),
    "jacobian": (lambda self, state: [["a"] * 4], "jacobian is not an array of real numbers"),
    "drift": (lambda self, state: np.zeros(2), r"drift has shape \(2,\); with this robot it must be \(1,\) or \(\)"),
    "feedforward": (lambda self, t: (np.zeros(3), 0.0), r"feedforward velocity has shape \(3,\).*\(1,\) or \(\)"),
}


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("method", ILL_SHAPED)
def test_what_a_task_of_ones_own_gives_is_tried_before_the_first_tick(method, order):
    gives, named = ILL_SHAPED[method]
    task = type("OwnTask", (ElbowHeight,), {method: gives})(gain=1.0)
    if method == "drift" and order == "velocity":
        assert Controller(ARM, task, order=order)([0.0] * 4, [0.0] * 4).ok  # the drift is not asked for
        return
    with pytest.raises(InvalidInput, match=f"OwnTask 'own': {named}"):
        Controller(ARM, task, order=order)


@pytest.mark.parametrize(
    ("gives", "named"),
    [
        (lambda self, t: (0.0, np.zeros(3)), r"feedforward acceleration has shape \(3,\)"),
        (lambda self, t: 3, r"feedforward = 3 must be \(velocity, acceleration\)"),
        (lambda self, t: None, r"feedforward = None must be"),
        (lambda self, t: ("a", 0.0), "feedforward velocity is not an array of real numbers"),
    ],
)
def test_refuses_a_feedforward_that_is_none(gives, named):
    task = type("OwnTask", (ElbowHeight,), {"feedforward": gives})(gain=1.0)
    with pytest.raises(InvalidInput, match=f"OwnTask 'own': {named}"):
        Controller(ARM, task)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_lists_are_as_good_as_arrays(order):
    class Lists(ElbowHeight):
        def jacobian(self, state):
            return super().jacobian(state).tolist()

        def drift(self, state):
            return super().drift(state).tolist()

        def feedforward(self, t):
            return [0.1], [0.2]

    class Arrays(ElbowHeight):
        def feedforward(self, t):
            return np.array([0.1]), np.array([0.2])

    answers = [
        Controller(ARM, part, order=order, backend="pseudoinverse")([0.9, 0.5, -0.3, 0.2], [0.1, 0.2, 0.3, 0.4])
        for kind in (Lists, Arrays)
        for part in (kind(gain=1.0), JointMotion(kind(gain=1.0)))
    ]
    for step in answers[1:]:
        np.testing.assert_allclose(step.solution.x, answers[0].solution.x, rtol=1e-12, atol=1e-14)


def test_weights_decide_inside_a_level_only():
    high, low = ElbowHeight(gain=1.0, weight=10.0, name="a"), OrientationTask(1.0, gain=1.0, weight=0.5)
    hierarchy = Controller(ARM, high + low, backend="pseudoinverse").hierarchy
    assert isinstance(hierarchy, hqp.Hierarchy)
    np.testing.assert_array_equal(hierarchy.levels[0].weights, [10.0, 0.5])


WRONG = {
    "error": [0.1, np.zeros(2), np.zeros((1, 1)), None, "far", np.array([1j])],
    "jacobian": [1.0, np.ones(3), np.ones((3, 1)), np.ones((2, 3)), None],
    "feedforward": [0.0, (0.0,), (np.zeros(2), 0.0), (0.0, np.zeros((1, 1))), None],
    "drift": [np.zeros(2), "fast"],
}


@pytest.mark.parametrize(("method", "value"), [(word, value) for word, values in WRONG.items() for value in values])
def test_what_a_method_returns_is_held_to_its_shape_at_every_tick(method, value) -> None:
    """As at the first one: numpy would spread a number over all joints, or drop an imaginary part."""
    later = [False]

    def own(self, *at):
        return value if later[0] else getattr(ElbowHeight, method)(self, *at)

    task = type("Own", (ElbowHeight,), {method: own})(gain=2.0)
    controller = Controller(ARM, task, order="acceleration", dt=0.01)
    assert controller([0.1, 0.2, 0.3, 0.4], np.ones(4)).ok
    later[0] = True
    with pytest.raises(InvalidInput, match=f"Own 'own': {method}"):
        controller([0.1, 0.2, 0.3, 0.4], np.ones(4), 0.01)


@pytest.mark.parametrize("method", ["measure", "feedforward"])
def test_a_method_that_nothing_asks_for_is_refused(method) -> None:
    """A class whose rows come from loops has its error from them, not from what its base class would ask."""
    for base in PositionTask([0.6, 0.2], gain=2.0), PostureTask(np.zeros(4), gain=2.0):
        kind = type("Own", (type(base),), {method: lambda self, at: np.zeros(2)})
        task = kind(base.target, gain=2.0)
        with pytest.raises(InvalidInput, match=rf"Own has its own {method}\(\)"):
            Controller(ARM, task, dt=0.01)
