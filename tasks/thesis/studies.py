"""Further runs, a table each: the effect of the line, of the tick, and of other stacks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import hqp

from .laws import COASTING, DAMPED, LIMITS, RESTING, STRICT, THESIS, TIP, TIP_HELD, TIP_LIMITS, Law
from .run_result import RunResult
from .runs import Job
from .scenarios import INCLINED, MINUTE, Course, Scenario, scenario
from .tables import Section, angle, every_run, verdict

#: Where the inclined line, which the text does not give, may end: short, as assumed, long; all at 45 degrees [m].
ENDS = ((0.5, 0.2), (0.3, 0.0), (-0.4, -0.7))
#: At which ticks the tip alone follows it [min].
TICKS = ("2e-4", "1e-4", "5e-5", "2.5e-5")

Run = tuple[Scenario, Law]


@dataclass(frozen=True)
class Study:
    """A table of its own in claims.md.

    Attributes
    ----------
    name : str
        For ``hqp thesis --figure``.
    runs : callable
        () -> pairs of Scenario and Law: what it shows.
    tabulate : callable
        Runs and what they show in numbers -> table.
    against_ticks : bool
        Whether each run is compared with the same at twice the tick.
    """

    name: str
    runs: Callable[[], Sequence[Run]]
    tabulate: Callable[[Mapping[Run, RunResult]], Section]
    against_ticks: bool = False

    @property
    def laws(self) -> tuple[Law, ...]:
        """The laws of its runs, each once."""
        return tuple(dict.fromkeys(law for _, law in self.runs()))

    def jobs(self, backend: str) -> list[Job]:
        """What to simulate for it; none if the backend cannot show one of its laws."""
        info = hqp.backend_info(backend)
        if any(law.refusal(info) for law in self.laws):
            return []
        return [Job(item, law, backend) for item, law in self.runs()]

    def section(self, jobs: Sequence[Job], found: Sequence[RunResult]) -> Section:
        """The table of these jobs and of what they show."""
        return self.tabulate({(job.scenario, job.law): one for job, one in zip(jobs, found, strict=True)})


def on_line(figure: str, end: tuple[float, float], tick: str = "") -> Scenario:
    """A figure on the inclined line to another end [m], without joint limits at another tick [min]."""
    item = scenario(figure)
    course = Course("line", (INCLINED.points[0], end))
    return replace(item, course=course, undecided="", free_tick=MINUTE * float(tick) if tick else item.free_tick)


def _lines() -> Iterable[tuple[str, Law, str]]:
    """The rows of the first study: figure, law, and tick [min] where there is more than one."""
    for tick in TICKS:
        yield "4.26", TIP, tick
    yield "4.26", TIP_LIMITS, ""
    for figure in ("4.27", "4.29", "4.31", "4.32", "4.33", "4.35", "4.37"):
        item = scenario(figure)
        decided = () if item.undecided else (DAMPED,)
        for law in (TIP, TIP_LIMITS) if item.phi is None else (THESIS, LIMITS, *decided):
            yield figure, law, ""


def lines(found: Mapping[Run, RunResult]) -> Section:
    """One row for each claim, law and tick; one column for each end of the line, with the verdict there."""
    rows = []
    for figure, law, tick in _lines():
        items = [on_line(figure, end, tick) for end in ENDS]
        title = f"{law.title}, tick {tick} min" if tick else law.title
        for claim in items[0].claims:
            cells = [verdict(item, claim, found[item, law]) for item in items]
            rows.append([figure, angle(items[0]), claim.says, title, *cells])
    headings = ("figure", "φ", "the text", "law", *(f"to ({x:g}, {y:g})" for x, y in ENDS))
    legend = (
        "What would be found if the inclined line from (1, 0.7), at 45 degrees, ended elsewhere; it is assumed to end"
        f" at ({ENDS[1][0]:g}, {ENDS[1][1]:g}). Marks as above."
    )
    return Section("Other lines, finer ticks", headings, rows, legend, left=4)


#: The runs of the second study.
STACKS = {
    **dict.fromkeys(("4.3", "4.11", "4.13", "4.27"), (LIMITS, COASTING, DAMPED)),
    **dict.fromkeys(("4.33", "4.35", "4.37"), (STRICT, LIMITS, RESTING)),
    "4.26": (TIP, TIP_HELD, TIP_LIMITS),
}
#: What the second study tells of its runs.
SHOWN = (
    "figure", "law", "tip_error_mm", "phi_share", "phi_peak_deg", "peak_speed", "reversals", "peak_acceleration",
    "end_speed", "turned_deg", "tick_deg",
)  # fmt: skip


def stacks(found: Mapping[Run, RunResult]) -> Section:
    """A row a run."""
    legend = (
        "Coasting: damping of the accelerations alone, by which speeds stay. Least motion: as a last level, below the"
        " orientation."
        " Reversals: how often the joint that does so most often turns back; speeds within 1 rad/min of zero have no"
        " direction."
    )
    return every_run("Other stacks", list(found.values()), SHOWN, legend)


#: Name -> study.
STUDIES = {
    study.name: study
    for study in (
        Study("lines", lambda: [(on_line(f, end, tick), law) for f, law, tick in _lines() for end in ENDS], lines),
        Study("stacks", lambda: [(scenario(f), law) for f, laws in STACKS.items() for law in laws], stacks, True),
    )
}
