"""Views of raw memory: arrays without an owner, so that no reference is ever counted.

A kernel that cuts fifty arrays from one block, and hands them on, would else spend most of a small solve on
counters. The caller keeps the block alive.
"""

from __future__ import annotations

from numba import types
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
