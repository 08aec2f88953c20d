"""Checks of scalar input: numbers, names, objects. A refusal names the argument, its value and what is allowed."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping
from numbers import Integral, Real
from typing import Any, ClassVar, TypeVar

import numpy as np

from .errors import InvalidInput, brief

T = TypeVar("T")

#: What the counters of compiled solvers hold.
LARGEST_COUNT = 2**31 - 1
#: An integer, and a number, as files and command lines spell them.
INTEGER = re.compile(r"[+-]?\d{1,999}", re.ASCII)
SPELLED = re.compile(r"[+-]?((\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?|inf(inity)?|nan)", re.ASCII | re.IGNORECASE)


def whole_number(value: object, what: str, least: int = 0, most: int = LARGEST_COUNT) -> int:
    """`value` as an int from `least` to `most`; True and 2.0 are none."""
    if not isinstance(value, Integral) or isinstance(value, bool) or int(value) < least:
        raise InvalidInput(f"{what} = {brief(value)} must be an integer of at least {least}")
    if int(value) > most:
        raise InvalidInput(f"{what} = {brief(value)} must be an integer of at most {most}")
    return int(value)


def real_number(value: object, what: str) -> float:
    """`value` as a float, which may be infinite or NaN; True, a string and an array are none."""
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:  # an int of more than 308 digits
            pass
    raise InvalidInput(f"{what} = {brief(value)} must be a real number")


def spelled_integer(word: str) -> int | None:
    """The integer that a word of a command line spells, or None; ``1_0`` and ``1.0`` are none."""
    return int(word) if INTEGER.fullmatch(word) else None


def spelled_number(word: str) -> float | None:
    """The number that a word of a file or of a command line spells, or None; infinite and NaN are numbers.

    Unlike ``float``: what Python alone reads as a number, as ``1_0`` or digits of other scripts, is none.
    """
    return float(word) if SPELLED.fullmatch(word) else None


def positive_number(value: object, what: str, below: float = math.inf, endless: bool = False) -> float:
    """`value` as a float between 0 and `below`, neither included; if `endless`, infinity is allowed, too."""
    number = real_number(value, what)
    if 0.0 < number < below or (endless and number == math.inf):
        return number
    allowed = "positive, and may be infinite" if endless else "positive and finite"
    raise InvalidInput(f"{what} = {number} must be {allowed if below == math.inf else f'positive and below {below:g}'}")


def truth(value: object, what: str) -> bool:
    """`value`, which must be True or False."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise InvalidInput(f"{what} = {brief(value)} must be True or False")


def listed(value: Iterable[T], what: str, of: str) -> list[T]:
    """`value` as a list; a text, an array without axes and a thing that is no sequence are none."""
    if not isinstance(value, str | bytes):
        try:
            items = iter(value)
        except TypeError:  # nothing to go through
            pass
        else:
            return list(items)
    raise InvalidInput(f"{what} = {brief(value)} is a {type(value).__name__}; it must be a list of {of}")


def one_of(value: object, choices: Collection[str], what: str) -> str:
    """`value`, which must be one of these words."""
    if isinstance(value, str) and value in choices:
        return value
    raise InvalidInput(f"{what} = {brief(value)}; it must be one of {', '.join(map(repr, choices))}")


def of_type(value: object, kind: type[T], what: str) -> T:
    """`value`, which must be a `kind`."""
    if isinstance(value, kind):
        return value
    wanted = "dict" if kind is Mapping else kind.__name__
    raise InvalidInput(f"{what} = {brief(value)} is a {type(value).__name__}; it must be a {wanted}")


class SetOnce:
    """Refuses to set the attributes that it names a second time, which would change what is told and not what is done.

    The value that is there may be set again, as ``hierarchy.lower += 1.0`` does once it has written in place.
    Attributes of other names, as those of a subclass, are free.
    """

    #: The attributes that stay, and what to do in place of setting one.
    _stays: ClassVar[frozenset[str]] = frozenset()
    _instead: ClassVar[str] = "make a new one"

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self._stays and getattr(self, name, value) is not value:
            raise InvalidInput(f"{type(self).__name__}: {name} is set once, when it is made; {self._instead}")
        object.__setattr__(self, name, value)
