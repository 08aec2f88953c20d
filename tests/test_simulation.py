"""The closed loop: its integrator, its record, and how it ends."""

from __future__ import annotations

import re

import numpy as np
import pytest

from hqp import InvalidInput, Side, Status
from tasks import (
    Controller,
    JointAccelerationLimit,
    JointVelocityLimit,
    Line,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    Task,
    simulate,
)

ARM = PlanarArm([0.5, 0.4, 0.3])
Q = np.array([0.3, 0.5, -0.4])


def controller(*parts, order="acceleration", dt=0.01, backend="pseudoinverse"):
    stack = parts[0]
    for part in parts[1:]:
        stack = stack >> part
    return Controller(ARM, stack, order=order, dt=dt, backend=backend, damping=None)


def constant_acceleration(a):
    """A posture that is asked to accelerate by a: q_d with error 0 at all times."""
    a = np.asarray(a, dtype=float)
    return PostureTask(lambda t: (Q + 0.5 * a * t * t, a * t, a), gain=1.0)


def test_the_integrator_is_exact_for_constant_acceleration():
    a = np.array([0.5, -0.2, 0.1])
    record = simulate(controller(constant_acceleration(a), dt=0.1), Q, duration=2.0)
    t = record.t[:, None]
    np.testing.assert_allclose(record.q, Q + 0.5 * a * t**2, atol=1e-13)
    np.testing.assert_allclose(record.v, a * t, atol=1e-13)
    np.testing.assert_allclose(record.a, np.tile(a, (20, 1)), atol=1e-12)


def test_velocity_order_integrates_its_commands():
    record = simulate(controller(PositionTask([0.6, 0.2], gain=2.0), order="velocity"), Q, duration=0.5)
    np.testing.assert_allclose(np.diff(record.q, axis=0), 0.01 * record.v[1:], atol=1e-15)
    np.testing.assert_allclose(np.diff(record.v, axis=0), 0.01 * record.a, atol=1e-13)


def test_the_record():
    path = Line([0.8, 0.3], [0.5, 0.4], 1.0)
    record = simulate(
        controller(PositionTask(path, gain=5.0), OrientationTask(1.0, gain=5.0), OrientationTask(0.0, gain=1.0)),
        Q,
        duration=1.0,
        certify=10,
    )
    assert len(record) == 100
    assert record.t.shape == (101,)
    assert record.t[-1] == pytest.approx(1.0)
    assert record.q.shape == record.v.shape == (101, 3)
    assert record.a.shape == (100, 3)
    assert list(record.errors) == ["position", "orientation", "orientation 2"]
    np.testing.assert_allclose(record.pose, [ARM.pose(q) for q in record.q], atol=1e-14)
    desired = np.array([path(t)[0] for t in record.t])
    np.testing.assert_allclose(record.errors["position"], desired - record.pose[:, :2], atol=1e-14)
    assert set(record.status) == {Status.OPTIMAL}
    assert (record.checked, record.certified, record.certified_share) == (10, 10, 1.0)
    assert record.stopped is None
    assert record.diverged_at is None
    with pytest.raises(ValueError, match="read-only"):
        record.q[0, 0] = 1.0


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_the_record_tells_torques_and_manipulability(order):
    record = simulate(controller(PositionTask([0.6, 0.2], gain=2.0), order=order), Q, duration=0.5)
    tau = [ARM.inverse_dynamics(q, v, a) for q, v, a in zip(record.q, record.v, record.a, strict=False)]
    np.testing.assert_allclose(record.tau, tau, atol=1e-12)
    np.testing.assert_allclose(record.manipulability, [ARM.manipulability(q) for q in record.q], atol=1e-14)
    assert record.tau.shape == (50, 3)
    assert record.manipulability.shape == (51,)
    with pytest.raises(ValueError, match="read-only"):
        record.tau[0, 0] = 1.0


class Bare:
    """An arm that keeps to the protocol and can do nothing else."""

    nq = nv = 3
    velocity_limit = acceleration_limit = position_limit = None
    at = staticmethod(ARM.at)


class Careless(Bare):
    """A robot that looks at the joints which it knows, however many it is given."""

    @staticmethod
    def at(q, v):
        return ARM.at(q[:3], v[:3])


@pytest.mark.parametrize(("q0", "v0", "named"), [(np.zeros(4), None, "q"), (Q, np.zeros(4), "v")])
def test_refuses_a_start_of_the_wrong_length_whatever_the_robot_says(q0, v0, named):
    tick = Controller(Careless(), PositionTask([0.6, 0.2], gain=2.0), dt=0.01, backend="pseudoinverse", damping=None)
    with pytest.raises(InvalidInput, match=rf"{named} has shape \(4,\); the robot takes \(3,\)"):
        simulate(tick, q0, v0, duration=0.1)


def test_a_robot_need_not_tell_torques_and_manipulability():
    tick = Controller(Bare(), PositionTask([0.6, 0.2], gain=2.0), dt=0.01, backend="pseudoinverse", damping=None)
    record = simulate(tick, Q, duration=0.1)
    assert len(record) == 10
    assert record.tau is None
    assert record.manipulability is None


