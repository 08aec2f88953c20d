"""Attributes that are set once, when an object is made: what is laid out by them would not follow another value."""

from __future__ import annotations

from typing import Any, ClassVar

from .errors import InvalidInput


class SetOnce:
    """Refuses to set the attributes that it names a second time, which would change what is told and not what is done.

    The value that is there may be set again, as ``hierarchy.lower += 1.0`` does once it has written in place.
    Attributes of other names, as those of a subclass, are free.
    """

    #: The attributes that stay, and what to do in place of setting one.
    _stays: ClassVar[frozenset[str]] = frozenset()
    _instead: ClassVar[str] = "make a new one"

    def __setattr__(self, name: str, value: Any) -> None:
        known = name in vars(self) or hasattr(type(self), name)
        if name in self._stays and known and vars(self).get(name) is not value:
            raise InvalidInput(f"{type(self).__name__}: {name} is set once, when it is made; {self._instead}")
        object.__setattr__(self, name, value)
