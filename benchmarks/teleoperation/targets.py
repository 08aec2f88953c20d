"""The design targets of the default stack, as laws over the rows of a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import degrees

from ..tables import Row
from .measure import CONSTANTS, Measure
from .metrics import ROUND_OFF
from .scenes import HUMANOID, KNOWN, SCENES, Scene

#: The rows that the laws are about: ours, ours without the default damping, and the calm one among the others.
OURS, STRICT, CALM = "hqp", "hqp strict", "pink daqp lm 100"
IN_REACH, EDGE = ("figure eight", "tremor", "slow joints"), ("stretched", "ur5 stretched", "outside")
BEYOND = tuple(s.name for s in SCENES if s.name not in (*IN_REACH, *EDGE, HUMANOID.name))
#: In and out of reach, by how much a tick may be longer than the strict one.
COSTS = {"in reach": 1.1, "out of reach": 1.8}
#: What second order does to a task that is held exactly, while the levels below move the joints at full speed [m].
UNMOVED = 1e-4

Rows = Mapping[str, Measure]


@dataclass(frozen=True)
class Check:
    """One law for one scene.

    Attributes
    ----------
    what, unit : str
    value : float or None
        What was measured; None where it never came about.
    limit : float or None
        What it may be at most; None where the row that it is compared with is missing.
    why : str
        Where the limit comes from.
    """

    what: str
    unit: str
    value: float | None
    limit: float | None
    why: str

    @property
    def met(self) -> bool | None:
        """Whether it holds; None where nobody can tell."""
        if self.limit is None:
            return None
        return self.value is not None and self.value <= self.limit


def checks(scene: Scene, rows: Rows) -> list[Check]:
    """All laws for a scene whose rows have been measured; none where the default is not among them."""
    if OURS not in rows:
        return []
    found = [*_limits(rows[OURS])]
    for names, laws in ((IN_REACH, _in_reach), (EDGE, _edge), (BEYOND, _beyond), ((HUMANOID.name,), _humanoid)):
        if scene.name in names:
            found += laws(scene, rows)
    return found


def costs(cost: list[Row]) -> list[Check]:
    """The laws for the times of ticks."""
    return [
        Check(f"tick, {row['where']}", "1", float(row["ratio p50"]), COSTS[row["where"]], "the strict tick")
        for row in cost
    ]


def told(scene: Scene, found: list[Check]) -> list[Row]:
    """As rows of a table."""
    verdict = {True: "met", False: "MISSED", None: "not told"}
    return [
        {
            "scene": scene.name,
            "name": check.what,
            "unit": check.unit,
            "measured": "never" if check.value is None else f"{check.value:.4g}",
            "at most": "" if check.limit is None else f"{check.limit:.4g}",
            "about": check.why,
            "verdict": verdict[check.met],
        }
        for check in found
    ]


def _limits(ours: Measure) -> Iterator[Check]:
    yield Check("joints out of their ranges", "rad", max(ours.out, ours.further), ROUND_OFF, "round-off")
    yield Check("joints too fast", "rad/s", ours.over, ROUND_OFF, "round-off")
    yield Check("ticks raised or frozen", "", float(ours.raised + ours.frozen), 0.0, "")


def _in_reach(scene: Scene, rows: Rows) -> Iterator[Check]:
    ours, strict = rows[OURS], rows.get(STRICT)
    yield Check("error from strict", "mm", _apart(ours, strict, _error), 0.2, STRICT)
    if ours.turned is not None:
        yield Check("angle from strict", "deg", _apart(ours, strict, _angle), 0.05, STRICT)
    yield Check("jerk", "rad/s^3", ours.jerk, _times(1.1, strict), f"1.1 x {STRICT}")
    yield from _moved(ours, UNMOVED, "in reach")


def _edge(scene: Scene, rows: Rows) -> Iterator[Check]:
    ours, soon = rows[OURS], CONSTANTS / scene.gain
    yield Check("error", "mm", _error(ours), 1.05 * _nearest(rows), "1.05 x the nearest")
    if _as_known(scene):
        yield Check("jerk", "rad/s^3", ours.jerk, 250.0, "")
    yield Check("power above 3 Hz", "%", 100.0 * ours.fast, 0.5, "")
    if scene.beyond:
        yield Check("joints back", "s", ours.back, soon, "5 / K")
    yield from _back(ours, soon)
    yield from _moved(ours, UNMOVED, "at the edge")


def _beyond(scene: Scene, rows: Rows) -> Iterator[Check]:
    ours = rows[OURS]
    yield Check("error", "mm", _error(ours), 1.15 * _nearest(rows) + 1.0, "1.15 x the nearest + 1")
    yield Check("jerk", "rad/s^3", ours.jerk, _times(2.0, rows.get(CALM)), f"2 x {CALM}")
    yield from _back(ours, CONSTANTS / scene.gain)
    yield from _moved(ours, 1e-3, "out of reach")


def _humanoid(scene: Scene, rows: Rows) -> Iterator[Check]:
    ours = rows[OURS]
    strayed = None if ours.strayed is None else 1e3 * ours.strayed
    yield Check("feet", "mm", strayed, 0.5, "")
    if ours.end is not None and ours.forced is not None:
        yield Check("at the end", "mm", 1e3 * ours.end, 1.1e3 * ours.forced, "1.1 x solve_ik")
    if _as_known(scene):
        yield Check("jerk", "rad/s^3", ours.jerk, 500.0, "")


def _back(ours: Measure, soon: float) -> Iterator[Check]:
    """Coming back into reach, of motions that do."""
    yield Check("caught", "", float(ours.caught), 0.0, "")
    if ours.reach is not None:
        yield Check("back in reach", "s", ours.reach, soon, "5 / K")


def _moved(ours: Measure, most: float, where: str) -> Iterator[Check]:
    if ours.moved is not None:
        yield Check("moved by levels below", "mm", 1e3 * ours.moved, 1e3 * most, where)
    if ours.pushed is not None:
        yield Check("pushed by levels below", "mm", 1e3 * ours.pushed, 1e3 * most, where)


def _error(of: Measure) -> float:
    """[mm]."""
    return 1e3 * of.excess


def _angle(of: Measure) -> float:
    """[deg]."""
    return 0.0 if of.turned is None else degrees(of.turned)


def _apart(ours: Measure, other: Measure | None, what: Callable[[Measure], float]) -> float | None:
    return None if other is None else abs(what(ours) - what(other))


def _times(factor: float, of: Measure | None) -> float | None:
    return None if of is None else factor * of.jerk


def _nearest(rows: Rows) -> float:
    """The least error of all rows [mm]."""
    return min(_error(row) for row in rows.values())


def _as_known(scene: Scene) -> bool:
    """Whether gain and tick are those that absolute numbers were set for."""
    known = KNOWN[0]
    return (scene.gain, scene.dt) == (known.gain, known.dt)