@pytest.mark.parametrize("method", ["inverse_dynamics", "manipulability"])
def test_a_method_that_takes_no_record_is_refused_before_the_run(method):
    robot = Bare()
    setattr(robot, method, lambda *values: np.zeros(7))
    tick = Controller(robot, PositionTask([0.6, 0.2], gain=2.0), dt=0.01, backend="pseudoinverse", damping=None)
    with pytest.raises(InvalidInput, match=rf"{method} of the robot, .* gives shape \(7,\); it must take leading axes"):
        simulate(tick, Q, duration=0.1)
    setattr(robot, method, lambda q: 1.0 / len(q[0][0]))
    with pytest.raises(InvalidInput, match=rf"{method} of the robot, .* raised TypeError: .*leading axes"):
        simulate(tick, Q, duration=0.1)


def test_the_degrees_of_every_level():
    stack = PositionTask([0.6, 0.2], gain=2.0), OrientationTask(0.4, gain=2.0), PostureTask(Q, gain=1.0)
    record = simulate(controller(*stack), Q, duration=0.5, certify=10)
    np.testing.assert_allclose(record.checked_t, [0.0, 0.1, 0.2, 0.3, 0.4])
    np.testing.assert_array_equal(record.ranks, np.tile([2, 1, 0], (5, 1)))
    np.testing.assert_array_equal(record.degrees.manipulability, record.ranks)
    np.testing.assert_array_equal(record.degrees.redundancy, np.tile([1, 0, 0], (5, 1)))


def test_a_stretched_arm_has_lost_a_direction():
    record = simulate(controller(PositionTask([1.2, 0.0], gain=1.0), order="velocity"), np.zeros(3), duration=0.01)
    assert record.ranks.tolist() == [[1]]
    assert record.degrees.redundancy.tolist() == [[2]]
    np.testing.assert_allclose(record.manipulability, 0.0, atol=1e-15)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_the_active_limits_are_those_of_the_solutions(order):
    limits = [JointVelocityLimit(0.8), JointVelocityLimit(0.6), JointAccelerationLimit(3.0)]
    tick = Controller(
        ARM, limits[0] + limits[1] + limits[2] >> PositionTask([0.2, 0.7], gain=3.0), order=order, dt=0.02, damping=None
    )
    sides = []

    def proof(solution):
        sides.append(solution.levels[0].active.reshape(3, 3))
        return solution.certify().ok

    record = simulate(tick, Q, duration=2.0, certify=1, proof=proof)
    assert record.certified_share == 1.0
    assert list(record.active) == ["velocity", "velocity 2", "acceleration"]
    for limit, active in enumerate(record.active.values()):
        assert active.shape == (100, 3)
        assert active.dtype == np.int8
        np.testing.assert_array_equal(active, np.array(sides)[:, limit])
    assert not record.active["velocity"].any()
    for name in "velocity 2", "acceleration":
        assert 0.01 < np.mean(record.active[name] != Side.INACTIVE) < 0.99
    assert {Side.LOWER, Side.UPPER} <= {side for active in record.active.values() for side in active.flat}
    on = record.active["velocity 2"] == Side.UPPER
    np.testing.assert_allclose(record.v[1:][on], 0.6, rtol=1e-6)


def test_names_in_the_record_are_never_the_same():
    names = "a", "a", "a 2", "a"
    stack = [OrientationTask(1.0, gain=1.0, name=name) for name in names]
    record = simulate(controller(*stack), Q, duration=0.01)
    assert list(record.errors) == ["a", "a 2", "a 2 2", "a 3"]


def test_certification_can_be_switched_off_or_judged_elsewhere():
    tick = controller(PositionTask([0.6, 0.2], gain=2.0))
    unchecked = simulate(tick, Q, duration=0.1, certify=0)
    assert np.isnan(unchecked.certified_share)
    assert unchecked.ranks.shape == unchecked.degrees.redundancy.shape == (0, 1)
    assert simulate(tick, Q, duration=0.1, certify=1, proof=lambda solution: False).certified_share == 0.0


def test_a_run_that_diverges_stops_and_keeps_what_it_had():
    record = simulate(controller(constant_acceleration([50.0, 0.0, 0.0]), dt=0.01), Q, duration=1.0, speed_cap=10.0)
    assert record.stopped is not None
    assert record.diverged_at == pytest.approx(0.2, abs=0.011)
    assert "diverged" in record.stopped.reason
    assert len(record.t) == len(record.q) == len(record.a) + 1 == len(record.status) + 1 == len(record.tau) + 1
    assert np.isfinite(record.q).all()
    assert np.abs(record.v).max() <= 10.0
    assert record.t[-1] < record.diverged_at


