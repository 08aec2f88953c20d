"""Families of hierarchies that break solvers, each for one reason: seeded and reproducible.

>>> from hqp import Solver
>>> from hqp.problems import hierarchies
>>> solver = Solver()
>>> [solver.solve(hierarchy).certify().ok for hierarchy in hierarchies("infeasible top", 3)]
[True, True, True]

A case is named by family, seed and number. The expected behaviour of a correct solver is one of:

``certified``
    ``solution.certify().ok``.
``undecidable rank``
    The same where ranks can be told. A singular value of which projection leaves between 1e-12 and 1e-6 of the row
    norm is a direction to one correct solver and round-off to another: they disagree on x, double precision
    cannot decide which is right, and the certificate accepts either rank. That x may still miss it by the round-off
    which so small a singular value magnifies: of 1000 cases each, seed 0, the native solver misses 6 of "algorithmic
    singularity" and 8 of "nearly parallel", most of them with an x of 1e7 and more.
``certified or stalled``
    Numbers of so different size that a correct solver may also report STALLED, but never claim an x that the
    certificate refutes.
``refused``
    Status INVALID, with a message that names level and row; :func:`hqp.solve` raises InvalidInput.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..checks import whole_number
from ..errors import InvalidInput, brief
from ..hierarchy import Hierarchy
from . import adversaries

Expectation = Literal["certified", "undecidable rank", "certified or stalled", "refused"]


@dataclass(frozen=True)
class Family:
    """One reason to fail.

    Attributes
    ----------
    name : str
    hierarchy : callable
        One hierarchy from a random generator: ``family.hierarchy(rng)``.
    expect : str
        Of a correct solver: see the module.
    """

    name: str
    hierarchy: Callable[[np.random.Generator], Hierarchy]
    expect: Expectation = "certified"

    @property
    def about(self) -> str:
        """What it is made of, in one line."""
        return self.hierarchy.__doc__ or ""


#: The families of hard problems, by name.
FAMILIES: dict[str, Family] = {
    family.name: family
    for family in (
        Family("nearly singular", adversaries.nearly_singular, "undecidable rank"),
        Family("algorithmic singularity", adversaries.algorithmic_singularity, "undecidable rank"),
        Family("nearly parallel", adversaries.nearly_parallel, "undecidable rank"),
        Family("rows again", adversaries.rows_again),
        Family("repeated conflict", adversaries.repeated_conflict),
        Family("vertex", adversaries.vertex),
        Family("one point", adversaries.one_point),
        Family("thin slab", adversaries.thin_slab),
        Family("single point", adversaries.single_point),
        Family("infeasible top", adversaries.infeasible_top),
        Family("nothing said", adversaries.nothing_said),
        Family("nothing left", adversaries.nothing_left),
        Family("scaled levels", adversaries.scaled_levels),
        Family("scaled variables", adversaries.scaled_variables, "undecidable rank"),
        Family("scaled rows", adversaries.scaled_rows, "certified or stalled"),
        Family("weights", adversaries.weights),
        Family("weighted conflict", adversaries.weighted_conflict),
        Family("bounds", adversaries.bounds),
        Family("bad numbers", adversaries.bad_numbers, "refused"),
    )
}


def hierarchies(name: str, count: int, seed: int = 0) -> Iterator[Hierarchy]:
    """The first `count` hierarchies of a family, the same for the same arguments.

    Parameters
    ----------
    name : str
        One of `FAMILIES`.
    count : int
        How many.
    seed : int
        Another one gives others.

    Raises
    ------
    InvalidInput
        If there is no such family, or count or seed is no integer of at least 0.
    """
    if not isinstance(name, str) or name not in FAMILIES:
        raise InvalidInput(f"unknown family {brief(name)}; there are: {', '.join(FAMILIES)}")
    stream = [whole_number(seed, "seed"), zlib.crc32(name.encode())]
    make, numbers = FAMILIES[name].hierarchy, range(whole_number(count, "count"))
    return (make(np.random.default_rng([*stream, k])) for k in numbers)
