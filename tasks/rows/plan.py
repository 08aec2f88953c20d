"""How the rows of a part are written: loops and what they are told, and what has to be brought up to date before."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from ctypes import addressof, c_char
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numba import int64
from numpy.typing import NDArray

from hqp.backends.native import make_ready
from hqp.kernels.compile import INTERPRETED, entries

if TYPE_CHECKING:
    from ..part import Part, Tick
    from .site import Site

#: Of a loop: the address of what it is told; nothing of interest.
SIGNATURE = int64(int64)
WHAT = "the rows of tasks"
#: Where loops are.
LOOPS = (
    "..kernels.chain",
    "..kernels.law",
    "..kernels.frames",
    "..kernels.directions",
    "..kernels.joints",
    "..kernels.robots",
    "..kernels.steps",
    "..kernels.joint_motion",
    "..kernels.envelope",
    "..limits.kernels",
    "..criteria.kernels.measures",
)
#: What a loop is told of: a size, an address, or by its address an array or a table.
Entry: TypeAlias = "int | np.integer[Any] | NDArray[Any] | Table"


class Table:
    """Sizes and addresses that a loop is told of, in one array; whoever has the table keeps what it tells of.

    Parameters
    ----------
    *told : int, array or Table
        Arrays and tables are told by their address.
    """

    def __init__(self, *told: Entry) -> None:
        self.told = told
        self.numbers = np.array([address(entry) for entry in told], dtype=np.int64)


class Call:
    """One loop, and what it is told of.

    Parameters
    ----------
    kernel : callable
        See :func:`hqp.kernels.compile.entry`.
    *told : int, array or Table
    """

    def __init__(self, kernel: Any, *told: Entry) -> None:
        self.kernel, self.table = kernel, Table(*told)
        self.run = partial(ready(kernel), address(self.table))
        self.run.__dict__["table"] = self.table  # whoever has the one has the other


@dataclass(frozen=True)
class Plan:
    """How one part writes its rows.

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
    """

    calls: tuple[Call, ...] = ()
    moves: tuple[Callable[[float], None], ...] = ()
    python: Callable[[Tick], None] | None = None
    why: str = ""


def plan_of(part: Part, site: Site) -> Plan:
    """How a part writes its rows here: by the plan of its class, unless a subclass says what that cannot know."""
    own = overridden(type(part), part.says)
    return part.plan(site) if own is None else replace(part.python_plan(site), why=own)


@cache
def overridden(kind: type[Part], says: tuple[str, ...], knows: str = "plan") -> str | None:
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


def address(entry: Entry) -> int:
    """Where an array is, or that of a table; a size is itself."""
    if isinstance(entry, Table):
        entry = entry.numbers
    if not isinstance(entry, np.ndarray):
        return int(entry)
    try:
        return addressof(c_char.from_buffer(entry))  # type: ignore[arg-type]  # a quarter of the time
    except (TypeError, ValueError):  # read-only, by columns, or empty
        return int(entry.__array_interface__["data"][0])


@cache
def ready(kernel: Any) -> Callable[[int], object]:
    """The compiled loop, from disk or compiled now; where the interpreter runs loops, the loop itself."""
    if INTERPRETED:
        return kernel  # type: ignore[no-any-return]
    make_ready(kernel, WHAT, SIGNATURE)
    return kernel.get_overload(SIGNATURE)  # type: ignore[no-any-return]


def run_all(calls: Iterable[Call]) -> None:
    """One after the other."""
    for call in calls:
        call.run()


def chained(calls: Iterable[Call]) -> Callable[[], object]:
    """What runs them, one after the other, at the price of one call from Python."""
    kept = tuple(calls)
    if INTERPRETED or len(kept) < 2:
        return partial(run_all, kept)
    from ..kernels.chain import run_chain

    chain = Call(run_chain, len(kept), *(told for call in kept for told in (compiled(call.kernel), call.table)))
    return chain.run


@cache
def compiled(kernel: Any) -> int:
    """The address of a compiled loop."""
    ready(kernel)
    found = kernel.overloads[SIGNATURE.args]
    return int(found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name))


def warm_up() -> bool:
    """Have all loops of rows ready: from disk, or compiled now. True if one had to be compiled."""
    from importlib import import_module

    for name in LOOPS:
        import_module(name, __package__)
    return sum(make_ready(kernel, WHAT, SIGNATURE) for kernel in entries("tasks")) > 0
