"""Judges an answer: by the certificate, and against the best answer known."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hqp import Hierarchy, InvalidInput, Side, certify
from hqp.arrays import Array
from hqp.certificate import excess, row_states

#: From where on a residual is another one, relative to the scale of its level; from where on a slack is one.
WRONG, NONE = 1e-5, 1e-9


class Verdict(NamedTuple):
    """One answer.

    Attributes
    ----------
    certified : bool
    gaps : tuple of float
        Residual norm minus that of the best answer, level by level, relative to the scale of the level,
        ``||d_i A_i|| max(1, ||x||)`` with the weights d; the implicit last level, ``||x||``, comes last. Infinite where
        x is no number.
    gap : float
        The lexicographic gap: the first of `gaps` beyond `WRONG`, the largest where none is.
    wrong : bool
        Whether x is not certified and has a gap beyond `WRONG`: more than tolerances explain.
    violation : float
        The largest slack, relative to ``||A_i|| max(1, ||x||)``, among the rows in which the best answer has none.
    error : float
        Distance from the best answer, relative to ``max(1, ||x||)``.
    """

    certified: bool
    gaps: tuple[float, ...]
    gap: float
    wrong: bool
    violation: float
    error: float


class Judgement(NamedTuple):
    """All answers to one problem.

    Attributes
    ----------
    verdicts : list of Verdict
    proved : bool
        Whether the best answer is certified; where none is, it is the best that was found.
    active : float
        Share of the inequality rows that the best answer has at a bound or beyond it.
    """

    verdicts: list[Verdict]
    proved: bool
    active: float


def proved(problem: Hierarchy, x: Array) -> bool:
    """Whether an answer is certified, whatever it is."""
    try:
        return certify(problem, x).ok
    except InvalidInput:  # no number, or beyond all sense
        return False


def judge(problem: Hierarchy, answers: Sequence[Array]) -> Judgement:
    """Judge the answers to a problem. The best is the first certified one, or the lexicographically smallest."""
    court = _Court(problem)
    certified = court.proofs(answers)
    with np.errstate(all="ignore"):  # an answer may be of any size, and none
        best = answers[certified.index(True)] if True in certified else court.smallest(answers)
        verdicts = [court.verdict(x, best, proof) for x, proof in zip(answers, certified, strict=True)]
        return Judgement(verdicts, True in certified, court.active(best))


class _Court:
    """A problem with everything that all verdicts on it need."""

    def __init__(self, problem: Hierarchy) -> None:
        self.problem, self.A, self.norms = problem, problem.dense(), problem.row_norms()
        self.levels = [slice(*ends) for ends in pairwise(problem.pointers)]
        scales = [float(np.linalg.norm((problem.weights * self.norms)[own])) for own in self.levels]
        self.scales = np.array([scale or 1.0 for scale in scales] + [1.0])

    def proofs(self, answers: Sequence[Array]) -> list[bool]:
        """Which of them are certified; what came more than once is looked at once."""
        proofs = {key: proved(self.problem, x) for key, x in {x.tobytes(): x for x in answers}.items()}
        return [proofs[x.tobytes()] for x in answers]

    def slacks(self, x: Array) -> Array:
        return excess(self.A @ x, self.problem.lower, self.problem.upper)

    def residuals(self, x: Array) -> Array:
        """Of every level and the implicit last one, in their scales."""
        weighted = self.problem.weights * self.slacks(x)
        norms = np.array([*(np.linalg.norm(weighted[own]) for own in self.levels), np.linalg.norm(x)]) / self.scales
        return np.where(np.isfinite(norms), norms, np.inf)

    def smallest(self, answers: Sequence[Array]) -> Array:
        """The answer that no other beats at the first level where they differ beyond `WRONG`."""
        best, least = answers[0], self.residuals(answers[0])
        for x in answers[1:]:
            residuals = self.residuals(x)
            other = np.flatnonzero(~(np.abs(residuals - least) <= WRONG * _length(x)))
            if len(other) and residuals[other[0]] < least[other[0]]:
                best, least = x, residuals
        return best

    def verdict(self, x: Array, best: Array, proof: bool) -> Verdict:
        size = _length(best)
        residuals, least = self.residuals(x), self.residuals(best)
        gaps = np.full(len(residuals), np.inf)
        np.subtract(residuals, least, out=gaps, where=np.isfinite(residuals) & np.isfinite(least))
        gaps /= size
        beyond = np.flatnonzero(np.abs(gaps) > WRONG)
        gap = float(gaps[beyond[0]] if len(beyond) else gaps.max())
        error = float(np.linalg.norm(x - best)) / size
        return Verdict(
            certified=proof,
            gaps=tuple(map(float, gaps)),
            gap=gap,
            wrong=bool(len(beyond)) and not proof,
            violation=self._violation(x, best),
            error=error if np.isfinite(error) else np.inf,
        )

    def _violation(self, x: Array, best: Array) -> float:
        unit = np.where(self.norms > 0, self.norms, 1.0)
        kept = np.abs(self.slacks(best)) <= NONE * unit * _length(best)
        broken = np.abs(self.slacks(x))[kept] / unit[kept]
        worst = float(broken.max(initial=0.0)) / _length(best)
        return worst if np.isfinite(worst) else np.inf

    def active(self, best: Array) -> float:
        if not np.isfinite(best).all():
            return float("nan")
        sides = row_states(self.problem, best, np.zeros(self.problem.n), NONE).sides
        inequalities = (self.problem.lower < self.problem.upper) & (
            np.isfinite(self.problem.lower) | np.isfinite(self.problem.upper)
        )
        return float(np.mean(sides[inequalities] != Side.INACTIVE)) if inequalities.any() else 0.0


def _length(x: Array) -> float:
    length = float(np.linalg.norm(x))
    return max(1.0, length) if np.isfinite(length) else 1.0
