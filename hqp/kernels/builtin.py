"""A kernel as a built-in function of Python, called with arrays.

Numba's own wrapper takes integers. To make those of addresses, to collect them in a tuple and to read them takes 0.1 us
a call, as long as a tenth of the smallest solves. A function made here gets the arrays themselves, and what is the same
in every call from an array of its own: it is what ``PyCFunction_New`` makes of a compiled loop for ``METH_FASTCALL``.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.extending import intrinsic

from ..arrays import Array
from . import layout as at
from . import ready
from .active_set import OPTIMAL
from .call import address_of, called_on
from .compile import INTERPRETED, entry, stamp
from .memory import floats, ints, vector
from .workspace import Workspace

#: Of the loop below: the function's own array, the arguments, and their number.
SIGNATURE = types.int64(types.int64, types.int64, types.int64)
#: ``METH_FASTCALL`` of Python's ``methodobject.h``.
FASTCALL = 0x80
#: Where an array has the address of its numbers, in bytes: behind what all objects begin with.
DATA = object.__basicsize__


def _api(name, result, *kinds):
    """Signature and code of an intrinsic that calls a function of Python's own interface."""

    def build(context, builder, signature, arguments):
        words = [context.get_value_type(kind) for kind in kinds]
        given = ir.VoidType() if result is types.void else context.get_value_type(result)
        function = get_or_insert_function(builder.module, ir.FunctionType(given, words), name)
        answer = builder.call(function, arguments)
        return context.get_dummy_value() if result is types.void else answer

    return result(*kinds), build


@intrinsic
def release(typing):
    """Let other threads have the interpreter; returns what it takes to have it back."""
    return _api("PyEval_SaveThread", types.int64)


@intrinsic
def take_back(typing, thread):
    """Wait for the interpreter."""
    return _api("PyEval_RestoreThread", types.void, types.int64)


@intrinsic
def boxed(typing, number):
    """This integer as an object of Python."""
    return _api("PyLong_FromLongLong", types.int64, types.int64)


@stamp
@entry
def run(own, arguments, count):
    """Call the loop at ``own[0]`` with the directory at ``own[1]`` and the numbers in the first argument.

    x and the work are read from the directory at ``own[2]``.

    Returns
    -------
    told : int
        Where the loop has proved an optimum, what it took, sweeps + :data:`ITERATION` * iterations, and the second
        argument is x. Otherwise -1. No object, an error, where there are not two arguments.
    """
    if count != 2:
        return 0
    table = ints(ints(own + DATA, 0, 1)[0], 0, 3)
    given = ints(arguments, 0, 2)
    here, numbers, point = table[2], ints(given[0] + DATA, 0, 1)[0], ints(given[1] + DATA, 0, 1)[0]
    thread = release()
    outcome = called_on(table[0], table[1], numbers)
    head, told = ints(here, 0, at.HEAD), -1
    if outcome == OPTIMAL:
        n, x = head[at.N], vector(here, at.X)
        answer = floats(point, 0, n)
        for j in range(n):
            answer[j] = x[j]
        told = head[at.SWEEPS] + at.ITERATION * head[at.ITERATIONS]
    take_back(thread)
    return boxed(told)


class _Method(ctypes.Structure):
    """``PyMethodDef``: the name of a function, its address, how it is called, and its documentation."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("address", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )


_make = ctypes.pythonapi.PyCFunction_NewEx
_make.restype, _make.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.py_object, ctypes.py_object)
#: Functions point to the one definition of what they are, so it stays.
_METHOD = _Method(b"run", None, FASTCALL, b"Solve: numbers and x, an array to write; what it took, or -1.")


def runner(workspace: Workspace, kernel: Any, address: int | None = None) -> Callable[[Array, Array], int]:
    """A function of numbers and an array for x by which a kernel solves in this workspace; what it tells: :func:`run`.

    A kernel with a directory of its own, at this address, tells x and its work in the workspace. Where the interpreter
    runs loops, or arrays are not as known here, the function is written in Python.
    """
    here, array = workspace.address if address is None else address, np.zeros(1)
    if not INTERPRETED and ctypes.c_size_t.from_address(id(array) + DATA).value == array.ctypes.data:
        _METHOD.address = address_of(run, SIGNATURE)
        own = np.array([address_of(kernel, ready.SIGNATURE), here, workspace.address], dtype=np.int64)
        made: Callable[[Array, Array], int] = _make(ctypes.addressof(_METHOD), own, workspace)  # which lives as long
        return made
    solve = ready.door(kernel)

    def run_in_python(numbers: Array, x: Array) -> int:
        if solve(here, numbers.ctypes.data) != OPTIMAL:
            return -1
        x[:] = workspace.x
        return int(workspace.head[at.SWEEPS] + at.ITERATION * workspace.head[at.ITERATIONS])

    return run_in_python
