"""Metrics of a motion: errors, jerk, spectrum, frozen ticks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import periodogram

from hqp.arrays import Array

#: What counts as fast in a motion that a hand leads [Hz].
FAST = 3.0
#: A joint that is slower stands still [rad/s].
STILL = 1e-4
#: Round-off: by less no limit is passed, [rad] and [rad/s].
ROUND_OFF = 1e-9


def rms(values: Array) -> float:
    """Root of the mean square of all numbers."""
    return float(np.sqrt(np.mean(np.square(values))))


def jerk(v: Array, dt: float) -> float:
    """Root mean square, over ticks and joints, of the third derivative of joint positions [rad/s^3].

    By second differences of the velocities v, shape (ticks, nv), which tick by tick are first ones of the positions.
    """
    return rms(np.diff(v, n=2, axis=0)) / dt**2


def fast_share(v: Array, dt: float, above: float = FAST) -> float:
    """The share of the spectral power of signals, shape (ticks, any), that is above a frequency [Hz].

    The power of all columns is added up. A Hann window keeps what is slow from leaking; the mean is not taken out. Of
    signals that are zero it is 0.
    """
    frequencies, power = periodogram(v, 1.0 / dt, window="hann", detrend=False, axis=0)
    total = float(power.sum())
    return float(power[frequencies > above].sum()) / total if total > 0.0 else 0.0


def longest(mask: Array) -> int:
    """Length of the longest sequence of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def frozen(v: Array, excess: Array, threshold: float) -> Array:
    """Ticks in which no joint moves, although the hand is further from its target than it had to be.

    Parameters
    ----------
    v : array, shape (ticks, nv)
    excess : array, shape (ticks,)
        How far the hand is from its target, less what no configuration avoids [m].
    threshold : float
        [m].

    Returns
    -------
    array of bool, shape (ticks,)
    """
    return (np.abs(v).max(axis=1) < STILL) & (excess > threshold)


@dataclass(frozen=True)
class Ranges:
    """How a motion kept the ranges of the joints; those that start outside are let come back first.

    Attributes
    ----------
    ticks : int
        After which a joint is outside that has been inside before.
    worst : float
        By how much, at most [rad].
    back : int or None
        After how many ticks all have been inside; None if never.
    further : float
        By how much a joint that has not been inside yet went further out than it was at the start, at most [rad].
    """

    ticks: int
    worst: float
    back: int | None
    further: float


def ranges(q: Array, low: Array, high: Array) -> Ranges:
    """The same, of joint positions q, shape (ticks + 1, nv), that begin with the start."""
    out = np.maximum(np.maximum(low - q, q - high), 0.0)
    back = np.logical_or.accumulate(out <= ROUND_OFF, axis=0)
    left = np.where(back, out, 0.0)
    coming = np.where(back, 0.0, out - out[0])
    all_back = np.flatnonzero(back.all(axis=1))
    return Ranges(
        int((left > ROUND_OFF).any(axis=1).sum()),
        float(left.max()),
        int(all_back[0]) if len(all_back) else None,
        float(np.maximum(coming, 0.0).max()),
    )


def overspeed(v: Array, fastest: Array) -> tuple[int, float]:
    """Ticks in which a joint is too fast, and by how much at most [rad/s]; v has the shape (ticks, nv)."""
    over = np.maximum(np.abs(v) - fastest, 0.0)
    return int((over > ROUND_OFF).any(axis=1).sum()), float(over.max())
