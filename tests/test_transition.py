"""Stacks that change on line: continuous, exact where both stacks agree, and back to what was."""

from __future__ import annotations

import gc
from weakref import ref

import numpy as np
import pytest

import hqp
from hqp import InvalidInput
from tasks import (
    Change,
    Contact,
    Controller,
    Damped,
    Dynamics,
    JointAccelerationLimit,
    JointLimits,
    JointVelocityLimit,
    Line,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    Stack,
    load_robot,
    quintic,
    simulate,
)

ARM = PlanarArm([0.5, 0.4, 0.4, 0.3])
Q, DT = np.array([0.8, -0.9, 0.7, 0.4]), 0.005
LIMIT = JointVelocityLimit(3.0)
HAND = PositionTask([0.9, 0.5], gain=4.0, name="hand")
TURN = OrientationTask(0.2, gain=3.0)
REST = PostureTask([0.2, 0.3, -0.4, 0.1], gain=2.0)
orders = pytest.mark.parametrize("order", ["velocity", "acceleration"])


def run(controller: Controller, ticks: int, first: int = 0, q: np.ndarray = Q) -> np.ndarray:
    """The commands of so many ticks in closed loop."""
    v, commands = np.zeros(len(q)), []
    for k in range(first, first + ticks):
        step = controller(q, v, k * DT)
        assert step.ok
        v = step.v
        q = q + DT * v
        commands.append(v)
    return np.array(commands)


@orders
def test_a_change_begins_at_the_old_answer_and_ends_at_the_new_one(order: str) -> None:
    old, new = LIMIT >> HAND >> TURN, LIMIT >> TURN >> REST
    controller = Controller(ARM, old, order=order, dt=DT, damping=None)
    alone = {
        stack: Controller(ARM, stacks, order=order, dt=DT, damping=None)
        for stack, stacks in (("old", old), ("new", new))
    }
    v = np.array([0.1, -0.2, 0.3, 0.0])
    answers = {name: own(Q, v).solution.x for name, own in alone.items()}
    controller(Q, v, 0.0)
    controller.change(new, duration=0.2)
    for t, s in (1.0, 0.0), (1.1, 0.5), (1.2, 1.0), (1.3, 1.0):
        step = controller(Q, v, t)
        x = step.v if order == "velocity" else step.a
        assert step.share == pytest.approx(s, abs=1e-12)
        np.testing.assert_allclose(x, (1.0 - s) * answers["old"] + s * answers["new"], atol=1e-9)
    assert controller.stack is new
    assert step.solution.certify().ok


def test_levels_that_both_begin_with_are_exact_all_the_way() -> None:
    """Also where they cannot be met: what they lack is the same for both, and for all between."""
    far = PositionTask([2.5, 0.5], gain=8.0, name="far")
    old = LIMIT >> far >> TURN >> REST
    new = LIMIT >> far >> REST
    controller = Controller(ARM, old, dt=DT, damping=None)
    run(controller, 3)
    controller.change(new, duration=0.1)
    q, v, shares = Q, np.zeros(4), []
    for k in range(25):
        step = controller(q, v, k * DT)
        shares.append(step.share)
        shared = Controller(ARM, LIMIT >> far, dt=DT, damping=None)(q, v, k * DT).solution
        h = hqp.Hierarchy(shared.hierarchy.levels)
        assert hqp.certify(h, step.v, unique=False).ok
        v = step.v
        q = q + DT * v
    assert 0.0 in shares
    assert any(0.0 < share < 1.0 for share in shares)


def test_an_inserted_equality_gets_its_intermediate_desired_value() -> None:
    """Of Lee, Mansard and Park 2012: the hierarchy with the target J x_without + s (h - J x_without)."""
    without, whole = HAND >> REST, HAND >> TURN >> REST
    controller = Controller(ARM, without, dt=DT, damping=None)
    controller(Q, np.zeros(4), 0.0)
    controller.change(without.inserted(TURN, below=HAND), duration=1.0)
    controller(Q, np.zeros(4), 0.0)
    step = controller(Q, np.zeros(4), 0.3)
    x = Controller(ARM, without, damping=None)(Q, np.zeros(4)).v
    full = Controller(ARM, whole, damping=None)(Q, np.zeros(4)).solution.hierarchy
    turn = full.levels[1]
    turn.lower[:] = turn.upper[:] = (1.0 - step.share) * (turn.A @ x) + step.share * turn.lower
    np.testing.assert_allclose(step.v, hqp.solve(full).x, atol=1e-9)


