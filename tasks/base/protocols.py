"""Whether an object satisfies a protocol: a structural check, cached by class."""

from __future__ import annotations

from typing import Protocol, TypeGuard, TypeVar

from .once import once

T = TypeVar("T")

#: Marks an attribute that a value does not have.
ABSENT = object()


def has(value: object, kind: type[T]) -> TypeGuard[T]:
    """Whether a value has all attributes of a protocol; a method that is None counts as missing.

    The result is that of ``isinstance``, which takes microseconds in old Pythons and evaluates properties.
    """
    by_class = _by_class(type(value), kind)
    return by_class or all(_there(value, name, method) for name, method in _members(kind))


@once
def _by_class(of: type, kind: type) -> bool:
    """Whether a class has all attributes of a protocol, so that its objects need no check."""
    own = [(getattr(of, name, ABSENT), method) for name, method in _members(kind)]
    return all(value is not ABSENT and not (method and value is None) for value, method in own)


def _there(value: object, name: str, method: bool) -> bool:
    own = getattr(type(value), name, ABSENT)
    if own is ABSENT:
        own = getattr(value, name, ABSENT)
    return own is not ABSENT and not (method and own is None)


@once
def _members(kind: type) -> tuple[tuple[str, bool], ...]:
    """The attributes of a protocol, and whether each is a method."""
    found: dict[str, bool] = {}
    for base in reversed(kind.__mro__):
        if getattr(base, "_is_protocol", False) and base is not Protocol:
            found |= dict.fromkeys(vars(base).get("__annotations__", {}), False)
            own = {name: value for name, value in vars(base).items() if not name.startswith("_")}
            found |= {name: not isinstance(value, property) and callable(value) for name, value in own.items()}
    return tuple(found.items())
