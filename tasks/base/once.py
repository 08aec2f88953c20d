"""A cache for functions of one or few arguments."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def once(function: Callable[P, T]) -> Callable[P, T]:
    """``functools.cache`` for type checkers: it keeps the types of the arguments, and accepts classes."""
    return cache(function)  # type: ignore[return-value]  # any hashable argument works, also a class
