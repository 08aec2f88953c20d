"""Rows of limits on any levels: the law of the envelope in NumPy beside the loop, and numbers that are live."""

from __future__ import annotations

import pickle
from functools import cache, reduce
from itertools import permutations
from operator import add, rshift
from typing import Any

import numpy as np
import pytest

from hqp import InvalidInput, Side
from tasks import (
    BoxLimit,
    Controller,
    FrameVelocityLimit,
    JointAccelerationLimit,
    JointLimits,
    JointPositionLimit,
    JointTorqueLimit,
    JointVelocityLimit,
    PlanarArm,
    PlaneLimit,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
)
from tasks.robots.robot import joint_names, joint_positions, positioned

DT = 0.01
ORDERS = ["velocity", "acceleration"]
KINDS = {"acceleration": JointAccelerationLimit, "position": JointPositionLimit, "velocity": JointVelocityLimit}


@cache
def robot(name: str) -> Any:
    if name == "planar":
        limits = {"position_limit": (-1.5, [1.5, np.inf, 1.2]), "velocity_limit": [1.0, 1.5, 2.0]}
        return PlanarArm([0.5, 0.4, 0.3], **limits, acceleration_limit=15.0, masses=[3, 2, 1], torque_limit=9.0)
    lock = {"lock": ["panda_finger_joint1"]} if name == "panda" else {}
    return load_robot(name, acceleration_limit=20.0, **lock)


def states(name: str, count: int = 5) -> list[Any]:
    """Random ones, some of them beyond the ranges, some far too fast."""
    arm, rng = robot(name), np.random.default_rng(7)
    found = []
    for _ in range(count):
        q = (
            rng.uniform(-2.0, 2.0, 3)
            if name == "planar"
            else arm.integrate(arm.random(rng), rng.normal(0, 0.1, arm.nv))
        )
        found.append((q, rng.normal(0.0, 10 ** rng.uniform(-1.0, 0.7), arm.nv)))
    return found


def furthest(room, acceleration):
    """p_max by search: the largest number of whole steps that leaves room, and the speed that uses all of it."""
    steps, rate = acceleration * DT, room / DT
    m = np.zeros_like(room)
    for k in range(1, 400):
        m = np.where(rate >= steps * k * (k + 1) / 2, k, m)
    with np.errstate(invalid="ignore"):
        return np.where(np.isinf(room), np.inf, (rate + steps * m * (m + 1) / 2) / (m + 1))


def asked(kind: str, arm: Any, state: Any, order: str) -> tuple[Any, Any]:
    """Least and most x of every joint by one limit of the robot's own, by itself."""
    v, q = state.v, joint_positions(state)
    if kind == "position":
        low, high = arm.position_limit
        ahead = q + 0.5 * DT * v if order == "acceleration" else q
        rooms = ahead - low, high - ahead
        below, above = (furthest(room, arm.acceleration_limit) for room in rooms)
        into, down = (furthest(-room, arm.acceleration_limit) for room in rooms)
        back = np.minimum(0.5, arm.velocity_limit)
        least = -np.where(below >= 0.0, below, -np.minimum(np.minimum(back, into), np.maximum(above, 0.0)))
        most = np.where(above >= 0.0, above, -np.minimum(np.minimum(back, down), np.maximum(below, 0.0)))
    elif kind == "velocity":
        least, most = -arm.velocity_limit, arm.velocity_limit
    else:
        least, most = -arm.acceleration_limit, arm.acceleration_limit
        return (least, most) if order == "acceleration" else (v + DT * least, v + DT * most)
    return (least, most) if order == "velocity" else ((least - v) / DT, (most - v) / DT)


