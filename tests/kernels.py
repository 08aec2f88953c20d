"""Loops of one module, both ways: compiled, and as plain Python."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any
from unittest import mock

from numba import njit

from hqp.kernels import compile as compiling


def compiled(kernel: Any, arguments: int) -> Callable[..., Any]:
    """A kernel that other kernels call, to be called from Python."""
    names = ", ".join(f"a{i}" for i in range(arguments))
    scope = {"kernel": kernel}
    exec(f"def call({names}):\n    return kernel({names})", scope)
    return njit(**compiling.ENTRY | {"_nrt": True})(scope["call"])


def plain(module: ModuleType, *below: ModuleType) -> ModuleType:
    """The same module as the interpreter runs it, on others of which the same is true."""
    with mock.patch.dict(sys.modules), mock.patch.object(compiling, "inner", lambda function: function):
        for one in (*below, module):
            spec = importlib.util.spec_from_file_location(one.__name__, one.__file__)
            made = importlib.util.module_from_spec(spec)
            sys.modules[one.__name__] = made
            spec.loader.exec_module(made)
            parent, _, name = one.__name__.rpartition(".")
        return made
