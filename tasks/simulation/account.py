"""The explanation of a whole motion: which levels had a residual, when, and what held them back."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from hqp import Solution
from hqp.certificate import LevelExplanation

from ..base.checks import Array

#: The most causes that are named for a tick, or for a stretch of time.
MOST_NAMED = 3
#: A residual up to this size is round-off [m/s], [rad/s], ...
ROUND_OFF = 1e-9
#: The most stretches of one level that a line each is written of: the worst ones; the rest of them share a line.
MOST_TOLD = 3
#: A level that lacks up to this counts as met: damping and contacts leave residuals of such sizes [m/s], [rad/s], ...
NEGLIGIBLE = 1e-5


@dataclass(frozen=True)
class Shortfall:
    """A level that could not be met in one tick.

    Attributes
    ----------
    level : str
        The names of its parts.
    lacks : dict of str to float
        Unit -> Euclidean norm of what is missing.
    causes : tuple of str
        What held it back: damping first, then the strongest causes; empty if its own rows contradict each other.
    """

    level: str
    lacks: dict[str, float]
    causes: tuple[str, ...]

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Shortfall:
        """The shortfall from its JSON data, as :func:`dataclasses.asdict` gives it."""
        return cls(plain["level"], dict(plain["lacks"]), tuple(plain["causes"]))


def shortfalls(solution: Solution) -> tuple[Shortfall, ...]:
    """The levels that a tick could not meet, the highest first; none if all were met up to round-off."""
    found = []
    for level in solution.explain().levels:
        if not met(level):
            name = " + ".join(part.part for part in level.parts)
            lacks: dict[str, float] = {}
            for part in level.parts:
                for unit, norm in part.residual.items():
                    lacks[unit] = (lacks.get(unit, 0.0) ** 2 + norm**2) ** 0.5
            causes = tuple((["damping"] if level.damped else []) + [str(cause) for cause in level.causes])[:MOST_NAMED]
            if level.zero or level.unmoved:
                causes = ("its own rows are zero" if level.zero else "nothing moves it in a direction",)
            found.append(Shortfall(name, {unit: norm for unit, norm in lacks.items() if norm > 0.0}, causes))
    return tuple(found)


def met(level: LevelExplanation) -> bool:
    """Whether a level lacks nothing that matters."""
    return all(norm <= NEGLIGIBLE for part in level.parts for norm in part.residual.values())


@dataclass(frozen=True)
class Stretch:
    """A period in which one level was never met.

    Attributes
    ----------
    level : str
    begin, end : float
        Times of its first and its last checked tick [s].
    most : dict of str to float
        Unit -> the largest norm of what was missing.
    causes : tuple of str
        The causes that held it back in the most of these ticks.
    """

    level: str
    begin: float
    end: float
    most: dict[str, float]
    causes: tuple[str, ...]

    def __str__(self) -> str:
        return self.told(f"at {self.begin:g} s" if self.begin == self.end else f"from {self.begin:g} to {self.end:g} s")

    def told(self, when: str) -> str:
        """The line about it, with the words for its time."""
        lacks = " and ".join(f"{norm:.3g} {unit}".rstrip() for unit, norm in self.most.items())
        why = ", then ".join(self.causes) if self.causes else "its own rows contradict each other"
        return f"{self.level} short {when}, by at most {lacks}: {why}"


@dataclass(frozen=True)
class Account:
    """The explanation of a whole motion; ``print`` it.

    Of a level with many stretches the worst are printed in a line each, and all others in one more line.

    Attributes
    ----------
    begin, end : float
        Times of the first and the last checked tick [s].
    checked, certified : int
        How many ticks were checked, and how many of them the certificate accepts.
    stretches : tuple of Stretch
        In the order of time.
    stopped : str or None
        Why the run ended early.
    """

    begin: float
    end: float
    checked: int
    certified: int
    stretches: tuple[Stretch, ...]
    stopped: str | None

    def __str__(self) -> str:
        if not self.checked:
            lines = ["no tick was checked; simulate(..., certify=1) checks all"]
        else:
            every = f"{self.certified} of {self.checked} checked ticks certified"
            lines = [f"t = {self.begin:g} .. {self.end:g} s, {every}", *_lines(self.stretches)]
            lines += [] if self.stretches else ["all levels met"]
        return "\n".join(lines + ([] if self.stopped is None else [f"stopped: {self.stopped}"]))

    __repr__ = __str__


def account(checked_t: Array, ticks: Sequence[Sequence[Shortfall]], certified: int, stopped: str | None) -> Account:
    """Join the shortfalls of checked ticks to stretches: a level's stretch ends at the first tick that meets the level.

    Parameters
    ----------
    checked_t : array, shape (ticks,)
        Times of the checked ticks [s].
    ticks : sequence of sequences of Shortfall
        What each of them could not meet.
    certified : int
    stopped : str or None
        As of :class:`Account`.
    """
    times = checked_t.tolist()
    open_: dict[str, list[tuple[float, Shortfall]]] = {}
    done: list[Stretch] = []
    for t, short in zip(times, ticks, strict=True):
        now = {each.level: each for each in short}
        done += [_stretch(open_.pop(level)) for level in list(open_) if level not in now]
        for level, each in now.items():
            open_.setdefault(level, []).append((t, each))
    done += [_stretch(ticks) for ticks in open_.values()]
    begin, end = (times[0], times[-1]) if times else (0.0, 0.0)
    stretches = tuple(sorted(done, key=lambda stretch: stretch.begin))
    return Account(begin, end, len(times), certified, stretches, stopped)


def _lines(stretches: Sequence[Stretch]) -> list[str]:
    """The lines about stretches, in the order of time."""
    found: list[tuple[float, str]] = []
    for level in dict.fromkeys(stretch.level for stretch in stretches):
        own = [stretch for stretch in stretches if stretch.level == level]
        own.sort(key=lambda stretch: max(stretch.most.values(), default=0.0), reverse=True)
        told, rest = (own, []) if len(own) <= MOST_TOLD + 1 else (own[:MOST_TOLD], own[MOST_TOLD:])
        found += [(stretch.begin, str(stretch)) for stretch in told]
        if rest:
            joined = _joined(rest)
            when = f"at {len(rest)} other times from {joined.begin:g} to {joined.end:g} s"
            found.append((joined.begin, joined.told(when)))
    return [line for _, line in sorted(found, key=lambda each: each[0])]


def _joined(stretches: Sequence[Stretch]) -> Stretch:
    """One stretch for several of a level, from the first begin to the last end, with their commonest causes."""
    parts = [(stretch.begin, Shortfall(stretch.level, stretch.most, stretch.causes)) for stretch in stretches]
    return replace(_stretch(sorted(parts, key=lambda each: each[0])), end=max(stretch.end for stretch in stretches))


def _stretch(ticks: Sequence[tuple[float, Shortfall]]) -> Stretch:
    most: dict[str, float] = {}
    causes: Counter[str] = Counter()
    for _, each in ticks:
        for unit, norm in each.lacks.items():
            most[unit] = max(most.get(unit, 0.0), norm)
        causes.update(each.causes)
    named = tuple(cause for cause, _ in causes.most_common(MOST_NAMED))
    return Stretch(ticks[0][1].level, ticks[0][0], ticks[-1][0], most, named)
