"""A hierarchy from a text file, line by line."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...errors import brief
from ...hierarchy import Hierarchy, Level, Side, check_told
from .lines import Lines, named
from .problem import BOUNDS, EQUALITIES, HEADER, INEQUALITIES, POINTS, ROWS, SIDES, WITH_GUESS, Problem

_OBJECTIVE = re.compile(r"#\s*OBJECTIVE\s*(\d*)\s*(.*)", re.ASCII)


def read(path: str | os.PathLike[str]) -> Problem:
    """Read a hierarchy from a file in the text format of LexLS, see :mod:`hqp.lexls`.

    Comments, blank lines and the order of the fields in front are free. More is asked than LexLS asks: no row is
    longer or shorter than it should be, no field comes twice, and nothing else stands between the fields.

    Parameters
    ----------
    path : str or path

    Raises
    ------
    InvalidInput
        If the file cannot be read or is malformed; the message names file and line, what is there and what should be.
    """
    from ..whole import bytes_of

    with bytes_of(path, "hierarchy") as stream:
        lines = Lines(stream)
        header = _header(lines)
        levels, sides = zip(*(_objective(lines, header, k) for k in range(len(header.rows))), strict=True)
        points = _points(lines, header.n)
        told = header.n if points or any(level.A is not None and len(level) for level in levels) else sum(header.rows)
        check_told(header.n, told)
        guess = np.concatenate(sides) if header.kind == WITH_GUESS else None
        return Problem(Hierarchy(levels, n=header.n), guess, *map(points.get, POINTS))


@dataclass(frozen=True)
class _Header:
    """What the fields in front tell: type of the hierarchy, unknowns, and rows and type of every level."""

    kind: int
    n: int
    rows: list[int]
    types: list[int]


def _header(lines: Lines) -> _Header:
    """The fields up to the first objective."""
    found: dict[str, tuple[list[int], int]] = {}
    lines.next_field(f"one of the fields {', '.join(HEADER)}")
    while lines.field in HEADER:
        name = lines.field
        if name in found:
            raise lines.fault(f"{name} again", f"it once, as on line {found[name][1]}")
        words = lines.words(f"the numbers of {name}")
        found[name] = [lines.count(word, f"{name} in whole numbers") for word in words], lines.number
        lines.next_field(f"a field or #OBJECTIVE 0: {name} is complete")

    def numbers(name: str, count: int, allowed: tuple[int, ...] = ()) -> list[int]:
        if name not in found:
            raise lines.fault(named(lines.field), f"{name} before it")
        given, number = found[name]
        if len(given) != count:
            raise lines.fault(f"numbers of {name}: {len(given)}", f"{count}", number)
        if strange := set(given).difference(allowed or given):
            raise lines.fault(f"{name} {min(strange)}", " or ".join(map(str, allowed)), number)
        return given

    (kind,) = numbers("#HierType", 1, (EQUALITIES, INEQUALITIES, WITH_GUESS))
    (n,), (levels,) = numbers("#nVar", 1), numbers("#nObj", 1)
    if not levels:
        raise lines.fault("#nObj 0", "at least 1", found["#nObj"][1])
    rows, types = numbers("#nCtr", levels), numbers("#ObjType", levels, (BOUNDS, ROWS))
    if BOUNDS in types[1:]:
        where = f"for objective {types.index(BOUNDS, 1)}"
        raise lines.fault(f"#ObjType {BOUNDS} {where}", f"{ROWS}: only objective 0 may be bounds", found["#ObjType"][1])
    return _Header(kind, n, rows, types)


def _objective(lines: Lines, header: _Header, k: int) -> tuple[Level, NDArray[np.int8]]:
    """Level k and the guess of its rows, and on to the next field."""
    match = _OBJECTIVE.fullmatch(lines.field or "")
    if not match or match[1] not in ("", str(k)):
        raise lines.fault(named(lines.field), f"#OBJECTIVE {k}")
    name, m, n = _name(lines, match[2]), header.rows[k], header.n
    table, variables = _rows(lines, header, k)
    lines.next_field(f"a field: objective {k} is complete with #nCtr {m}")

    data = np.reshape(np.array(table, dtype=float), (m, -1 if m else 3))
    A, (lower, upper, sides) = data[:, :-3], data[:, -3:].T
    if header.types[k] == BOUNDS:
        level = Level.bounds(lower, upper, indices=np.array(variables, dtype=int) - 1, name=name)
    else:
        level = Level(A.reshape(m, n), lower, upper, name=name)
    return level, sides.astype(np.int8)


def _rows(lines: Lines, header: _Header, k: int) -> tuple[list[list[float]], list[int]]:
    """The rows of level k: numbers of A if it has any, lower, upper and side; and the variables of bounds."""
    n, bounds, guess = header.n, header.types[k] == BOUNDS, ["activation"] * (header.kind == WITH_GUESS)
    ends = ["b"] if header.kind == EQUALITIES else ["lower", "upper"]
    layout = ", ".join(["the number of a variable" if bounds else f"{n} of A", *ends, *guess])
    first = 1 if bounds else n
    last = first + len(ends)

    table: list[list[float]] = []
    seen: dict[int, int] = {}
    for row in range(header.rows[k]):
        words = lines.words(f"row {row} of the {header.rows[k]} of objective {k}")
        if len(words) != last + len(guess):
            raise lines.fault(f"a row of {len(words)}", f"one of {last + len(guess)}: {layout}")
        numbers = [] if bounds else [lines.real(word, f"A[{column}]") for column, word in enumerate(words[:n])]
        if bounds:
            variable = lines.count(words[0], f"the number of a variable, from 1 to {n}", 1, n)
            if variable in seen:
                raise lines.fault(f"variable {variable} again", f"it once, as on line {seen[variable]}")
            seen[variable] = lines.number
        side = SIDES[lines.count(words[-1], "activation 0, 1, 2 or 3", 0, 3)] if guess else Side.INACTIVE
        table.append([*numbers, *_interval(lines, words[first:last], ends), side])
    return table, [*seen]


def _name(lines: Lines, text: str) -> str:
    """The name of a level: as it stands, or in quotes as a string of JSON."""
    import json

    if not text.startswith('"'):
        return text
    try:
        return str(json.loads(text))
    except ValueError:
        raise lines.fault(f"the name {brief(text)}", "a string of JSON, as it begins with a quote") from None


def _interval(lines: Lines, words: list[str], ends: list[str]) -> tuple[float, float]:
    """Lower and upper bound of a row, which are the same where only b is given."""
    values = [lines.bound(word, end) for word, end in zip(words, ends, strict=True)]
    lower, upper = values[0], values[-1]
    if lower > upper or lower == np.inf or upper == -np.inf:
        limits = "lower at most upper, lower below inf, and upper above -inf"
        raise lines.fault(" and ".join(f"{end} = {value}" for end, value in zip(ends, values, strict=True)), limits)
    return lower, upper


def _points(lines: Lines, n: int) -> dict[str, Array]:
    """What comes after the objectives, up to the end of the file."""
    points: dict[str, Array] = {}
    while lines.field is not None:
        name = lines.field
        if name not in POINTS or name in points:
            choice = " or ".join(point for point in POINTS if point not in points)
            raise lines.fault(named(name), f"{choice + ' or ' if choice else ''}the end of the file")
        values: list[float] = []
        while len(values) < n:
            words = lines.words(f"number {len(values)} of the {n} of {name}")
            values += [lines.real(word, f"x[{i}]") for i, word in enumerate(words, len(values))]
        if len(values) > n:
            raise lines.fault(f"numbers of {name}: {len(values)}", f"{n}")
        points[name] = np.array(values)
        lines.next_field(f"a field or the end of the file: {name} is complete with #nVar {n}")
    return points
