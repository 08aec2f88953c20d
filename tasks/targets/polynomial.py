r"""A polynomial trajectory through conditions at its ends and at times between.

.. math::

    q(t) = a_0 + a_1 t + a_2 t^2 + \dots + a_n t^n \qquad \text{(Eq. 3.19 for n = 3)}

satisfies n + 1 conditions (Eq. 3.20): position and velocity at both ends need a cubic, accelerations too a quintic,
jerks too degree 7, and each condition at a time between one degree more.

It is kept in Newton's form, in the share of time :math:`u = t / T`: with every time :math:`u_i` repeated once for
each condition at it, the :math:`c_i` are the divided differences, of repeated times the derivatives:

.. math::

    q = \sum_{i=0}^{n} c_i \prod_{j<i} (u - u_j), \qquad
    c_i = q[u_0 \dots u_i], \quad
    q[u_i \dots u_k] = \begin{cases}
        q^{(k-i)}(u_i) / (k-i)! & u_i = u_k \\
        \dfrac{q[u_{i+1} \dots u_k] - q[u_i \dots u_{k-1}]}{u_k - u_i} & \text{otherwise}
    \end{cases}

The ends come first, then the times between. No system is solved, and at an end only the terms of the conditions at
both ends are not zero: they are met to round-off at degrees where the powers of t would have lost them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type, real_number

from ..base.checks import Array, finite, finite_scalar, positive_scalar
from ..base.live import structure
from .trajectories import Target

#: How far from a condition at a time between the ends the motion may be, against the largest of all conditions, each
#: as the part of a Taylor series over the duration that it stands for.
MISS = 1e-9


class Polynomial(Target):
    """The polynomial of least degree through conditions at t = 0, at `duration`, and at times between.

    From t = 0 to `duration`, both included, it is the polynomial. Outside it holds its first or last position at
    rest: where a velocity at that end is not zero, the velocity jumps there.

    A cubic from rest to rest, and the same through a place on the way, which takes degree 4:

    >>> Polynomial([1.0, 0.0], [3.0, 0.0], 2.0).coefficients.ravel()
    array([ 1. ,  0. ,  1.5, -0.5])
    >>> Polynomial([1.0, 0.0], [3.0, 0.0], 2.0, via={1.0: 2.5}).degree
    4

    Parameters
    ----------
    start, end : array, shape (k, rows) and (m, rows), or (k,) and (m,) for one row
        Position, velocity, acceleration, ... at t = 0 and at `duration`, in the unit of the task [m] or [rad], per s,
        per s^2, ...: any number of them, at least the position. The degree is k + m - 1.
    duration : float
        T [s]
    via : dict from times to arrays, optional
        The same at times [s] between the ends; each condition raises the degree by one.

    Attributes
    ----------
    coefficients : array, shape (degree + 1, rows)
        a_0, a_1, ... of Eq. 3.19: the position is ``sum(a_i t^i)``, in the unit of the task per s^i.

    Raises
    ------
    InvalidInput
        If conditions are not finite or do not fit together, the duration is not positive, a time of `via` is not
        between the ends or too near to another, or there are too many conditions for floats to meet.
    """

    start: Array = structure()
    end: Array = structure()
    duration: float = structure()
    via: Mapping[float, Array] = structure()
    coefficients: Array = structure()

    def __init__(
        self, start: ArrayLike, end: ArrayLike, duration: float, *, via: dict[float, ArrayLike] | None = None
    ) -> None:
        self.start, self.end = _conditions(start, "polynomial: start"), _conditions(end, "polynomial: end")
        self.duration = T = positive_scalar(duration, "polynomial: duration", unit="s")
        self.via = _between({} if via is None else via, T)
        with np.errstate(all="ignore"):  # what leaves the floats is refused below
            self._fit({0.0: self.start, T: self.end, **self.via})
        self.coefficients.flags.writeable = False
        still = np.zeros_like(self.start[0])
        self._before, self._after = (self.start[0], still, still), (self.end[0], still, still)

    def _fit(self, given: dict[float, Array]) -> None:
        T = self.duration
        for t, conditions in given.items():
            if conditions.shape[1] != self.start.shape[1]:
                raise InvalidInput(
                    f"polynomial: the conditions at t = {t:g} s have {conditions.shape[1]} rows,"
                    f" at 0 s {self.start.shape[1]}; they must have the same, (conditions, rows)"
                )
        taylor = {t / T: _taylor(conditions, T) for t, conditions in given.items()}
        if len(taylor) < len(given):
            raise InvalidInput(f"polynomial: times {sorted(given)} s must be further apart")
        self._times, self._newton = _newton(taylor)
        self.coefficients = _powers(self._times, self._newton) / T ** np.arange(float(len(self._times)))[:, None]
        if not (np.isfinite(self.coefficients).all() and np.isfinite(self._newton).all()):
            raise InvalidInput(
                f"polynomial: its coefficients leave the range of floats; of degree {self.degree} over {T:g} s it must"
                " have smaller conditions, or fewer, or times further apart"
            )
        size = max(np.abs(terms).max() for terms in taylor.values())
        for t, conditions in self.via.items():
            met = np.array(self(t))[: len(conditions)]
            if not np.abs(_taylor(met - conditions[:3], T)).max() <= MISS * size:
                raise InvalidInput(
                    f"polynomial: of degree {self.degree} it is too steep to meet the conditions at t = {t:g} s; it"
                    " must have fewer of them, or times further apart, or be split into a chain"
                )

    @property
    def degree(self) -> int:
        """One less than there are conditions (Eq. 3.20)."""
        return len(self._newton) - 1

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        if type(t) is not float:
            t = real_number(t, "t")
        if t < 0.0:
            return self._before
        if t > self.duration:
            return self._after
        u, per_second = float(t) / self.duration, 1.0 / self.duration
        # The products of Newton's form and their derivatives by t, from each to the next by the product rule.
        value, rate, bend = 1.0, 0.0, 0.0
        values, rates, bends = [value], [rate], [bend]
        for time in self._times[:-1]:
            step = u - time
            value, rate, bend = value * step, rate * step + value * per_second, bend * step + 2.0 * rate * per_second
            values.append(value)
            rates.append(rate)
            bends.append(bend)
        position, velocity, acceleration = np.array([values, rates, bends]) @ self._newton
        return position, velocity, acceleration

    def __repr__(self) -> str:
        shown = {t: conditions.tolist() for t, conditions in self.via.items()}
        via = f", via={shown}" if shown else ""
        return f"Polynomial({self.start.tolist()}, {self.end.tolist()}, {self.duration:g}{via})"


def _conditions(value: ArrayLike, what: str) -> Array:
    """Position, velocity, ... at one time, shape (conditions, rows)."""
    array = np.atleast_1d(finite(value, what))
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or array.size == 0:
        raise InvalidInput(
            f"{what} has shape {np.shape(value)}; it must be (conditions, rows), or (conditions,) for one row,"
            " at least the position"
        )
    return array


def _between(via: dict[float, ArrayLike], T: float) -> dict[float, Array]:
    """The conditions at times between 0 and T [s], the earliest first."""
    checked = {}
    for time, conditions in of_type(via, dict, "polynomial: via").items():
        t = finite_scalar(time, "polynomial: time in via")
        if not 0.0 < t < T:
            raise InvalidInput(f"polynomial: time in via = {t} s must be between 0 and the duration, {T} s")
        checked[t] = _conditions(conditions, f"polynomial: via[{t}]")
    return dict(sorted(checked.items()))


def _taylor(conditions: Array, T: float) -> Array:
    """The Taylor coefficients of the polynomial in u: conditions of order d times T^d / d!."""
    return conditions * np.cumprod([1.0, *(T / np.arange(1.0, len(conditions)))])[:, None]


def _newton(taylor: dict[float, Array]) -> tuple[list[float], Array]:
    """The times u_i, each repeated once a condition, and the c_i, shape (degree + 1, rows)."""
    times = [u for u in taylor for _ in taylor[u]]
    differences = [taylor[u][0] for u in times]
    newton = [differences[0]]
    for order in range(1, len(times)):
        differences = [
            taylor[first][order] if first == last else (differences[i + 1] - differences[i]) / (last - first)
            for i, (first, last) in enumerate(zip(times, times[order:], strict=False))
        ]
        newton.append(differences[0])
    return times, np.array(newton)


def _powers(times: list[float], newton: Array) -> Array:
    """From Newton's form to the coefficients of the powers of u, the lowest first."""
    powers = np.zeros_like(newton)
    for time, c in zip(reversed(times), newton[::-1], strict=True):
        powers = np.concatenate([c[None], powers[:-1]]) - time * powers
    return powers
