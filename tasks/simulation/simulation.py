r"""Closed-loop simulation: controller and robot, tick after tick, and the record of it.

The command holds over the tick and the robot follows it exactly:

.. math::

    \text{acceleration, torque order:}\quad & q \leftarrow q + v\,dt + \tfrac12 a\,dt^2, \quad v \leftarrow v + a\,dt \\
    \text{velocity order:}\quad & q \leftarrow q + v\,dt

which is the exact motion under such a command: what a run shows is the controller, not the integrator. Where a
configuration is more than one number per joint, the sum is the robot's own ``integrate``.

At torque order the acceleration that holds is the one which the torque gives where the tick begins, which makes the
motion that of the acceleration order. Real motors hold the torque instead. For that, and for a robot that is not quite
as its model says, a run takes a `Plant`, which moves by its own physics: :class:`tasks.MujocoPlant`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Solution
from hqp.checks import listed, of_type, truth, whole_number
from hqp.errors import brief

from ..base.checks import Array, finite, finite_scalar, function, not_negative, positive_scalar, scalar
from ..control.contacts import find_contact
from ..control.controller import Controller
from ..control.step import Step
from ..robots.robot import Robot, check_joints, integration, joint_names, joint_units
from ..rows.part import Part, Stack
from ..targets.timing import as_timing
from .log import Log
from .motion import check_moved, follow
from .record import Record, Stop
from .schedule import Change, Switch, check_switches

#: Joint speed [rad/s] beyond which a run counts as diverged: 16 turns a second.
SPEED_CAP = 100.0


#: The longest run: a record of so many ticks fills a gigabyte or two.
MOST_TICKS = 10_000_000


@runtime_checkable
class Plant(Protocol):
    """A plant: what the commands move, in place of the model of the controller."""

    def advance(self, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Positions and velocities dt [s] after (q, v), while the torques tau [N m] hold."""
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
    """Run a controller on the robot it was made for.

    Contacts and loops hold where the robot is at the start. Which of them are on, and changes under way, stay as they
    are in the controller.

    Parameters
    ----------
    controller : Controller
        With its dt [s]: one solve a tick.
    q0 : array, shape (nq,)
        Joint positions at the start [rad].
    v0 : array, shape (nv,), optional
        Joint velocities at the start [rad/s] (default: at rest).
    duration : float
        [s], rounded to whole ticks.
    start : float
        Time of the first tick [s].
    speed_cap : float
        A run in which a joint turns faster than this [rad/s] has diverged and stops.
    certify : int
        Put every so many-th tick to the certificate; 0 for none.
    proof : callable, optional
        The judge of the solutions of those ticks (default: ``solution.certify().ok``).
    changes : iterable of Change and Switch
        Changes of the stack, the controller keeps the last one; and contacts to make or release, each of which must be
        in the other state by then.
    progress : callable, optional
        Called with the share of the run that is done, about a hundred times.
    plant : Plant, optional
        What the torques move, at torque order (default: the model of the controller). The record then holds the states
        that were measured, and the accelerations and torques that were commanded.

    Returns
    -------
    Record
        Up to the tick before, if the run diverges or the solver has no answer: see ``stopped``.

    Raises
    ------
    InvalidInput
        If the controller has no dt, the start is not finite or has the wrong shape, a number is
        out of range, the run would take more than `MOST_TICKS`, or a plant is given no torques.

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
    progress = None if progress is None else function(progress, "progress")
    report_every = max(run.ticks // 100, 1)
    for k in range(run.ticks):
        stopped = run.tick(k)
        if stopped is not None:
            return run.log.record(stopped)
        if progress is not None and (k + 1) % report_every == 0:
            progress((k + 1) / run.ticks)
    run.end()
    return run.log.record(None)


class _Run:
    """A closed loop under way: the state of the robot, the changes that wait, and the log.

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
        self.log = Log(controller, self.ticks, robot.at(self._q, self._v), parts.values())
        self._integrate = integration(robot)
        controller.settle()

    def tick(self, k: int) -> Stop | None:
        """Solve and move on by one tick; why the run stops here, or None if it goes on."""
        controller, t = self._controller, self._start + k * self.dt
        while self._waiting and t >= self._waiting[0].t:
            _make_happen(self._waiting.popleft(), controller)
        step = controller.unchecked(self._q, self._v, t)
        self.log.state(k, t, step.state)
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
        """Bring the robot where the command takes it; the acceleration [rad/s^2] of the tick."""
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

    def end(self) -> None:
        """Log the state after the last tick."""
        self.log.state(self.ticks, self._start + self.ticks * self.dt, self._controller.robot.at(self._q, self._v))


def _ticks(controller: Controller, duration: float) -> tuple[float, int]:
    """The tick [s], and how many of them the duration is."""
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
    """Refuse a plant that is none, or that would be given no torques."""
    if plant is None:
        return
    if controller.order != "torque":
        raise InvalidInput(f"a plant is moved by torques, but order = {controller.order!r}; it must be 'torque'")
    if isinstance(plant, type) or not (isinstance(plant, Plant) and callable(plant.advance)):
        raise InvalidInput(f"plant = {brief(plant)} is a {type(plant).__name__}; a plant has advance(q, v, tau, dt)")


def _checked(change: Change | Switch, controller: Controller, changes: Sequence[Change | Switch]) -> Change | Switch:
    """A change whose time is a number, and whose stack is one, or a switch of a contact of one of the stacks."""
    if isinstance(change, Switch):
        coming = [other.stack for other in changes if isinstance(other, Change)]
        find_contact([*controller.stack, *(part for stack in coming for part in _parts(stack))], change.contact)
        scalar(not_negative(change.duration, "a switch: duration", unit="s"), "a switch: duration")
        return replace(change, t=finite_scalar(change.t, "a switch: t"), on=truth(change.on, "a switch: on"))
    stack = of_type(change, Change, "a change").stack
    stack = stack if isinstance(stack, Stack) else Stack(stack)
    scalar(not_negative(change.duration, "a change: duration", unit="s"), "a change: duration")
    as_timing(change.law, "a change: law")
    return replace(change, t=finite_scalar(change.t, "a change: t"), stack=stack)


def _parts(stack: Stack | Part) -> Iterable[Part]:
    return stack if isinstance(stack, Stack) else (stack,)


def _make_happen(change: Change | Switch, controller: Controller) -> None:
    if isinstance(change, Change):
        controller.change(change.stack, duration=change.duration, law=change.law)
    elif change.on:
        controller.make(change.contact, change.duration)
    else:
        controller.release(change.contact, change.duration)


def _fastest(robot: Robot, v: Array) -> str:
    """Which joint moves how fast."""
    joint = int(np.argmax(np.abs(v)))  # NaN is the largest
    return f"{joint_names(robot)[joint]} moves at {abs(float(v[joint])):.3g} {joint_units(robot)[joint]}/s"


def _certified(solution: Solution) -> bool:
    return solution.certify().ok
