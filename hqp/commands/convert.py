"""``hqp convert``: converts a hierarchy between file formats, and tells what the other format cannot hold."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from .solve import read

if TYPE_CHECKING:
    from ..arrays import Array
    from ..hierarchy import Hierarchy
    from ..lexls import Problem

#: What the end of a name says of the format.
FORMATS = {".npz": "npz", ".dat": "lexls", ".txt": "lexls", ".lexls": "lexls"}


def convert(
    source: Annotated[
        str, typer.Argument(help="A hierarchy, from hqp.save or in the text format of LexLS.", metavar="SOURCE")
    ],
    target: Annotated[
        str, typer.Argument(help="The file to write: .npz; .dat, .txt or .lexls for text.", metavar="TARGET")
    ],
    to: Annotated[
        Literal["npz", "lexls"] | None, typer.Option("--to", help="The format of a TARGET without a suffix.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace TARGET if it exists.")] = False,
) -> None:
    """Write a hierarchy in another file format.

    The problem stays the same, with the same x and the same residuals. What the format cannot hold is told.
    """
    from .. import lexls
    from ..errors import InvalidInput
    from ..files import save

    wanted = to or _format(target)
    problem, x_ref = read(source)
    if Path(target).exists() and not force:
        raise InvalidInput(f"{target!r} exists; --force replaces it")
    h = problem.hierarchy
    if wanted == "npz":
        save(target, h, x_ref)
        notes = _not_in_npz(problem)
    else:
        lexls.write(
            target, h, x_ref, guess=problem.guess, solution_guess=problem.solution_guess, solution=problem.solution
        )
        notes = _not_in_lexls(h, x_ref)
    print(f"wrote {target!r}, {wanted}: {len(h.levels)} levels, {h.m} rows, {h.n} unknowns")
    for note in notes:
        print(f"  {note}")


def _format(target: str) -> str:
    from ..errors import InvalidInput

    suffix = Path(target).suffix.lower()
    if suffix not in FORMATS:
        raise InvalidInput(
            f"{target!r} ends with none of {', '.join(FORMATS)}; if it has no suffix, --to npz or --to lexls tells the"
            " format"
        )
    return FORMATS[suffix]


def _not_in_npz(problem: Problem) -> Iterator[str]:
    given = {
        "the guess of active rows": problem.guess,
        "#SolGuess": problem.solution_guess,
        "#Solution": problem.solution,
    }
    if left := [what for what, value in given.items() if value is not None]:
        yield f"not kept: {', '.join(left)}"


def _not_in_lexls(hierarchy: Hierarchy, x_ref: Array | None) -> Iterator[str]:
    from ..lexls import as_lexls

    def listed(chosen: list[bool]) -> str:
        return ", ".join(str(k) for k, yes in enumerate(chosen) if yes)

    levels, written = hierarchy.levels, as_lexls(hierarchy).levels
    if labels := listed([level.labels is not None for level in levels]):
        yield f"not kept: the labels of the rows of level {labels}"
    if weights := listed([bool((level.weights != 1.0).any()) for level in levels]):
        yield f"multiplied into their rows: the weights of level {weights}"
    if rows := listed([mine.A is None and its.A is not None for mine, its in zip(levels, written, strict=True)]):
        yield f"made rows of A: the bounds on variables of level {rows}"
    if x_ref is not None:
        yield f"written as one more level, {len(levels)}: x = x_ref"