def test_a_solver_without_an_answer_stops_the_run():
    tick = controller(JointVelocityLimit(1.0), PositionTask([0.6, 0.2], gain=2.0))
    record = simulate(tick, Q, duration=1.0)
    assert record.stopped is not None
    assert not record.stopped.diverged
    assert "unsupported" in record.stopped.reason
    assert "inequality" in record.stopped.reason
    assert len(record) == len(record.tau) == len(record.active["velocity"]) == 0
    np.testing.assert_array_equal(record.q, [Q])


def test_a_target_that_breaks_stops_the_run():
    def broken(t):
        return np.full(2, 0.5 if t < 0.05 else np.nan), np.zeros(2), np.zeros(2)

    record = simulate(controller(PositionTask(broken, gain=1.0)), Q, duration=0.2)
    assert record.stopped is not None
    assert "invalid" in record.stopped.reason
    assert "level 0 ('position'), row 0" in record.stopped.reason
    assert len(record) == 5


def test_progress_is_told():
    told = []
    simulate(controller(PositionTask([0.6, 0.2], gain=2.0)), Q, duration=2.0, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert 50 <= len(told) <= 200


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"duration": 0.0}, "duration = 0.0 s must be positive"),
        ({"duration": 0.001}, "shorter than one tick"),
        ({"speed_cap": -1.0}, "speed cap = -1.0"),
        ({"duration": 1e300}, "duration = 1e+300 s must be positive and at most"),
        ({"duration": 1e12}, "duration = 1e+12 s is more than 10000000 ticks of dt = 0.01 s"),
        ({"duration": "a"}, "duration is not an array of real numbers"),
        ({"start": "a"}, "start is not an array of real numbers"),
        ({"start": np.nan}, "start = nan must be finite"),
        ({"start": [0.0]}, "start has shape (1,); it must be one number"),
        ({"proof": 3}, "proof = 3 is a int; it must be a function"),
        ({"progress": 3}, "progress = 3 is a int; it must be a function"),
        ({"certify": 1.5}, "certify = 1.5 must be an integer"),
        ({"certify": -1}, "certify = -1 must be an integer of at least 0"),
        ({"q0": [0.0, np.nan, 0.0]}, "q0[1] = nan must be finite"),
        ({"q0": [0.0]}, "q has shape (1,)"),
        ({"v0": [0.0]}, "v has shape (1,)"),
    ],
)
def test_refuses_bad_options(change, named):
    options = {"q0": Q, "duration": 1.0} | change
    with pytest.raises(InvalidInput, match=re.escape(named)):
        simulate(controller(PositionTask([0.6, 0.2], gain=2.0)), options.pop("q0"), **options)


def test_refuses_a_controller_without_a_tick():
    with pytest.raises(InvalidInput, match="give the controller dt"):
        simulate(
            Controller(ARM, PositionTask([0.6, 0.2], gain=2.0), backend="pseudoinverse", damping=None), Q, duration=1.0
        )


@pytest.mark.parametrize("no_controller", [None, 3, ARM])
def test_refuses_what_is_no_controller(no_controller):
    with pytest.raises(InvalidInput, match=r"controller = .* it must be a Controller"):
        simulate(no_controller, Q, duration=1.0)


@pytest.mark.parametrize("error", [RuntimeError("the sensor broke"), KeyboardInterrupt()])
@pytest.mark.parametrize("where", ["target", "progress"])
def test_an_exception_midway_has_the_record_until_then(error, where):
    """It goes on as it is; and what was run before it is that of a run which ends there."""

    def broken(t):
        if t > 0.0955:
            raise error
        return np.array([1.0, 0.2]), np.zeros(2), np.zeros(2)

    target = broken if where == "target" else [1.0, 0.2]
    controller = Controller(ARM, PositionTask(target, gain=3.0), dt=0.01)
    told = {"progress": broken} if where == "progress" else {}
    with pytest.raises(type(error)) as raised:
        simulate(controller, [1.1, -1.3, -0.7], duration=1.0, **told)
    assert raised.value is error
    record = error.record
    whole = simulate(Controller(ARM, PositionTask([1.0, 0.2], gain=3.0), dt=0.01), [1.1, -1.3, -0.7], duration=1.0)
    assert 9 <= len(record.t) <= 11
    np.testing.assert_array_equal(record.q, whole.q[: len(record.t)])
    np.testing.assert_array_equal(record.a, whole.a[: len(record.t) - 1])
    assert record.stopped.reason.startswith(f"{type(error).__name__} at t = ")
    assert "record" in error.__notes__[0]
    del error.record, error.__notes__


def test_a_run_asks_tasks_only_at_its_own_times():
    """An error of one's own may be of the time of day, and know nothing of t = 0."""
    asked = []

    class Own(Task):
        rows = 1

        def error(self, state, t):
            asked.append(t)
            return 0.6 - state.frame().position[:1]

        def jacobian(self, state):
            return state.frame().linear[:1]

    loop = controller(Own(gain=2.0), order="velocity")
    asked.clear()
    simulate(loop, Q, duration=0.1, start=50.0)
    assert min(asked) == 50.0
