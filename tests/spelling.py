"""The options of a command that take numbers, and words that spell none."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, get_args, get_type_hints

import typer

#: Python reads the first four as ten, pydantic the fifth; the others as no number at all.
NO_INTEGER = ("1_0", "１０", " 10", "10 ", "10.0", "1e1", "0xa", "ten", "")
NO_NUMBER = ("1_0", "１０", " 10", "10 ", "1_0.0", "0xa", "ten", "")


class Option(NamedTuple):
    """An option of a command, and the ends of what it takes."""

    command: str
    name: str
    whole: bool
    least: float | None
    most: float | None

    def wrong(self) -> Iterator[str]:
        """Words that it must refuse: misspelled, beyond an end, and without an order to the ends."""
        yield from NO_INTEGER if self.whole else NO_NUMBER
        if self.least is not None:
            yield str(self.least - 1)
        if self.most is not None:
            yield str(self.most + 1)
        if not self.whole and (self.least, self.most) != (None, None):
            yield "nan"


def numeric(app: typer.Typer) -> list[Option]:
    """All options of all commands that take integers or floats, one by one or several."""
    return [
        Option(own.name or own.callback.__name__, name, int in kinds, info.min, info.max)
        for own in app.registered_commands
        if own.callback is not None
        for kinds, name, info in _annotated(own.callback)
        if {int, float} & kinds
    ]


def _annotated(callback: Any) -> Iterator[tuple[set[type], str, Any]]:
    """Of each option of a command the types inside its annotation, its name, and what is said of it."""
    for hint in get_type_hints(callback, include_extras=True).values():
        if hasattr(hint, "__metadata__"):
            info = hint.__metadata__[0]
            words = (info.default, *(info.param_decls or ()))  # typer keeps the first word as a default
            yield set(_leaves(get_args(hint)[0])), next((w for w in words if str(w).startswith("--")), "argument"), info


def _leaves(hint: Any) -> Iterator[Any]:
    inside = get_args(hint)
    if not inside:
        yield hint
    for own in inside:
        yield from _leaves(own)
