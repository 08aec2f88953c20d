"""Loops that other loops call, both ways: compiled, and as the interpreter runs them."""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Callable
from functools import cache
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest import mock

from numba import njit

from hqp.kernels import compile as compiling


@cache
def compiled(module: ModuleType, *names: str) -> SimpleNamespace:
    """These kernels of a module, each with a door for Python."""
    return SimpleNamespace(**{name: _door(getattr(module, name)) for name in names})


def _door(kernel: Any) -> Callable[..., Any]:
    arguments = ", ".join(inspect.signature(kernel.py_func).parameters)
    scope = {"kernel": kernel}
    exec(f"def door({arguments}):\n    return kernel({arguments})", scope)
    return njit(fastmath=compiling.FAST, error_model="numpy")(scope["door"])


def plain(*modules: ModuleType) -> ModuleType:
    """The last of these modules as plain Python, and the others, which it imports, too."""
    changes = {"inner": lambda function: function, "precise": lambda function: function, "INTERPRETED": True}
    with mock.patch.dict(sys.modules), mock.patch.multiple(compiling, **changes):
        for module in modules:
            spec = importlib.util.spec_from_file_location(module.__name__, module.__file__)
            made = sys.modules[module.__name__] = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(made)
        return made
