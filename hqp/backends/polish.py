"""Polish: from a QP solver's 1e-9 to round-off, by one equality least squares on the rows found active.

Where the active rows of a :class:`.subproblem.LevelProblem` are known, it is an equality-constrained least
squares. The QP solver's answer tells them nearly always; where round-off blurred one, the optimality
conditions say which, the guess is mended and the least squares solved again, a few times.

Where rho, or a first-order solver, has blurred many, a mended guess may be further off than the one before. Then the
polish descends from the QP solver's point instead, a step towards the least squares of the present guess each time,
no further than the level improves and a hard row allows, and the rows found there are the next guess.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from ..arrays import Array, length
from ..certificate import excess
from .lapack import least_squares, row_space
from .subproblem import REACH, LevelProblem, Signs

#: Rounds of mending, all faults at once; and of descent after these.
MENDING, DESCENT = 6, 100
#: Slacks of the QP solver's point up to this share of the row's norm are taken for none.
BLUR = 1e-7
#: A multiplier of the wrong sign counts beyond this share of the forces in the level, one of the right sign
#: freezes its row for good beyond that share.
PULL, PRESS = 1e-9, 1e-7
#: What may remain of the forces in the level after the active hard rows have balanced them.
SLOPE = 1e-9
#: Round-off of a slack that a least squares has just computed, as a share of its tolerance.
ROUNDED = 1e-3


@dataclass(frozen=True, eq=False)
class Polished:
    """The point, whether it meets the optimality conditions to round-off, and which hard rows press (-1, 0, 1)."""

    y: Array
    verified: bool
    pressing: Signs
    rounds: int


class Fault(NamedTuple):
    """One contradiction to optimality: how bad, in what ("hard" row, "level" row, "slope"), and the row's new sign."""

    size: float
    kind: str
    row: int
    sign: int


def polish(problem: LevelProblem, y: Array, pressing: Signs, rank_tolerance: float) -> Polished:
    """Least squares on the active rows at y, mended until the optimality conditions hold or the rounds are used up."""
    problem = problem.reaching(y)
    active = pressing.copy()
    pulled: Signs = np.zeros(len(problem.B), dtype=np.int8)
    if not problem.equations:
        w = problem.slacks(y)
        pulled = (np.sign(w) * (np.abs(w) > BLUR * problem.norms)).astype(np.int8)
    start = y
    for turn in range(1, MENDING + 1):
        y = _least_squares(problem, y, active, pulled, rank_tolerance)
        faults, presses = _faults(problem, y, active, pulled)
        if not faults:
            return Polished(y, True, np.where(presses, active, 0).astype(np.int8), turn)
        for fault in faults:
            if fault.kind != "slope":
                (active if fault.kind == "hard" else pulled)[fault.row] = fault.sign
    done = _descend(problem, start, pressing.copy(), rank_tolerance)
    return replace(done, rounds=MENDING + done.rounds)


def _descend(problem: LevelProblem, y: Array, active: Signs, rank_tolerance: float) -> Polished:
    """Least squares after least squares, each reached as far as it pays, until the optimality conditions hold."""
    for turn in range(1, DESCENT + 1):
        pulled = np.sign(problem.slacks(y)).astype(np.int8)
        aim = _least_squares(problem, y, active, pulled, rank_tolerance)
        step, row = _pays(problem, y, aim - y, active)
        if step < 1.0:
            y = y + step * (aim - y)
            if row is not None:
                active[row[0]] = row[1]
            continue
        y = aim
        faults, presses = _faults(problem, y, active, pulled)
        if not faults:
            return Polished(y, True, np.where(presses, active, 0).astype(np.int8), turn)
        worst = next((fault for fault in faults if fault.kind == "hard"), None)
        if worst is not None:
            active[worst.row] = worst.sign
    return Polished(y, False, active, DESCENT)


def _pays(problem: LevelProblem, y: Array, d: Array, active: Signs) -> tuple[float, tuple[int, int] | None]:
    """How far along d the level improves, at most 1; and the hard row that ends it before, with its sign."""
    step, row = 1.0, None
    move, place = problem.N @ d, problem.N @ y
    for sign, room in ((1, problem.high - place), (-1, place - problem.low)):
        toward = (active == 0) & (sign * move > REACH * length(d)) & (room < sign * move)
        for i in np.flatnonzero(toward):
            reached = max(float(room[i]), 0.0) / float(sign * move[i])
            if reached < step:
                step, row = reached, (int(i), sign)
    best = _least(problem, y, d, step)
    return (step, row) if best >= step else (best, None)


