"""The list of pictures that the report makes: simulated figures, drawings, ideas and studies."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import hqp
from hqp.backends import BackendInfo

from ..simulation.record import Record
from .animation import animate
from .drawings import DRAWINGS, Drawing
from .figures import draw
from .ideas import IDEAS, Idea
from .laws import NAMES, Law, laws_of
from .plain import draw_plain
from .runs import Job, jobs_of
from .scenarios import SCENARIOS, Scenario, scenario
from .studies import STUDIES, Study
from .style import PRINT, SCREEN, part, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Subject = Scenario | Idea | Study | Drawing


@dataclass(frozen=True)
class Picture:
    """A picture of the report: the runs it shows, and its files; of a study, which is a table, none."""

    subject: Subject
    jobs: tuple[Job, ...]
    files: tuple[str, ...]

    @property
    def shown(self) -> tuple[Job, ...]:
        """One run a law of a figure: the backend's, which comes after the formula's. Of others, all."""
        return tuple({job.law.key: job for job in self.jobs}.values()) if self.of_figure else self.jobs

    @property
    def coarser(self) -> dict[Job, Job]:
        """Run -> the same run at twice the tick that it is compared with."""
        compared = self.of_figure or (isinstance(self.subject, Study) and self.subject.against_ticks)
        return {job: job.coarser for job in self.shown} if compared else {}

    @property
    def needed(self) -> tuple[Job, ...]:
        """All that has to be simulated."""
        return *self.jobs, *self.coarser.values()

    @property
    def of_figure(self) -> bool:
        """Whether it is a simulated figure of the text."""
        return isinstance(self.subject, Scenario)

    @property
    def measured(self) -> bool:
        """Whether its runs stand in a table, in numbers."""
        return self.of_figure or isinstance(self.subject, Study)


def subjects(names: Sequence[str], laws: Collection[str]) -> list[Subject]:
    """What the names mean, each once. If there are none: all there is, in the order of the text.

    Drawings, ideas and studies are left out where only some laws are asked for: no law concerns the first,
    and the others take all.

    Raises
    ------
    InvalidInput
        If a name is unknown; lists those that there are.
    """
    known = [*DRAWINGS, *SCENARIOS, *IDEAS, *STUDIES]
    if not names:
        return [_subject(name) for name in (known if set(laws) >= set(NAMES) else SCENARIOS)]
    wanted = dict.fromkeys(map(str.strip, names))
    for name in wanted:
        if name not in known:
            raise hqp.InvalidInput(f"figure {name!r} is unknown; available: {', '.join(known)}")
    return [_subject(name) for name in wanted]


def pictures(
    chosen: Sequence[Subject], backend: str, laws: Collection[str], form: str, animated: bool
) -> list[Picture]:
    """What can be shown with this backend.

    Raises
    ------
    InvalidInput
        If that is nothing; tells why.
    """
    found = [_picture(subject, backend, laws, form, animated) for subject in chosen]
    found = [picture for picture in found if picture.jobs or not _laws(picture.subject, laws)]
    if not found:
        reasons = refusals(chosen, hqp.backend_info(backend), laws)
        raise hqp.InvalidInput(f"there is nothing to show: {'; '.join(reasons)}")
    return found


def refusals(chosen: Sequence[Subject], backend: BackendInfo, laws: Collection[str]) -> list[str]:
    """Which laws are left out because this backend cannot show them, and why, each once."""
    told = (law.refusal(backend) for subject in chosen for law in _laws(subject, laws))
    return list(dict.fromkeys(why for why in told if why is not None))


def make(picture: Picture, records: Mapping[Job, Record], files: Sequence[Path]) -> None:
    """Make files of one picture; one that comes in several formats is drawn once."""
    shown = {job: records[job] for job in picture.shown}
    drawn: dict[str, Figure] = {}
    for file in files:
        if file.suffix == ".gif":
            assert isinstance(picture.subject, Scenario)
            animate(picture.subject, shown, part(file))
            part(file).replace(file)
            continue
        if file.stem not in drawn:
            drawn[file.stem] = _drawn(picture.subject, shown, plain=file.stem.endswith("-plain"))
        printed = isinstance(picture.subject, Drawing) or file.stem.endswith("-plain")
        save(drawn[file.stem], file, PRINT if printed else SCREEN)


def _drawn(subject: Subject, shown: Mapping[Job, Record], *, plain: bool) -> Figure:
    """The picture of a subject that has one, of a simulated figure in one of its two forms."""
    if isinstance(subject, Drawing):
        return subject.draw()
    if isinstance(subject, Scenario):
        return draw_plain(*next(iter(shown.items()))) if plain else draw(subject, shown)
    assert isinstance(subject, Idea)  # a study is a table
    return subject.draw(shown)


def _subject(name: str) -> Subject:
    return DRAWINGS.get(name) or IDEAS.get(name) or STUDIES.get(name) or scenario(name)


def _laws(subject: Subject, laws: Collection[str]) -> Sequence[Law]:
    if isinstance(subject, Scenario):
        return laws_of(subject, laws)
    return () if isinstance(subject, Drawing) else subject.laws


def _picture(subject: Subject, backend: str, laws: Collection[str], form: str, animated: bool) -> Picture:
    """A picture with its files; one that may go into a paper is made in pixels and in lines."""
    paper = ("png", "svg" if form == "svg" else "pdf")
    if isinstance(subject, Study):
        return Picture(subject, tuple(subject.jobs(backend)), ())
    if isinstance(subject, Idea):
        return Picture(subject, tuple(subject.jobs(backend)), (f"{subject.name}.{form}",))
    name = f"figure-{subject.figure}"
    if isinstance(subject, Drawing):
        return Picture(subject, (), tuple(f"{name}.{suffix}" for suffix in paper))
    files = [f"{name}.{form}", *(f"{name}-plain.{suffix}" for suffix in paper)]
    if animated:
        files.append(f"{name}.gif")
    return Picture(subject, tuple(jobs_of(subject, backend, laws)), tuple(files))
