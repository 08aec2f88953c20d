"""Indices in kernels, which count from the front.

Python counts ``x[-1]`` from the end, so Numba asks of every index whether it is negative: of one that comes from a
table, as of most in kernels, with a comparison and a choice for each axis. No kernel counts from the end.
"""

from __future__ import annotations

import os
from contextlib import contextmanager

from llvmlite import ir
from numba import types
from numba.np import arrayobj

#: What of Numba's arrays is replaced here while a kernel is translated.
PRIVATE = ("fix_integer_index",)
#: Whether an index that is negative ends the process, at once: for those who change kernels, see CONTRIBUTING.md.
TRAPPED = os.environ.get("HQP_TRAP_INDICES") == "1"


def _as_it_is(context, builder, kind, index, size):
    """The place of an index, which is not negative."""
    place = context.cast(builder, index, kind, types.intp)
    if TRAPPED:
        with builder.if_then(builder.icmp_signed("<", place, place.type(0)), likely=False):
            nothing = ir.FunctionType(ir.VoidType(), [])
            builder.call(builder.module.declare_intrinsic("llvm.trap", (), nothing), [])
    return place


@contextmanager
def from_the_front():
    """Have Numba, which compiles one function at a time, take indices as they are."""
    usual = arrayobj.fix_integer_index
    arrayobj.fix_integer_index = _as_it_is
    try:
        yield
    finally:
        arrayobj.fix_integer_index = usual
