r"""A damped level written as undamped levels: first with its damping rows, then frozen at the values it reached."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, length, lengths, products
from ..certificate import excess, row_states, split
from ..errors import InvalidInput
from ..hierarchy import Hierarchy, Label, Level, Side
from ..settings import Settings


class DampedLevel:
    """One damped level at work: the plain hierarchies of its stages, laid out once and refilled.

    Parameters
    ----------
    whole : Hierarchy
        The hierarchy that is refilled and solved again and again.
    k : int
        The level.

    Attributes
    ----------
    above, levels : Hierarchy
        The levels above it, and those with it: as of the last `refill`.
    joined : Hierarchy
        The levels above, and this one with the rows of damping, ``x = aim`` of weight lambda: as of the last
        `damp` or `filter`.
    """

    def __init__(self, whole: Hierarchy, k: int) -> None:
        self.level, self._whole = whole.levels[k], whole
        self.above = Hierarchy(whole.levels[:k], n=whole.n)
        self.levels = Hierarchy(whole.levels[: k + 1], n=whole.n)
        self._rows = np.array(whole.matrix(k))  # which stay as they are where the level is plain
        labels = [whole.label_of(row) for row in range(*whole.pointers[k : k + 2])]
        labels += [Label("damping", f"x[{i}]") for i in range(whole.n)]
        zeros = np.zeros(len(labels))
        rows = np.concatenate([self._rows, np.eye(whole.n)])
        self.joined = Hierarchy([*whole.levels[:k], Level(rows, zeros, zeros, name=self.level.name, labels=labels)])
        self._own = self.joined.levels[k]

    def refill(self) -> None:
        """Take the numbers of the levels above, and of this one."""
        for part in self.above, self.levels:
            self._copy(part)

    def lacking(self, x: Array) -> float:
        """``||D_k w_k||`` of the level at x."""
        level = self.level
        return length(level.weights * excess(self._dense() @ x, level.lower, level.upper))

    def least_damping(self, settings: Settings) -> float:
        """Smallest lambda at which rows of damping count as independent; below it the level is left strict.

        A strict level ignores singular values below the rank tolerance, so that its x is no larger.
        """
        return 0.1 * settings.rank_tolerance * float((self.level.weights * lengths(self._dense())).min(initial=np.inf))

    def satisfied_above(self, x: Array) -> bool:
        """Whether x, a reference, is the answer of the levels above, because it violates none of their rows."""
        value = self.above.product(x)
        return bool(((self.above.lower <= value) & (value <= self.above.upper)).all())

    def damp(self, damping: float, aim: Array) -> None:
        """Join the rows of damping."""
        level = self.level
        self._write(self._dense(), level.lower, level.upper, level.weights, damping, aim)

    def filter(self, own: NDArray[np.bool_], u: Array, damping: float, filtering: float, aim: Array) -> None:
        r"""Join the rows of damping, and weaken the combination u of the rows `own`, which are equalities.

        :math:`J^T (J J^T + \lambda^2 I + \beta^2 u u^T)^{-1} r` minimises :math:`\|F (J x - r)\|^2 + \lambda^2
        \|x\|^2` for :math:`F = \lambda (\lambda^2 I + \beta^2 u u^T)^{-1/2} = I - (1 - \lambda / \sqrt{\lambda^2 +
        \beta^2}) u u^T`.
        """
        level = self.level
        F = np.eye(len(u)) - (1.0 - damping / math.hypot(damping, filtering)) * np.outer(u, u)
        combined = np.zeros((len(level), len(level)))  # the other rows are free, or zero
        combined[np.ix_(own, own)] = F * level.weights[own]
        b = combined @ np.where(own, level.lower, 0.0)
        self._write(combined @ self._dense(), b, b, np.ones(len(b)), damping, aim)

    def freeze(self, x: Array, aim: Array, settings: Settings) -> None:
        """Hold the equality and violated rows of the level where they are at x, in the whole hierarchy itself.

        The x of the next stage may be shorter by orders of magnitude: what is round-off here is none there.
        """
        level = self.level
        reached = products(self._dense(), x)
        if (level.lower == level.upper).all():
            level.lower[:] = level.upper[:] = reached
            return
        self._copy(self.levels)
        states, first = row_states(self.levels, x, aim, tolerance(settings)), self.levels.pointers[-2]
        held = (states.sides[first:] == Side.EQUALITY) | states.violated[first:]
        level.lower[:], level.upper[:] = np.where(held, (reached, reached), (level.lower, level.upper))

    def _dense(self) -> Array:
        return self._rows if self.level.A is None else self.level.A

    def _write(self, A: Array, lower: Array, upper: Array, weights: Array, damping: float, aim: Array) -> None:
        self._copy(self.joined, self.above)
        own, m = self._own, len(lower)
        assert own.A is not None
        own.A[:m], own.lower[:m], own.upper[:m], own.weights[:m] = A, lower, upper, weights
        own.lower[m:], own.upper[m:], own.weights[m:] = aim, aim, damping

    def _copy(self, part: Hierarchy, top: Hierarchy | None = None) -> None:
        """The numbers of the whole, as far as the levels of `top` go (default: all of the part)."""
        like = part if top is None else top
        m, dense, whole = like.m, len(like.A), self._whole
        part.A[:dense], part.weights[:m] = whole.A[:dense], whole.weights[:m]
        part.lower[:m], part.upper[:m] = whole.lower[:m], whole.upper[:m]


def project(levels: Hierarchy, x: Array, aim: Array, settings: Settings) -> tuple[Array, NDArray[np.bool_]]:
    """The rows of the last level that are active at x, weighted, in the null space of those above.

    Returns
    -------
    J : array, shape (rows, unknowns left)
    own : array of bool, shape (m_k,)
        Which rows of the level these are.
    """
    states, first = row_states(levels, x, aim, tolerance(settings)), levels.pointers[-2]
    rows, active = levels.dense(), (states.sides != Side.INACTIVE) & (states.norms > 0)
    above, own = active[:first], active[first:]
    _, null_space = split(rows[:first][above], states.norms[:first][above], settings.rank_tolerance)
    J: Array = levels.weights[first:][own, None] * rows[first:][own] @ null_space
    return J, own


def left_singular(J: Array) -> tuple[Array, Array]:
    """Left singular vectors, and as many singular values as there are rows, largest first."""
    vectors, singular, _ = np.linalg.svd(J)
    return vectors, np.concatenate([singular, np.zeros(len(J) - len(singular))])


def tolerance(settings: Settings) -> float:
    """The tolerance by which rows count as satisfied or active, as in `levels` of a solution."""
    return 10 * settings.tolerance


def has_inequalities(levels: Hierarchy) -> bool:
    """Whether it matters to the active rows where x is."""
    return bool(_inequalities(levels.lower, levels.upper).any())


def refuse_inequalities(levels: Hierarchy) -> None:
    """Raise InvalidInput at the first row of the last level that is an inequality."""
    level = levels.levels[-1]
    wrong = _inequalities(level.lower, level.upper)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InvalidInput(
            f"{levels.level_name(len(levels.levels) - 1)}, row {row} is an inequality"
            f" ({level.lower[row]:g} <= A x <= {level.upper[row]:g}); numerical filtering takes equality rows only"
        )


def _inequalities(lower: Array, upper: Array) -> NDArray[np.bool_]:
    """Rows that are neither equalities nor free."""
    wanted: NDArray[np.bool_] = (lower != upper) & (np.isfinite(lower) | np.isfinite(upper))
    return wanted
