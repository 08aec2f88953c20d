r"""Closed-loop simulation of a controller and a robot, tick after tick, with a record of the motion.

The command is constant over a tick, and the robot follows it exactly:

.. math::

    \text{acceleration, torque order:}\quad & q \leftarrow q + v\,dt + \tfrac12 a\,dt^2, \quad v \leftarrow v + a\,dt \\
    \text{velocity order:}\quad & q \leftarrow q + v\,dt

This is the exact motion under such a command, so that a run shows the controller, without errors of an integrator. If a
configuration has more than one number per joint, the robot's own ``integrate`` replaces the sum.

At torque order the acceleration that the torque causes at the beginning of the tick is held, so that the motion is that
of acceleration order. Real motors hold the torque instead. For this, and for a robot that differs from its model, a run
takes a `Plant`, which moves by its own physics, such as :class:`tasks.MujocoPlant`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Solution
from hqp.checks import listed, of_type, whole_number
from hqp.errors import brief

from ..base.checks import Array, finite, finite_scalar, function, positive_scalar
from ..control.contacts import find_contact
from ..control.controller import Controller
from ..control.step import Step
from ..robots.robot import Robot, check_joints, integration, joint_names, joint_units
from .log import Log
from .motion import check_moved, follow
from .record import Record, Stop
from .schedule import Change, Switch, check_switches

#: Joint speed [rad/s] beyond which a run counts as diverged: 16 turns a second.
SPEED_CAP = 100.0


#: The most ticks of a run; their record takes one or two gigabytes.
MOST_TICKS = 10_000_000


@runtime_checkable
class Plant(Protocol):
    """A plant: what the torques of the controller move, in place of the controller's model."""

    def advance(self, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Positions and velocities dt [s] after the state (q, v), under constant torques tau [N m] of the motors."""
        ...


def simulate(
    controller: Controller,
    q0: ArrayLike,
    v0: ArrayLike | None = None,
    *,
    duration: float,
    start: float = 0.0,
    speed_cap: float = SPEED_CAP,
    certify: int = 50,
    proof: Callable[[Any], bool] | None = None,
    changes: Iterable[Change | Switch] = (),
    progress: Callable[[float], None] | None = None,
    plant: Plant | None = None,
) -> Record:
    """Run a controller in closed loop with its robot.

    Contacts and loops hold where the robot is at the start. Which of them are on, and changes under way, stay as they
    are in the controller.

    Parameters
    ----------
    controller : Controller
        It must have a dt [s]; it is solved once per tick.
    q0 : array, shape (nq,)
        Joint positions at the start [rad].
    v0 : array, shape (nv,), optional
        Joint velocities at the start [rad/s] (default: at rest).
    duration : float
        Length of the run [s], rounded to whole ticks.
    start : float
        Time of the first tick [s].
    speed_cap : float
        Joint speed [rad/s] above which the run counts as diverged and stops.
    certify : int
        Every how many ticks one is put to the certificate; 0 for none.
    proof : callable, optional
        Judges the solutions of these ticks (default: ``solution.certify().ok``).
    changes : iterable of Change and Switch
        Changes of the stack, the last of which the controller keeps; and contacts to make or release, each of which
        must be in the other state by then.
    progress : callable, optional
        Called about a hundred times, with the share of the run that is done.
    plant : Plant, optional
        What the torques move, at torque order only (default: the model of the controller). The record then has the
        measured states, and the commanded accelerations and torques.

    Returns
    -------
    Record
        If the run diverges, or the solver has no answer, it ends with the tick before; ``stopped`` tells why.

    Raises
    ------
    InvalidInput
        If the controller has no dt, the start is not finite or has the wrong shape, a number is out of range, the run
        would take more than `MOST_TICKS`, or there is a plant and the order is not torque.
    BaseException
        Whatever a task, a target or a plant of your own raises, and Ctrl-C. The record until then is its attribute
        ``record``.

    Examples
    --------
    >>> from tasks import Controller, PlanarArm, PositionTask, simulate
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> controller = Controller(arm, PositionTask([1.0, 0.2], gain=5.0), dt=0.01)
    >>> record = simulate(controller, [1.1, -1.3, -0.7], duration=1.0)
    >>> record.q.shape, bool(abs(record.errors["position"][-1]).max() < 0.01)
    ((101, 3), True)
    """
    run = _Run(controller, q0, v0, duration, start, speed_cap, certify, proof, changes, plant)
    return run.whole(None if progress is None else function(progress, "progress"))


class _Run:
    """A closed loop while it runs: the state of the robot, the coming changes, and the log.

    Parameters
    ----------
    controller, q0, v0, duration, start, speed_cap, certify, proof, changes, plant
        See :func:`simulate`.

    Raises
    ------
    InvalidInput
        See :func:`simulate`.
    """

    def __init__(
        self,
        controller: Controller,
        q0: ArrayLike,
        v0: ArrayLike | None,
        duration: float,
        start: float,
        speed_cap: float,
        certify: int,
        proof: Callable[[Any], bool] | None,
        changes: Iterable[Change | Switch],
        plant: Plant | None,
    ) -> None:
        self.dt, self.ticks = _ticks(controller, duration)
        _check_plant(plant, controller)
        self._controller, self._plant = controller, plant
        self._start = finite_scalar(start, "start")
        self._cap = positive_scalar(speed_cap, "speed cap", unit="rad/s")
        self._certify = whole_number(certify, "certify")
        robot = controller.robot
        self._q = finite(q0, "q0")
        self._v = np.zeros(robot.nv) if v0 is None else finite(v0, "v0")
        check_joints(robot, self._q, self._v)
        self._judge = _certified if proof is None else function(proof, "proof")
        given = listed(changes, "changes", "Change or Switch")
        given = [_checked(change, controller, given) for change in given]
        self._waiting = deque(sorted(given, key=lambda change: change.t))
        check_switches(controller, self._waiting)
        stacks = [controller.stack, *(change.stack for change in self._waiting if isinstance(change, Change))]
        parts = {id(part): part for stack in stacks for part in stack}
        self.log = Log(controller, self.ticks, robot.at(self._q, self._v), self._start, parts.values())
        self._integrate = integration(robot)
        controller.settle()

    def whole(self, progress: Callable[[float], None] | None) -> Record:
        """Run all ticks; what ends the run midway is given the record until then."""
        report_every, k = max(self.ticks // 100, 1), 0
        try:
            for k in range(self.ticks):
                stopped = self.tick(k)
                if stopped is not None:
                    return self.log.record(stopped)
                if progress is not None and (k + 1) % report_every == 0:
                    progress((k + 1) / self.ticks)
            self.end()
        except BaseException as error:
            self.hand_over(k, error)
            raise
        return self.log.record(None)

    def tick(self, k: int) -> Stop | None:
        """Run tick k; returns why the run stops here, or None if it goes on."""
        controller, t = self._controller, self._start + k * self.dt
        while self._waiting and t >= self._waiting[0].t:
            _make_happen(self._waiting.popleft(), controller)
        step = controller.unchecked(self._q, self._v, t)
        self.log.state(k, t, step.state, solved=step.ok)
        if not step.ok:
            where = f" ({step.solution.message})" if step.solution.message else ""
            return Stop(t, f"{step.solution.status} at t = {t:g} s{where}", diverged=False)
        if self._certify and k % self._certify == 0:
            self.log.check(t, step.solution, self._judge(step.solution))
        a = self._move(step)
        speed = float(np.abs(self._v).max(initial=0.0))
        if not speed <= self._cap:  # NaN too
            where = _fastest(controller.robot, self._v)
            return Stop(t + self.dt, f"diverged at t = {t + self.dt:g} s: {where}", diverged=True)
        self.log.tick(k, a, step)
        return None

    def _move(self, step: Step[Any, Any, Any]) -> Array:
        """Move the robot by one tick under the command; returns the accelerations [rad/s^2] over the tick."""
        q, v, dt = self._q, self._v, self.dt
        if self._plant is not None:
            assert step.a is not None  # at torque order, as was checked
            assert step.tau is not None
            a = step.a
            q, v = check_moved(self._controller.robot, self._plant.advance(q, v, step.tau, dt), "plant")
        else:
            q, v, a = follow(self._integrate, step, q, v, dt)
        q.flags.writeable = v.flags.writeable = False  # read-only, so that a robot need not copy them
        self._q, self._v = q, v
        return np.asarray(a)

    def hand_over(self, k: int, error: BaseException) -> None:
        """Give an exception that ends the run in tick k the record until then, and a note that says so."""
        t = self._start + k * self.dt
        with suppress(Exception):  # what keeps it from being made, or from being taken, is no news beside the error
            if self.log.states:
                what = f"{type(error).__name__} at t = {t:g} s: {error}".removesuffix(": ")
                error.record = self.log.record(Stop(t, what, diverged=False))  # type: ignore[attr-defined]
                error.add_note(f"simulate: raised at t = {t:g} s; its attribute `record` is the run until then")

    def end(self) -> None:
        """Log the state after the last tick."""
        self.log.state(self.ticks, self._start + self.ticks * self.dt, self._controller.robot.at(self._q, self._v))


def _ticks(controller: Controller, duration: float) -> tuple[float, int]:
    """The tick [s], and the number of ticks in the duration."""
    dt = of_type(controller, Controller, "controller").dt
    if dt is None:
        raise InvalidInput("simulate needs the tick; give the controller dt in s")
    share = positive_scalar(duration, "duration", unit="s") / dt
    if share > MOST_TICKS:
        raise InvalidInput(f"duration = {duration:g} s is more than {MOST_TICKS} ticks of dt = {dt:g} s")
    ticks = round(share)
    if ticks < 1:
        raise InvalidInput(f"duration = {duration} s is shorter than one tick, dt = {dt} s")
    return dt, ticks


def _check_plant(plant: Plant | None, controller: Controller) -> None:
    """Refuse a plant without `advance`, or with a controller that commands no torques."""
    if plant is None:
        return
    if controller.order != "torque":
        raise InvalidInput(f"a plant is moved by torques, but order = {controller.order!r}; it must be 'torque'")
    if isinstance(plant, type) or not (isinstance(plant, Plant) and callable(plant.advance)):
        raise InvalidInput(f"plant = {brief(plant)} is a {type(plant).__name__}; a plant has advance(q, v, tau, dt)")


def _checked(change: Change | Switch, controller: Controller, changes: Sequence[Change | Switch]) -> Change | Switch:
    """The checked change or switch; the contact of a switch must belong to one of the stacks of the run."""
    if not isinstance(change, Switch):
        return of_type(change, Change, "a change")
    coming = [other.stack for other in changes if isinstance(other, Change)]
    find_contact([*controller.stack, *(part for stack in coming for part in stack)], change.contact)
    return change


def _make_happen(change: Change | Switch, controller: Controller) -> None:
    if isinstance(change, Change):
        controller.change(change.stack, duration=change.duration, law=change.law)
    elif change.on:
        controller.make(change.contact, change.duration)
    else:
        controller.release(change.contact, change.duration)


def _fastest(robot: Robot, v: Array) -> str:
    """The fastest joint and its speed, in words."""
    joint = int(np.argmax(np.abs(v)))  # NaN is the largest
    return f"{joint_names(robot)[joint]} moves at {abs(float(v[joint])):.3g} {joint_units(robot)[joint]}/s"


def _certified(solution: Solution) -> bool:
    return solution.certify().ok
