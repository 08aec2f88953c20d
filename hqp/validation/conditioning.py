r"""Backends against the closed forms on the way into a singularity.

Two levels of three rows on seven unknowns, an arm with a position above an orientation. All singular values are one
but for those that are :math:`\sigma`:

* inside a level, the smallest of :math:`J_1` or of :math:`J_2`: a kinematic singularity;
* between the levels, those of :math:`\hat J_2 = J_2 (I - J_1^\# J_1)`: an algorithmic singularity, at which
  :math:`J_2 = T J_1` although both have full rank.

No method can be more accurate than :math:`\varepsilon / \sigma` in x, because the numbers of the stack are
rounded themselves. Where :math:`\sigma` is between 1e-12 and 1e-6 the rank is not decidable, see ``docs/theory.md``:
results there are shown and not judged.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..backends.registry import ACCURACY, backend_info
from ..certificate import certify
from ..hierarchy import Hierarchy, Level
from ..settings import Settings
from ..solver import Solver
from .closed_forms import FORMULAS, difference, formulas_of, problems, residual_difference

#: The singular values, two a decade.
SIGMAS = tuple(10.0 ** (-k / 2) for k in range(29))
#: Between these, exclusive, the rank is not decidable in double precision.
UNDECIDABLE = 1e-12, 1e-6
#: From the regular end to the singular one.
ZONES = "full rank", "undecidable", "truncated"
#: Targets: ``J x*`` of a standard normal x*, so that x stays of its size; or standard normal, so that it may not.
TARGETS = "in reach", "any"
UNKNOWNS, ROWS = 7, 3


def zone(sigma: float) -> str:
    """The zone of `ZONES`: every solver has to keep the direction of `sigma`, none has to, or that is undecidable."""
    low, high = UNDECIDABLE
    return ZONES[0] if sigma >= high else ZONES[2] if sigma <= low else ZONES[1]


def _orthonormal(rng: np.random.Generator, rows: int, n: int) -> Array:
    """Rows of length one, at right angles to each other, in a random direction."""
    return np.linalg.svd(rng.standard_normal((rows, n)), full_matrices=False)[2]


def _nearly_singular(rng: np.random.Generator, sigma: float) -> Array:
    singular = np.append(np.ones(ROWS - 1), sigma)
    J: Array = _orthonormal(rng, ROWS, ROWS) * singular @ _orthonormal(rng, ROWS, UNKNOWNS)
    return J


def _inside_first(rng: np.random.Generator, sigma: float) -> tuple[Array, Array]:
    """J1 itself is nearly singular."""
    return _nearly_singular(rng, sigma), _orthonormal(rng, ROWS, UNKNOWNS)


def _inside_second(rng: np.random.Generator, sigma: float) -> tuple[Array, Array]:
    """J2 itself is nearly singular."""
    return _orthonormal(rng, ROWS, UNKNOWNS), _nearly_singular(rng, sigma)


def _between(rng: np.random.Generator, sigma: float) -> tuple[Array, Array]:
    """J2 = T J1 + sigma E, where E is at right angles to J1."""
    directions = _orthonormal(rng, 2 * ROWS, UNKNOWNS)
    own, beside = directions[:ROWS], directions[ROWS:]
    J1, T, E = (_orthonormal(rng, ROWS, ROWS) for _ in range(3))
    return J1 @ own, T @ own + sigma * (E @ beside)


#: Where the singularity is -> J1 and J2.
PLACES: dict[str, Callable[[np.random.Generator, float], tuple[Array, Array]]] = {
    "inside level 0": _inside_first,
    "inside level 1": _inside_second,
    "between the levels": _between,
}


def stream(seed: int, *names: str | float) -> np.random.Generator:
    """Random numbers that depend on seed and purpose, not on the caller: all backends get the same stacks."""
    return np.random.default_rng([seed, zlib.crc32(repr(names).encode())])


def near_singular(place: str, targets: str, sigma: float, rng: np.random.Generator) -> Hierarchy:
    """A random stack of a place of `PLACES` and targets of `TARGETS`."""
    tasks = PLACES[place](rng, sigma)
    point = rng.standard_normal(UNKNOWNS)
    aims = [J @ point if targets == "in reach" else rng.standard_normal(ROWS) for J in tasks]
    return Hierarchy(
        [Level.equality(J, aim, name=f"task {k}") for k, (J, aim) in enumerate(zip(tasks, aims, strict=True))]
    )


@dataclass(eq=False)
class Point:
    """One backend against one formula at one sigma.

    Attributes
    ----------
    backend, formula, place, targets : str
    sigma : float
    polished : bool
        Whether the cascade polished; if not, it is there to explain, and promises nothing.
    x, residual : array, shape (stacks,)
        Differences from the closed form, as in :class:`hqp.validation.Report`, of every stack.
    length : array, shape (stacks,)
        ``||x||`` of the backend.
    certified, failures : int
        As in :class:`hqp.validation.Report`.
    """

    backend: str
    formula: str
    place: str
    targets: str
    sigma: float
    polished: bool
    x: Array
    residual: Array
    length: Array
    certified: int = 0
    failures: int = 0

    @property
    def name(self) -> str:
        """Name of the backend, and whether it was left unpolished."""
        return self.backend if self.polished else f"{self.backend}, unpolished"

    @property
    def allowed(self) -> float:
        """The relative accuracy that the backend's class promises."""
        return ACCURACY[backend_info(self.backend).accuracy] if self.polished else math.inf

    @property
    def outside(self) -> int:
        """Stacks on which the backend is not within its class, or 1e-6 where it promises nothing."""
        allowed = ACCURACY["exact"] if math.isinf(self.allowed) else self.allowed
        return int(np.count_nonzero(np.maximum(self.x, self.residual) > allowed))

    @property
    def ok(self) -> bool:
        """Whether the backend is inside its class, or the rank not decidable."""
        return zone(self.sigma) == "undecidable" or math.isinf(self.allowed) or not (self.outside or self.failures)


def approach(
    backend: str,
    place: str,
    count: int,
    seed: int,
    *,
    sigmas: Sequence[float] = SIGMAS,
    polished: bool = True,
) -> list[Point]:
    """Solve `count` random stacks at every sigma, for both kinds of targets and every formula the backend aims at."""
    points = []
    for formula in formulas_of(backend):
        solver, reference = Solver(backend, Settings(polish=polished)), Solver(FORMULAS[formula])
        for targets in TARGETS:
            for sigma in sigmas:
                rng = stream(seed, place, targets, sigma)
                point = Point(backend, formula, place, targets, sigma, polished, *np.zeros((3, count)))
                for k in range(count):
                    stack = near_singular(place, targets, sigma, rng)
                    own, posed = problems(backend, formula, stack)
                    solution, closed = solver.solve(posed), reference.solve(stack).x
                    point.x[k] = difference(solution.x, closed)
                    point.residual[k] = residual_difference(own, solution.x, closed)
                    point.length[k] = np.linalg.norm(solution.x)
                    point.certified += certify(own, solution.x).ok
                    point.failures += not solution.ok
                points.append(point)
    return points
