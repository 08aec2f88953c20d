"""``hqp solve``: solves a hierarchy from a file, and certifies the solution."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from .terminal import console

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from ..arrays import Array
    from ..lexls import Problem
    from ..solution import Solution

NOT_CERTIFIED = 1


def solve(
    file: Annotated[
        str, typer.Argument(help="A hierarchy, from hqp.save or in the text format of LexLS.", metavar="FILE")
    ],
    backend: Annotated[
        list[str] | None,
        typer.Option(
            "--backend",
            "-b",
            help="The solver, see 'hqp backends'; may be given several times, to compare.",
            metavar="NAME",
        ),
    ] = None,
    x_ref: Annotated[
        str | None,
        typer.Option(
            "--x-ref", help="Reference of the last level, as in 0.5,0,-1, in place of the file's.", metavar="X"
        ),
    ] = None,
) -> None:
    """Solve a hierarchy from a file, and certify the answer.

    If the file holds a solution of another solver, the certificate checks that one too.

    Exit code 1 if an answer is not certified.
    """
    from ..solver import DEFAULT_BACKEND, Solver

    problem, reference = read(file)
    given = reference if x_ref is None else _numbers(x_ref)
    solutions = [Solver(name).solve(problem.hierarchy, given) for name in backend or [DEFAULT_BACKEND]]
    if len(solutions) == 1:
        _show(console(), solutions[0])
    else:
        _compare(console(120), solutions)
    for line in _theirs(problem, solutions[0]):
        _say(console(), line)
    if not all(map(_certified, solutions)):
        raise typer.Exit(NOT_CERTIFIED)


def read(file: str) -> tuple[Problem, Array | None]:
    """What a file of either format holds, and the x_ref of an .npz."""
    from .. import lexls
    from ..files import load
    from ..files.whole import is_archive

    if not is_archive(file):
        return lexls.read(file), None
    hierarchy, x_ref = load(file)
    return lexls.Problem(hierarchy), x_ref


def _numbers(text: str) -> list[float]:
    from ..errors import InvalidInput

    try:
        return [float(number) for number in text.split(",")]
    except ValueError:
        raise InvalidInput(f"--x-ref {text!r}: give numbers with commas between them, as in 0.5,0,-1") from None


def _certified(solution: Solution) -> bool:
    from ..solution import Status

    return solution.status is not Status.INVALID and solution.certify().ok


def _show(out: Console, solution: Solution) -> None:
    """All that there is to say of one answer."""
    import numpy as np

    from ..hierarchy import Side
    from ..solution import Status

    _say(out, _outcome(solution))
    if solution.status is Status.INVALID:
        return
    table = _table("level", "rows", "residual", "rank", "at a bound")
    for k, level in enumerate(solution.levels):
        bound = int(np.count_nonzero((level.active == Side.LOWER) | (level.active == Side.UPPER)))
        cells = len(level.slack), f"{level.residual_norm:.6g}", level.rank, bound
        table.add_row(_text(solution.hierarchy.level_name(k)), *map(str, cells))
    out.print(table)
    if why := solution.explain().levels:
        _say(out, "\n".join(map(str, why)) + "\n")
    if solution.x_ref.any():
        _say(out, f"x_ref = {solution.x_ref.tolist()}")
    _say(out, f"x = {solution.x.tolist()}\n")  # every digit: it may be what is to be reported
    _say(out, str(solution.certify()))


def _compare(out: Console, solutions: list[Solution]) -> None:
    """A line a backend."""
    table = _table("backend", "status", "certified", *map(str, range(len(solutions[0].hierarchy.levels))))
    for solution in solutions:
        residuals = [f"{level.residual_norm:.6g}" for level in solution.levels]
        table.add_row(solution.backend, str(solution.status), "yes" if _certified(solution) else "NO", *residuals)
    out.print(table)
    names = ", ".join(map(solutions[0].hierarchy.level_name, range(len(solutions[0].hierarchy.levels))))
    _say(out, f"residual norms of {names}")
    for solution in solutions:
        if solution.message:
            _say(out, _outcome(solution))


def _theirs(problem: Problem, ours: Solution) -> Iterator[str]:
    """A line for each point that the file brings."""
    from ..arrays import length
    from ..certificate import certify

    def away(point: Array) -> str:
        return f"{length(point - ours.x):.3g} from the x of {ours.backend}"

    if (guess := problem.solution_guess) is not None:
        yield f"#SolGuess: {away(guess)}"
    if (solution := problem.solution) is not None:
        certificate = certify(problem.hierarchy, solution, ours.x_ref)
        levels = len(problem.hierarchy.levels)
        if (failed := certificate.failed) is None:
            verdict = "certified"
        elif failed.level == levels:
            verdict = f"certified at all {levels} levels of the file, which leave x free"
        else:
            verdict = str(certificate).partition("\n")[0]
        yield f"#Solution: {verdict}; {away(solution)}"


def _table(first: str, *others: str) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column(first)
    for name in others:
        table.add_column(name, justify="left" if name == "status" else "right", no_wrap=True)
    return table


def _outcome(solution: Solution) -> str:
    return f"{solution.backend}: {solution.status}" + (f", {solution.message}" if solution.message else "")


def _say(out: Console, text: str) -> None:
    """One paragraph as it stands: no markup, no line broken."""
    out.print(_text(text), soft_wrap=True)


def _text(text: str) -> str:
    """What a name from another's file may do to a terminal, undone."""
    from rich.markup import escape

    return escape("".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in text))
