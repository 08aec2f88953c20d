r"""Paths: a curve in space and a timing law on it, and paths one after the other.

A path is a curve :math:`r(s)`, with s from 0 to 1, and a timing law :math:`s(u)`, with :math:`u = t / T`:

.. math::

    x = r(s), \qquad \dot x = r' \dot s, \qquad \ddot x = r'' \dot s^2 + r' \ddot s,
    \qquad \dot s = \frac{s'(u)}{T}, \quad \ddot s = \frac{s''(u)}{T^2}

Every path starts at t = 0, and rests at its first point before and at its last point from its duration on.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate, pairwise
from math import cos, pi, sin
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import real_number, truth
from hqp.errors import brief

from ..base.checks import Array, finite, finite_scalar, positive_scalar
from ..base.live import structure
from .timing import Timing, as_timing, cubic
from .trajectories import Target, Trajectory, as_trajectory

#: How far apart the pieces of a chain may be where they meet, against the largest coordinate on its way.
GAP = 1e-9


class Path(Target):
    """Base of a single curve. One of your own needs `curve`.

    Parameters
    ----------
    duration : float
        T [s]
    timing : callable
        Timing law, u -> (s, ds/du, d2s/du2); see :mod:`~tasks.targets.timing`.

    Raises
    ------
    InvalidInput
        If the duration is not positive, or the timing is none.
    """

    duration: float = structure()
    timing: Timing = structure()

    def __init__(self, duration: float, timing: Timing = cubic) -> None:
        what = type(self).__name__.lower()
        self.duration = positive_scalar(duration, f"{what}: duration", unit="s")
        self.timing = as_timing(timing, f"{what}: timing")

    def curve(self, s: float) -> tuple[Array, Array, Array | float]:
        """The position r at the share s of the way, and its derivatives r' and r'' by s, each (rows,)."""
        raise NotImplementedError(f"{type(self).__name__} must define curve(s)")

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        if type(t) is not float:
            t = real_number(t, "t")
        s, rate, bend = self.timing(t / self.duration)
        rate, bend = rate / self.duration, bend / self.duration**2
        r, slope, curvature = self.curve(s)
        return r, rate * slope, (rate * rate) * curvature + bend * slope


class Line(Path):
    """The straight line from `start` to `end`, in `duration` seconds from t = 0 on.

    Parameters
    ----------
    start, end : array, shape (rows,)
        In the unit of the task: [m] or [rad].
    duration : float
        [s]
    timing : callable
        Timing law, u -> (s, ds/du, d2s/du2); the default is that of Eq. 3.21-3.26, :func:`~tasks.targets.timing.cubic`.

    Raises
    ------
    InvalidInput
        If the ends do not match or are not finite, the duration is not positive, or the timing is none.

    Examples
    --------
    >>> from tasks import Line
    >>> position, velocity, acceleration = Line([0.0, 0.0], [1.0, 0.0], duration=2.0)(1.0)
    >>> position, velocity, acceleration
    (array([0.5, 0. ]), array([0.75, 0.  ]), array([0., 0.]))
    """

    start: Array = structure()
    end: Array = structure()

    def __init__(self, start: ArrayLike, end: ArrayLike, duration: float, timing: Timing = cubic) -> None:
        self.start, self.end = np.atleast_1d(finite(start, "line: start")), np.atleast_1d(finite(end, "line: end"))
        if self.start.ndim != 1 or self.start.shape != self.end.shape:
            raise InvalidInput(f"line: start has shape {self.start.shape}, end {self.end.shape}; both must be (rows,)")
        super().__init__(duration, timing)
        self._way = self.end - self.start

    def curve(self, s: float) -> tuple[Array, Array, float]:
        return self.start + s * self._way, self._way, 0.0

    def __repr__(self) -> str:
        return f"Line({self.start.tolist()}, {self.end.tolist()}, {self.duration:g})"