def test_a_change_during_a_change_starts_from_where_that_one_is() -> None:
    stack = LIMIT >> HAND >> REST
    controller = Controller(ARM, stack, dt=DT, damping=None)
    before = run(controller, 10)
    controller.change(stack.swapped(HAND, REST), duration=0.3)
    during = run(controller, 20, 10)
    controller.change(LIMIT >> TURN >> REST, duration=0.3)
    after = run(controller, 80, 30)
    first = run(Controller(ARM, stack, dt=DT, damping=None), 1)
    np.testing.assert_array_equal(before[0], first[0])
    # Each run starts at Q again: at the first tick of the second change nothing of the third stack counts yet.
    replay = Controller(ARM, stack, dt=DT, damping=None)
    run(replay, 10)
    replay.change(stack.swapped(HAND, REST), duration=0.3)
    run(replay, 20, 10)
    np.testing.assert_allclose(run(replay, 1, 30)[0], after[0], atol=1e-12)
    assert np.abs(np.diff(during, axis=0)).max() < 0.5
    assert np.abs(np.diff(after, axis=0)).max() < 0.5
    assert controller._transition is None


def test_going_back_finds_rows_and_solver_as_they_were() -> None:
    stack = LIMIT >> HAND >> REST
    other = stack.swapped(HAND, REST)
    controller = Controller(ARM, stack, dt=DT, damping=None)
    rows, solver = controller._rows, controller._now.solver
    controller.change(other, duration=0.1)
    assert controller._rows is not rows
    controller.change(stack, duration=0.1)
    assert (controller._rows, controller._now.solver) == (rows, solver)


def test_stacks_with_parts_inserted_removed_and_swapped() -> None:
    stack = LIMIT >> HAND + TURN >> REST
    assert stack.swapped(TURN, REST) == LIMIT >> HAND + REST >> TURN
    assert stack.without(TURN) == LIMIT >> HAND >> REST
    assert stack.without(HAND, TURN) == LIMIT >> REST
    limit = JointAccelerationLimit(20.0)
    assert stack.inserted(limit) == limit >> LIMIT >> HAND + TURN >> REST
    assert stack.inserted(limit, below=TURN) == LIMIT >> HAND + TURN >> limit >> REST
    for wrong in (
        lambda: stack.swapped(HAND, limit),
        lambda: stack.without(limit),
        lambda: stack.inserted(limit, below=limit),
        lambda: stack.inserted(HAND),
        lambda: stack.without(LIMIT, HAND, TURN, REST),
    ):
        with pytest.raises(InvalidInput, match=r"is not in the stack|is in the stack twice|an empty stack"):
            wrong()


@pytest.mark.parametrize(
    ("stack", "options", "named"),
    [
        (HAND, {"duration": -0.5}, "duration of a change = -0.5 s must be positive"),
        (HAND, {"duration": np.nan}, "duration of a change = nan"),
        (HAND, {"duration": 1.0, "law": 3}, "law of a change"),
        (PostureTask([0.0], gain=1.0), {"duration": 1.0}, "target has shape"),
        ("hand", {"duration": 1.0}, "a stack takes tasks"),
    ],
)
def test_what_cannot_be_changed_to_leaves_all_as_it_was(stack, options, named) -> None:
    controller = Controller(ARM, LIMIT >> HAND, dt=DT, damping=None)
    before = controller.stack, controller._rows
    with pytest.raises(InvalidInput, match=named):
        controller.change(stack, **options)
    assert (controller.stack, controller._rows) == before
    assert controller(Q, np.zeros(4)).share == 1.0


def test_a_simulation_changes_on_its_way_and_records_all_tasks() -> None:
    robot = load_robot("ur5")
    tip = robot.at(robot.home, np.zeros(6)).frame()
    reach = PositionTask(Line(tip.position, tip.position + np.array([0.1, 0.1, 0.0]), 1.0), gain=5.0)
    level = OrientationTask(tip.rotation, gain=5.0)
    stack = JointVelocityLimit() >> reach
    changes = [Change(0.5, stack >> level, 0.3), Change(1.2, JointVelocityLimit() >> level, 0.3, quintic)]
    record = simulate(Controller(robot, stack, dt=0.01), robot.home, duration=2.0, changes=changes)
    assert record.stopped is None
    assert set(record.errors) == {"position", "orientation"}
    assert set(record.active) == {"velocity", "velocity 2"}
    assert record.certified == len(record.checked_t)
    assert np.abs(record.errors["orientation"][-1]).max() < 0.02


