r"""Eq. 4.8 against the strict stack {J1} > {J2}: where they coincide, and how far they differ elsewhere.

Eq. 4.8 leaves of the second task :math:`J_2 J_1^\# (h_1 - J_1 J_2^\# h_2)` more than the second task alone would. That
is nothing if :math:`J_1 J_2^T = 0`, or if the motion :math:`J_2^\# h_2` happens to do what the first task asks for; and
if the rows of J2 lie in the row space of J1, no method can avoid it. On the way into an algorithmic
singularity they part without bounds: the strict stack diverges, Eq. 4.8 leaves its second task where it is.

The strict answers are the native solver's, for near singularities the residuals of Eq. 3.17 are not its optimum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..backends.registry import ACCURACY
from ..certificate import certify
from ..hierarchy import Hierarchy, Level
from ..solver import Solver
from .closed_forms import FORMULAS, difference
from .conditioning import ROWS, SIGMAS, UNKNOWNS, ZONES, near_singular, stream, zone


def _tasks(rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    """J1, h1, J2, h2, which have nothing to do with each other."""
    J1, J2 = rng.standard_normal((2, ROWS, UNKNOWNS))
    h1, h2 = rng.standard_normal((2, ROWS))
    return J1, h1, J2, h2


def _at_right_angles(rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    J1, h1, J2, h2 = _tasks(rng)
    return J1, h1, J2 - J2 @ np.linalg.pinv(J1) @ J1, h2


def _inside(rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    J1, h1, _, h2 = _tasks(rng)
    return J1, h1, rng.standard_normal((ROWS, ROWS)) @ J1, h2


def _met_alone(rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    J1, _, J2, h2 = _tasks(rng)
    return J1, J1 @ np.linalg.pinv(J2) @ h2, J2, h2


#: How J2 stands to J1 -> the tasks, and whether both answers have to be the same.
RELATIONS: dict[str, tuple[Callable[[np.random.Generator], tuple[Array, Array, Array, Array]], bool]] = {
    "J1 J2^T = 0": (_at_right_angles, True),
    "row(J2) inside row(J1)": (_inside, True),
    "J1 J2# h2 = h1": (_met_alone, True),
    "in general": (_tasks, False),
}


@dataclass(frozen=True, eq=False)
class Parting:
    """Both answers to random stacks of one relation.

    Attributes
    ----------
    relation : str
        Of `RELATIONS`, or a place of :data:`hqp.validation.PLACES`.
    sigma : float
        The singular value there; NaN for a relation.
    coincide : bool
        Whether they have to be the same.
    x : array, shape (stacks,)
        ``||x_4.8 - x|| / ||x||``, where x is the strict one.
    residual : array, shape (stacks,)
        By how much Eq. 4.8 leaves the second task farther from its target than it need be, relative to ``||h2||``.
    strict, joint : array, shape (stacks,)
        Lengths of both answers.
    certified : int
        How many answers of Eq. 4.8 are the optimum of {J1} > {J2} all the same.
    """

    relation: str
    sigma: float
    coincide: bool
    x: Array
    residual: Array
    strict: Array
    joint: Array
    certified: int

    @property
    def ok(self) -> bool:
        """Whether they are the same where they have to be."""
        return not self.coincide or float(self.x.max()) <= ACCURACY["exact"]


def compare(relation: str, count: int, seed: int) -> list[Parting]:
    """Both answers to `count` random stacks of a relation of `RELATIONS`: a list of one."""
    rng = stream(seed, relation)
    make, coincide = RELATIONS[relation]
    stacks = []
    for _ in range(count):
        J1, h1, J2, h2 = make(rng)
        stacks.append(Hierarchy([Level.equality(J1, h1), Level.equality(J2, h2)]))
    return [_part(relation, math.nan, coincide, stacks)]


def part(place: str, count: int, seed: int, sigmas: Sequence[float] = SIGMAS) -> list[Parting]:
    """Both answers near a singularity: to the stacks of :func:`hqp.validation.approach`, any targets."""
    partings = []
    for sigma in sigmas:
        rng = stream(seed, place, "any", sigma)
        stacks = [near_singular(place, "any", sigma, rng) for _ in range(count)]
        coincide = place == "between the levels" and zone(sigma) == ZONES[-1]
        partings.append(_part(place, sigma, coincide, stacks))
    return partings


def _part(relation: str, sigma: float, coincide: bool, stacks: Iterable[Hierarchy]) -> Parting:
    solvers = Solver(), Solver(FORMULAS["Eq. 4.8"])
    rows, certified = [], 0
    for stack in stacks:
        best, other = (solver.solve(stack).x for solver in solvers)
        J2, h2 = stack.matrix(1), stack.levels[1].lower
        left = [float(np.linalg.norm(J2 @ x - h2)) for x in (other, best)]
        worse = (left[0] - left[1]) / float(np.linalg.norm(h2))
        rows.append([difference(other, best), worse, np.linalg.norm(best), np.linalg.norm(other)])
        certified += certify(stack, other).ok
    x, residual, strict, joint = np.array(rows).T
    return Parting(relation, sigma, coincide, x, residual, strict, joint, certified)
