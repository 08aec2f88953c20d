"""The controller: one call a tick, refusals at once, numbers never raise."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import hqp
from hqp import InvalidInput, Status
from tasks import Controller, JointMotion, JointVelocityLimit, Line, OrientationTask, PlanarArm, PositionTask

ARM = PlanarArm([0.5, 0.4, 0.3])
Q, V = [0.3, 0.5, -0.4], [0.2, -0.9, 1.0]


def stack():
    return PositionTask([0.6, 0.2], gain=2.0) >> OrientationTask(1.0, gain=3.0)


def test_a_step_says_what_was_asked_for():
    step = Controller(ARM, stack(), backend="pseudoinverse")(Q, V)
    assert (step.order, step.a) == ("velocity", None)
    np.testing.assert_array_equal(step.v, step.solution.x)
    step = Controller(ARM, stack(), order="acceleration", backend="pseudoinverse")(Q, V)
    assert (step.order, step.v) == ("acceleration", None)
    np.testing.assert_array_equal(step.a, step.solution.x)
    assert step.ok
    with pytest.raises(AttributeError):
        step.a = None


def test_the_answer_is_certified_and_meets_both_tasks():
    step = Controller(ARM, stack(), damping=None)(Q, V)
    assert step.solution.certify().ok
    np.testing.assert_allclose(ARM.jacobian(Q)[:2] @ step.v, 2.0 * ([0.6, 0.2] - ARM.pose(Q)[:2]), atol=1e-8)
    np.testing.assert_allclose(step.v.sum(), 3.0 * (1.0 - sum(Q)), atol=1e-8)


def test_torques_are_those_of_the_accelerations():
    controller = Controller(ARM, stack(), order="acceleration", backend="pseudoinverse", torque=True)
    step = controller(Q, V)
    np.testing.assert_array_equal(step.tau, ARM.inverse_dynamics(Q, V, step.a))
    assert "torque=True" in repr(controller)
    assert Controller(ARM, stack(), order="acceleration", backend="pseudoinverse")(Q, V).tau is None


class Bare:
    """An arm that keeps to the protocol."""

    nq = nv = 3
    velocity_limit = acceleration_limit = position_limit = None
    at = staticmethod(ARM.at)


@pytest.mark.parametrize(
    ("robot", "options", "named"),
    [
        (ARM, {"torque": True}, "torque = True, but order = 'velocity' gives no accelerations"),
        (ARM, {"torque": 1, "order": "acceleration"}, "torque = 1 must be True or False"),
        (Bare(), {"torque": True, "order": "acceleration"}, r"torque = True, but .*Bare.* has no inverse_dynamics"),
    ],
)
def test_refuses_torques_that_cannot_be_told(robot, options, named):
    with pytest.raises(InvalidInput, match=named):
        Controller(robot, stack(), **options)


def test_the_bounds_of_a_part_are_those_of_the_last_tick():
    speed, reach = JointVelocityLimit(1.0), PositionTask([0.6, 0.2], gain=2.0)
    controller = Controller(ARM, JointVelocityLimit(3.0) + speed >> reach, order="acceleration", dt=0.1)
    step = controller(Q, V)
    lower, upper = controller.bounds(speed)
    np.testing.assert_allclose(lower, (-1.0 - np.array(V)) / 0.1)
    np.testing.assert_allclose(upper, (1.0 - np.array(V)) / 0.1)
    lower, upper = controller.bounds(reach)
    np.testing.assert_array_equal(lower, step.solution.hierarchy.levels[1].lower)
    np.testing.assert_array_equal(lower, upper)
    with pytest.raises(InvalidInput, match=r"PositionTask.* is not in the stack JointVelocityLimit"):
        controller.bounds(PositionTask([0.6, 0.2], gain=2.0))


def test_a_single_task_is_a_stack():
    assert len(Controller(ARM, PositionTask([0.6, 0.2], gain=2.0), backend="pseudoinverse").stack) == 1


def test_steps_keep_their_numbers_when_the_hierarchy_is_refilled():
    controller = Controller(ARM, stack(), backend="pseudoinverse")
    first = controller(Q, V)
    numbers = first.solution.hierarchy.A.copy()
    second = controller([1.0, 1.0, 1.0], V)
    np.testing.assert_array_equal(first.solution.hierarchy.A, numbers)
    assert not np.array_equal(second.solution.hierarchy.A, numbers)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300])
@pytest.mark.parametrize("where", ["q", "v"])
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_numbers_never_raise(bad, where, order):
    tasks = PositionTask([0.6, 0.2], gain=2.0) >> JointMotion(PositionTask([0.1, 0.2], gain=1.0))
    controller = Controller(ARM, tasks, order=order, backend="pseudoinverse")
    q, v = list(Q), list(V)
    (q if where == "q" else v)[1] = bad
    step = controller(q, v)
    if where == "v" and order == "velocity":
        assert step.ok  # the velocity is not asked for
    elif not np.isfinite(bad):
        assert step.solution.status is Status.INVALID
        assert "level 0 ('position'), row 0" in step.solution.message
    assert controller(Q, V).ok  # and the next tick is as good as ever


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"order": "force"}, "order = 'force'; it must be one of 'velocity', 'acceleration', 'torque'"),
        ({"dt": 0.0}, "dt = 0.0 s must be positive"),
        ({"dt": np.nan}, "dt = nan"),
        ({"dt": "a"}, "dt is not an array of real numbers"),
        ({"settings": 3}, "settings = 3 is a int; it must be a Settings"),
        ({"backend": "magic"}, "unknown backend 'magic'; installed here: .*pseudoinverse"),
    ],
)
def test_refuses_bad_options(options, named):
    with pytest.raises(InvalidInput, match=named):
        Controller(ARM, stack(), **options)


def test_refuses_states_of_the_wrong_length():
    controller = Controller(ARM, stack(), backend="pseudoinverse")
    with pytest.raises(InvalidInput, match=r"q has shape \(2,\); the robot takes \(3,\)"):
        controller(Q[:2], V)
    with pytest.raises(InvalidInput, match=r"v has shape \(4,\)"):
        controller(Q, [*V, 0.0])
    with pytest.raises(InvalidInput, match="q is not an array of real numbers"):
        controller(["a", 0, 0], V)


@pytest.mark.parametrize("t", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("target", [[0.6, 0.2], Line([0.6, 0.2], [0.2, 0.6], 1.0)], ids=["still", "moving"])
def test_a_time_that_is_none_is_a_status(t, order, target):
    controller = Controller(ARM, PositionTask(target, gain=2.0), order=order)
    before = controller(Q, V, 0.3)
    step = controller(Q, V, t)
    assert step.solution.status is Status.INVALID
    assert step.solution.message == f"t = {t} s must be finite"
    np.testing.assert_array_equal(step.solution.x, 0.0)
    np.testing.assert_allclose(controller(Q, V, 0.3).solution.x, before.solution.x, atol=1e-9)


@pytest.mark.parametrize("t", ["a", None, [0.0, 1.0], 1j])
def test_refuses_times_that_are_no_number(t):
    with pytest.raises(InvalidInput, match=r"t (is not|has shape)"):
        Controller(ARM, stack(), backend="pseudoinverse")(Q, V, t)


@pytest.mark.parametrize("robot", [None, [1, 1], 3, PlanarArm])
def test_refuses_what_is_no_robot(robot):
    with pytest.raises(InvalidInput, match=r"robot = .* a robot has nq, nv and at\(q, v\)"):
        Controller(robot, stack())


def test_refuses_a_robot_without_joints():
    class Rock:
        nq, nv, at = 0, 0, None

    with pytest.raises(InvalidInput, match="nq of the robot = 0 must be an integer of at least 1"):
        Controller(Rock(), stack())


@pytest.mark.parametrize("nothing", [None, 3, [PositionTask([0.6, 0.2], gain=2.0)]])
def test_refuses_what_is_no_stack(nothing):
    with pytest.raises(InvalidInput, match="a stack takes tasks, limits and stacks"):
        Controller(ARM, nothing)


def test_an_inequality_for_a_closed_form_is_a_status():
    step = Controller(ARM, JointVelocityLimit(1.0) >> stack(), backend="pseudoinverse")(Q, V)
    assert step.solution.status is Status.UNSUPPORTED
    assert "level 0 ('velocity'), row 0 is an inequality" in step.solution.message


def test_the_default_backend_is_the_librarys():
    assert Controller(ARM, stack()).backend == hqp.DEFAULT_BACKEND


def test_importing_tasks_is_light():
    heavy = ("matplotlib", "scipy", "rich", "typer", "proxsuite")
    code = f"import sys, tasks; print([name for name in {heavy} if name in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
