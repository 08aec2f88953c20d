"""The columns of the results: one row for each draw, method, setting and start."""

from __future__ import annotations

import pyarrow as pa

_TEXT, _FLAG, _WHOLE, _REAL = pa.string(), pa.bool_(), pa.int32(), pa.float64()

#: Column -> type and what it says.
COLUMNS: dict[str, tuple[pa.DataType, str]] = {
    "family": (_TEXT, "key of the problem family"),
    "group": (_TEXT, "its group"),
    "curve": (_TEXT, "the growth curve on which the family is a point, or empty"),
    "at": (_WHOLE, "where on that curve"),
    "seed": (_WHOLE, "of the problem"),
    "draw": (_WHOLE, "number of the problem"),
    "n": (_WHOLE, "unknowns"),
    "m": (_WHOLE, "rows, bounds included"),
    "levels": (_WHOLE, "levels, without the implicit last one"),
    "method": (_TEXT, "who solved it"),
    "setting": (_TEXT, "how exactly it was asked to"),
    "start": (_TEXT, "cold: knows the structure alone; warm: right after the problem before"),
    "seconds": (_REAL, "the shortest of the rounds [s]"),
    "slowest": (_REAL, "the longest of them [s]"),
    "rounds": (_WHOLE, "how many"),
    "claimed": (_FLAG, "whether the method says that its answer is the optimum"),
    "status": (_TEXT, "in its own words"),
    "iterations": (_WHOLE, "guesses and steps, QPs, or iterations, as the method counts"),
    "proved": (_FLAG, "whether the best answer to this problem is certified"),
    "active": (_REAL, "share of the inequality rows that the best answer has at a bound"),
    "certified": (_FLAG, "whether this answer is certified"),
    "gaps": (pa.list_(_REAL), "residual norm beyond the best answer's, level by level, in the scale of the level"),
    "gap": (_REAL, "the lexicographic gap"),
    "wrong": (_FLAG, "neither certified nor as good as the best"),
    "violation": (_REAL, "the largest slack in a row in which the best answer has none"),
    "error": (_REAL, "distance from the best answer, relative to max(1, ||x||)"),
}

#: What the machine decides, not the problem.
TIMES = ("seconds", "slowest")
#: What names a row.
KEYS = ("family", "seed", "draw", "method", "setting", "start")

SCHEMA = pa.schema([pa.field(name, kind, metadata={"about": about}) for name, (kind, about) in COLUMNS.items()])
