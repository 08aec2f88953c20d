"""Where a part writes: its rows in the hierarchy of one robot, and the quantities that all parts of a stack share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import chain
from typing import TYPE_CHECKING, Any, Protocol
from weakref import WeakKeyDictionary

import numpy as np

from ..base.checks import Array, per_row
from ..base.live import Live
from ..robots import abilities as able
from ..robots.answers import at_rest, joint_reader
from ..robots.robot import Robot, RobotState, is_flat
from ..robots.source import Source
from ..targets.turns import constant
from .blocks import Blocks, StateSource
from .envelope import Envelope
from .tick import Order
from .unknowns import Unknowns

if TYPE_CHECKING:
    from ..base.loops import Call, Table

#: Brings a target up to date, by the time [s].
Move = Callable[[float], None]
#: What parts keep from tick to tick, whatever stack they are in; it goes with the part.
Memory = WeakKeyDictionary[Live, Any]
#: What is measured of every row of a task: see :mod:`tasks.rows.kernels.law`.
KINDS = 5
#: The numbers of a task that its law goes by.
OF_THE_LAW = ("gain", "damping_ratio", "cap", "deceleration")


class Governed(Protocol):
    """A task as its law sees it: gain, damping ratio, name; see :class:`tasks.rows.task.Task`."""

    @property
    def gain(self) -> Array: ...

    @property
    def damping_ratio(self) -> float: ...

    @property
    def cap(self) -> Array | None: ...

    @property
    def deceleration(self) -> float | None: ...

    @property
    def plain(self) -> bool: ...

    def full_name(self) -> str: ...


class Band(Protocol):
    """How far from its target a task may be, as an inequality tells it."""

    @property
    def below(self) -> Array: ...

    @property
    def above(self) -> Array: ...


class Workspace:
    """What all parts of one stack share on one robot, each quantity computed once a tick.

    Attributes
    ----------
    robot : Robot
    order : {"velocity", "acceleration", "displacement"}
    dt : float or None
        [s].
    q, v : array, shapes (nq,) and (nv,)
        Of this tick.
    positions, position_indices : array, array of int, shape (nv,)
        Where the position of each joint is: ``positions[position_indices[j]]``; -1 where it has none of its own.
    circles : array of int, shape (nv,)
        Where in q the cosine of each joint on a circle is, the sine being the next; -1 for all others.
    numbered : bool
        Whether these suffice to subtract configurations; else only the robot can.
    braking : array, shape (2,)
        The largest rate [1/s] at which a bound may be neared, if the joints are to stop in time: infinite where nothing
        limits their accelerations; and dt.
    blocks : Blocks
    envelope : Envelope
        The joint limits of the stack.
    work : array, shape (64,)
        For loops to work in.
    curvature : bool
        Whether plans have to give the curvature of their rows.
    n, unknowns : int, Unknowns
        Velocities of the joints; the layout of x.
    memory : Memory
        What the parts of all stacks of the same controller keep.
    wrenches : array, shape (unknowns.n - n, n)
        G: the joint torques that the unknown forces f give are G^T f.
    aims : tuple of array, shape (unknowns.n,)
        What each damped level is damped towards at this tick: who knows what forces are needed writes those.
    given : dict of list of Call
        What writes G, and whatever else is shared and comes after the blocks; by whom it was asked for.
    """

    def __init__(
        self,
        robot: Robot,
        order: Order,
        dt: float | None,
        unknowns: Unknowns | None = None,
        memory: Memory | None = None,
    ) -> None:
        self.robot, self.order, self.dt = robot, order, dt
        self.n = robot.nv
        self.unknowns = Unknowns(robot.nv) if unknowns is None else unknowns
        self.wrenches = np.zeros((self.unknowns.n - self.n, self.n))
        self.aims: tuple[Array, ...] = ()
        self.given: dict[int, list[Call]] = {}
        self.memory: Memory = Memory() if memory is None else memory
        self.q, self.v = np.zeros(robot.nq), np.zeros(robot.nv)
        self.braking = np.array([np.inf, np.nan if dt is None else dt])
        joints = np.arange(robot.nv)
        self._joints: Callable[[RobotState], Array] | None = None
        self.positions, self.position_indices, self.circles = self.q, joints, np.full(robot.nv, -1)
        source: Source = StateSource(robot)
        self.numbered = is_flat(robot)
        if able.has(robot, able.Sourced):
            source, self.numbered = robot.frame_source(self.q, self.v), True
            self.position_indices, self.circles = robot.position_indices(joints), robot.circles(joints)
        elif robot.nq != robot.nv:
            self.positions, self._joints = np.zeros(robot.nv), joint_reader(at_rest(robot))
        self.blocks = Blocks(source, self.n)
        self.envelope = Envelope(self.n)
        self.work, self.curvature = np.zeros(64), True
        if order == "acceleration":
            self.blocks.drifts[0] = 1

    @property
    def calls(self) -> list[Call]:
        """The loops that compute the shared quantities at the state of the tick, in this order."""
        return [*self.blocks.calls, *chain.from_iterable(self.given.values()), *self.envelope.calls]

    def kept(self, part: Live, make: Callable[[], Any]) -> Any:
        """What a part keeps from tick to tick, made at the first use; it must not hold the part itself."""
        return self.memory[part] if part in self.memory else self.memory.setdefault(part, make())

    def update(self, state: RobotState) -> None:
        """Compute all shared quantities at this state."""
        self.come_to(state)
        for call in self.calls:
            call.run()

    def come_to(self, state: RobotState) -> None:
        """Take up the state; :attr:`calls` compute the rest."""
        self.q[:], self.v[:] = state.q, state.v
        if self._joints is not None:
            self.positions[:] = self._joints(state)
        self.blocks.update(state)


class Site:
    """Where one part writes its rows, and the quantities that it may read.

    Attributes
    ----------
    shared : Workspace
    A : array, shape (rows, nv), or None
        Its rows, None where they are plain; of a part that is `wide`, (rows, n) of all unknowns.
    lower, upper : array, shape (rows,)
    band : Band or None
        How far from its target a task may be; None where it is to be met.
    bounds : bool
        Whether the task only bounds.
    shortens : bool
        Whether errors are cut off by the `cap` and `deceleration` of the task.
    off : list of (array, array, array)
        Of those who follow the law: the error, and how far from it below and above a task may be, shape (rows,) each.
    plain_error : list of array, shape (rows,)
        The error of the task as it measures it, if loops leave it so; empty where they cut it off.
    targets, numbers : dict of (int, str) to callable
        What writes an attribute of a part, by the id of the part and its name, where the plan has put it: targets, and
        other numbers. False where it takes a new plan.
    rate : array, shape (nv,)
        Of every joint, the largest :meth:`tasks.Part.decay_rate` on its level [1/s], at acceleration order; else 0.
    """

    def __init__(
        self, shared: Workspace, A: Array | None, lower: Array, upper: Array, rate: Array | None = None
    ) -> None:
        self.shared, self.A, self.lower, self.upper = shared, A, lower, upper
        self.rate: Array = np.zeros(shared.n) if rate is None else rate
        self.rows = len(lower)
        self.band: Band | None = None
        self.bounds, self.shortens = False, True
        self.measured = np.zeros((KINDS, self.rows))
        self.off: list[tuple[Array, Array, Array]] = []
        self.plain_error: list[Array] = []
        self.targets: dict[tuple[int, str], Callable[[], bool]] = {}
        self.numbers: dict[tuple[int, str], Callable[[], bool]] = {}

    @property
    def drifts(self) -> bool:
        """Whether drifts and speeds are measured: accelerations need them, and inequalities that brake in time."""
        return self.shared.order == "acceleration" or (self.bounds and np.isfinite(self.shared.braking[0]))

    def within(self, band: Band) -> Site:
        """A site of the same rows as an inequality: the error between -above and -below."""
        site = Site(self.shared, self.A, self.lower, self.upper, self.rate)
        site.band, site.bounds, site.off, site.targets, site.numbers = band, True, self.off, self.targets, self.numbers
        return site

    def forget(self) -> None:
        """Forget what the last plan left here."""
        for left in self.off, self.plain_error, self.targets, self.numbers:
            left.clear()

    def frame(self, name: str | None, relative_to: str | None = None) -> Array:
        """The block of a frame, kept up to date."""
        if self.drifts:
            self.shared.blocks.drifts[0] = 1
        return self.shared.blocks.frame(name, relative_to)

    def center_of_mass(self, relative_to: str | None = None) -> Array:
        """The block of the centre of mass, kept up to date."""
        if self.drifts:
            self.shared.blocks.drifts[0] = 1
        return self.shared.blocks.center_of_mass(relative_to)

    def law(self, task: Governed) -> Table:
        """The arguments of the law of a task; see :mod:`tasks.rows.kernels.law`.

        Its gain, damping ratio, cap, deceleration and weight, and the band of an inequality, may then change without a
        new plan, which therefore is to copy none of them by itself.
        """
        from ..base.loops import Table
        from .kernels import law as of

        rows, shared, band = self.rows, self.shared, self.band
        numbers, longest = np.empty((of.FIELDS, rows)), np.empty(2)
        self.off.append((self.measured[of.ERROR], numbers[of.BELOW], numbers[of.ABOVE]))
        table = Table(
            of.ORDERS.index(shared.order),
            rows,
            shared.n,
            0 if self.A is None else self.A,
            self.lower,
            self.upper,
            numbers,
            self.measured,
            shared.v,
            shared.braking,
            self.bounds and not task.plain,
            self.drifts,
            longest,
            False,
        )
        shortens = self.shortens and shared.order != "displacement"

        def fitting(name: str, value: Array) -> Array:
            return per_row(value, rows, f"{task.full_name()}: {name}") if value.ndim else value

        def write() -> bool:
            gain, cap, brakes = fitting("gain", task.gain), task.cap, task.deceleration
            numbers[of.GAIN], numbers[of.C1], numbers[of.C2] = gain, 2.0 * task.damping_ratio * gain, gain * gain
            numbers[of.CAP] = np.inf if cap is None or cap.ndim == 0 else fitting("cap", cap)
            longest[0] = np.inf if cap is None or cap.ndim else cap
            longest[1] = np.inf if brakes is None else brakes
            table.numbers[of.SHORTENS] = cut = shortens and not (cap is None and brakes is None)
            self.plain_error[:] = [] if cut else [self.measured[of.ERROR]]
            numbers[of.BELOW] = 0.0 if band is None else fitting("below", band.below)
            numbers[of.ABOVE] = 0.0 if band is None else fitting("above", band.above)
            return True

        write()
        self.numbers |= {(id(task), name): write for name in OF_THE_LAW}
        self.numbers |= {(id(band), name): write for name in ("below", "above") if band is not None}
        self.numbers[id(task), "weight"] = lambda: True  # it stands beside the rows
        return table

    def keep_up(self, part: object, name: str, *places: Array) -> tuple[Move, ...]:
        """Write what the trajectory in this attribute of a part gives into these arrays; see :meth:`follow`."""
        return self.follow(part, (name,), lambda: kept_up(getattr(part, name), *places), lambda: (getattr(part, name),))

    def follow(
        self,
        part: object,
        names: Iterable[str],
        write: Callable[[], tuple[Move, ...]],
        goals: Callable[[], tuple[object, ...]],
    ) -> tuple[Move, ...]:
        """Write targets where a plan wants them, now, every tick if they move, and when other constants are set.

        A constant of the same form is then taken without a new plan, and :meth:`tasks.Part.check` is not asked again.

        Parameters
        ----------
        part : Part
        names : iterable of str
            Its attributes that the targets are in.
        write : callable
            Writes them as they are now, and gives what keeps up with those that move.
        goals : callable
            The targets.
        """
        form = tuple(map(constant, goals()))

        def renew() -> bool:
            alike = tuple(map(constant, goals())) == form
            return alike and not write()

        if None not in form:
            self.targets |= {(id(part), name): renew for name in names}
        return write()


def kept_up(trajectory: Callable[[float], Any], value: Array, rate: Array, change: Array) -> tuple[Move, ...]:
    """Write what a trajectory gives into these arrays, now, and every tick unless it stands still."""

    def move(t: float) -> None:
        value[:], rate[:], change[:] = trajectory(t)

    move(0.0)
    return () if constant(trajectory) is not None else (move,)
