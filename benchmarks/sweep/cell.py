"""One cell: its draws solved by everyone in turn, cold and warm, and judged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ..families import FAMILIES, Sample
from ..methods import Call, Method, Outcome
from ..settings import Setting
from ..timing import timed
from .judge import judge
from .plan import Cell, Plan

#: A fresh solver that knows the structure alone, and one that has just solved the problem before.
STARTS = ("cold", "warm")

Entrant = tuple[Method, Setting]
#: One row of the results: a value for each column.
Row = dict[str, Any]


def measure(plan: Plan, cell: Cell) -> list[Row]:
    """The rows of a cell: one a draw, method, setting and start; but for times, the same for the same arguments."""
    family = FAMILIES[cell.family]
    entrants = plan.entrants(family)
    _warm_up(entrants, family.sample(plan.seed, cell.first))
    rows = []
    for draw in range(cell.first, cell.last):
        rounds = {entrant: number for entrant in entrants if (number := plan.rounds_of(entrant[0], draw))}
        if not rounds:  # where slow methods are alone
            continue
        sample = family.sample(plan.seed, draw)
        told = {"family": family.key, "group": family.group, "curve": family.curve, "at": family.at}
        told |= {"seed": plan.seed, "draw": draw, "n": sample.now.n, "m": sample.now.m}
        told["levels"] = len(sample.now.levels)
        rows += [told | row for row in _solved(sample, rounds, draw)]
    return rows


def _solved(sample: Sample, rounds: dict[Entrant, int], draw: int) -> Iterator[Row]:
    """One problem by everyone, in turns, so that the machine's moods hit all alike; another one begins each time."""
    runs: dict[tuple[Entrant, str], list[float]] = {}
    outcomes: dict[tuple[Entrant, str], Outcome] = {}
    everyone = list(rounds)
    for number in range(max(rounds.values(), default=0)):
        turn = (draw + number) % len(everyone)
        for entrant in everyone[turn:] + everyone[:turn]:
            if number >= rounds[entrant]:
                continue
            for start in STARTS:
                seconds, answer = timed(_call(entrant, start, sample))
                runs.setdefault((entrant, start), []).append(seconds)
                outcomes[entrant, start] = entrant[0].outcome(answer)
    # In the order of the plan: the first certified answer is what the others are compared with.
    runs = dict(sorted(runs.items(), key=lambda item: everyone.index(item[0][0])))
    verdicts, proved, active = judge(sample.now, [outcomes[key].x for key in runs])
    for ((method, setting), start), verdict in zip(runs, verdicts, strict=True):
        outcome, seconds = outcomes[(method, setting), start], runs[(method, setting), start]
        yield {
            "method": method.name,
            "setting": setting.name,
            "start": start,
            "seconds": min(seconds),
            "slowest": max(seconds),
            "rounds": len(seconds),
            "claimed": outcome.claimed,
            "status": outcome.status,
            "iterations": outcome.iterations,
            "proved": proved,
            "active": active,
        } | verdict._asdict()


def _call(entrant: Entrant, start: str, sample: Sample) -> Call:
    method, setting = entrant
    return method.cold(sample.now, setting) if start == "cold" else method.warm(*sample, setting)


def _warm_up(entrants: Sequence[Entrant], sample: Sample) -> None:
    """Let everything be imported, compiled and laid out."""
    for entrant in entrants:
        for start in STARTS:
            _call(entrant, start, sample)()
