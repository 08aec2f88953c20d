"""What Numba does not offer as it is needed here: views of raw memory, and the clock.

Views are arrays without an owner, so that no reference is ever counted.

A kernel that cuts fifty arrays from one block, and hands them on, would else spend most of a small solve on
counters. The caller keeps the block alive.
"""

from __future__ import annotations

import time

from llvmlite import ir
from numba import types
from numba.core.cgutils import alloca_once, get_or_insert_function
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array


def _view(kind, axes):
    """An intrinsic (address, first number, shape...) -> contiguous array."""
    array = types.Array(kind, axes, "C")

    def build(context, builder, signature, arguments):
        address, first, *shape = arguments
        number = context.get_value_type(kind)
        data = builder.gep(builder.inttoptr(address, number.as_pointer()), [first])
        item = context.get_constant(types.intp, 8)
        strides = [item] if axes == 1 else [builder.mul(shape[1], item), item]
        view = make_array(array)(context, builder)
        populate_array(view, data=data, shape=shape, strides=strides, itemsize=item, meminfo=None)
        return view._getvalue()

    return array, build


@intrinsic
def floats(typing, address, first, count):
    """float64 (count,), from the first-th number on."""
    array, build = _view(types.float64, 1)
    return array(types.int64, types.int64, types.int64), build


@intrinsic
def ints(typing, address, first, count):
    """int64 (count,), from the first-th number on."""
    array, build = _view(types.int64, 1)
    return array(types.int64, types.int64, types.int64), build


@intrinsic
def matrix(typing, address, first, rows, columns):
    """float64 (rows, columns), from the first-th number on."""
    array, build = _view(types.float64, 2)
    return array(types.int64, types.int64, types.int64, types.int64), build


#: Which clock; none where the system has no POSIX clocks, and time limits are not kept.
MONOTONIC = getattr(time, "CLOCK_MONOTONIC", None)


@intrinsic
def clock(typing):
    """Nanoseconds of a clock that never goes back; 0 where there is none."""

    def build(context, builder, signature, arguments):
        long, short = ir.IntType(64), ir.IntType(32)
        if MONOTONIC is None:
            return long(0)
        pair = ir.ArrayType(long, 2)  # struct timespec
        reading = alloca_once(builder, pair)
        kind = ir.FunctionType(short, [short, pair.as_pointer()])
        builder.call(get_or_insert_function(builder.module, kind, "clock_gettime"), [short(MONOTONIC), reading])
        seconds, rest = (builder.extract_value(builder.load(reading), k) for k in range(2))
        return builder.add(builder.mul(seconds, long(1_000_000_000)), rest)

    return types.int64(), build
