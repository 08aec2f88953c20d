r"""A bound on how much of a distance one tick can take beyond what the linear row accounts for.

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

import math

from hqp.kernels.compile import inner
from hqp.kernels.memory import floats

from ...robots.kernels import block as at
from .distances import CORE, NORMAL, WITNESS

#: A link that could turn by more than this may be anywhere [rad].
QUARTER = 0.5 * math.pi


@inner
def fastest(v, velocity, limited, acceleration, braked, dt, reached, w):
    """How fast each joint may turn in this tick [rad/s], by the limits of the stack; infinite without.

    `limited` and `braked` say whether the stack limits velocities and accelerations at all; `reached`, whether the
    joints move by their mean velocity of the tick, so that the one they have counts too.
    """
    for j in range(len(v)):
        now = abs(v[j])
        most = velocity[j] if limited else math.inf
        if braked:  # a joint that is too fast can only slow down so much
            step = acceleration[j] * dt
            most = max(min(most, now + step), now - step)
        if reached:
            most = max(most, now) if most < math.inf else now
        w[j] = most if now == now else now


@inner
def columns(address, n, witness, w, dt, c, turns):
    """How far each joint moves the witness (c, per unit), and how fast it turns the link; returns the whole turn."""
    block, J = floats(address, 0, at.JACOBIAN), floats(address, at.JACOBIAN, 6 * n)
    r0, r1, r2 = witness[0] - block[0], witness[1] - block[1], witness[2] - block[2]
    turn = 0.0
    for j in range(n):
        x, y, z = J[3 * n + j], J[4 * n + j], J[5 * n + j]
        a, b, g = J[j] + y * r2 - z * r1, J[n + j] + z * r0 - x * r2, J[2 * n + j] + x * r1 - y * r0
        c[j], spin = math.sqrt(a * a + b * b + g * g), math.sqrt(x * x + y * y + z * z)
        turns[j] = 0.0 if c[j] == 0.0 and spin == 0.0 else w[j] * spin  # what does not move the link may be infinite
        turn += turns[j]
    return turn * dt


@inner
def bends(n, base, w, turn, c, turns):
    """The acceleration b of the witness, and how fast it may be at the end of the tick."""
    longest, of_base = 0.0, 0.0
    for j in range(n):
        longest = max(longest, c[j])
        if j < base:
            of_base = max(of_base, c[j])
    grown = longest * math.expm1(turn)
    bend, speed, before, base_speed, base_turn = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        if c[j] == 0.0 and turns[j] == 0.0:
            continue
        way = w[j] * ((of_base if j < base else c[j]) + grown)
        bend += way * (2.0 * before + turns[j])
        before += turns[j]
        speed += way
        if j < base:  # its velocities are of no order: either may come first
            base_speed += way
            base_turn += turns[j]
    return bend + 2.0 * base_speed * base_turn, speed


@inner
def reserve(address, n, base, found, shape, shift, w, dt, work):
    """rho [m]; infinite where the link could turn by more than a quarter.

    `address` is that of the link's block, `base` how many velocities are those of a floating base, `shift` the way of
    the obstacle within the tick [m]; `work` holds 2 n numbers.
    """
    c, turns = work[:n], work[n : 2 * n]
    witness = found[WITNESS : WITNESS + 3]
    turn = columns(address, n, witness, w, dt, c, turns)
    if not turn < QUARTER:
        return math.inf
    bend, speed = bends(n, base, w, turn, c, turns)
    cosine, sine = math.cos(turn), math.sin(turn)
    nearest, left = math.inf, math.inf
    for k in range(2):
        core = CORE + 3 * k
        g0, g1, g2 = witness[0] - shape[core], witness[1] - shape[core + 1], witness[2] - shape[core + 2]
        n0, n1, n2 = found[NORMAL], found[NORMAL + 1], found[NORMAL + 2]
        ahead = g0 * n0 + g1 * n1 + g2 * n2
        g0, g1, g2 = g0 - ahead * n0, g1 - ahead * n1, g2 - ahead * n2
        aside = math.sqrt(g0 * g0 + g1 * g1 + g2 * g2)
        nearest, left = min(nearest, ahead), min(left, ahead * cosine - aside * sine)
    return 0.5 * bend * dt * dt + (speed * dt + shift) * turn + nearest - left