class Circle(Path):
    """A circle in the plane, or an arc of it, in `duration` seconds from t = 0 on.

    Parameters
    ----------
    center : array, shape (2,)
        [m]
    radius : float
        [m]
    duration : float
        [s]
    start : float
        The angle of the start against the x axis, counter-clockwise [rad].
    turn : float
        The angle of the arc [rad]: counter-clockwise if positive, clockwise if negative, once around by default.
    timing : callable
        Timing law, u -> (s, ds/du, d2s/du2).

    Raises
    ------
    InvalidInput
        If the centre is no point in the plane, an angle is not finite or the turn larger than 1e15, the radius or the
        duration is not positive, or the timing is none.

    Examples
    --------
    >>> from tasks import Circle
    >>> position, velocity, _ = Circle([0.5, 0.0], 0.2, duration=2.0)(0.5)
    >>> position.round(3), velocity.round(3)
    (array([0.611, 0.166]), array([-0.588,  0.393]))
    """

    center: Array = structure()
    radius: float = structure()
    start: float = structure()
    turn: float = structure()

    def __init__(
        self,
        center: ArrayLike,
        radius: float,
        duration: float,
        *,
        start: float = 0.0,
        turn: float = 2.0 * pi,
        timing: Timing = cubic,
    ) -> None:
        self.center = finite(center, "circle: center")
        if self.center.shape != (2,):
            raise InvalidInput(f"circle: center has shape {self.center.shape}; it must be (2,): x and y")
        self.radius = positive_scalar(radius, "circle: radius", unit="m")
        self.start = finite_scalar(start, "circle: start")
        self.turn = finite_scalar(turn, "circle: turn")
        super().__init__(duration, timing)

    def curve(self, s: float) -> tuple[Array, Array, Array]:
        turn, angle = self.turn, self.start + s * self.turn
        x, y, bend = self.radius * cos(angle), self.radius * sin(angle), -turn * turn
        return self.center + np.array([x, y]), np.array([-turn * y, turn * x]), np.array([bend * x, bend * y])

    def __repr__(self) -> str:
        arc = f", start={self.start:g}, turn={self.turn:g}"
        return f"Circle({self.center.tolist()}, {self.radius:g}, {self.duration:g}{arc})"


@runtime_checkable
class Piece(Trajectory, Protocol):
    """A segment of a chain: a trajectory from t = 0 to its duration [s]."""

    duration: float


class Chain(Target):
    """Trajectories one after the other: a path of many conditions, split into intervals (section 3.8).

    The end of a piece must be the start of the next. Velocities may differ, as at the corners of lines at constant
    speed: then the velocity jumps.

    Parameters
    ----------
    pieces : sequence of trajectories
        Each with a duration [s] and from t = 0 of its own on; each begins where the one before ends.

    Raises
    ------
    InvalidInput
        If there is no piece, one has no duration or is no trajectory, or two do not meet; names the pieces.

    Examples
    --------
    >>> from tasks import Chain, Line
    >>> path = Chain([Line([0.0, 0.0], [1.0, 0.0], duration=1.0), Line([1.0, 0.0], [1.0, 1.0], duration=1.0)])
    >>> path.duration, path(1.5)[0]
    (2.0, array([1. , 0.5]))
    """

    pieces: tuple[Piece, ...] = structure()
    duration: float = structure()

    def __init__(self, pieces: Sequence[Piece]) -> None:
        if not isinstance(pieces, (list, tuple)) or not pieces:
            raise InvalidInput(f"chain: pieces = {brief(pieces)} must be a list of trajectories, at least one")
        self.pieces = tuple(pieces)
        self._called = [_trajectory(piece, f"chain: piece {k}") for k, piece in enumerate(pieces)]
        places = [_places(*own, f"chain: piece {k}") for k, own in enumerate(zip(self._called, pieces, strict=True))]
        size = max(float(np.abs(place).max(initial=0.0)) for place in places)
        for k, ((*_, end), (begin, *_)) in enumerate(pairwise(places)):
            if end.shape != begin.shape or not np.abs(end - begin).max(initial=0.0) <= GAP * size:
                raise InvalidInput(
                    f"chain: piece {k}, {self.pieces[k]!r}, ends at {end.tolist()},"
                    f" but piece {k + 1}, {self.pieces[k + 1]!r}, begins at {begin.tolist()}; they must meet"
                )
        *self._starts, self.duration = accumulate((float(piece.duration) for piece in pieces), initial=0.0)
        end = places[-1][-1]
        self._end = end, np.zeros_like(end), np.zeros_like(end)

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        if type(t) is not float:
            t = real_number(t, "t")
        if t >= self.duration:  # said here: the sum of the durations is rounded, and the last piece could fall short
            return self._end
        k = bisect_right(self._starts, t, lo=1) - 1  # before t = 0 the first; at NaN the last, which gives NaN
        return self._called[k](t - self._starts[k])

    def __repr__(self) -> str:
        return f"Chain({list(self.pieces)!r})"


