"""Simulate, draw, tabulate: figure after figure, each saved as soon as it is finished."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import hqp

from .._checks import writable
from .._terminal import console
from ..motion.record import Record
from .claims import Claim, measure, to_csv, to_markdown, to_terminal
from .laws import laws_of
from .runs import Job, jobs_of, run
from .scenarios import Scenario, scenario

if TYPE_CHECKING:
    from rich.progress import Progress

DEFAULT_FIGURES = ("4.6", "4.7", "4.8", "4.9")
ASSUMPTIONS = (
    "Assumed: the arm starts at rest and follows each commanded acceleration exactly, one solve every 2e-4 min;"
    " joint limits of 40 rad/min and 4000 rad/min^2; the inclined line runs from (1, 0.7) to (0.3, 0)"
)


def report(figures: Sequence[str], backend: str | None, out: Path) -> list[Claim]:
    """Reproduce figures of the thesis into a folder, and print the table.

    Parameters
    ----------
    figures : sequence of str
        Such as ``"4.7"``.
    backend : str, optional
        Beside the closed forms (default: ``hqp.DEFAULT_BACKEND``).
    out : Path
        Receives ``figure-4.7.png``, ..., ``claims.md`` and ``claims.csv``.

    Returns
    -------
    list of Claim
        The rows of the table.

    Raises
    ------
    InvalidInput
        Before anything is simulated, if a figure or the backend is unknown, or the folder or a file
        in it cannot be written to.
    """
    from .figures import draw

    chosen = hqp.DEFAULT_BACKEND if backend is None else backend
    scenarios = list({name: scenario(name) for name in figures}.values())
    info = hqp.backend_info(chosen)
    writable(out, [*(f"figure-{item.figure}.png" for item in scenarios), "claims.md", "claims.csv"])

    records: dict[Job, Record] = {}
    claims: list[Claim] = []
    left_out = dict.fromkeys(why for item in scenarios for law in laws_of(item) if (why := law.refusal(info)))
    remarks = [*left_out, *(f"Figure {item.figure}, the text: {item.claim}" for item in scenarios), ASSUMPTIONS]
    with _progress() as progress:
        jobs = dict.fromkeys(job for item in scenarios for job in jobs_of(item, chosen))
        whole = progress.add_task("thesis", total=len(jobs))
        for item in scenarios:
            for job in jobs_of(item, chosen):
                if job not in records:
                    progress.update(whole, description=job.title)
                    before = len(records)
                    records[job] = run(job, lambda share, n=before: progress.update(whole, completed=n + share))  # type: ignore[misc]
                    progress.update(whole, completed=len(records))
            progress.update(whole, description=f"{item.figure}, drawing")
            claims += _claims(item, chosen, records)
            draw(item, _shown(item, chosen, records)).savefig(out / f"figure-{item.figure}.png", dpi=150)
            (out / "claims.md").write_text(to_markdown(claims, remarks), encoding="utf-8")
            (out / "claims.csv").write_text(to_csv(claims), encoding="utf-8")

    printer = console(140)  # give every row its line
    printer.print(to_terminal(claims))
    for why in left_out:
        printer.print(why)
    printer.print(f"{len(scenarios)} figures, claims.md and claims.csv in {out}", soft_wrap=True)
    return claims


def _claims(item: Scenario, backend: str, records: dict[Job, Record]) -> Iterator[Claim]:
    jobs = jobs_of(item, backend)
    closed = {job.law.key: records[job] for job in jobs if job.closed_form}
    return (measure(job, records[job], closed.get(job.law.key)) for job in jobs)


def _shown(item: Scenario, backend: str, records: dict[Job, Record]) -> dict[Job, Record]:
    """One run a law for the figure: the backend's where there is one, the formula's otherwise."""
    best = {job.law.key: job for job in sorted(jobs_of(item, backend), key=lambda job: not job.closed_form)}
    return {best[law.key]: records[best[law.key]] for law in laws_of(item) if law.key in best}


@contextmanager
def _progress() -> Iterator[Progress]:
    """A bar on stderr, so that stdout is the table alone."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description:<54}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as progress:
        yield progress
