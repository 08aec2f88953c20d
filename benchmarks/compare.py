"""``python -m benchmarks compare``: what changed from one run, or commit, to another, beyond noise."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from hqp import InvalidInput
from hqp.commands.terminal import console

from .extra import required_packages
from .sweep.plans import PLANS
from .tables import Row, show, terminal


def compare(
    before: Annotated[str, typer.Argument(help="The folder of a run, or a commit.", metavar="BEFORE")],
    after: Annotated[str, typer.Argument(help="The same.", metavar="AFTER")],
    plan: Annotated[str, typer.Option("--plan", help="What commits are measured by.")] = "smoke",
    by: Annotated[Literal["group", "family"], typer.Option("--by", help="Where times are compared.")] = "group",
    everything: Annotated[bool, typer.Option("--all", help="Show times that did not change, too.")] = False,
) -> None:
    """Compare two runs, or the library at two commits, which the present benchmarks measure first."""
    required_packages()
    from .analysis.comparison import ROUND_OFF, UNSTEADY, answers, changes, differences, paired
    from .sweep.store import Store

    if plan not in PLANS:
        raise InvalidInput(f"unknown plan {plan!r}; there are {', '.join(PLANS)}")
    a, b = (Store.open(_folder(what, plan)).table() for what in (before, after))
    pairs = paired(a, b)
    if pairs.empty:
        raise InvalidInput(f"{before} and {after} have no problem, method and setting in common")
    printer = console(120)
    printer.print(f"{len(pairs)} answers in common, of {len(a)} and {len(b)}")
    unequal = differences(pairs)
    if unequal:
        told = ", ".join(f"{name} in {number}" for name, number in unequal.items())
        printer.print(f"answers that are not the same: {told}", soft_wrap=True)
        show(printer, terminal("what they are worth, where some are not the same", answers(pairs)))
    else:
        printer.print(f"all answers are the same, to {ROUND_OFF:g}")
    times = changes(pairs, by)
    shown: list[Row] = [
        {
            by: change.where,
            "method": change.method,
            "setting": change.setting,
            "start": change.start,
            "problems": str(change.problems),
            "time": f"{change.factor:.2f}",
            "noise": f"{change.noise:.2f}",
            "drift": f"{change.drift:.2f}",
            "": "" if not change.real else "slower" if change.factor > 1.0 else "faster",
        }
        for change in times
        if everything or change.real
    ]
    if shown:
        show(printer, terminal("times after over before, the drift of the machine taken out", shown))
    drifts = [change.drift for change in times]
    if drifts and max(*drifts, 1.0 / min(drifts)) > 1.0 + UNSTEADY:
        printer.print(
            "the machine was not equally fast in both runs: what is short and what is long drift apart; see drift"
        )
    real = sum(change.real for change in times)
    printer.print(f"{real} of {len(times)} times changed beyond noise")


def _folder(what: str, plan: str) -> Path:
    """The folder of a run, or that of a commit, which is measured first."""
    from .sweep.commits import run_commit

    return Path(what) if Path(what).is_dir() else run_commit(what, plan)
