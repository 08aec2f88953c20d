"""A cache for functions of one or few arguments."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def once(function: Callable[P, T]) -> Callable[P, T]:
    """As ``functools.cache``, which takes no classes where types are checked, and forgets what the arguments are."""
    return cache(function)  # type: ignore[return-value]  # it takes what is hashable, classes too
