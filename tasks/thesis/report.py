"""The report: simulates, draws and tabulates on all cores; finished files are kept and not made again."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import hqp
from hqp.certificate import judging
from hqp.checks import whole_number
from hqp.commands.terminal import console
from hqp.files.whole import writable

from ..simulation.record import Record
from .laws import NAMES
from .measuring import measure, to_csv
from .pictures import Picture, make, pictures, refusals, subjects
from .run_result import RunResult
from .runs import Job, controller, run
from .scenarios import ASSUMPTIONS
from .store import Drawn, Store
from .studies import Study
from .style import FORMATS
from .tables import Section, to_markdown, to_terminal

if TYPE_CHECKING:
    from rich.progress import Progress


def report(
    figures: Sequence[str],
    backend: str | None,
    out: Path,
    *,
    laws: Collection[str] = NAMES,
    form: str = "png",
    animated: bool = False,
    processes: int = -1,
) -> list[RunResult]:
    """Reproduce figures of the thesis into a folder, and print the table of claims against results.

    Parameters
    ----------
    figures : sequence of str
        Such as ``"4.7"``, the number of a drawing, such as ``"4.1"``, or the name of an idea or a study, such as
        ``"argument"`` or ``"lines"``; empty for all.
    backend : str, optional
        Beside the closed forms (default: ``hqp.DEFAULT_BACKEND``).
    out : Path
        Receives ``figure-4.7.png``, ``figure-4.7-plain.png``, ``figure-4.7-plain.pdf``, ..., ``claims.md``
        and ``claims.csv`` of the figures asked for, and ``runs/``: what is finished there is not made again.
    laws : collection of str
        Of :data:`tasks.thesis.laws.NAMES`.
    form : {"png", "pdf", "svg"}
        Of the pictures; what may go into a paper comes as PNG and as PDF, or as SVG if that is asked for.
    animated : bool
        Whether each figure is written as a GIF, too.
    processes : int
        That work at the same time; -1 for one a core.

    Returns
    -------
    list of RunResult
        One a run of every figure, in the order of the text.

    Raises
    ------
    InvalidInput
        Before anything is simulated, if a figure, a law, the format or the backend is unknown, or the
        folder or a file in it cannot be written to.
    """
    from joblib import Parallel

    _check(laws, form, processes)
    chosen = hqp.DEFAULT_BACKEND if backend is None else backend
    wanted = subjects(figures, laws)
    left_out = refusals(wanted, hqp.backend_info(chosen), laws)
    shown = pictures(wanted, chosen, laws, form, animated)
    writable(out, [*(file for picture in shown for file in picture.files), "claims.md", "claims.csv"])
    writable(out / "runs", ["drawn.json"])
    store, drawn = Store(out / "runs"), Drawn(out, out / "runs" / "drawn.json")

    missing = [job for job in dict.fromkeys(job for picture in shown for job in picture.needed) if job not in store]
    if missing:
        _compile(missing)
    parallel = Parallel(n_jobs=processes, return_as="generator")
    with _progress() as progress:
        _simulate_all(missing, store, parallel, progress)
        found, made = _draw_all(shown, store, drawn, parallel, progress)
    results, studies = _told(shown, found)

    store.forget_other_versions()
    printer = console(140)  # give every row its line
    if results or studies:
        told = to_markdown(results, studies, [*left_out, *ASSUMPTIONS])
        (out / "claims.md").write_text(told, encoding="utf-8")
        (out / "claims.csv").write_text(to_csv(results), encoding="utf-8")
    if results:
        printer.print(to_terminal(results))
    for why in left_out:
        printer.print(why)
    printer.print(f"runs simulated: {len(missing)}, pictures drawn: {made}, all in {out}", soft_wrap=True)
    return results


def _check(laws: Collection[str], form: str, processes: int) -> None:
    if form not in FORMATS:
        raise hqp.InvalidInput(f"format {form!r} is unknown; available: {', '.join(FORMATS)}")
    if whole_number(abs(processes) if isinstance(processes, int) else processes, "processes") == 0:
        raise hqp.InvalidInput("processes = 0; give a number of processes, or -1 for one a core")
    unknown = [law for law in laws if law not in NAMES]
    if unknown or not laws:
        raise hqp.InvalidInput(f"law {unknown[0] if unknown else ''!r} is unknown; available: {', '.join(NAMES)}")


def _compile(jobs: Sequence[Job]) -> None:
    """Compile here, once, what every process would compile for itself."""
    for job in jobs:
        controller(job)
    judging.warm_up()


def _simulate_all(missing: Sequence[Job], store: Store, parallel: Any, progress: Progress) -> None:
    """The runs that are not kept yet, the longest first."""
    from joblib import delayed

    bar = progress.add_task("simulating", total=len(missing), visible=bool(missing))
    ordered = sorted(missing, key=lambda job: job.ticks, reverse=True)
    for _ in parallel(delayed(_simulate)(job, store.path(job)) for job in ordered):
        progress.advance(bar)


def _draw_all(
    shown: Sequence[Picture], store: Store, drawn: Drawn, parallel: Any, progress: Progress
) -> tuple[list[list[RunResult]], int]:
    """The files that are not up to date; what the runs of each show, and how many were drawn, whole or in part."""
    from joblib import delayed

    keys = [drawn.key([store.key(job) for job in picture.jobs]) for picture in shown]
    due = [
        [file for file in picture.files if not drawn.has(file, key)] for picture, key in zip(shown, keys, strict=True)
    ]
    drawn.forget(file for files in due for file in files)
    bar = progress.add_task("drawing", total=len(shown))
    rows = parallel(
        delayed(_show)(
            picture, {job: store.path(job) for job in picture.needed}, [drawn.folder / file for file in files]
        )
        for picture, files in zip(shown, due, strict=True)
    )
    found: list[list[RunResult]] = []
    for files, key, of_picture in zip(due, keys, rows, strict=True):
        for file in files:
            drawn.add(file, key)
        found.append(of_picture)
        progress.advance(bar)
    return found, sum(map(bool, due))


def _told(shown: Sequence[Picture], found: Sequence[list[RunResult]]) -> tuple[list[RunResult], list[Section]]:
    """What figures show, a row a run, and what studies show, a table each."""
    results: list[RunResult] = []
    studies: list[Section] = []
    for picture, rows in zip(shown, found, strict=True):
        if isinstance(picture.subject, Study):
            studies.append(picture.subject.section(picture.jobs, rows))
        else:
            results += rows
    return results, studies


def _simulate(job: Job, path: Path) -> None:
    """In a process of its own: one run, kept as soon as it is finished."""
    run(job).save(path)


def _show(picture: Picture, runs: Mapping[Job, Path], due: Sequence[Path]) -> list[RunResult]:
    """In a process of its own: what is due of one picture, and what its runs show in numbers."""
    if not due and not picture.measured:
        return []
    records = {job: _loaded(job, path) for job, path in runs.items()}
    make(picture, records, due)
    if not picture.measured:
        return []
    closed = {job.law.key: records[job] for job in picture.jobs if job.closed_form}
    coarser = {job: records[other] for job, other in picture.coarser.items()}
    return [measure(job, records[job], closed.get(job.law.key), coarser.get(job)) for job in picture.jobs]


def _loaded(job: Job, path: Path) -> Record:
    """The record that is kept; a damaged one is made anew."""
    try:
        return Record.load(path)
    except hqp.InvalidInput:
        _simulate(job, path)
        return Record.load(path)


@contextmanager
def _progress() -> Iterator[Progress]:
    """A bar on stderr, so that stdout is the table alone."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description:<10}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), refresh_per_second=2) as progress:
        yield progress
