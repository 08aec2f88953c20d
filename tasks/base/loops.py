"""Calls of compiled loops: arguments as sizes and addresses in one table.

A loop is a kernel (:func:`hqp.kernels.compile.entry`) whose one argument is the address of a table. It is compiled at
first use and cached on disk; under ``NUMBA_DISABLE_JIT=1`` the interpreter runs it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from ctypes import addressof, c_char
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numba import int64
from numpy.typing import NDArray

from hqp.kernels.call import address_of
from hqp.kernels.compile import INTERPRETED, entries
from hqp.kernels.ready import door, make_ready

from .once import once

#: Type of a loop: it takes the address of its table; its return value is not used.
SIGNATURE = int64(int64)
WHAT = "the rows of tasks"
#: An argument of a loop: a size, an address, or an array or table, which is passed by its address.
Entry: TypeAlias = "int | np.integer[Any] | NDArray[Any] | Table"


class Table:
    """The arguments of a loop, sizes and addresses in one array; the table keeps the arrays alive.

    Parameters
    ----------
    *told : int, array or Table
        Arrays and tables are passed by their address.
    """

    def __init__(self, *told: Entry) -> None:
        self.told = told
        self.numbers = np.array([address(entry) for entry in told], dtype=np.int64)


class Call:
    """A compiled loop with its arguments.

    Parameters
    ----------
    kernel : callable
        See :func:`hqp.kernels.compile.entry`.
    *told : int, array or Table
    """

    def __init__(self, kernel: Any, *told: Entry) -> None:
        self.kernel, self.table = kernel, Table(*told)
        self.run = partial(ready(kernel), address(self.table))
        self.run.__dict__["table"] = self.table  # whoever holds `run` keeps the table alive


def address(entry: Entry) -> int:
    """The address of an array, or of the array in a table; a size is returned as it is."""
    if type(entry) is int:
        return entry
    if isinstance(entry, Table):
        entry = entry.numbers
    if not isinstance(entry, np.ndarray):
        return int(entry)
    try:
        return addressof(c_char.from_buffer(entry))  # type: ignore[arg-type]  # a quarter of the time of the line below
    except (TypeError, ValueError):  # read-only, column-major, or empty
        return int(entry.__array_interface__["data"][0])


@once
def ready(kernel: Any) -> Callable[[int], object]:
    """The compiled loop, from disk or compiled now; if the interpreter runs loops, the Python function."""
    make_ready(kernel, WHAT, SIGNATURE)
    return door(kernel, SIGNATURE)


def run_all(calls: Iterable[Call]) -> None:
    """Run these calls, one after the other."""
    for call in calls:
        call.run()


def chained(calls: Iterable[Call]) -> Callable[[], object]:
    """A function that runs these calls one after the other, at the cost of one call from Python."""
    kept = tuple(calls)
    if INTERPRETED or len(kept) < 2:
        return partial(run_all, kept)
    from .kernels.chain import run_chain

    return Call(run_chain, len(kept), *(told for call in kept for told in (compiled(call.kernel), call.table))).run


@once
def compiled(kernel: Any) -> int:
    """The address of a compiled loop."""
    ready(kernel)
    return int(address_of(kernel, SIGNATURE))


def warm_up() -> bool:
    """Load all loops of this package from disk, or compile them. True if one had to be compiled."""
    package = __name__.partition(".")[0]
    home = Path(__file__).parents[1]
    for path in sorted({*home.rglob("kernels.py"), *home.rglob("kernels/*.py")}):
        import_module(".".join((package, *path.relative_to(home).with_suffix("").parts)).removesuffix(".__init__"))
    return sum(make_ready(kernel, WHAT, SIGNATURE) for kernel in entries(package)) > 0
