r"""Steps in place, by a linear inverted pendulum: where the feet press decides how the mass goes to and fro.

With the mass at the height h above the ground, and the pressure at p, :math:`\ddot c = \omega^2 (c - p)` with
:math:`\omega^2 = g / h`. Of all motions under a given p(t), one stays near it for all time, the mean of two:

.. math:: c = \tfrac12 (f + b), \quad \dot f = \omega (p - f), \quad \dot b = \omega (b - p), \quad
   \dot c = \tfrac12 \omega (b - f),

f which follows p, run forwards from the beginning, and b which expects it, run backwards from the end.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tasks import Switch, quintic

GRAVITY = 9.81  # [m/s^2]
State = tuple[np.ndarray, np.ndarray, np.ndarray]  # position, velocity, acceleration


def followed(p: np.ndarray, share: float) -> np.ndarray:
    """What follows p, a share of the way every tick."""
    out = np.empty_like(p)
    now = p[0]
    for k, there in enumerate(p):
        out[k] = now = now + share * (there - now)
    return out


class Steps:
    """A foot is released, raised and made, then the other; every `phase` [s] one of the two switches.

    Parameters
    ----------
    feet : dict
        The y at which each presses [m], in the order in which they are raised.
    mass : array, shape (3,)
        Where the centre of mass begins [m].
    floor : float
        Height of the ground [m].
    phase, start, end : float
        Between switches; of the first; of the last [s].
    height : float
        By which feet are raised [m].
    """

    def __init__(
        self,
        feet: dict[str, float],
        mass: np.ndarray,
        floor: float,
        phase: float,
        start: float,
        end: float,
        height: float,
    ) -> None:
        self.feet, self.mass, self.phase, self.height = list(feet), mass, phase, height
        self.starts = start + 2.0 * phase * np.arange(round((end - start - phase) / (2.0 * phase)) + 1)
        self.t = np.arange(0.0, end + 5.0, 1e-3)
        self.p = np.full(len(self.t), mass[1])
        stays = [feet[self.feet[(k + 1) % 2]] for k in range(len(self.starts))]
        over = [mass[1], *stays, mass[1]]
        for k, begin in enumerate([*self.starts, self.starts[-1] + 2.0 * phase]):  # over the foot that stays by then
            share = np.array([quintic(float(s))[0] for s in (self.t - begin) / phase + 1.0])
            self.p += share * (over[k + 1] - over[k])
        self.omega = np.sqrt(GRAVITY / (mass[2] - floor))
        share = -np.expm1(-self.omega * 1e-3)
        f, b = followed(self.p, share), followed(self.p[::-1], share)[::-1]
        self.c, self.rate = 0.5 * (f + b), 0.5 * self.omega * (b - f)

    def center_of_mass(self, t: float) -> State:
        """Where it is to be, at the height at which it begins."""
        y, rate, p = (float(np.interp(t, self.t, x)) for x in (self.c, self.rate, self.p))
        side = np.array([0.0, 1.0, 0.0])
        return self.mass + side * (y - self.mass[1]), side * rate, side * self.omega**2 * (y - p)

    def foot(self, name: str, place: np.ndarray, delay: float) -> Callable[[float], State]:
        """Where a foot is to be: raised and put down between `delay` [s] after it is released, and when it is made."""
        half, up = 0.5 * (self.phase - delay), np.array([0.0, 0.0, self.height])

        def at(t: float) -> State:
            k = int(np.searchsorted(self.starts, t, "right")) - 1
            s = (t - self.starts[k] - delay) / half if k >= 0 and self.feet[k % 2] == name else 0.0
            share, rate, change = quintic(min(max(s, 0.0), 2.0) if s < 1.0 else 2.0 - min(s, 2.0))
            rate = -rate if s > 1.0 else rate
            return place + share * up, rate / half * up, change / half**2 * up

        return at

    def switches(self, ramp: float) -> list[Switch]:
        """Those of the contacts, which bear the names of the feet."""
        off = [Switch(t, self.feet[k % 2], False, ramp) for k, t in enumerate(self.starts)]
        return off + [Switch(t + self.phase, self.feet[k % 2], True, ramp) for k, t in enumerate(self.starts)]
