"""The log of a closed loop, filled tick by tick, from which its record is made."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hqp import InvalidInput, Side, Solution, Status

from ..base.checks import Array
from ..control.contacts import has_dynamics
from ..control.controller import Controller
from ..control.step import Step
from ..robots.robot import RobotState, base, inverse_dynamics, manipulability, pose_reader
from ..rows.part import Part
from .account import Shortfall, shortfalls
from .record import Record, Stop

#: How far x may be from a bound and still count as on it, relative to ``1 + |x|``.
AT_BOUND = 1e-9
#: Bounds of a limit that is not in the stack.
FREE = (-np.inf, np.inf)

Scalar = TypeVar("Scalar", bound=np.generic)


@runtime_checkable
class Erring(Protocol):
    """A part with an error: a task or an inequality."""

    name: str

    def error(self, state: RobotState, t: float) -> Array:
        """Desired - actual."""
        ...


P = TypeVar("P", Part, Erring)


class Log:
    """Preallocated arrays, filled tick by tick; the record has the part for the ticks that were run.

    Parameters
    ----------
    controller : Controller
    ticks : int
        The largest number of ticks.
    first : RobotState
        The state at the start.
    start : float
        The time of the start [s].
    parts : iterable of Part
        All parts that are in the stack of the controller, now or later.

    Raises
    ------
    InvalidInput
        If an optional method of the robot does not take a whole record at once.
    """

    def __init__(
        self, controller: Controller, ticks: int, first: RobotState, start: float, parts: Iterable[Part]
    ) -> None:
        parts = list(parts)
        self._controller = controller
        self.order = controller.order
        nq, nv = len(first.q), len(first.v)
        self.t = np.empty(ticks + 1)
        self.q, self.v = np.empty((ticks + 1, nq)), np.empty((ticks + 1, nv))
        self.a = np.empty((ticks, nv))
        self._pose = pose_reader(first)
        self.pose = np.empty((ticks + 1, len(self._pose(first))))
        self.status: list[Status] = []
        self.states = 0
        telling: list[Erring] = [part for part in parts if isinstance(part, Erring)]
        self.errors = [
            (name, part, np.empty((ticks + 1, len(part.error(first, start))))) for name, part in _named(telling)
        ]
        limits = list(_named(part for part in parts if part.limited is not None))
        #: Bounds at every tick: of limits on the motion, x, and of limits on torques.
        self.bounds, self.torque_bounds = (
            [
                (name, part, *np.empty((2, ticks, part.size(controller.robot))))
                for name, part in limits
                if part.limited == what
            ]
            for what in ("motion", "torque")
        )
        #: The commanded torques, if forces are unknowns: then accelerations alone do not determine them.
        self.tau = np.empty((ticks, nv - base(controller.robot))) if has_dynamics(controller.stack) else None
        #: Name of the contact -> its forces, if these are unknowns.
        self.forces: dict[str, Array] = {}
        self._ticks = ticks
        self.checked_t: list[float] = []
        self.certified = 0
        self.ranks: list[list[int]] = []
        self.shortfalls: list[tuple[Shortfall, ...]] = []
        q, v = first.q[None], first.v[None]
        self._torque = _asked_at_once(inverse_dynamics(controller.robot), "inverse_dynamics", (q, v, v), (1, nv))
        self._manipulability = _asked_at_once(manipulability(controller.robot), "manipulability", (q,), (1,))
        self._levels, self._unknowns = len(controller.hierarchy.levels), controller.hierarchy.n

    def state(self, k: int, t: float, state: RobotState, *, solved: bool = False) -> None:
        """Log the state at the beginning of tick k; `solved` tells that the controller has just solved there."""
        self.t[k], self.q[k], self.v[k], self.pose[k] = t, state.q, state.v, self._pose(state)
        for _, part, values in self.errors:
            known = self._controller.error(part) if solved and isinstance(part, Part) else None
            values[k] = part.error(state, t) if known is None else known
        self.states = k + 1

    def tick(self, k: int, a: Array, step: Step[Any, Any, Any]) -> None:
        """Log the result of tick k; the arrays of the controller must still hold its bounds."""
        self.a[k] = a
        if self.tau is not None:
            self.tau[k] = np.nan if step.tau is None else step.tau
        for name, force in ({} if step.forces is None else step.forces).items():
            if name not in self.forces:
                self.forces[name] = np.full((self._ticks, *force.shape), np.nan)
            self.forces[name][k] = force
        self.status.append(step.solution.status)
        if self.bounds or self.torque_bounds:
            stack, bounds = self._controller.stack, self._controller.bounds
            for _, part, lowers, uppers in (*self.bounds, *self.torque_bounds):
                lowers[k], uppers[k] = bounds(part) if part in stack else FREE

    def check(self, t: float, solution: Solution, passed: bool) -> None:
        """Log a tick that was put to the certificate; `passed` tells whether it was accepted."""
        self.checked_t.append(t)
        self.certified += bool(passed)
        ranks = [level.rank for level in solution.levels]
        self.ranks.append((ranks + [0] * self._levels)[: self._levels])
        self.shortfalls.append(shortfalls(solution))

    def record(self, stopped: Stop | None) -> Record:
        """The record of the ticks that were run; `stopped` tells why the run ended early, if it did."""
        n = self.states
        q, v, a = self.q[:n], self.v[:n], self.a[: n - 1]
        x = v[1:] if self.order == "velocity" else a
        with np.errstate(all="ignore"):
            tau = None if self._torque is None else _frozen(self._torque(q[:-1], v[:-1], a))
            bias = None if self._torque is None else self._torque(q[:-1], v[:-1], np.zeros_like(a))
            manipulability = None if self._manipulability is None else _frozen(self._manipulability(q))
        if self.tau is not None and bias is not None:
            tau, bias = _frozen(self.tau[: n - 1]), bias[:, base(self._controller.robot) :]
        active = {name: _sides(x, low[: n - 1], high[: n - 1]) for name, _, low, high in self.bounds}
        if tau is not None and bias is not None:  # bounds of torque rows are those of tau less the bias
            active |= {
                name: _sides(tau, low[: n - 1] + bias, high[: n - 1] + bias)
                for name, _, low, high in self.torque_bounds
            }
        return Record(
            t=_frozen(self.t[:n]),
            q=_frozen(q),
            v=_frozen(v),
            a=_frozen(a),
            tau=tau,
            pose=_frozen(self.pose[:n]),
            manipulability=manipulability,
            errors={name: _frozen(values[:n]) for name, _, values in self.errors},
            active={name: _frozen(sides) for name, sides in active.items()},
            status=tuple(self.status[: n - 1]),
            checked_t=_frozen(np.array(self.checked_t, dtype=np.float64)),
            ranks=_frozen(np.array(self.ranks, dtype=np.int64).reshape(-1, self._levels)),
            certified=self.certified,
            stopped=stopped,
            shortfalls=tuple(self.shortfalls),
            unknowns=self._unknowns,
            robot=self._controller.robot,
            forces={name: _frozen(forces[: n - 1]) for name, forces in self.forces.items()},
        )


def _named(parts: Iterable[P]) -> Iterator[tuple[str, P]]:
    """Every part with a unique name: a second part of the same name gets a number."""
    taken: set[str] = set()
    for part in parts:
        name, number = part.name, 1
        while name in taken:
            number += 1
            name = f"{part.name} {number}"
        taken.add(name)
        yield name, part


def _asked_at_once(
    method: Callable[..., Array] | None, name: str, example: tuple[Array, ...], shape: tuple[int, ...]
) -> Callable[..., Array] | None:
    """The method, or None; a method that does not take leading axes is refused before the run.

    It is called with `example`, and must give `shape`; `name` is for the message.
    """
    if method is None:
        return None
    asked = f"{name} of the robot, asked for arrays of one row,"
    try:
        given = np.shape(method(*example))
    except Exception as error:
        raise InvalidInput(f"{asked} raised {type(error).__name__}: {error}; it must take leading axes") from error
    if given != shape:
        raise InvalidInput(f"{asked} gives shape {given}; it must take leading axes and give {shape}")
    return method


def _sides(x: Array, lower: Array, upper: Array) -> NDArray[np.int8]:
    """The :class:`hqp.Side` of each x; an x beyond a bound counts as on it."""
    near = AT_BOUND * (1.0 + np.abs(x))
    at_lower, at_upper = x <= lower + near, x >= upper - near
    sides = at_upper.astype(np.int8) * np.int8(Side.UPPER)
    sides[at_lower] = Side.LOWER
    sides[at_lower & at_upper] = Side.EQUALITY
    return sides


def _frozen(array: NDArray[Scalar]) -> NDArray[Scalar]:
    own = np.array(array)
    own.flags.writeable = False
    return own