def _least(problem: LevelProblem, y: Array, d: Array, furthest: float) -> float:
    """The t from 0 to `furthest` at which the level is least along ``y + t d``: its slope there grows with t."""
    value, move = problem.B @ y, problem.B @ d
    with np.errstate(divide="ignore", invalid="ignore"):
        kinks = np.concatenate([(problem.lower - value) / move, (problem.upper - value) / move])
    kinks = kinks[(kinks > 0.0) & (kinks < furthest)]
    ends = np.unique(np.concatenate([[0.0], kinks, [furthest]]))
    at = value + ends[:, None] * move
    slopes = excess(at, problem.lower, problem.upper) @ move
    if slopes[0] >= 0.0 or slopes[-1] <= 0.0:  # d is round-off: y is the least squares already; or it goes on
        return furthest
    after = int(np.argmax(slopes > 0.0))
    before = slopes[after - 1]
    t: float = ends[after - 1] - before * (ends[after] - ends[after - 1]) / (slopes[after] - before)
    return t


def _least_squares(problem: LevelProblem, y: Array, active: Signs, pulled: Signs, rank_tolerance: float) -> Array:
    """Smallest step from y to the least squares of the pulled rows on the active hard rows."""
    hard, Z = np.flatnonzero(active), np.eye(len(y))
    if len(hard):
        rows = problem.N[hard]
        goal = np.where(active[hard] > 0, problem.high[hard], problem.low[hard])
        fixed, Z = row_space(rows, rank_tolerance)
        y = y + fixed @ least_squares(rows @ fixed, goal - rows @ y)
    rows, norms, goal = problem.B, problem.norms, problem.lower
    if not problem.equations:
        chosen = problem.equality | (pulled != 0)
        goal = np.where(pulled > 0, problem.upper, problem.lower)[chosen]
        rows, norms = rows[chosen], norms[chosen]
    gap = goal - rows @ y
    rows = rows @ Z
    span, _ = row_space(rows / norms[:, None], rank_tolerance)
    return y + Z @ (span @ least_squares(rows @ span, gap))


def _faults(problem: LevelProblem, y: Array, active: Signs, pulled: Signs) -> tuple[list[Fault], NDArray[np.bool_]]:
    """What contradicts optimality at y, the worst first, and which hard rows carry force."""
    faults = [*_outside(problem, y, active), *_misjudged(problem, y, pulled)]
    w = problem.slacks(y)
    if not problem.equations:
        w = np.where(problem.equality | (pulled != 0), w, 0.0)
    pressing = np.zeros(len(active), dtype=np.bool_)
    if (np.abs(w) > problem.slack).any():
        force = float(problem.norms @ np.abs(w))
        hard = np.flatnonzero(active)
        gradient = problem.B.T @ w / force
        outward = problem.N[hard] * active[hard, None]
        multipliers, slope = _balance(outward, gradient)
        if slope > SLOPE + ROUNDED * float(problem.norms @ problem.slack) / force:
            faults.append(Fault(slope, "slope", 0, 0))  # a least squares from far away: once more from here
        faults += [Fault(float(-multipliers[i]), "hard", int(hard[i]), 0) for i in np.flatnonzero(multipliers < -PULL)]
        pressing[hard] = multipliers > PRESS
    return sorted(faults, reverse=True), pressing


def _outside(problem: LevelProblem, y: Array, active: Signs) -> Iterator[Fault]:
    """Hard rows beyond a bound, active or not: then the active rows contradict each other."""
    if not len(active):
        return
    place = problem.N @ y
    beyond = np.maximum(place - problem.high, problem.low - place)
    for row in np.flatnonzero(beyond > problem.margin):
        sign = 1 if place[row] > problem.high[row] else -1
        yield Fault(float(beyond[row]), "hard", int(row), sign if active[row] != sign else 0)


def _misjudged(problem: LevelProblem, y: Array, pulled: Signs) -> Iterator[Fault]:
    """Inequalities of the level that are violated and not pulled, or pulled and no longer violated."""
    if problem.equations:
        return
    value = problem.B @ y
    for sign, beyond in ((1, value - problem.upper), (-1, problem.lower - value)):
        ignored = ~problem.equality & (pulled != sign) & (beyond > problem.slack)
        overshot = ~problem.equality & (pulled == sign) & (beyond < -ROUNDED * problem.slack)
        for row in np.flatnonzero(ignored | overshot):
            size = abs(beyond[row]) / problem.norms[row]
            yield Fault(float(size), "level", int(row), sign if ignored[row] else 0)


def _balance(outward: Array, gradient: Array) -> tuple[Array, float]:
    """Multipliers with ``gradient + outward^T multipliers`` smallest, without a wrong sign if there is a choice."""
    if not len(outward):
        return np.zeros(0), length(gradient)
    multipliers: Array = np.asarray(np.linalg.lstsq(outward.T, -gradient, rcond=1e-12)[0], dtype=np.float64)
    slope = float(np.linalg.norm(outward.T @ multipliers + gradient))
    if multipliers.min(initial=0.0) < -PULL:
        try:  # dependent rows leave a choice
            chosen, left = nnls(outward.T, -gradient)
        except RuntimeError:
            return multipliers, slope
        if left <= slope + PULL:
            return chosen, float(left)
    return multipliers, slope
