"""Indices in kernels, which count from the front.

Python counts ``x[-1]`` from the end, so Numba asks of every index whether it is negative: of one that comes from a
table, as of most in kernels, with a comparison and a choice for each axis. No kernel counts from the end.
"""

from __future__ import annotations

from contextlib import contextmanager

from numba import types
from numba.np import arrayobj

#: What of Numba's arrays is replaced here while a kernel is translated.
PRIVATE = ("fix_integer_index",)


def _as_it_is(context, builder, kind, index, size):
    """The place of an index, which is not negative."""
    return context.cast(builder, index, kind, types.intp)


@contextmanager
def from_the_front():
    """Have Numba, which compiles one function at a time, take indices as they are."""
    usual = arrayobj.fix_integer_index
    arrayobj.fix_integer_index = _as_it_is
    try:
        yield
    finally:
        arrayobj.fix_integer_index = usual