def _trajectory(piece: Any, what: str) -> Trajectory:
    if not isinstance(piece, Piece):
        raise InvalidInput(f"{what}, {brief(piece)}, has no duration; it must be a trajectory with a duration [s]")
    return as_trajectory(piece, None, what)


def _places(trajectory: Trajectory, piece: Piece, what: str) -> Array:
    """Where a piece begins, some places on its way, and where it ends, shape (5, rows)."""
    duration = positive_scalar(piece.duration, f"{what}: duration", unit="s")
    return finite([trajectory(share * duration)[0] for share in (0.0, 0.25, 0.5, 0.75, 1.0)], f"{what}: places")


class Polygon(Chain):
    """Straight from corner to corner, at rest at each: every side a line of its own, all in equal times.

    Parameters
    ----------
    corners : array, shape (n, rows)
        In the unit of the task: [m] or [rad]; at least two, one after the other different.
    duration : float
        Of the whole [s].
    timing : callable
        Timing law of each side, u -> (s, ds/du, d2s/du2).
    closed : bool
        Whether the last side leads back to the first corner, as in a triangle of three corners.

    Raises
    ------
    InvalidInput
        If there are no two corners, two that follow each other are the same or one is not finite, the duration is
        not positive, or the timing is none.

    Examples
    --------
    >>> from tasks import Polygon
    >>> path = Polygon([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], duration=3.0)
    >>> path(1.0)[0], path(3.0)[0]
    (array([1., 0.]), array([0., 0.]))
    """

    corners: Array = structure()
    closed: bool = structure()

    def __init__(self, corners: ArrayLike, duration: float, timing: Timing = cubic, *, closed: bool = True) -> None:
        self.corners = finite(corners, "polygon: corners")
        if self.corners.ndim != 2 or len(self.corners) < 2:
            raise InvalidInput(f"polygon: corners has shape {self.corners.shape}; it must be (n, rows) with n >= 2")
        self.closed = truth(closed, "polygon: closed")
        total = positive_scalar(duration, "polygon: duration", unit="s")
        as_timing(timing, "polygon: timing")
        n = len(self.corners)
        sides = [(k, (k + 1) % n) for k in range(n if self.closed else n - 1)]
        for a, b in sides:
            if np.array_equal(self.corners[a], self.corners[b]):
                hint = "; a closed polygon returns to corner 0 by itself" if b == 0 else ""
                raise InvalidInput(
                    f"polygon: corners {a} and {b} are both {self.corners[a].tolist()}; they must differ{hint}"
                )
        super().__init__([Line(self.corners[a], self.corners[b], total / len(sides), timing) for a, b in sides])
        self.duration = total  # which the sum of its parts may miss by round-off

    def __repr__(self) -> str:
        return f"Polygon({self.corners.tolist()}, {self.duration:g}{'' if self.closed else ', closed=False'})"
