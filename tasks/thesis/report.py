"""Simulate, draw, tabulate: on all cores, every file kept as soon as it is finished, nothing made twice."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import hqp
from hqp.checks import whole_number

from .._checks import writable
from .._terminal import console
from ..motion.record import Record
from .animation import animate
from .figures import draw
from .findings import Finding, measure, to_csv
from .ideas import IDEAS, Idea
from .laws import NAMES, Law, laws_of
from .runs import Job, jobs_of, run
from .scenarios import ASSUMPTIONS, SCENARIOS, Scenario, scenario
from .store import Drawn, Store
from .studies import STUDIES, Study
from .tables import Section, to_markdown, to_terminal

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.progress import Progress

FORMATS = ("png", "pdf", "svg")
DPI = 110

Subject = Scenario | Idea | Study


@dataclass(frozen=True)
class Picture:
    """A figure of the text, the picture of an idea or a study, the runs it shows, and the files to make of it."""

    subject: Subject
    jobs: tuple[Job, ...]
    files: tuple[str, ...]

    @property
    def shown(self) -> tuple[Job, ...]:
        """One run a law of a figure: the backend's, which comes after the formula's. Of others, all."""
        return tuple({job.law.key: job for job in self.jobs}.values()) if self.of_figure else self.jobs

    @property
    def coarser(self) -> dict[Job, Job]:
        """Of the runs that are compared with the same at twice the tick, that one."""
        compared = self.of_figure or (isinstance(self.subject, Study) and self.subject.against_ticks)
        return {job: job.coarser for job in self.shown} if compared else {}

    @property
    def needed(self) -> tuple[Job, ...]:
        """All that has to be simulated."""
        return *self.jobs, *self.coarser.values()

    @property
    def of_figure(self) -> bool:
        """Whether it is a figure of the text."""
        return isinstance(self.subject, Scenario)


def report(
    figures: Sequence[str],
    backend: str | None,
    out: Path,
    *,
    laws: Collection[str] = NAMES,
    form: str = "png",
    animated: bool = False,
    processes: int = -1,
) -> list[Finding]:
    """Reproduce figures of the thesis into a folder, and print the table of claims against findings.

    Parameters
    ----------
    figures : sequence of str
        Such as ``"4.7"``, or the name of an idea or a study, such as ``"argument"`` or ``"lines"``; empty for all.
    backend : str, optional
        Beside the closed forms (default: ``hqp.DEFAULT_BACKEND``).
    out : Path
        Receives ``figure-4.7.png``, ..., ``claims.md`` and ``claims.csv`` of the figures asked for,
        and ``runs/``: what is finished there is not made again.
    laws : collection of str
        Of :data:`tasks.thesis.laws.NAMES`.
    form : {"png", "pdf", "svg"}
        Of the pictures.
    animated : bool
        Whether each figure is written as a GIF, too.
    processes : int
        That work at the same time; -1 for one a core.

    Returns
    -------
    list of Finding
        One a run of every figure, in the order of the text.

    Raises
    ------
    InvalidInput
        Before anything is simulated, if a figure, a law, the format or the backend is unknown, or the
        folder or a file in it cannot be written to.
    """
    from joblib import Parallel, delayed

    if form not in FORMATS:
        raise hqp.InvalidInput(f"format {form!r} is unknown; available: {', '.join(FORMATS)}")
    if whole_number(abs(processes) if isinstance(processes, int) else processes, "processes") == 0:
        raise hqp.InvalidInput("processes = 0; give a number of processes, or -1 for one a core")
    unknown = [law for law in laws if law not in NAMES]
    if unknown or not laws:
        raise hqp.InvalidInput(f"law {unknown[0] if unknown else ''!r} is unknown; available: {', '.join(NAMES)}")
    chosen = hqp.DEFAULT_BACKEND if backend is None else backend
    info = hqp.backend_info(chosen)
    subjects = _subjects(figures, laws)
    left_out = dict.fromkeys(
        why for item in subjects for law in _laws(item, laws) if (why := law.refusal(info)) is not None
    )
    pictures = [_picture(subject, chosen, laws, form, animated) for subject in subjects]
    pictures = [picture for picture in pictures if picture.jobs or not _laws(picture.subject, laws)]
    if not pictures:
        raise hqp.InvalidInput(f"there is nothing to show: {'; '.join(left_out)}")
    writable(out, [*(file for picture in pictures for file in picture.files), "claims.md", "claims.csv"])
    writable(out / "runs", ["drawn.json"])
    store, drawn = Store(out / "runs"), Drawn(out, out / "runs" / "drawn.json")

    missing = [job for job in dict.fromkeys(job for picture in pictures for job in picture.needed) if job not in store]
    missing.sort(key=lambda job: job.ticks, reverse=True)  # the longest first
    if missing:
        hqp.Solver(chosen)  # what has to be compiled is compiled once, not by every process
    parallel = Parallel(n_jobs=processes, return_as="generator")
    findings: list[Finding] = []
    studies: list[Section] = []
    made = 0
    with _progress() as progress:
        bar = progress.add_task("simulating", total=len(missing), visible=bool(missing))
        for _ in parallel(delayed(_simulate)(job, store.path(job)) for job in missing):
            progress.advance(bar)

        keys = [drawn.key([store.key(job) for job in picture.jobs]) for picture in pictures]
        due = [
            [file for file in picture.files if not drawn.has(file, key)]
            for picture, key in zip(pictures, keys, strict=True)
        ]
        drawn.forget(file for files in due for file in files)
        bar = progress.add_task("drawing", total=len(pictures))
        shown = parallel(
            delayed(_show)(picture, {job: store.path(job) for job in picture.needed}, [out / file for file in files])
            for picture, files in zip(pictures, due, strict=True)
        )
        for picture, files, key, found in zip(pictures, due, keys, shown, strict=True):
            for file in files:
                drawn.add(file, key)
            made += len(files)
            if isinstance(picture.subject, Study):
                studies.append(picture.subject.section(picture.jobs, found))
            else:
                findings += found
            progress.advance(bar)

    store.forget_other_versions()
    printer = console(140)  # give every row its line
    if findings or studies:
        told = to_markdown(findings, studies, [*left_out, *ASSUMPTIONS])
        (out / "claims.md").write_text(told, encoding="utf-8")
        (out / "claims.csv").write_text(to_csv(findings), encoding="utf-8")
    if findings:
        printer.print(to_terminal(findings))
    for why in left_out:
        printer.print(why)
    printer.print(f"runs simulated: {len(missing)}, pictures drawn: {made}, all in {out}", soft_wrap=True)
    return findings


def _subjects(figures: Sequence[str], laws: Collection[str]) -> list[Subject]:
    """What the names mean, each once. If there are none: all figures, and ideas and studies, which take all laws."""
    others: dict[str, Idea | Study] = {**IDEAS, **STUDIES}
    if not figures:
        return [*SCENARIOS.values(), *(others.values() if set(laws) >= set(NAMES) else ())]
    names = dict.fromkeys(map(str.strip, figures))
    for name in names:
        if name not in others and name not in SCENARIOS:
            raise hqp.InvalidInput(f"figure {name!r} is unknown; available: {', '.join([*SCENARIOS, *others])}")
    return [others[name] if name in others else scenario(name) for name in names]


def _laws(subject: Subject, laws: Collection[str]) -> Sequence[Law]:
    return laws_of(subject, laws) if isinstance(subject, Scenario) else subject.laws


def _picture(subject: Subject, backend: str, laws: Collection[str], form: str, animated: bool) -> Picture:
    if isinstance(subject, Study):
        return Picture(subject, tuple(subject.jobs(backend)), ())
    if isinstance(subject, Idea):
        return Picture(subject, tuple(subject.jobs(backend)), (f"{subject.name}.{form}",))
    name = f"figure-{subject.figure}"
    files = (f"{name}.{form}", f"{name}.gif") if animated else (f"{name}.{form}",)
    return Picture(subject, tuple(jobs_of(subject, backend, laws)), files)


def _simulate(job: Job, path: Path) -> None:
    """In a process of its own: one run, kept as soon as it is finished."""
    run(job).save(path)


def _show(picture: Picture, runs: Mapping[Job, Path], due: Sequence[Path]) -> list[Finding]:
    """In a process of its own: what is due of one picture, and what its runs show in numbers."""
    records = {job: _loaded(job, path) for job, path in runs.items()}
    item = picture.subject
    if isinstance(item, Idea):
        for file in due:
            _save(item.draw({job: records[job] for job in picture.jobs}), file)
        return []
    for file in due:  # none of a study
        assert isinstance(item, Scenario)
        shown = {job: records[job] for job in picture.shown}
        if file.suffix == ".gif":
            animate(item, shown, _part(file))
            _part(file).replace(file)
        else:
            _save(draw(item, shown), file)
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


def _save(figure: Figure, file: Path) -> None:
    """The file appears whole or not at all."""
    figure.savefig(_part(file), dpi=DPI)
    _part(file).replace(file)


def _part(file: Path) -> Path:
    """What a file is called while it is written; the suffix stays, for it tells the format."""
    return file.with_stem(f".{file.stem}-part")


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
