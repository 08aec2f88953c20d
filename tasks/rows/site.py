"""A part at work: its rows in the hierarchy of one robot, and all that its loops may ask for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._checks import Array, per_row
from ..motion.turns import stands_still
from ..robots.robot import Robot, RobotState, joint_positions
from .blocks import Blocks, HasSource, StateSource

if TYPE_CHECKING:
    from ..limits.envelope import Envelope
    from ..part import Order
    from ..task import Task

#: Brings a target up to date, by the time [s].
Move = Callable[[float], None]
#: What is measured of every row of a task: see :mod:`tasks.kernels.law`.
KINDS = 5


class Workspace:
    """What all parts of one stack share on one robot, each quantity computed once a tick.

    Attributes
    ----------
    robot : Robot
    order : {"velocity", "acceleration", "step"}
    dt : float or None
        [s].
    q, v : array, shapes (nq,) and (nv,)
        Of this tick.
    positions, places : array, array of int, shape (nv,)
        Where the position of each joint is: ``positions[places[j]]``; -1 where it has none of its own.
    braking : array, shape (2,)
        The largest rate [1/s] at which a bound may be neared, if the joints are to stop in time: infinite where nothing
        limits their accelerations; and dt.
    blocks : Blocks
    envelope : Envelope or None
        What the joint limits of the stack know of each other; None where a part is at work by itself.
    work : array, shape (64,)
        For loops to work in.
    kept : list
        What loops know by its address, and nobody else may keep.
    """

    def __init__(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.robot, self.order, self.dt = robot, order, dt
        self.n = robot.nv
        self.q, self.v = np.zeros(robot.nq), np.zeros(robot.nv)
        self.braking = np.array([np.inf, np.nan if dt is None else dt])
        own = isinstance(robot, HasSource)
        self.blocks = Blocks(robot.frame_source(self.q, self.v) if own else StateSource(robot), self.n)  # type: ignore[attr-defined]
        self._joints: Array | None = None
        if own or robot.nq == robot.nv:
            self.positions = self.q
            self.places = robot.places(np.arange(robot.nv)) if own else np.arange(robot.nv)  # type: ignore[attr-defined]
        else:
            self._joints = self.positions = np.zeros(robot.nv)
            self.places = np.arange(robot.nv)
        self.envelope: Envelope | None = None
        self.work = np.zeros(64)
        self.kept: list[object] = []
        if order == "acceleration":
            self.blocks.drifts[0] = 1

    def update(self, state: RobotState) -> None:
        """Be at this state."""
        self.q[:], self.v[:] = state.q, state.v
        if self._joints is not None:
            self._joints[:] = joint_positions(state)
        self.blocks.update(state)


class Site:
    """A part at work.

    Attributes
    ----------
    shared : Workspace
    A : array, shape (rows, nv), or None
        Its rows, None where they are plain.
    lower, upper : array, shape (rows,)
    below, above : array, shape (rows,), or float
        How far from its target a task may be; 0 where it is to be met.
    bounds : bool
        Whether the task only bounds.
    """

    def __init__(self, shared: Workspace, A: Array | None, lower: Array, upper: Array) -> None:
        self.shared, self.A, self.lower, self.upper = shared, A, lower, upper
        self.rows = len(lower)
        self.below: Array = np.zeros(())
        self.above: Array = np.zeros(())
        self.bounds = False
        self.measured = np.zeros((KINDS, self.rows))

    @property
    def drifts(self) -> bool:
        """Whether drifts and speeds are to be measured: accelerations need them, and what has to brake in time."""
        return self.shared.order == "acceleration" or (self.bounds and np.isfinite(self.shared.braking[0]))

    def within(self, below: Array, above: Array) -> Site:
        """The same rows as an inequality: the error between -above and -below."""
        site = Site(self.shared, self.A, self.lower, self.upper)
        site.below, site.above, site.bounds = below, above, True
        return site

    def frame(self, name: str | None, relative_to: str | None = None) -> Array:
        """The block of a frame, kept up to date."""
        if self.drifts:
            self.shared.blocks.drifts[0] = 1
        return self.shared.blocks.frame(name, relative_to)

    def center_of_mass(self, relative_to: str | None = None) -> Array:
        """That of the centre of mass."""
        if self.drifts:
            self.shared.blocks.drifts[0] = 1
        return self.shared.blocks.center_of_mass(relative_to)

    def law(self, task: Task) -> NDArray[np.int64]:
        """What the law of a task is told: sizes and addresses, of arrays that the workspace keeps alive."""
        from ..kernels import law as of

        rows, what = self.rows, task.label()
        gain = per_row(task.gain, rows, f"{what}: gain")
        numbers = np.empty((of.FIELDS, rows))
        numbers[of.GAIN], numbers[of.C1], numbers[of.C2] = gain, 2.0 * task.damping_ratio * gain, gain**2
        numbers[of.BELOW] = per_row(self.below, rows, f"{what}: below")
        numbers[of.ABOVE] = per_row(self.above, rows, f"{what}: above")
        told = {
            of.ORDER: of.ORDERS.index(self.shared.order),
            of.ROWS: rows,
            of.N: self.shared.n,
            of.MATRIX: 0 if self.A is None else self.A.ctypes.data,
            of.LOWER: self.lower.ctypes.data,
            of.UPPER: self.upper.ctypes.data,
            of.NUMBERS: numbers.ctypes.data,
            of.MEASURED: self.measured.ctypes.data,
            of.V: self.shared.v.ctypes.data,
            of.TICK: self.shared.braking.ctypes.data,
            of.BOUNDS: self.bounds and self.A is not None,
            of.DRIFTS: self.drifts,
        }
        table = np.array([told[k] for k in range(of.LENGTH)], dtype=np.int64)
        self.shared.kept += [self, numbers, table]
        return table


def kept_up(trajectory: Callable[[float], Any], *places: Array) -> tuple[Move, ...]:
    """Write what a trajectory gives into these arrays, now, and every tick unless it stands still."""

    def move(t: float) -> None:
        for place, part in zip(places, trajectory(t), strict=True):
            place[:] = part

    move(0.0)
    return () if stands_still(trajectory) else (move,)
