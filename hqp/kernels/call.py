"""Loops that are known by their address alone: to call one from another, without compiling it into that one."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .compile import INTERPRETED


def _call(count):
    """An intrinsic (loop, numbers) -> what the loop at this address gives for so many numbers."""

    def build(context, builder, signature, arguments):
        long = ir.IntType(64)
        kind = ir.FunctionType(long, [long] * count)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.int64(*[types.int64] * (count + 1)), build


@intrinsic
def called(typing, loop, here):
    """Call the loop at this address with what it is told."""
    return _call(1)


@intrinsic
def called_on(typing, loop, here, numbers):
    """The same for a loop of two addresses."""
    return _call(2)


@cache
def address_of(kernel, signature):
    """The address of a compiled loop; where the interpreter runs loops, a number by which it knows this one."""
    if INTERPRETED:
        KNOWN.append(kernel)
        return len(KNOWN) - 1
    kernel.compile(signature)
    found = kernel.overloads[signature.args]
    return int(found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name))


#: Loops that the interpreter knows by their number.
KNOWN: list[Callable[..., int]] = []

if INTERPRETED:

    def called(loop, here):
        return KNOWN[int(loop)](here)

    def called_on(loop, here, numbers):
        return KNOWN[int(loop)](here, numbers)
