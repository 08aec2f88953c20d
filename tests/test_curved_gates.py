"""The gates of the default damping spare work where the strict answer stands: they never change what is answered."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import curved_stacks
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hqp import Status
from hqp.arrays import Array
from hqp.kernels import curved_layout as at
from tasks import (
    CenterOfMassTask,
    Controller,
    JointLimits,
    JointVelocityLimit,
    OrientationTask,
    PositionTask,
    PostureTask,
    Setpoint,
    TargetTask,
    load_robot,
)

DT = 0.005


def let_through(controller: Controller) -> None:
    """Take the gates away: no bound of a curvature is known, and the last tick needed stages and the strict answer."""
    work = controller._now.solver._solver._work
    for own, _ in work._own:
        own[at.CALLS].reshape(-1, at.CALL)[:, 5] = 0
        own[at.SO_FAR][at.FADE] = 0.0
    work.head[at.OPENED] = 0


def opened(controller: Controller) -> bool:
    """Whether a level had a stage of its own."""
    solver = controller._now.solver._solver
    return bool(solver._head[at.OPENED] < solver._levels)


def agree(make: Callable[[], Controller], q: Array, v: Array, ticks: int = 3) -> list[bool]:
    """Whether stages were needed, tick by tick; the answers with and without gates are the same."""
    gated, every, needed = make(), make(), []
    for _ in range(ticks):
        let_through(every)
        step, other = gated(q, v), every(q, v)
        np.testing.assert_allclose(other.v, step.v, atol=1e-8 * (1.0 + np.abs(step.v).max()))
        assert opened(every) == opened(gated)
        assert [told.level for told in other.relaxed] == [told.level for told in step.relaxed]
        needed.append(opened(gated))
        q, v = q + DT * step.v, step.v
    return needed


def planar(seed: int) -> list[bool]:
    """The tip of an arm, with a target near by or far, and its angle, in either order."""
    robot, rng = curved_stacks.arm(seed), np.random.default_rng(seed)
    q, v = rng.choice([0.05, 1.0]) * rng.uniform(0.2, 1.5, robot.nv), 0.1 * rng.standard_normal(robot.nv)
    angles, far = np.cumsum(q), rng.choice([1e-4, 0.02, 1.0])
    place = robot.lengths @ np.array([np.cos(angles), np.sin(angles)]).T + far * rng.standard_normal(2)
    tip, turn = PositionTask(place, gain=10.0), OrientationTask(angles[-1] + 0.1 * far, gain=10.0)
    first, second = (tip, turn) if seed % 2 else (turn, tip)

    def make() -> Controller:
        return Controller(robot, JointLimits() >> first >> second >> PostureTask(q, gain=1.0), dt=DT)

    return agree(make, q, v)


def panda(seed: int) -> list[bool]:
    """A hand and its turn or the centre of mass, with a target near by or far, and an elbow from nearly straight on."""
    robot, rng = load_robot("panda", lock=["panda_finger_joint1"]), np.random.default_rng(seed)
    q, v = robot.home + rng.uniform(-0.3, 0.3, 7), 0.1 * rng.standard_normal(7)
    q[3] = rng.uniform(-1.5, -0.1)
    here, far = robot.at(q), rng.choice([1e-3, 5e-3, 0.02, 0.6])
    place = here.frame("panda_hand").position + far * rng.standard_normal(3)

    def make() -> Controller:
        hand = PositionTask(place, frame="panda_hand", gain=20.0)
        turn = OrientationTask(here.frame("panda_hand").rotation, frame="panda_hand", gain=20.0)
        mass = CenterOfMassTask(here.center_of_mass.position[:2], mask="xy", gain=10.0)
        first, second = [(hand, turn), (hand, mass), (mass, hand)][seed % 3]
        return Controller(robot, JointLimits() >> first >> second >> PostureTask(robot.home, gain=1.0), dt=DT)

    return agree(make, q, v)


class Measured(TargetTask):
    """The position of a tip, of which nobody tells how it curves."""

    rows = 2

    def measure(self, state: Any) -> Array:
        return np.asarray(state.pose[:2])

    def jacobian(self, state: Any) -> Array:
        return np.asarray(state.jacobian[:2])


def unknown(seed: int) -> list[bool]:
    """The same position twice, above of unknown curvature, or below: what pushes on it pushes on both."""
    robot, rng = curved_stacks.arm(seed), np.random.default_rng(seed)
    q, v = rng.choice([0.05, 1.0]) * rng.uniform(0.2, 1.5, robot.nv), 0.1 * rng.standard_normal(robot.nv)
    place = robot.at(q, v).pose[:2] + rng.choice([1e-4, 0.02]) * rng.standard_normal(2)
    measured, tip = Measured(place, gain=10.0), PositionTask(place, gain=10.0)
    first, second = (measured, tip) if seed % 2 else (tip, measured)
    turn = OrientationTask(rng.uniform(-1.0, 1.0), gain=rng.uniform(0.5, 10.0))

    def make() -> Controller:
        return Controller(robot, first >> second >> turn >> PostureTask(q, gain=1.0), dt=DT)

    return agree(make, q, v)


@given(st.integers(0, 10**6))
def test_gates_change_no_answer_where_a_curvature_is_not_known(seed: int) -> None:
    unknown(seed)


@given(st.integers(0, 10**6))
def test_gates_change_no_answer_of_a_planar_arm(seed: int) -> None:
    planar(seed)


@given(st.integers(0, 10**6))
def test_gates_change_no_answer_of_a_panda(seed: int) -> None:
    panda(seed)


@pytest.mark.parametrize("draw", [planar, panda, unknown])
def test_gates_are_open_for_some_draws_and_shut_for_others(draw: Callable[[int], list[bool]]) -> None:
    assert {needed for seed in range(12) for needed in draw(seed)} == {True, False}


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e40])
def test_numbers_are_tested_where_the_strict_answer_is_left_out(wrong: float) -> None:
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    place = Setpoint([1.5, 0.0, 0.5])
    stack = JointLimits() >> PositionTask(place, gain=20.0) >> PostureTask(robot.home, gain=1.0)
    controller = Controller(robot, stack, dt=DT)
    q, v = robot.home, np.zeros(robot.nv)
    for _ in range(100):
        step = controller(q, v)
        q, v = robot.integrate(q, DT * step.v), step.v
    assert all(own[at.SO_FAR][at.FADE] == 1.0 for own, _ in controller._now.solver._solver._work._own)
    place.move([wrong, 0.0, 0.5])
    assert controller(q, v).solution.status is Status.INVALID
    place.move([1.5, 0.0, 0.5])
    assert controller(q, v).solution.certify().ok


def test_while_a_hand_is_followed_in_reach_no_stage_is_prepared() -> None:
    """The smallest singular value is judged as sharply before the stages as for them."""
    robot, place = load_robot("panda", lock=["panda_finger_joint1"]), Setpoint(np.zeros(3))
    centre = robot.at(robot.home).frame("panda_hand")
    hand = PositionTask(place, frame="panda_hand", gain=20.0)
    turn = OrientationTask(centre.rotation, frame="panda_hand", gain=20.0)
    stack = JointLimits() >> hand >> turn >> PostureTask(robot.home, gain=1.0)
    controller, q, v, prepared = Controller(robot, stack, dt=DT), robot.home, np.zeros(robot.nv), 0
    head = controller._now.solver._solver._head
    for k in range(1000):  # a figure eight, 0.5 m wide
        turned = 2.0 * np.pi * 0.2 * DT * k
        place.move(centre.position + np.array([0.0, 0.25 * np.sin(turned), 0.12 * np.sin(2.0 * turned)]))
        head[at.SWEEPS] = -1
        step = controller(q, v)
        prepared += int(head[at.SWEEPS]) != -1
        assert k < 20 or not opened(controller)
        q, v = robot.integrate(q, DT * step.v), step.v
    assert prepared <= 20  # some at the start, from rest, when no sides of rows are known and joints leap


@pytest.mark.parametrize("dt", [DT, None])
def test_whether_the_last_velocity_is_known_is_told_by_every_tick(dt: float | None) -> None:
    robot = load_robot("panda", lock=["panda_finger_joint1"])

    def make() -> Controller:
        far = PositionTask([1.5, 0.0, 0.5], gain=20.0)
        return Controller(robot, JointVelocityLimit(2.0) >> far >> PostureTask(robot.home, gain=1.0), dt=dt)

    q, v, controller, found = robot.home, np.full(robot.nv, 0.1), make(), []
    for last in v, None, v, -v, None, np.full(robot.nv, 1e13), v:
        found.append(controller(q, last).v)
        np.testing.assert_allclose(found[-1], make()(q, last).v, atol=1e-9)
    known, unknown, beyond = found[0], found[1], found[5]
    assert (np.abs(known - unknown).max() > 1e-3) == (dt is not None)  # a level leans towards it
    np.testing.assert_allclose(beyond, unknown, atol=1e-9)
