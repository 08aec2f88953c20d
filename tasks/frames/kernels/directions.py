r"""Error, rates, Jacobian and drift of tasks of one direction of a frame, from its block (:mod:`.block`).

An *axis* a of a frame, a unit vector in it, has two rows: U, perpendicular to it in the frame. With the wanted unit
vector d of the world, that turns by itself at :math:`\sigma`,

.. math:: e = U \vartheta \frac{a \times R^T d}{\lVert a \times R^T d \rVert}, \qquad J = U R^T J_\omega,

and the rows have :math:`U R^T \sigma` and, as they turn with the frame, :math:`U R^T (\dot\sigma - \omega \times
\sigma)` of it. A *sight* is the same where d points at a point c that is :math:`\rho` away, and so turns with the
frame too: see :mod:`tasks.frames.look_at`. The *distance* of the frame from a plane with the unit normal n is
:math:`n \cdot p`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.algebra import best_way
from ...base.kernels.rotation import crossed, turned_back
from ...robots.kernels import block as at
from ...rows.kernels import law as of

#: Of every measure: the table of its law, the block of its frame, and its target: where it is, its velocity and
#: acceleration. Then a and U by rows (9,) and work space; or n.
LAW, BLOCK, TARGET, AXIS, WORK = range(5)
NORMAL = 3
#: Of the work space: U R^T by rows; three vectors; what :func:`best_way` takes.
ACROSS, FIRST, SECOND, THIRD, REST = 0, 6, 9, 12, 15
#: Below this sine two directions are parallel or opposite; at half a turn any way round is right.
PARALLEL = 1e-9
#: Nearer than this [m] a point has no direction.
NEAR = 1e-9


def work_size(n: int) -> int:
    """Numbers of work space, for n joint velocities."""
    return REST + 2 * n + 6


@inner
def dot(one, first, other, second):
    """The product of two vectors of space."""
    return one[first] * other[second] + one[first + 1] * other[second + 1] + one[first + 2] * other[second + 2]


@inner
def cross_into(one, first, other, second, scale, out, begin):
    """``scale one x other``, into out[begin:begin + 3]."""
    out[begin] = out[begin + 1] = out[begin + 2] = 0.0
    x, y, z = other[second], other[second + 1], other[second + 2]
    crossed(one[first], one[first + 1], one[first + 2], x, y, z, scale, out, begin)


@inner
def look_across(axis, block, work):
    """U R^T, into its place."""
    for r in range(2):
        for k in range(3):
            work[ACROSS + 3 * r + k] = dot(axis, 3 + 3 * r, block, at.ROTATION + 3 * k)


@inner
def shortest_turn(axis, block, n, A, measured, work):
    """The error: the shortest turn of the axis to the direction of the world in work[FIRST:], along both rows.

    At half a turn the way round that the joints turn best: along the long axis of what J can do.
    """
    turned_back(block[at.ROTATION : at.ROTATION + 9], work[FIRST], work[FIRST + 1], work[FIRST + 2], work, SECOND)
    cross_into(axis, 0, work, SECOND, 1.0, work, THIRD)
    sine, cosine = math.sqrt(dot(work, THIRD, work, THIRD)), dot(axis, 0, work, SECOND)
    if not sine < PARALLEL:
        angle = math.atan2(sine, cosine) / sine
        measured[0], measured[1] = angle * dot(axis, 3, work, THIRD), angle * dot(axis, 6, work, THIRD)
    elif cosine > 0.0:
        measured[0] = measured[1] = 0.0
    else:
        best_way(A, 2, n, measured, work[REST:])
        for r in range(2):
            measured[r] *= math.pi


@inner
def across(work, x, y, z, out, first):
    """``U R^T (x, y, z)``, into both rows of out."""
    for r in range(2):
        out[first + r] = work[3 * r] * x + work[3 * r + 1] * y + work[3 * r + 2] * z


@stamp
@entry
def write_axis(here):
    """Error, rates, Jacobian and drift of an axis that is to point in a direction."""
    told = ints(here, 0, 5)
    law = ints(told[LAW], 0, of.LENGTH)
    n = law[of.N]
    block, J = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    target, axis, work = floats(told[TARGET], 0, 9), floats(told[AXIS], 0, 9), floats(told[WORK], 0, REST + 2 * n + 6)
    measured, A = floats(law[of.MEASURED], 0, of.KINDS * 2), floats(law[of.MATRIX], 0, 2 * n)
    look_across(axis, block, work)
    for j in range(n):
        across(work, J[3 * n + j], J[4 * n + j], J[5 * n + j], work, FIRST)
        A[j], A[n + j] = work[FIRST], work[FIRST + 1]
    square = dot(target, 0, target, 0)
    share = 1.0 / square if square > 0.0 else math.nan
    length = math.sqrt(share)
    for k in range(3):
        work[FIRST + k] = length * target[k]
    shortest_turn(axis, block, n, A, measured, work)
    cross_into(target, 0, target, 3, share, work, FIRST)  # its spin
    across(work, work[FIRST], work[FIRST + 1], work[FIRST + 2], measured, 2)
    if law[of.DRIFTS] != 0:
        cross_into(target, 0, target, 6, share, work, SECOND)
        slower = 2.0 * share * dot(target, 0, target, 3)
        for k in range(3):
            work[SECOND + k] -= slower * work[FIRST + k]
        w, spin = at.ANGULAR_VELOCITY, work[FIRST : FIRST + 3]
        crossed(block[w], block[w + 1], block[w + 2], spin[0], spin[1], spin[2], -1.0, work, SECOND)
        across(work, work[SECOND], work[SECOND + 1], work[SECOND + 2], measured, 4)
        drift = at.ANGULAR_DRIFT
        across(work, block[drift], block[drift + 1], block[drift + 2], measured, 6)
        of.moving(told[LAW])
    of.law(told[LAW])
    return 0


@stamp
@entry
def write_sight(here):
    """Error, rates, Jacobian and drift of an axis that is to point at a point."""
    told = ints(here, 0, 5)
    law = ints(told[LAW], 0, of.LENGTH)
    n = law[of.N]
    block, J = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    target, axis, work = floats(told[TARGET], 0, 9), floats(told[AXIS], 0, 9), floats(told[WORK], 0, REST + 2 * n + 6)
    measured, A = floats(law[of.MEASURED], 0, of.KINDS * 2), floats(law[of.MATRIX], 0, 2 * n)
    look_across(axis, block, work)
    x, y, z = target[0] - block[0], target[1] - block[1], target[2] - block[2]
    distance = math.sqrt(x * x + y * y + z * z)
    if distance < NEAR:
        distance = NEAR
    x, y, z = x / distance, y / distance, z / distance
    for j in range(n):
        a, b, c = J[j] / distance, J[n + j] / distance, J[2 * n + j] / distance
        a, b, c = y * c - z * b, z * a - x * c, x * b - y * a
        across(work, J[3 * n + j] + a, J[4 * n + j] + b, J[5 * n + j] + c, work, FIRST)
        A[j], A[n + j] = work[FIRST], work[FIRST + 1]
    work[FIRST], work[FIRST + 1], work[FIRST + 2] = x, y, z
    shortest_turn(axis, block, n, A, measured, work)
    cross_into(work, FIRST, target, 3, 1.0 / distance, work, SECOND)
    across(work, work[SECOND], work[SECOND + 1], work[SECOND + 2], measured, 2)
    if law[of.DRIFTS] != 0:
        sight_drifts(block, target, distance, measured, work)
        of.moving(told[LAW])
    of.law(told[LAW])
    return 0


@inner
def sight_drifts(block, target, distance, measured, work):
    """What the point takes of acceleration, and the drift as if it stood; d is in work[FIRST:], the rest overwritten.

    All are sums of d x something and of omega x something; see :mod:`tasks.frames.look_at`.
    """
    v, w = block[at.LINEAR_VELOCITY : at.LINEAR_VELOCITY + 3], block[at.ANGULAR_VELOCITY : at.ANGULAR_VELOCITY + 3]
    passing = dot(work, FIRST, v, 0)  # towards the point
    moving = passing - dot(work, FIRST, target, 3)
    # change = d x (c'' - 2 ((d u) u - (d p') p') / rho) / rho - omega x (d x c') / rho, of which the last is in SECOND
    for k in range(3):
        u = v[k] - target[3 + k]
        work[THIRD + k] = target[6 + k] - 2.0 * (moving * u - passing * v[k]) / distance
    turned = work[SECOND : SECOND + 3]
    a, b, c = (
        w[1] * turned[2] - w[2] * turned[1],
        w[2] * turned[0] - w[0] * turned[2],
        w[0] * turned[1] - w[1] * turned[0],
    )
    cross_into(work, FIRST, work, THIRD, 1.0 / distance, work, SECOND)
    across(work, work[SECOND] - a, work[SECOND + 1] - b, work[SECOND + 2] - c, measured, 4)
    # drift = omega' + d x (p'' + 2 (d p') p' / rho) / rho - omega x (d x p') / rho
    for k in range(3):
        work[THIRD + k] = block[at.LINEAR_DRIFT + k] + 2.0 * passing * v[k] / distance
    cross_into(work, FIRST, work, THIRD, 1.0 / distance, work, SECOND)
    cross_into(work, FIRST, v, 0, 1.0 / distance, work, THIRD)
    crossed(w[0], w[1], w[2], work[THIRD], work[THIRD + 1], work[THIRD + 2], -1.0, work, SECOND)
    x, y, z = block[at.ANGULAR_DRIFT], block[at.ANGULAR_DRIFT + 1], block[at.ANGULAR_DRIFT + 2]
    across(work, x + work[SECOND], y + work[SECOND + 1], z + work[SECOND + 2], measured, 6)


@stamp
@entry
def write_plane(here):
    """Error, rates, Jacobian and drift of the distance of the origin of a frame from a plane."""
    told = ints(here, 0, 4)
    law = ints(told[LAW], 0, of.LENGTH)
    n = law[of.N]
    block, J = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 3 * n)
    target, normal = floats(told[TARGET], 0, 3), floats(told[NORMAL], 0, 3)
    measured, A = floats(law[of.MEASURED], 0, of.KINDS), floats(law[of.MATRIX], 0, n)
    measured[of.ERROR] = target[0] - dot(normal, 0, block, 0)
    measured[of.RATE], measured[of.CHANGE] = target[1], target[2]
    for j in range(n):
        A[j] = normal[0] * J[j] + normal[1] * J[n + j] + normal[2] * J[2 * n + j]
    if law[of.DRIFTS] != 0:
        measured[of.DRIFT] = dot(normal, 0, block, at.LINEAR_DRIFT)
        of.moving(told[LAW])
    of.law(told[LAW])
    return 0