def reconciled(kinds: tuple[str, ...], arm: Any, state: Any, order: str) -> dict[str, tuple[Any, Any]]:
    """The same of several limits, each relaxed so far that it meets the harder ones."""
    infinite = np.full(arm.nv, np.inf)
    reach = asked("acceleration", arm, state, order)
    least, most = reach if {"acceleration", "position"} & set(kinds) else (-infinite, infinite)
    found = {}
    for kind in [kind for kind in KINDS if kind in kinds]:
        low, high = asked(kind, arm, state, order)
        found[kind] = low, high = np.minimum(low, most), np.maximum(high, least)
        least, most = np.maximum(least, low), np.minimum(most, high)
    return found


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", ["planar", "panda", "tiago", "g1"])
def test_limits_alone_and_together_obey_the_law_of_the_envelope(name: str, order: Any) -> None:
    """Every choice of limits, in any order: on one level, on several, in one row a joint, and beside one another."""
    arm = robot(name)
    task = PostureTask([0.1], joints=[joint_names(arm)[np.flatnonzero(positioned(arm))[-1]]], gain=1.0)
    for kinds in [kinds for count in (1, 2, 3) for kinds in permutations(KINDS, count)]:
        separate = [KINDS[kind]() for kind in kinds]
        whole = JointLimits(*[KINDS[kind]() for kind in kinds])
        stacks = {
            "one level": reduce(add, separate) >> task,
            "several": reduce(rshift, separate, task),
            "merged": whole >> task,
            "beside": task >> whole + separate[0] >> KINDS[kinds[-1]](),
        }
        at_work = {how: stack.build(arm, order, DT) for how, stack in stacks.items()}
        for q, v in states(name):
            state = arm.at(q, v)
            expected = reconciled(kinds, arm, state, order)
            one = (
                np.max([low for low, _ in expected.values()], axis=0),
                np.min([h for _, h in expected.values()], axis=0),
            )
            for how, rows in at_work.items():
                rows.fill(state, 0.0)
                for part in stacks[how]:
                    if isinstance(part, JointLimits) or part.is_limit:
                        wanted = one if isinstance(part, JointLimits) else expected[part.quantity]
                        for mine, theirs in zip(rows.places.bounds(part), wanted, strict=True):
                            np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-9, err_msg=f"{how} {kinds}")


@pytest.mark.parametrize("name", ["planar", "panda", "tiago"])
def test_a_step_of_inverse_kinematics_ends_in_the_range_and_knows_no_speed(name: str) -> None:
    arm = robot(name)
    limits = [JointPositionLimit(), JointVelocityLimit(), JointAccelerationLimit(), JointLimits()]
    others = [FrameVelocityLimit(0.1, mask="xy", frame=None if name != "tiago" else arm.frame_names[-1])]
    stack = reduce(add, limits + others + ([] if name == "tiago" else [JointTorqueLimit()]))
    rows = stack.build(arm, "displacement")
    for q, v in states(name):
        state = arm.at(q, v)
        rows.fill(state, 0.0)
        for part in stack:
            lower, upper = rows.places.bounds(part)
            if part is limits[0] or part is limits[3]:
                low, high = arm.position_limit
                np.testing.assert_allclose(
                    [lower, upper], [low - joint_positions(state), high - joint_positions(state)]
                )
            else:
                assert np.isinf([lower, upper]).all(), part


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("where", ["q", "v"])
def test_what_is_no_number_is_in_the_bounds(where: str, order: Any) -> None:
    arm, q, v = robot("planar"), np.zeros(3), np.zeros(3)
    (q if where == "q" else v)[1] = np.nan
    limits = JointLimits() + JointPositionLimit()
    hierarchy = limits.build(arm, order, DT).fill(arm.at(q, v), 0.0)
    assert np.isnan(hierarchy.lower.reshape(2, 3)[:, 1]).all()
    assert not np.isnan(hierarchy.lower.reshape(2, 3)[:, [0, 2]]).any()
    assert not Controller(arm, limits >> PostureTask(np.zeros(3), gain=1.0), order=order, dt=DT, damping=None)(q, v).ok


