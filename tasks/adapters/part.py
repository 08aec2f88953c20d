r"""Rows that another library measures, as a part of a stack.

Pink and mink solve one quadratic program for a step :math:`\Delta q = v\,\Delta t`. Each of their objects adds a cost

.. math:: \tfrac12 \lVert W (J \Delta q + \alpha e) \rVert^2 + \tfrac\mu2 \lVert \Delta q \rVert^2,

or a constraint :math:`G \Delta q \le h`. Here these become rows of v: :math:`W J v = -\alpha W e / \Delta t` with
:math:`\sqrt\mu\, v = 0` below them, and :math:`G v \le h / \Delta t`. On one level they give the step of the other
library; on several, priorities.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array
from ..base.live import structure
from ..robots.answers import at_rest
from ..robots.robot import Robot
from ..rows.expansion import Companions, Setting
from ..rows.part import Order, Part
from ..rows.tick import Tick

#: Names of rows that both libraries have in this order.
ROW_NAMES = {
    "FrameTask": ("x", "y", "z", "rx", "ry", "rz"),
    "RelativeFrameTask": ("x", "y", "z", "rx", "ry", "rz"),
    "ComTask": ("x", "y", "z"),
}
#: A matrix (rows, nv) and a vector (rows,), of a step of the joints.
Rows = tuple[Array, Array]


class Source(ABC):
    """Computes the rows of one object of another library."""

    #: What messages call it: ``FrameTask``.
    kind: str

    @abstractmethod
    def rows(self, robot: Robot, q: Array, dt: float) -> Rows:
        """The rows of a step at configuration q; of a constraint those of ``G dq <= h``.

        Raises
        ------
        InvalidInput
            If the object cannot be measured.
        """

    def row_names(self, count: int) -> Sequence[str]:
        """What explanations call so many rows."""
        own = ROW_NAMES.get(self.kind, ())
        return [*own, *(f"row {i}" for i in range(len(own), count))] if len(own) <= count else own[:count]


def origin(given: object) -> str:
    """The class of an object and the library it is of: the libraries call theirs alike."""
    kind = type(given)
    library = kind.__module__.partition(".")[0]
    return kind.__name__ if library == "builtins" else f"{kind.__name__} of {library}"


class Adapted(Part):
    """One object of another library as rows of velocity; made by :func:`from_pink` or :func:`from_mink`.

    Its numbers are live: what is set on the object of the other library takes effect at the next tick.
    At velocity order only, with the dt of the controller as the length of the step.

    Parameters
    ----------
    source : Source
        Computes the rows.
    bounds : bool
        Whether the rows are inequalities ``G dq <= h``; otherwise they ask for a motion.
    name : str or None
        Its name in explanations (default: the class of the object).
    """

    bounds: bool = structure()

    def __init__(self, source: Source, *, bounds: bool, name: str | None) -> None:
        self._source = source
        self._counted: tuple[Robot, int] | None = None
        self.bounds = bounds
        self.name = source.kind.lower() if name is None else of_type(name, str, f"name of a {source.kind}")
        self.weight = np.array(1.0)

    @property
    def is_limit(self) -> bool:  # type: ignore[override]
        """Whether the rows only bound, and ask for nothing."""
        return self.bounds

    def full_name(self) -> str:
        return f"{self._source.kind} {self.name!r}"

    def __repr__(self) -> str:
        return f"Adapted({self.full_name()})"

    def companions(self, setting: Setting) -> Companions:
        """Itself, with as many rows as the object has now."""
        self._counted = None
        return super().companions(setting)

    def size(self, robot: Robot) -> int:
        """As many rows as the object had at rest when the stack was built; later it may have fewer, and not more."""
        if self._counted is None or self._counted[0] is not robot:
            self._counted = robot, len(self._measure(robot, at_rest(robot).q, 1.0)[1])
        return self._counted[1]

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        unit = "step/s" if self.bounds else "cost/s"
        return [Label(self.name, row, unit) for row in self._source.row_names(self.size(robot))]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if order != "velocity" or dt is None:
            raise InvalidInput(f"{self.full_name()} is for velocity order with a dt: its rows are those of one step")

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        """Measure the object at the configuration of this tick."""
        assert A is not None
        assert tick.dt is not None
        matrix, vector = self._measure(tick.robot, tick.state.q, tick.dt)
        count = len(vector)
        if count > len(lower):
            raise InvalidInput(
                f"{self.full_name()} has {count} rows now, and {len(lower)} when the controller was made;"
                " make a new one"
            )
        A[:count], A[count:] = matrix, 0.0
        lower[:], upper[count:] = -np.inf, np.inf
        upper[:count] = vector / tick.dt
        if not self.bounds:
            lower[:count] = upper[:count]

    def _measure(self, robot: Robot, q: Array, dt: float) -> Rows:
        """The rows of a step; any exception of the other library becomes an InvalidInput with its reason."""
        try:
            found = self._source.rows(robot, q, dt)
            matrix, vector = np.atleast_2d(np.asarray(found[0], dtype=float)), np.asarray(found[1], dtype=float)
        except InvalidInput:
            raise
        except Exception as error:
            raise InvalidInput(f"{self.full_name()} raised {type(error).__name__}: {error}") from error
        if vector.ndim != 1 or matrix.shape != (len(vector), robot.nv):
            raise InvalidInput(
                f"{self.full_name()} gives shapes {matrix.shape} and {vector.shape};"
                f" they must be (rows, {robot.nv}) and (rows,) on {robot!r}"
            )
        # Plus infinity means no bound.
        allowed = np.isfinite(vector) | (vector == np.inf) if self.bounds else np.isfinite(vector)
        if not (allowed.all() and np.isfinite(matrix).all()) and np.isfinite(q).all():
            row = int(np.argmin(allowed & np.isfinite(matrix).all(axis=1)))
            raise InvalidInput(
                f"{self.full_name()}: row {row} is not finite, it is to be {vector[row]}; look at its target, gain,"
                " cost and damping"
            )
        return matrix, vector


def least_squares(H: Array, c: Array, what: str) -> Rows:
    r"""Rows whose half squared norm is :math:`\tfrac12 x^T H x + c^T x`, up to a constant.

    Raises
    ------
    InvalidInput
        If there is no least value: H is not positive semidefinite, or c leads along its null space.
    """
    values, vectors = np.linalg.eigh(H)
    small = 1e-12 * max(1.0, float(np.abs(values).max(initial=0.0)))
    along = vectors.T @ c
    if values.min(initial=0.0) < -small or np.abs(along[values <= small]).max(initial=0.0) > small:
        raise InvalidInput(f"{what}: its cost has no least value: it cannot be a level of its own")
    root = np.sqrt(np.maximum(values, 0.0))
    kept = values > small
    target = np.where(kept, -along / np.where(kept, root, 1.0), 0.0)
    return np.where(kept, root, 0.0)[:, None] * vectors.T, target


def damped(J: Array, e: Array, mu: float) -> Rows:
    """Rows J dq = e with ``sqrt(mu) dq = 0`` below them."""
    n = J.shape[1]
    return np.concatenate([J, np.sqrt(mu) * np.eye(n)]), np.concatenate([e, np.zeros(n)])
