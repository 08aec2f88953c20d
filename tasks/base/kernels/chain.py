"""Runs many loops by one call: from Python each call would cost more than most loops take."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import ints


@intrinsic
def called(typing, loop, here):
    """Call the loop at this address with what it is told."""

    def build(context, builder, signature, arguments):
        long = ir.IntType(64)
        kind = ir.FunctionType(long, [long])
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), [arguments[1]])

    return types.int64(types.int64, types.int64), build


@stamp
@entry
def run_chain(here):
    """How many loops, and the address of each with that of its table."""
    count = ints(here, 0, 1)[0]
    told = ints(here, 1, 2 * count)
    for k in range(count):
        called(told[2 * k], told[2 * k + 1])
    return 0