@pytest.mark.parametrize("order", ORDERS)
def test_the_rate_of_braking_is_told_before_others_ask(order: Any) -> None:
    """From full speed, or, where no limit tells it, from the speed within reach."""
    arm, (q, v) = PlanarArm([0.5, 0.4, 0.3]), states("planar")[0]
    stack = JointAccelerationLimit([5.0, 10.0, 20.0]) + JointVelocityLimit([1.0, 2.0, 3.0])
    rows = stack.build(arm, order, DT)
    assert rows.envelope.has_velocity
    assert not rows.envelope.brakes_blindly
    rows.fill(arm.at(q, v), 0.0)
    assert rows.envelope.braking_rate() == pytest.approx(1.0 / (0.2 + DT))
    rows = (JointAccelerationLimit([5.0, 10.0, 20.0]) >> PostureTask(q, gain=1.0)).build(arm, order, DT)
    assert rows.envelope.brakes_blindly
    rows.fill(arm.at(q, v), 0.0)
    assert rows.envelope.braking_rate() == pytest.approx(1.0 / ((np.abs(v) / [5.0, 10.0, 20.0]).max() + 2 * DT))
    free = PostureTask(q, gain=1.0) >> JointVelocityLimit(1.0)
    assert free.build(arm, order, DT).envelope.braking_rate() == np.inf


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("reference", ["local", "world", "local_world_aligned"])
@pytest.mark.parametrize("relative_to", [None, "panda_link3"])
def test_a_frame_at_its_limit_has_that_speed_at_the_end_of_the_tick(
    order: Any, reference: Any, relative_to: Any
) -> None:
    arm, limit = robot("panda"), np.array([0.1, 0.2, 0.3, 0.4])
    part = FrameVelocityLimit(limit, mask="x z ry rz", reference=reference, relative_to=relative_to)
    rows = (JointLimits() >> part).build(arm, order, DT)
    for q, v in states("panda"):
        level = rows.fill(arm.at(q, v), 0.0).levels[1]
        x = np.linalg.lstsq(level.A, level.upper, rcond=None)[0]
        if order == "velocity":
            np.testing.assert_allclose(level.A @ x, limit, atol=1e-9)
            continue
        # J(q + v h) (v + a h) after a short time h, by what the rows are there.
        h = 1e-6
        now, later = level.A @ v, rows.fill(arm.at(arm.integrate(q, h * v), v), 0.0).levels[1].A @ (v + h * x)
        np.testing.assert_allclose(now + DT * (later - now) / h, limit, atol=1e-4)


def fresh_equals(change: Any, make: Any, arm: Any, order: str) -> None:
    """A change on rows at work gives what fresh rows give."""
    part, other = make(), make()
    task = PostureTask(np.zeros(arm.nv), gain=1.0)
    rows = (part >> task).build(arm, order, DT)
    q, v = np.full(arm.nv, 0.3), np.linspace(-0.5, 0.5, arm.nv)
    before = rows.fill(arm.at(q, v), 0.0).numbers.copy()
    change(part), change(other)
    after = rows.fill(arm.at(q, v), 0.0).numbers.copy()
    np.testing.assert_array_equal(after, (other >> task).build(arm, order, DT).fill(arm.at(q, v), 0.0).numbers)
    assert not np.array_equal(before, after)


CHANGES = {
    "position": (lambda: JointPositionLimit(-1.0, 1.0), {"lower": 0.3, "upper": 0.35}),
    "velocity": (lambda: JointVelocityLimit(1.0), {"limit": [0.1, 0.2, 0.3]}),
    "velocity, own": (lambda: JointVelocityLimit(1.0), {"limit": None}),
    "acceleration": (lambda: JointAccelerationLimit(1.0), {"limit": 3.0}),
    "torque": (lambda: JointTorqueLimit(1.0), {"limit": 3.0}),
    "frame": (lambda: FrameVelocityLimit(1.0, mask="xy"), {"limit": 0.2}),
    "plane": (lambda: PlaneLimit([0, 1, 0], 0.2, gain=2.0), {"normal": [1, 1, 0], "distance": 0.3}),
    "box": (lambda: BoxLimit([-1, -1], [1, 1], gain=2.0), {"lower": [-0.5, -0.6], "upper": [0.4, 0.5]}),
}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("what", CHANGES)
def test_numbers_are_live(what: str, order: Any) -> None:
    if (what, order) == ("torque", "velocity"):
        return
    make, values = CHANGES[what]
    for name, value in values.items():
        fresh_equals(lambda part, name=name, value=value: setattr(part, name, value), make, robot("planar"), order)


def test_numbers_that_cannot_be_are_refused_and_change_nothing() -> None:
    box, ranges = BoxLimit([-1, -1], [1, 1], gain=2.0), JointPositionLimit(-1.0, 1.0)
    for part, name, value, named in (
        (box, "lower", [2, -1], "lower = .* must be below upper"),
        (box, "upper", [1, 1, 1], r"upper has shape \(3,\)"),
        (ranges, "lower", 2.0, "the lowest must not be above"),
        (ranges, "upper", None, "upper is missing"),
        (FrameVelocityLimit(1.0), "limit", [1.0, 2.0], r"limit has shape \(2,\)"),
        (JointLimits(JointVelocityLimit(1.0)), "limits", (), "part of its structure"),
        (JointVelocityLimit(1.0), "name", "v", "part of its structure"),
        (FrameVelocityLimit(1.0), "pose_task", None, "part of its structure"),
    ):
        before = getattr(part, name)
        with pytest.raises(InvalidInput, match=named):
            setattr(part, name, value)
        assert getattr(part, name) is before


