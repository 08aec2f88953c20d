"""Whether joints can still stop, tick by tick: what the formulas of the position limit are measured by."""

from __future__ import annotations

import numpy as np


def path_of_stop(v, a_max, dt, order):
    """How far joints at v >= 0 still go while they brake in whole ticks."""
    gone = np.zeros_like(v)
    while v.any():
        slower = np.maximum(v - a_max * dt, 0.0)
        gone += dt * (slower if order == "velocity" else 0.5 * (v + slower))
        v = slower
    return gone


def slow_down(q, v, lower, upper, a_max, dt, order):
    """Velocities, reduced until each joint can stop before the limit ahead, or comes from beyond it."""
    v = v.copy()
    while True:
        path = path_of_stop(np.abs(v), a_max, dt, order)
        ahead = np.where(v > 0.0, upper - q, q - lower)
        late = (ahead >= 0.0) & (ahead < path)
        if not late.any():
            return v
        v[late] *= np.where(np.abs(v[late]) < 1e-9, 0.0, 0.7)
