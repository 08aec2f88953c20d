"""Arrays that view raw memory, and a clock, as intrinsics that Numba compiles.

The views have no owner, so that no references are counted: a kernel that takes fifty arrays from one block and passes
them on would otherwise spend most of a small solve on counting. The caller keeps the block alive.
"""

from __future__ import annotations

import ctypes
import time

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.cgutils import alloca_once, get_or_insert_function
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

from .compile import INTERPRETED
from .layout import HEAD, LOWER, UPPER, WEIGHTS, A


def _array(kind, axes):
    """Signature and code of an intrinsic (directory, place) -> the contiguous array of `axes` axes there."""
    array = types.Array(kind, axes, "C")

    def build(context, builder, signature, arguments):
        here, place = arguments
        long, number = context.get_value_type(types.int64), context.get_value_type(kind)
        entry = builder.add(long(HEAD), builder.mul(place, long(3)))
        directory = builder.inttoptr(here, long.as_pointer())
        address, *shape = (builder.load(builder.gep(directory, [builder.add(entry, long(k))])) for k in range(axes + 1))
        data = builder.inttoptr(address, number.as_pointer())
        return _view(context, builder, array, data, shape)

    return array(types.int64, types.int64), build


def _view(context, builder, array, data, shape):
    """An array without an owner, of numbers of eight bytes."""
    item = context.get_constant(types.intp, 8)
    strides = [item] if array.ndim == 1 else [builder.mul(shape[1], item), item]
    view = make_array(array)(context, builder)
    populate_array(view, data=data, shape=shape, strides=strides, itemsize=item, meminfo=None)
    return view._getvalue()


@intrinsic
def vector(typing, here, place):
    """The float64 array of one axis at this place of the directory."""
    return _array(types.float64, 1)


@intrinsic
def matrix(typing, here, place):
    """The float64 array of two axes at this place of the directory."""
    return _array(types.float64, 2)


@intrinsic
def marks(typing, here, place):
    """The int64 array of one axis at this place of the directory."""
    return _array(types.int64, 1)


def _raw(kind):
    array = types.Array(kind, 1, "C")

    def build(context, builder, signature, arguments):
        address, first, count = arguments
        data = builder.gep(builder.inttoptr(address, context.get_value_type(kind).as_pointer()), [first])
        return _view(context, builder, array, data, [count])

    return array(types.int64, types.int64, types.int64), build


@intrinsic
def floats(typing, address, first, count):
    """float64 array (count,), which begins `first` numbers after the address."""
    return _raw(types.float64)


@intrinsic
def ints(typing, address, first, count):
    """int64 array (count,), which begins `first` numbers after the address."""
    return _raw(types.int64)


@intrinsic
def given(typing, here, numbers):
    """Point A, LOWER, UPPER and WEIGHTS of the directory to the numbers at an address, where they follow each other."""

    def build(context, builder, signature, arguments):
        here, address = arguments
        long = context.get_value_type(types.int64)
        directory = builder.inttoptr(here, long.as_pointer())
        for place in (A, LOWER, UPPER, WEIGHTS):
            entry = [builder.gep(directory, [long(HEAD + 3 * place + k)]) for k in range(3)]
            builder.store(address, entry[0])
            count = builder.mul(builder.load(entry[1]), builder.load(entry[2]))
            address = builder.add(address, builder.mul(count, long(8)))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), build


#: Which POSIX clock; None if the system has none: time limits are then ignored.
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


if INTERPRETED:

    def floats(address, first, count):
        return _at(address + 8 * first, ctypes.c_double, count)

    def ints(address, first, count):
        return _at(address + 8 * first, ctypes.c_int64, count)

    def vector(here, place):
        address, count, _ = ints(here, HEAD + 3 * place, 3)
        return floats(address, 0, count)

    def matrix(here, place):
        address, rows, columns = ints(here, HEAD + 3 * place, 3)
        return floats(address, 0, rows * columns).reshape(rows, columns)

    def marks(here, place):
        address, count, _ = ints(here, HEAD + 3 * place, 3)
        return ints(address, 0, count)

    def given(here, numbers):
        for place in (A, LOWER, UPPER, WEIGHTS):
            entry = ints(here, HEAD + 3 * place, 3)
            entry[0], numbers = numbers, numbers + 8 * entry[1] * entry[2]

    def clock():
        return 0 if MONOTONIC is None else time.clock_gettime_ns(MONOTONIC)

    def _at(address, kind, count):
        """The numbers at an address, as a NumPy array: its 1 / 0 is infinite, as in compiled kernels."""
        return np.ctypeslib.as_array((kind * int(count)).from_address(int(address))) if count else np.empty(0, kind)
