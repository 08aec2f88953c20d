"""Options of every command that take numbers and files: what is spelled wrong is refused before anything is done."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import typer

from ..files.names import misnamed


def integer(*names: str, least: int | None = None, most: int | None = None, **told: Any) -> Any:
    """An option that takes an integer from `least` to `most`; the rest is said to ``typer.Option``."""
    from ..checks import spelled_integer

    return _numeric(names, spelled_integer, "integer", least, most, told)


def real(*names: str, least: float | None = None, most: float | None = None, **told: Any) -> Any:
    """An option that takes a number from `least` to `most`; without both, an infinite one or NaN, too."""
    from ..checks import spelled_number

    return _numeric(names, spelled_number, "number", least, most, told)


def path(text: str) -> Path:
    """What follows ``--out``; an empty word is refused, for it would mean the current folder."""
    if not str(text):
        raise typer.BadParameter("it is empty; the current folder is '.'")
    return Path(text)


def file(what: str, suffixes: Collection[str]) -> Callable[[str], Path]:
    """A parser of an option that takes the name of a file to write, see :mod:`hqp.files.names`."""

    def parse(text: str) -> Path:
        if why := misnamed(path(text), what, suffixes):
            raise typer.BadParameter(f"{str(text)!r}; {why}")
        return Path(text)

    return parse


def _numeric(
    names: tuple[str, ...],
    spelled: Callable[[str], float | None],
    kind: str,
    least: float | None,
    most: float | None,
    told: dict[str, Any],
) -> Any:
    # typer shows min and max in the help, and leaves their check to the parser.
    def parse(text: str | float) -> float:
        value = spelled(text) if isinstance(text, str) else text  # a default is a number already
        if value is None:
            raise typer.BadParameter(f"{text!r} is no {kind}.")
        if not (least is None or value >= least) or not (most is None or value <= most):  # NaN is outside of any
            ends = [f"at {word} {end:g}" for word, end in (("least", least), ("most", most)) if end is not None]
            raise typer.BadParameter(f"{text} must be {' and '.join(ends)}.")
        return value

    return typer.Option(*names, min=least, max=most, parser=parse, **told)
