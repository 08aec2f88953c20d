"""The plan of a part: the compiled loops or the Python function that write its rows, and what is updated before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, numbers, per_row
from ..base.once import once
from ..robots.robot import Robot
from .site import Site
from .tick import Order, Tick

if TYPE_CHECKING:
    from ..base.loops import Call

#: What a subclass may refuse by.
CHECK = ("check",)


@dataclass(frozen=True)
class Plan:
    """The compiled loops or the Python function that write the rows of one part.

    Attributes
    ----------
    calls : tuple of Call
        In this order, every tick.
    moves : tuple of callable
        Bring targets up to date, by the time [s].
    python : callable, optional
        What Python writes, before the calls.
    why : str
        Why Python does.
    curvature : Call, optional
        Adds ``S(w)`` of :mod:`tasks.rows.curvature`, on request, at the state of the last tick. The first two
        entries of its table are where the weights (rows,) are, and the sum (nv, nv); whoever runs it may put other
        addresses there. Without one the rows are linear, or their curvature is not known.
    bound : callable, optional
        A loop with the table of `curvature`, but for the first entry: F (rows, rows), which it writes, so that the
        Frobenius norm of S(w) is at most the root of w' F w.
    linear : bool
        Whether the rows are the same in every configuration.
    """

    calls: tuple[Call, ...] = ()
    moves: tuple[Callable[[float], None], ...] = ()
    python: Callable[[Tick], None] | None = None
    why: str = ""
    curvature: Call | None = None
    bound: Any = None
    linear: bool = False

    def curvature_of(self, weights: ArrayLike) -> Array:
        """``S(w)`` of these weights, one a row, at the state of the last tick; shape (nv, nv).

        Raises
        ------
        InvalidInput
            If the part has no curvature.
        """
        if self.curvature is None:
            raise InvalidInput("this part has no curvature: its rows are straight, or nobody tells how they bend")
        from ..base.loops import address, ready

        table = self.curvature.table.numbers.copy()
        rows, total = (np.zeros_like(told) for told in self.curvature.table.told[:2])
        rows[:] = per_row(numbers(weights, "weights"), len(rows), "weights")
        table[:2] = address(rows), address(total)
        ready(self.curvature.kernel)(address(table))
        return total


class Planned(Protocol):
    """The methods of a part that its plan is made by; see :class:`tasks.rows.row_writer.RowWriter`."""

    @property
    def says(self) -> tuple[str, ...]: ...

    def check(self, robot: Robot, order: Order, dt: float | None) -> None: ...

    def check_numbers(self, robot: Robot, order: Order, dt: float | None) -> None: ...

    def plan(self, site: Site) -> Plan: ...

    def python_plan(self, site: Site) -> Plan: ...


def plan_of(part: Planned, site: Site) -> Plan:
    """How a part writes its rows here: by the plan of its class, unless a subclass says what that cannot know."""
    own = overridden(type(part), part.says)
    return part.plan(site) if own is None else replace(part.python_plan(site), why=own)


def check_numbers(part: Planned, robot: Robot, order: Order, dt: float | None) -> None:
    """Have a part refuse the numbers that it has now; by its whole check, where a subclass has one of its own."""
    own = overridden(type(part), CHECK, "check_numbers")
    (part.check_numbers if own is None else part.check)(robot, order, dt)


@once
def overridden(kind: type, says: tuple[str, ...], knows: str = "plan") -> str | None:
    """What a subclass says in Python, below the class that has the plan; None where the plan is right for it too.

    So it is of any other method that `knows` what is said in Python.
    """
    for cls in kind.__mro__:
        if knows in vars(cls):
            return None
        own = [name for name in says if name in vars(cls)]
        if own:
            return f"{cls.__name__} has its own {own[0]}()"
    raise AssertionError(kind)


def free(site: Site) -> Plan:
    """The plan of a limit that says nothing at this order: its rows have no bounds."""
    site.lower[:], site.upper[:] = -inf, inf
    return Plan()