def wave(rng: np.random.Generator, start: np.ndarray, size: float):
    rows = len(start)
    a, w, p = size * rng.uniform(0.3, 1.0, rows), rng.uniform(0.5, 2.0, rows), rng.uniform(0.0, 6.0, rows)
    return lambda t: (start + a * np.sin(w * t + p), a * w * np.cos(w * t + p), -a * w * w * np.sin(w * t + p))


def swap_case(seed: int) -> tuple[Controller, Stack, np.ndarray]:
    """An arm with two tasks that cannot both be met, and the stack with the two swapped."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 8))
    arm = PlanarArm(rng.uniform(0.3, 0.6, n))
    q = rng.uniform(0.3, 0.9, n) * rng.choice([-1.0, 1.0])
    hand = PositionTask(wave(rng, arm.pose(q)[:2], 0.08 * arm.lengths.sum()), gain=4.0)
    joints = range(n - seed % 2)
    rest = PostureTask(wave(rng, q[list(joints)] + rng.uniform(-0.3, 0.3, len(joints)), 0.3), joints=joints, gain=3.0)
    stack = JointVelocityLimit(10.0) >> hand >> rest
    return Controller(arm, stack, dt=DT, damping=None), stack.swapped(hand, rest), q


def steps_between(seed: int, duration: float | None) -> np.ndarray:
    """The largest change of a joint velocity between ticks, of a motion from rest; the swap comes after 1 s."""
    controller, swapped, q = swap_case(seed)
    before = run(controller, 200, 0, q)
    if duration is not None:
        controller.change(swapped, duration=duration)
    after = run(controller, 150, 200, q + DT * before.sum(axis=0))
    v = np.concatenate([np.zeros((1, len(q))), before, after])
    return np.abs(np.diff(v, axis=0)).max(axis=1)


@pytest.mark.parametrize("first", [0, *(pytest.param(k, marks=pytest.mark.sweep) for k in range(5, 200, 5))])
def test_swapping_two_conflicting_tasks_makes_no_jump(first: int) -> None:
    for seed in range(first, first + 5):
        plain, smooth = (steps_between(seed, duration) for duration in (None, 0.5))
        assert smooth.max() <= 1.5 * plain.max(), seed


def test_an_abrupt_swap_jumps_where_a_smooth_one_does_not() -> None:
    plain, smooth, abrupt = (np.array([steps_between(s, d)[100:].max() for s in range(4)]) for d in (None, 0.5, 1e-9))
    assert (abrupt > 10.0 * plain).all(), "once under way"
    assert (smooth < 0.1 * abrupt).all()


def test_a_damped_level_keeps_its_rule_when_it_changes_places() -> None:
    stack = LIMIT >> HAND >> Damped(TURN, 0.1) >> REST
    assert stack.swapped(HAND, TURN) == LIMIT >> Damped(TURN, 0.1) >> HAND >> REST
    assert stack.without(HAND) == LIMIT >> Damped(TURN, 0.1) >> REST
    assert (LIMIT >> HAND >> REST).inserted(Damped(TURN, 0.1), below=HAND) == stack
    controller = Controller(ARM, stack, dt=DT, damping=None)
    before = run(controller, 5)
    controller.change(stack.swapped(HAND, TURN), duration=0.05)
    after = run(controller, 20, 5)
    assert np.isfinite([*before, *after]).all()
    assert controller(Q, np.zeros(4), 1.0).relaxed


def test_what_a_controller_has_left_for_long_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """With what its parts kept from tick to tick; what somebody else still has, as a contact that is off, stays so."""
    monkeypatch.setattr("tasks.control.prepared.MOST_PREPARED", 2)
    robot = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=20.0)

    def standing(contact: Contact) -> Stack:
        return Dynamics() + contact >> JointLimits() >> PostureTask(robot.home, gain=1.0)

    mine = standing(Contact("panda_hand", friction=0.6, name="hand"))
    controller, q, v = Controller(robot, mine, order="torque", dt=DT), robot.home, np.zeros(robot.nv)
    controller(q, v, 0.0)
    controller.release("hand")
    left = []
    for _ in range(6):
        contact = Contact("panda_hand", friction=0.6, name="hand")
        left.append(ref(contact))
        controller.change(standing(contact), duration=0.0)
        controller(q, v, 0.0)
    del contact
    controller.change(mine, duration=0.0)
    controller(q, v, 0.0)
    gc.collect()
    assert [known() is None for known in left] == [*[True] * 5, False]
    assert controller.loaded == ()