class Foreign:
    """A robot of somebody's own, that tells nobody what is set on it."""

    def __init__(self) -> None:
        self.nq = self.nv = 3
        self.position_limit: Any = np.array([[-1.0] * 3, [1.0] * 3])
        self.velocity_limit: Any = np.ones(3)
        self.acceleration_limit: Any = None
        self._arm = PlanarArm([0.5, 0.4, 0.3])

    def at(self, q: Any, v: Any) -> Any:
        return self._arm.at(q, v)


@pytest.mark.parametrize("how", ["set", "in place", "another"])
def test_limits_of_a_robot_that_is_not_live_are_looked_at(how: str) -> None:
    foreign = Foreign()
    stack = JointLimits() >> PostureTask(np.zeros(3), gain=1.0)
    rows, state = stack.build(foreign, "velocity", DT), foreign.at(np.full(3, 0.995), np.zeros(3))
    plans = rows.plans
    np.testing.assert_allclose(rows.fill(state, 0.0).levels[0].upper, 0.5)
    assert rows.plans is plans
    if how == "set":
        foreign.velocity_limit = np.full(3, 0.2)
    elif how == "in place":
        foreign.velocity_limit[:] = 0.2
    else:
        foreign.position_limit[1] = 0.997
    np.testing.assert_allclose(rows.fill(state, 0.0).levels[0].upper, 0.2)
    foreign.velocity_limit = np.ones(2)
    with pytest.raises(InvalidInput, match=r"limit has shape \(2,\)"):
        rows.fill(state, 0.0)


def test_which_limit_a_bound_is_follows_its_number() -> None:
    limit = JointVelocityLimit(1.0)
    stack = JointLimits(JointPositionLimit(-9.0, 9.0), limit) >> PostureTask([5.0] * 3, gain=5.0)
    controller = Controller(robot("planar"), stack, dt=DT, damping=None)
    label = controller.hierarchy.levels[0].labels[0]
    limit.limit = 0.4
    now = controller.hierarchy.levels[0].labels[0]
    assert (now.part_at(Side.UPPER, 1.0), now.part_at(Side.UPPER, 0.4)) == ("position limit", "velocity limit")
    for kept in label, pickle.loads(pickle.dumps(label)):  # of an earlier tick: it keeps its words
        assert (kept.part_at(Side.UPPER, 1.0), kept.part_at(Side.UPPER, 0.4)) == ("velocity limit", "position limit")


def test_a_subclass_says_what_it_limits_and_the_loop_writes_it() -> None:
    class Half(JointVelocityLimit):
        """Half of what the robot has."""

        def largest(self, robot: Any) -> Any:
            return 0.5 * super().largest(robot)

    class Own(JointVelocityLimit):
        def write(self, tick: Any, A: Any, lower: Any, upper: Any) -> None:
            lower[:], upper[:] = -1.0, 1.0

    arm = robot("planar")
    rows = (JointLimits(Half()) >> PostureTask(np.zeros(3), gain=1.0)).build(arm, "velocity", DT)
    assert rows.plans[0][1].python is None
    np.testing.assert_array_equal(
        rows.fill(arm.at(np.zeros(3), np.zeros(3)), 0.0).levels[0].upper, 0.5 * arm.velocity_limit
    )
    for part in Own(), JointLimits(Own()):
        with pytest.raises(InvalidInput, match=r"never calls write\(\); define ends\(robot\)"):
            Controller(arm, part, dt=DT, damping=None)


def test_a_record_tells_of_limits_as_they_were() -> None:
    """Torques that a limit held are at it, also where it was set anew on the way."""
    arm, limit = robot("planar"), JointTorqueLimit(9.0)
    stack = limit >> PositionTask([0.2, 0.9], gain=20.0)
    controller = Controller(arm, stack, order="torque", dt=DT, damping=None)

    def loosen(done: float) -> None:
        limit.limit = 9.0 if done < 0.5 else 6.0

    record = simulate(controller, [0.3, 0.8, -0.4], duration=0.4, progress=loosen)
    sides, tops = record.active["torque"], np.where(np.arange(len(record.tau)) < 20, 9.0, 6.0)[:, None]
    known = np.r_[0:19, 22 : len(sides)]
    np.testing.assert_array_equal((sides == Side.UPPER)[known], (record.tau >= tops * (1.0 - 1e-8))[known])
    assert (sides[:20] != 0).any()
    assert (sides[22:] != 0).any()
