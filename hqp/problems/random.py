"""Hierarchies to try solvers on: seeded, reproducible, with the degeneracies that break them.

Everything here is a pure function of its random generator, so a case is named by its seed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from warnings import warn

import numpy as np

from ..arrays import Array
from ..hierarchy import Hierarchy, Level

#: (unknowns, rows of each level) of the validation against the closed form.
SHAPES: tuple[tuple[int, tuple[int, ...]], ...] = (
    (3, (2, 1)),
    (4, (2, 1, 4)),
    (7, (3, 3, 7)),
    (7, (3, 4)),
    (10, (6, 3, 10)),
    (30, (6, 6, 6, 30)),
)


def _full_rank(rng: np.random.Generator, n: int, rows: tuple[int, ...]) -> list[Array]:
    return [rng.standard_normal((m, n)) for m in rows]


def _rank_deficient(rng: np.random.Generator, n: int, rows: tuple[int, ...]) -> list[Array]:
    """The first level has rank one less than rows, at the most."""
    tasks = _full_rank(rng, n, rows)
    rank = max(1, rows[0] - 1)
    tasks[0] = rng.standard_normal((rows[0], rank)) @ rng.standard_normal((rank, n))
    return tasks


def _inside(rng: np.random.Generator, n: int, rows: tuple[int, ...]) -> list[Array]:
    """The second level lies in the row space of the first: nothing is left for it."""
    tasks = _full_rank(rng, n, rows)
    tasks[1] = rng.standard_normal((rows[1], rows[0])) @ tasks[0]
    return tasks


def _repeated(rng: np.random.Generator, n: int, rows: tuple[int, ...]) -> list[Array]:
    """The first row of the first level comes again, first in the second, with another target."""
    tasks = _full_rank(rng, n, rows)
    tasks[1][0] = tasks[0][0]
    return tasks


#: The rank cases of the validation.
CASES: dict[str, Callable[[np.random.Generator, int, tuple[int, ...]], list[Array]]] = {
    "full rank": _full_rank,
    "rank deficient": _rank_deficient,
    "second inside first": _inside,
    "repeated row": _repeated,
}


@dataclass(frozen=True)
class Case:
    """One case of the validation: the shape of a stack, and the ranks of its levels.

    Parameters
    ----------
    n : int
        Number of unknowns.
    rows : tuple of int
        Rows of each level.
    rank : str
        A rank case, one of `CASES`.
    """

    n: int
    rows: tuple[int, ...]
    rank: str

    @property
    def name(self) -> str:
        """Unknowns, rows and ranks, as in ``7; 3,4 repeated row``."""
        return f"{self.n}; {','.join(map(str, self.rows))} {self.rank}"

    @property
    def label(self) -> str:
        """Former name of :attr:`name`."""
        warn("Case.label is Case.name now", DeprecationWarning, stacklevel=2)
        return self.name

    def hierarchy(self, rng: np.random.Generator) -> Hierarchy:
        """A random stack of equality levels of this family; targets are standard normal."""
        tasks = CASES[self.rank](rng, self.n, self.rows)
        return Hierarchy(
            [Level.equality(J, rng.standard_normal(len(J)), name=f"task {k}") for k, J in enumerate(tasks)]
        )


def equality_cases() -> Iterator[Case]:
    """Every shape of `SHAPES` in every rank case of `CASES`."""
    for n, rows in SHAPES:
        for rank in CASES:
            yield Case(n, rows, rank)


def random_hierarchy(rng: np.random.Generator, *, n: int | None = None, levels: int | None = None) -> Hierarchy:
    """A small hierarchy with everything in it that a hierarchy may have.

    Equality, one-sided, two-sided, free and zero rows; plain bounds; empty levels; more rows than
    unknowns; rank-deficient levels; rows that come again lower down, scaled or negated, with the
    same or a contradicting target; integer data (exact ties); weights over two decades.

    Parameters
    ----------
    rng : numpy.random.Generator
    n : int, optional
        Unknowns (default: 2 to 12).
    levels : int, optional
        Levels (default: 1 to 6).

    Examples
    --------
    >>> import numpy as np
    >>> from hqp import solve
    >>> from hqp.problems import random_hierarchy
    >>> solve(random_hierarchy(np.random.default_rng(0))).certify().ok
    True
    """
    n = int(rng.integers(2, 13)) if n is None else n
    count = int(rng.integers(1, 7)) if levels is None else levels
    integers = rng.random() < 0.2
    above: list[Array] = []
    built = []
    for k in range(count):
        name = f"random {k}"
        if rng.random() < 0.2:
            built.append(_bounds(rng, n, integers, name))
            continue
        m = int(rng.integers(0, n + 3)) if rng.random() < 0.2 else int(rng.integers(1, max(2, n // 2 + 1)))
        A = _rows(rng, m, n, integers, above)
        above.extend(A)
        lower, upper = random_sides(rng, A @ _draw(rng, n, integers), integers)
        weights = 10.0 ** rng.uniform(-1, 1, m) if rng.random() < 0.3 else None
        built.append(Level(A, lower, upper, weights=weights, name=name))
    return Hierarchy(built, n=n)


def _draw(rng: np.random.Generator, size: int | tuple[int, int], integers: bool) -> Array:
    return rng.integers(-2, 3, size).astype(float) if integers else rng.standard_normal(size)


def _rows(rng: np.random.Generator, m: int, n: int, integers: bool, above: list[Array]) -> Array:
    A = _draw(rng, (m, n), integers)
    if m > 1 and rng.random() < 0.2:  # rank-deficient
        rank = int(rng.integers(1, m))
        A = _draw(rng, (m, rank), integers) @ _draw(rng, (rank, n), integers)
    for i in range(m):
        if above and rng.random() < 0.2:  # a row from above, the same, negated or scaled
            A[i] = above[int(rng.integers(len(above)))] * rng.choice([1.0, -1.0, 2.0, 0.5])
        elif rng.random() < 0.02:
            A[i] = 0.0
    return A


def random_sides(rng: np.random.Generator, value: Array, integers: bool = False) -> tuple[Array, Array]:
    """Lower and upper bounds of all kinds about `value`; a third of them shifted, so that levels conflict.

    Parameters
    ----------
    rng : numpy.random.Generator
    value : array, shape (m,)
        About which the bounds lie.
    integers : bool
        Whether they are whole numbers, so that ties are exact.

    Returns
    -------
    lower, upper : array, shape (m,)
    """
    m = len(value)
    shift = np.where(rng.random(m) < 0.33, _draw(rng, m, integers), 0.0)
    centre = value + shift
    width = np.abs(_draw(rng, m, integers))
    lower, upper = centre - width, centre + width
    kind = rng.choice(["equality", "two-sided", "above", "below", "free"], size=m, p=[0.4, 0.25, 0.15, 0.15, 0.05])
    lower, upper = np.where(kind == "equality", centre, lower), np.where(kind == "equality", centre, upper)
    lower = np.where((kind == "below") | (kind == "free"), -np.inf, lower)
    upper = np.where((kind == "above") | (kind == "free"), np.inf, upper)
    return lower, upper


def _bounds(rng: np.random.Generator, n: int, integers: bool, name: str) -> Level:
    m = int(rng.integers(1, n + 1))
    indices = rng.choice(n, size=m, replace=False)
    lower, upper = random_sides(rng, _draw(rng, m, integers), integers)
    return Level.bounds(lower, upper, indices=indices, name=name)
