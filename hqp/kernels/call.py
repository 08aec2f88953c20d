"""Calls of compiled loops by their address, so that a loop can call another one without compiling it anew."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .compile import INTERPRETED


def _call(count):
    """Signature and code of an intrinsic that calls the loop at an address with `count` integers."""

    def build(context, builder, signature, arguments):
        long = ir.IntType(64)
        kind = ir.FunctionType(long, [long] * count)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.int64(*[types.int64] * (count + 1)), build


@intrinsic
def called(typing, loop, here):
    """Call the loop at address `loop` with one argument, the address of its table or directory; returns its result."""
    return _call(1)


@intrinsic
def called_on(typing, loop, here, numbers):
    """Call the loop at address `loop` with two arguments, such as a directory and numbers; returns its result."""
    return _call(2)


@cache
def address_of(kernel, signature):
    """The address of a loop compiled for this signature; where the interpreter runs loops, its place in KNOWN."""
    if INTERPRETED:
        KNOWN.append(kernel)
        return len(KNOWN) - 1
    kernel.compile(signature)
    found = kernel.overloads[signature.args]
    return int(found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name))


def is_ready(kernel):
    """Whether a loop can be called: the interpreter's, or one that was compiled or read from disk."""
    return INTERPRETED or bool(kernel.signatures)


#: Where the interpreter runs loops: the loops whose "address" is their place here. No loop has address 0.
KNOWN: list[Callable[..., int] | None] = [None]

if INTERPRETED:

    def called(loop, here):
        return KNOWN[int(loop)](here)

    def called_on(loop, here, numbers):
        return KNOWN[int(loop)](here, numbers)
