"""The measured methods, by name. A module here that has a tuple `METHODS` adds its own: a new method is one file."""

from __future__ import annotations

import sys

from hqp import InvalidInput

from ..registry import registered
from .method import Call, Method, Outcome

#: All of them, in the order of their files, whether they can run here or not.
METHODS: dict[str, Method] = {method.name: method for method in registered(sys.modules[__name__], "METHODS")}


def required(methods: list[Method]) -> list[Method]:
    """These methods, every one of which must be here.

    Raises
    ------
    InvalidInput
        If one cannot run here.
    """
    for method in methods:
        if why := method.missing():
            raise InvalidInput(f"{method.name}: {why}")
    return methods


__all__ = ["METHODS", "Call", "Method", "Outcome", "required"]
