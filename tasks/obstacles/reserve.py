r"""How much of a distance one tick can take beyond the linear row: a bound that always holds.

The row says :math:`n^T J x` of the witness p, the point of the link that is nearest. Within a tick of dt, in which no
joint turns faster than w, the distance D of the cores obeys

.. math::

    D^+ \ge D + n^T J x\, dt - \rho, \qquad
    \rho = \tfrac12 b\, dt^2 + s\, \delta + D - \min_k \left( n^T g_k \cos\delta
        - \lVert g_k - n n^T g_k \rVert \sin\delta \right)

with s the way of p and of the obstacle, :math:`\delta = \sum_i w_i\, dt` the turn of the link by its revolute joints i,
:math:`g_k = p - x_k` from the points of the obstacle's core, and b the largest acceleration of p at constant joint
velocities,

.. math:: b = \sum_{i,j} w_i w_j c_{\max(i, j)}, \qquad c_j = \lVert J_j \rVert + C (e^\delta - 1).

Why: the link is convex, so that all of it lies beyond the plane through p with normal n, and turns with that plane
until its normal is m, by no more than delta. The obstacle is on the other side of a plane with normal m, at least
:math:`m^T(p^+ - x_k)` away for the nearest k. The first term is Taylor's remainder: two joints give p the second
derivative :math:`z_i \times J_j`, j the one nearer to p, and no column of J grows faster than :math:`e^\delta`,
C being the longest.
"""

from __future__ import annotations

import numpy as np

from .._checks import Array
from ..part import Tick
from .links import Placed


def fastest(tick: Tick) -> Array:
    """How fast each joint may turn in this tick, by the limits of the stack, shape (nv,) [rad/s]; infinite without."""
    v, envelope, w = np.abs(tick.state.v), tick.envelope, np.full(len(tick.state.v), np.inf)
    if envelope is not None and envelope.has_velocity:
        w = envelope.velocity
    if envelope is not None and envelope.has_acceleration:
        assert tick.dt is not None  # checked before the first tick
        step = envelope.acceleration * tick.dt
        w = np.maximum(np.minimum(w, v + step), v - step)  # a joint that is too fast can only slow down so much
    return w


def reserve(
    place: Placed, normal: Array, gaps: Array, w: Array, dt: float, *, shift: float = 0.0, base: int = 0
) -> float:
    """rho of the module's docstring [m]; infinite where the link could turn by more than a quarter.

    Parameters
    ----------
    place : Placed
        The witness.
    normal : array, shape (3,)
        n, from the obstacle to the link.
    gaps : array, shape (k, 3)
        g [m].
    w : array, shape (nv,)
        How fast a joint may turn [rad/s].
    dt : float
        [s].
    shift : float
        The way of the obstacle within the tick [m].
    base : int
        How many velocities are those of a floating base, which are of no order.
    """
    c, spin = np.linalg.norm(place.jacobian, axis=0), np.linalg.norm(place.frame.angular, axis=0)
    moves = (c > 0.0) | (spin > 0.0)
    c, turns, w = c[moves], (w * spin)[moves], w[moves]
    turn = float(turns.sum()) * dt
    if not turn < 0.5 * np.pi:
        return np.inf
    c += c.max(initial=0.0) * np.expm1(turn)
    c[:base] = c[:base].max(initial=0.0)
    bend = float((w * c) @ (2.0 * np.cumsum(turns) - turns))
    if base:
        bend += 2.0 * float((w * c)[:base].sum() * turns[:base].sum())  # in either order
    ahead = gaps @ normal
    aside = np.linalg.norm(gaps - ahead[:, None] * normal, axis=1)
    left = float((ahead * np.cos(turn) - aside * np.sin(turn)).min())
    return 0.5 * bend * dt * dt + (float(w @ c) * dt + shift) * turn + float(ahead.min()) - left
