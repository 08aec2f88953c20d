"""The form of a hierarchy: all of it but its numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ..checks import whole_number
from ..errors import InvalidInput, brief
from .level import Level

#: Most unknowns that indices alone may imply: a larger index is more likely a typing error.
MOST_GUESSED = 10_000

#: Most unknowns of any hierarchy: a solver needs a dense matrix of that size.
MOST_UNKNOWNS = 1_000_000


def form_of(levels: Sequence[Level], n: int | None) -> dict[str, Any]:
    """The attributes of a hierarchy of these levels that are no numbers; n as given to it.

    Raises
    ------
    InvalidInput
        If the levels disagree on the number of unknowns, or an index is out of range.
    """
    n = _unknowns(levels, n)
    pointers = (0, *np.cumsum([len(level) for level in levels], dtype=int).tolist())
    columns = np.concatenate(
        [level.indices if level.indices is not None else np.full(len(level), -1) for level in levels]
        or [np.zeros(0, dtype=np.intp)]
    ).astype(np.intp)
    columns.flags.writeable = False
    has_rows = tuple(level.A is not None for level in levels)
    return {
        "n": n,
        "m": pointers[-1],
        "pointers": pointers,
        "columns": columns,
        "structure": (n, pointers, has_rows, columns.tobytes()),
        "_names": tuple(level.name for level in levels),
        "_labels": tuple(level.labels for level in levels),
        "_has_rows": has_rows,
        "_dense": np.flatnonzero(columns < 0),
    }


def checked_levels(levels: Iterable[Level]) -> list[Level]:
    """The levels that a hierarchy is given, checked."""
    if isinstance(levels, Level):
        raise InvalidInput("a hierarchy takes a sequence of levels, highest first; put the one level into a list")
    try:
        given = list(levels)
    except TypeError:
        raise InvalidInput(f"a hierarchy takes a sequence of levels, highest first, not {brief(levels)}") from None
    for k, level in enumerate(given):
        if not isinstance(level, Level):
            raise InvalidInput(f"level {k} is a {type(level).__name__}; it must be a hqp.Level")
    return given


def called(k: int, name: str) -> str:
    """Number and name of a level, as messages call it."""
    return f"level {k} ({name!r})" if name else f"level {k}"


def _unknowns(levels: Sequence[Level], n: int | None) -> int:
    """Number of unknowns on which all levels agree."""
    if n is None:
        rows = [level.A.shape[1] for level in levels if level.A is not None]
        highest = [int(level.indices.max()) + 1 for level in levels if level.indices is not None and len(level)]
        if not rows and not highest:
            raise InvalidInput("the levels do not tell how many unknowns there are; give n")
        if not rows and max(highest) > max(MOST_GUESSED, sum(map(len, levels))):
            raise InvalidInput(f"index {max(highest) - 1} makes {max(highest)} unknowns; if so many are meant, give n")
        n = rows[0] if rows else max(highest)
    n = whole_number(n, "n", most=MOST_UNKNOWNS)
    for k, level in enumerate(levels):
        what = called(k, level.name)
        if level.A is not None and level.A.shape[1] != n:
            raise InvalidInput(f"{what}: A has shape {level.A.shape}, but the hierarchy has {n} unknowns")
        if level.indices is not None and np.any(level.indices >= n):
            row = int(np.argmax(level.indices >= n))
            raise InvalidInput(f"{what}, row {row}: index {level.indices[row]}, but the hierarchy has {n} unknowns")
    return n


def check_told(n: int, numbers: int) -> None:
    """Refuse more unknowns than the numbers of a file account for: an error, or an attack on memory.

    Parameters
    ----------
    n : int
    numbers : int
        As many as there are of one kind: of A, of bounds, or of x.

    Raises
    ------
    InvalidInput
    """
    if n > max(MOST_GUESSED, numbers):
        raise InvalidInput(
            f"n = {n} unknowns, of which only {numbers} numbers tell; without more, there may be {MOST_GUESSED}"
        )
