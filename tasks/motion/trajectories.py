r"""Where to be when: targets that stand still or move, with the velocity and acceleration they need.

A timing law maps the elapsed share of a move :math:`u = t / T` to the share of the path
:math:`s(u)` and its derivatives by u; a path turns s into places. The thesis's law is the cubic
from rest to rest of Eq. 3.19-3.26, :math:`s = 3u^2 - 2u^3`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from .._checks import Array, finite, function, numbers, positive_scalar

#: u -> (s, ds/du, d2s/du2)
Timing = Callable[[float], tuple[float, float, float]]


@runtime_checkable
class Trajectory(Protocol):
    """A function of time: ``trajectory(t)`` gives position, velocity and acceleration, each (rows,)."""

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]: ...


def cubic(u: float) -> tuple[float, float, float]:
    """The cubic from rest to rest, ``s = 3u^2 - 2u^3``; at rest before 0 and from 1 on; NaN at NaN."""
    if u < 0.0:
        return 0.0, 0.0, 0.0
    if u >= 1.0:
        return 1.0, 0.0, 0.0
    return u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u), 6.0 - 12.0 * u


class Fixed:
    """A target that stands still.

    Parameters
    ----------
    target : array, shape (rows,)
        In the unit of the task: [m] or [rad].
    """

    def __init__(self, target: ArrayLike) -> None:
        self.target = np.atleast_1d(finite(target, "target"))
        if self.target.ndim != 1:
            raise InvalidInput(f"target has shape {self.target.shape}; it must have one axis")
        self._sample = (self.target, np.zeros(len(self.target)), np.zeros(len(self.target)))

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        return self._sample

    def __repr__(self) -> str:
        return str(self.target.tolist())


class Line:
    """The straight line from `start` to `end`, in `duration` seconds from t = 0 on.

    Parameters
    ----------
    start, end : array, shape (rows,)
        In the unit of the task: [m] or [rad].
    duration : float
        [s]
    timing : callable
        Timing law, u -> (s, ds/du, d2s/du2); see :func:`cubic`.

    Raises
    ------
    InvalidInput
        If the ends do not match or are not finite, or the duration is not positive.
    """

    def __init__(self, start: ArrayLike, end: ArrayLike, duration: float, timing: Timing = cubic) -> None:
        self.start, self.end = np.atleast_1d(finite(start, "line: start")), np.atleast_1d(finite(end, "line: end"))
        if self.start.ndim != 1 or self.start.shape != self.end.shape:
            raise InvalidInput(f"line: start has shape {self.start.shape}, end {self.end.shape}; both must be (rows,)")
        self.duration = positive_scalar(duration, "line: duration", unit="s")
        self.timing = function(timing, "line: timing")
        self._way = self.end - self.start

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        s, rate, bend = self.timing(t / self.duration)
        way = self._way
        return self.start + s * way, (rate / self.duration) * way, (bend / self.duration**2) * way

    def __repr__(self) -> str:
        return f"Line({self.start.tolist()}, {self.end.tolist()}, {self.duration:g})"


def as_trajectory(target: ArrayLike | Trajectory, rows: int | None, what: str) -> Trajectory:
    """`target` as a trajectory of so many rows (None: any number): numbers stand still, functions of time move.

    Raises
    ------
    InvalidInput
        If a number is not finite, or the target (at t = 0) does not give what a trajectory must.
    """
    if not callable(target):
        trajectory: Trajectory = Fixed(finite(target, f"{what}: target"))
    else:
        trajectory = target
    try:
        sample = tuple(trajectory(0.0))
    except Exception as error:
        raise InvalidInput(f"{what}: target(0.0) raised {type(error).__name__}: {error}") from error
    shapes = [numbers(part, f"{what}: target(0.0)").shape for part in sample]
    size = rows if rows is not None else int(np.prod(shapes[0])) if shapes else 1
    if shapes != [(size,)] * 3:
        if isinstance(trajectory, Fixed):
            raise InvalidInput(f"{what}: target has shape {shapes[0]}; it must be ({size},)")
        raise InvalidInput(
            f"{what}: target(0.0) gives shapes {shapes};"
            f" it must give position, velocity and acceleration, each ({size},)"
        )
    return trajectory
