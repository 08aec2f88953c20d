r"""Timing laws: the share of a path covered by a time, from rest to rest.

A timing law maps the elapsed share of a move :math:`u = t / T` to the share of the way :math:`s(u)` that is done,
and its derivatives by u:

.. math::

    \text{cubic}\quad & s = 3u^2 - 2u^3 && \text{at rest at both ends (Eq. 3.21-3.26)} \\
    \text{quintic}\quad & s = 10u^3 - 15u^4 + 6u^5 && \text{and without acceleration there (Eq. 3.20)} \\
    \text{harmonic}\quad & s = \tfrac12 (1 - \cos \pi u) && \text{at rest at both ends (section 3.8)} \\
    \text{cycloid}\quad & s = u - \tfrac{1}{2\pi} \sin 2 \pi u && \text{and without acceleration there (section 3.8)}
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from math import cos, pi, sin

import numpy as np

from hqp import InvalidInput
from hqp.checks import real_number

from ..base.checks import function, numbers

#: u -> (s, ds/du, d2s/du2): (0, 0, 0) before u = 0, (1, 0, 0) from u = 1 on, and NaN at NaN
Timing = Callable[[float], tuple[float, float, float]]

#: Tolerance on the rest of a law before and after, which it may compute with round-off.
ROUND_OFF = 1e-12


def _at_rest_outside(law: Timing) -> Timing:
    """`law` where 0 <= u < 1, at rest before and after. NaN is neither, and left to the law."""

    @wraps(law)
    def timing(u: float) -> tuple[float, float, float]:
        if type(u) is not float:
            u = real_number(u, f"{law.__name__}: u")
        if u < 0.0:
            return 0.0, 0.0, 0.0
        if u >= 1.0:
            return 1.0, 0.0, 0.0
        return law(u)

    return timing


@_at_rest_outside
def cubic(u: float) -> tuple[float, float, float]:
    """``s = 3u^2 - 2u^3``: the least degree that rests at both ends. Its acceleration jumps there.

    Parameters
    ----------
    u : float
        Share of the duration that is over; at rest below 0 and above 1.

    Returns
    -------
    tuple of float
        s, and its first and second derivative by u.
    """
    return u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u), 6.0 - 12.0 * u


@_at_rest_outside
def quintic(u: float) -> tuple[float, float, float]:
    """``s = 10u^3 - 15u^4 + 6u^5``: no acceleration at the ends either, so that only the jerk jumps.

    Parameters
    ----------
    u : float
        Share of the duration that is over; at rest below 0 and above 1.

    Returns
    -------
    tuple of float
        s, and its first and second derivative by u.

    Examples
    --------
    >>> from tasks import quintic
    >>> quintic(0.5)
    (0.5, 1.875, 0.0)
    """
    rest = 1.0 - u
    return u * u * u * (10.0 - u * (15.0 - 6.0 * u)), 30.0 * (u * rest) ** 2, 60.0 * u * rest * (1.0 - 2.0 * u)


@_at_rest_outside
def harmonic(u: float) -> tuple[float, float, float]:
    """``s = (1 - cos(pi u)) / 2``: half a period of a cosine. Its acceleration jumps at the ends.

    Parameters
    ----------
    u : float
        Share of the duration that is over; at rest below 0 and above 1.

    Returns
    -------
    tuple of float
        s, and its first and second derivative by u.
    """
    # sin^2 of half the angle: the same, without the difference of two near numbers at small u.
    return sin(0.5 * pi * u) ** 2, 0.5 * pi * sin(pi * u), 0.5 * pi * pi * cos(pi * u)


@_at_rest_outside
def cycloid(u: float) -> tuple[float, float, float]:
    """``s = u - sin(2 pi u) / (2 pi)``: no acceleration at the ends either, so that only the jerk jumps.

    Parameters
    ----------
    u : float
        Share of the duration that is over; at rest below 0 and above 1.

    Returns
    -------
    tuple of float
        s, and its first and second derivative by u.
    """
    return u - sin(2.0 * pi * u) / (2.0 * pi), 2.0 * sin(pi * u) ** 2, 2.0 * pi * sin(2.0 * pi * u)


def as_timing(value: Timing, what: str) -> Timing:
    """`value`, which must be a timing law, at rest before u = 0 and from u = 1 on; one of a user's own is watched.

    Raises
    ------
    InvalidInput
        If it is no function, fails, or does not rest at the start at u = -1 and at the end at u = 2.
    """
    law = function(value, what)
    for u, rest in (-1.0, (0.0, 0.0, 0.0)), (2.0, (1.0, 0.0, 0.0)):
        try:
            sample = law(u)
        except Exception as error:
            raise InvalidInput(f"{what}({u}) raised {type(error).__name__}: {error}") from error
        given = numbers(sample, f"{what}({u})")
        if given.shape != (3,) or not np.abs(given - rest).max() <= ROUND_OFF:
            raise InvalidInput(f"{what}({u}) = {given.tolist()} must be (s, ds/du, d2s/du2), there at rest: {rest}")
    return law if law in KNOWN or isinstance(law, WatchedTiming) else WatchedTiming(law, what)


class WatchedTiming:
    """A user's timing law: at every u in order it must give three finite numbers.

    Parameters
    ----------
    law : callable
    what : str
        Whose law it is, for messages.
    """

    def __init__(self, law: Timing, what: str) -> None:
        self.law, self._what = law, what

    def __call__(self, u: float) -> tuple[float, float, float]:
        given = numbers(self.law(u), f"{self._what}({u})")
        if given.shape != (3,) or not (np.isfinite(given).all() or u != u):
            raise InvalidInput(f"{self._what}({u}) = {given.tolist()}; it must be three finite numbers")
        s, rate, change = given.tolist()
        return s, rate, change

    def __repr__(self) -> str:
        return repr(self.law)


#: The laws of this module, which need no watching.
KNOWN = (cubic, quintic, harmonic, cycloid)
