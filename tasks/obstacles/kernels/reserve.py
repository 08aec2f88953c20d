r"""The reserve rho: a bound on the loss of distance within one tick beyond what the linear row accounts for.

The row is :math:`n^T J x` of the witness p, the nearest point of the link. Within a tick dt, in which no joint turns
faster than w, the distance D of the cores obeys

.. math::

    D^+ \ge D + n^T J x\, dt - \rho, \qquad
    \rho = \tfrac12 b\, dt^2 + s\, \delta + D - \min_k \left( n^T g_k \cos\delta
        - \lVert g_k - n n^T g_k \rVert \sin\delta \right)

where s is how far p and the obstacle move at most, :math:`\delta = \sum_i w_i\, dt` how far the link rotates by its
revolute joints i, :math:`g_k = p - x_k` with the ends x_k of the obstacle's core, and b the largest acceleration of p
at constant joint velocities,

.. math:: b = \sum_{i,j} w_i w_j c_{\max(i, j)}, \qquad c_j = \lVert J_j \rVert + C (e^\delta - 1).

Proof. The link is convex, so it lies beyond the plane through p with normal n. The plane rotates with the link by at
most delta; let m be its normal then. The obstacle is on the other side of a plane with normal m, at a distance of at
least :math:`m^T(p^+ - x_k)` for the nearest k. The first term is Taylor's remainder: two joints i, j give p the second
derivative :math:`z_i \times J_j`, where j is the one nearer to p, and no column of J grows faster than
:math:`e^\delta`; C is the longest column.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import inner
from hqp.kernels.memory import floats

from ...robots.kernels import block as at
from .distances import CORE, NORMAL, WITNESS

#: Largest rotation of a link within a tick [rad] for which the bound holds.
QUARTER = 0.5 * math.pi


@inner
def fastest(v, velocity, limited, acceleration, braked, dt, reached, w):
    """Write how fast each joint may turn in this tick [rad/s], w (n,), by the limits of the stack; infinite without.

    `limited` and `braked` tell whether the stack limits velocities and accelerations at all; `reached`, whether joints
    change their velocity gradually over the tick (acceleration order), so that their present velocity counts as well.
    """
    for j in range(len(v)):
        now = abs(v[j])
        most = velocity[j] if limited else math.inf
        if braked:  # a joint that is too fast slows down by no more than one step
            step = acceleration[j] * dt
            most = max(min(most, now + step), now - step)
        if reached:
            most = max(most, now) if most < math.inf else now
        w[j] = most if now == now else now


@inner
def columns(address, n, witness, w, dt, c, turns):
    """Write how far each joint moves the witness, c (n,) per unit, and how fast it turns the link, `turns` (n,).

    `address` is that of the link's block. Returns delta [rad].
    """
    block, J = floats(address, 0, at.JACOBIAN), floats(address, at.JACOBIAN, 6 * n)
    r0, r1, r2 = witness[0] - block[0], witness[1] - block[1], witness[2] - block[2]
    turn = 0.0
    for j in range(n):
        x, y, z = J[3 * n + j], J[4 * n + j], J[5 * n + j]
        a, b, g = J[j] + y * r2 - z * r1, J[n + j] + z * r0 - x * r2, J[2 * n + j] + x * r1 - y * r0
        c[j], spin = math.sqrt(a * a + b * b + g * g), math.sqrt(x * x + y * y + z * z)
        turns[j] = 0.0 if c[j] == 0.0 and spin == 0.0 else w[j] * spin  # w may be infinite for other joints
        turn += turns[j]
    return turn * dt


@inner
def bends(n, base, w, turn, c, turns):
    """The bound b on the acceleration of the witness, and the largest speed that it may have within the tick.

    `turn` is delta; the first `base` velocities are those of a floating base.
    """
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
        if j < base:  # the velocities of a base have no order: count both orders
            base_speed += way
            base_turn += turns[j]
    return bend + 2.0 * base_speed * base_turn, speed


@inner
def reserve(address, n, base, found, shape, shift, w, dt, work):
    """The reserve rho [m] of a pair; infinite if the link could turn by a quarter of a turn or more.

    `address` is that of the link's block, `base` the number of velocities of a floating base, `found` the pair, `shape`
    the obstacle, `shift` how far it moves within the tick [m]; `work` holds 2 n numbers.
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
