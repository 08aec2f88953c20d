"""A loop at a constant rate: tick k begins k/rate after the first, however long earlier ticks took.

Deadlines are counted from the first tick, not from the previous one, so that delays do not add up. If a tick is not
done when the next one is due, the next begins at once. Ticks whose whole period has passed by then are left out; `dt`
of the next tick includes them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from math import ceil, floor, inf
from typing import NamedTuple

from ..base.checks import positive_scalar, scalar
from ..base.live import Live, structure
from ..base.telling import LOG

#: The longest single sleep [s]; clocks do not accept arbitrarily long ones.
LONGEST = 1e6
#: Tolerance for round-off in the number of ticks.
ROUND_OFF = 1e-9


class Beat(NamedTuple):
    """One tick of a loop.

    Attributes
    ----------
    k : int
        Its number; it increases by more than 1 if ticks were left out.
    t : float
        When it is due, counted from the first tick [s].
    dt : float
        Time since the previous tick [s]: 1/rate, or a multiple of it.
    """

    k: int
    t: float
    dt: float


class RateLoop(Live):
    """A loop at a constant rate, which counts late ticks; made by :func:`loop`.

    Attributes
    ----------
    rate : float
        [Hz].
    duration : float
        [s]; infinite if the loop runs until it is left.
    ticks : int
        Number of ticks begun.
    overruns : int
        Number of ticks that were not done when the next was due.
    worst : float
        The largest delay of such a tick [s].
    left_out : int
        Number of ticks that never began because an earlier one took too long.
    """

    rate: float = structure()
    duration: float = structure()

    def __init__(
        self,
        rate: float,
        duration: float = inf,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.rate = positive_scalar(rate, "rate of a loop", unit="Hz")
        endless = scalar(duration, "duration of a loop") == inf
        self.duration = inf if endless else positive_scalar(duration, "duration of a loop", unit="s")
        self._clock, self._sleep = clock, sleep
        self.ticks = self.overruns = self.left_out = 0
        self.worst = 0.0

    def __iter__(self) -> Iterator[Beat]:
        """Start the loop from tick 0, with all counts at zero."""
        self.ticks = self.overruns = self.left_out = 0
        self.worst = 0.0
        last = inf if self.duration == inf else ceil(self.duration * self.rate - ROUND_OFF)
        start, k, before = self._clock(), 0, -1
        try:
            while k < last:
                self.ticks += 1
                yield Beat(k, k / self.rate, (k - before) / self.rate)
                before, k = k, self._next(k, start)
        finally:
            if self.overruns:
                LOG.warning(str(self))

    def _next(self, k: int, start: float) -> int:
        """Wait for the next tick that is not over yet, and return its number."""
        due = start + (k + 1) / self.rate
        late = self._clock() - due
        if late > 0.0:
            missed = floor(late * self.rate)
            self.overruns, self.worst = self.overruns + 1, max(self.worst, late)
            self.left_out += missed
            return k + 1 + missed
        while late < -LONGEST:
            self._sleep(LONGEST)
            late = self._clock() - due
        self._sleep(max(-late, 0.0))
        return k + 1

    def __str__(self) -> str:
        told = f"loop at {self.rate:g} Hz: {self.overruns} of {self.ticks} ticks took too long"
        if not self.overruns:
            return told
        skipped = f"; {self.left_out} were left out" if self.left_out else ""
        return f"{told}, the latest by {1e3 * self.worst:.3g} ms{skipped}"


def loop(rate: float, duration: float = inf) -> RateLoop:
    """A loop at a constant rate, in real time.

    ``for tick in loop(rate=200, duration=5.0): step = controller(q, v, tick.t)``. Ticks that take too long are counted
    (`overruns`, `worst`, `left_out`) and reported by the logger "hqp" when the loop ends.

    Parameters
    ----------
    rate : float
        [Hz].
    duration : float
        [s]; default: until the loop is left.

    Returns
    -------
    RateLoop
        It yields one :class:`Beat` per tick: its number `k`, its time `t` [s], and `dt` [s].

    Raises
    ------
    InvalidInput
        If the rate or the duration is not positive.

    Examples
    --------
    >>> from tasks import loop
    >>> all(tick.dt >= 0.002 for tick in loop(rate=500, duration=0.01))
    True
    """
    return RateLoop(rate, duration)
