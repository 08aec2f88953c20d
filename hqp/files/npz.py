"""Hierarchies in .npz files, without pickle: all that a bug report needs.

>>> import hqp
>>> hqp.save("hard.npz", hierarchy, x_ref)  # doctest: +SKIP
>>> hierarchy, x_ref = hqp.load("hard.npz")  # doctest: +SKIP

Structure, names and numbers come back to the last bit, including NaN and other numbers that a solver refuses, because
these are what a bug report is about. ``hqp solve hard.npz`` shows the solution.

The file holds the arrays of :class:`hqp.Hierarchy` under their names (A, lower, upper, weights, columns), x_ref if
there is one, and ``head``, JSON text: the format, n, and of every level its name, how many rows it has, whether
they are plain bounds, and their labels if they have any. :func:`load` also reads the text format of :mod:`hqp.lexls`,
which keeps less.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import Array, real_array
from ..checks import of_type, truth, whole_number
from ..errors import InvalidInput
from ..hierarchy import Hierarchy, Label, Level, check_told

#: What the head of a file says; the number changes with its arrays.
FORMAT = "hqp hierarchy 1"


def save(path: str | os.PathLike[str], hierarchy: Hierarchy, x_ref: ArrayLike | None = None) -> None:
    """Write a hierarchy to a file, which appears whole or not at all.

    Parameters
    ----------
    path : str or path
        The file, such as ``"hard.npz"``.
    hierarchy : Hierarchy
        Its numbers may be such that no solver takes them. Of labels the texts are kept, not what `bound` may be.
    x_ref : array, shape (n,), optional
        Reference of the implicit last level.

    Raises
    ------
    InvalidInput
        If the file has another suffix than .npz or cannot be written, x_ref has the wrong shape, or n is more than
        10 000 and than all numbers.
    """
    import json

    from .whole import write_arrays

    h = of_type(hierarchy, Hierarchy, "the hierarchy")
    # Names and labels are free text: they go into the head, as JSON.
    head = np.array(json.dumps({"format": FORMAT, "n": h.n, "levels": [_described(level) for level in h.levels]}))
    arrays: dict[str, NDArray[Any]] = {
        "head": head, "A": h.A, "lower": h.lower, "upper": h.upper, "weights": h.weights, "columns": h.columns,
    }  # fmt: skip
    if x_ref is not None:
        arrays["x_ref"] = real_array(x_ref, "x_ref")
        if arrays["x_ref"].shape != (h.n,):
            raise InvalidInput(f"x_ref has shape {arrays['x_ref'].shape}; it must be ({h.n},)")
    check_told(h.n, max(array.size for array in arrays.values()))
    write_arrays(path, arrays, compressed=True)


def load(path: str | os.PathLike[str]) -> tuple[Hierarchy, Array | None]:
    """What :func:`save` wrote: the hierarchy, and x_ref or None.

    A file that is no archive, and is not called .npz, is read as text, see :func:`hqp.lexls.read`, which also tells
    the solutions that are in it.

    Parameters
    ----------
    path : str or path
        A file of :func:`save`, or one of LexLS.

    Raises
    ------
    InvalidInput
        If the file cannot be read, is no hierarchy or is damaged; the message names the file and what is wrong.
    """
    from .lexls.read import read
    from .whole import arrays_of, is_archive

    if not is_archive(path):
        return read(path).hierarchy, None
    with arrays_of(path, "hierarchy") as arrays:
        head = _head(arrays)
        n, kinds = whole_number(head["n"], "its n"), [_kind(k, level) for k, level in enumerate(head["levels"])]
        check_told(n, max(array.size for array in arrays.values()))
        m, dense = sum(rows for _, rows, _ in kinds), sum(rows for _, rows, bounds in kinds if not bounds)
        A = _array(arrays, "A", (dense, n))
        lower, upper, weights = (_array(arrays, name, (m,)) for name in ("lower", "upper", "weights"))
        columns = _array(arrays, "columns", (m,), "i")
        levels, first, above = [], 0, 0
        for k, (name, rows, bounds) in enumerate(kinds):
            own = slice(first, first + rows)
            first += rows
            labels = _labels(k, head["levels"][k])
            if bounds:
                levels.append(Level.bounds(lower[own], upper[own], indices=columns[own], name=name, labels=labels))
                continue
            if (columns[own] != -1).any():
                raise ValueError(f"its columns of level {k}, which has rows of its own, must be -1")
            levels.append(Level(A[above : above + rows], lower[own], upper[own], name=name, labels=labels))
            above += rows
        hierarchy = Hierarchy(levels, n=n)
        hierarchy.weights[:] = weights  # afterwards: a Level refuses what is not positive
        x_ref = _array(arrays, "x_ref", (n,)).astype(np.float64) if "x_ref" in arrays else None
    return hierarchy, x_ref


def _head(arrays: dict[str, NDArray[Any]]) -> dict[str, Any]:
    import json

    head = json.loads(str(_array(arrays, "head", (), "U")))
    found = head.get("format") if isinstance(head, dict) else None
    if found != FORMAT:
        raise ValueError(f"its format is {found!r}; it must be {FORMAT!r}")
    lacks = {"n", "levels"} - set(head)
    if lacks or not isinstance(head["levels"], list):
        raise ValueError("its head does not tell n and the list of levels")
    return dict(head)


def _described(level: Level) -> dict[str, Any]:
    """The entry of a level in the head; with labels only if the level has some."""
    told: dict[str, Any] = {"name": level.name, "rows": len(level), "bounds": level.indices is not None}
    if level.labels is not None:
        told["labels"] = [(label.part, label.row, label.unit) for label in level.labels]
    return told


def _labels(k: int, level: dict[str, Any]) -> list[Label] | None:
    """The labels of level k, as :func:`_described` told them."""
    if "labels" not in level:
        return None
    told = level["labels"]
    if not (isinstance(told, list) and all(isinstance(label, list) and len(label) == 3 for label in told)):
        raise ValueError(f"its head does not tell part, row and unit of every label of level {k}")
    return [Label(part, row, unit) for part, row, unit in told]


def _kind(k: int, level: Any) -> tuple[str, int, bool]:
    """Name, number of rows, and whether they are plain bounds."""
    if not (isinstance(level, dict) and {"name", "rows", "bounds"} <= set(level)):
        raise ValueError(f"its head does not tell name, rows and bounds of level {k}")
    name = of_type(level["name"], str, f"name of level {k}")
    return name, whole_number(level["rows"], f"rows of level {k}"), truth(level["bounds"], f"bounds of level {k}")


def _array(arrays: dict[str, NDArray[Any]], name: str, shape: tuple[int, ...], kind: str = "f") -> NDArray[Any]:
    if name not in arrays:
        raise ValueError(f"it has no array {name!r}")
    array = arrays[name]
    if array.shape != shape:
        raise ValueError(f"its array {name!r} has shape {array.shape}; it must be {shape}")
    if array.dtype.kind != kind:
        allowed = {"f": "floats", "i": "integers", "U": "text"}[kind]
        raise ValueError(f"its array {name!r} holds {array.dtype}; it must hold {allowed}")
    return array
