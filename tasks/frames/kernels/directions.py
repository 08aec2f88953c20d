r"""Error, rates, Jacobian and drift of tasks of one direction of a frame, from its block.

The block is that of :mod:`tasks.robots.kernels.block`. An *axis* a, a unit vector fixed in the frame, has two rows:
those of U, perpendicular to a in the frame. With the desired unit vector d in the world, which turns at
:math:`\sigma`, and the angle :math:`\vartheta` between both,

.. math:: e = U \vartheta \frac{a \times R^T d}{\lVert a \times R^T d \rVert}, \qquad J = U R^T J_\omega;

the feed-forward velocity is :math:`U R^T \sigma`, and the acceleration, as the rows turn with the frame,
:math:`U R^T (\dot\sigma - \omega \times \sigma)`. A *sight* is an axis whose d points at a point c at the distance
:math:`\rho`, so that d also changes with the frame: see :mod:`tasks.frames.look_at`. The *distance* of the frame from
a plane with the unit normal n is :math:`n \cdot p`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.algebra import best_way
from ...base.kernels.rotation import crossed, turned_back
from ...robots.kernels import block as at
from ...rows.kernels import law as of

#: Table: the table of the law, the block of the frame; the target, its velocity and acceleration. Then a and U by rows
#: (9,) and work space; for a plane, its normal n.
LAW, BLOCK, TARGET, AXIS, WORK = range(5)
NORMAL = 3
#: Work space: U R^T by rows; three vectors; work space of :func:`best_way`.
ACROSS, FIRST, SECOND, THIRD, REST = 0, 6, 9, 12, 15
#: Two directions with a smaller sine between them are parallel or opposite; if opposite, any axis of rotation is right.
PARALLEL = 1e-9
#: Smallest distance [m] to a target point: nearer, its direction is not defined.
NEAR = 1e-9


def work_size(n: int) -> int:
    """The size of the work space for n joint velocities."""
    return REST + 2 * n + 6


@inner
def dot(one, first, other, second):
    """The scalar product of one[first:first + 3] and other[second:second + 3]."""
    return one[first] * other[second] + one[first + 1] * other[second + 1] + one[first + 2] * other[second + 2]


@inner
def cross_into(one, first, other, second, scale, out, begin):
    """Write ``scale one x other`` to out[begin:begin + 3], of the vectors that begin at `first` and `second`."""
    out[begin] = out[begin + 1] = out[begin + 2] = 0.0
    x, y, z = other[second], other[second + 1], other[second + 2]
    crossed(one[first], one[first + 1], one[first + 2], x, y, z, scale, out, begin)


@inner
def look_across(axis, block, work):
    """Write U R^T to work[ACROSS:ACROSS + 6]; `axis` (9,) is a, then U by rows."""
    for r in range(2):
        for k in range(3):
            work[ACROSS + 3 * r + k] = dot(axis, 3 + 3 * r, block, at.ROTATION + 3 * k)


@inner
def shortest_turn(axis, block, n, A, measured, work):
    """Write the error to measured[:2]: the shortest rotation of the axis onto d, in work[FIRST:], along both rows.

    If both are opposite, it is pi about the axis about which the joints can turn the frame fastest (:func:`best_way`).
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
    """Write ``U R^T (x, y, z)`` to out[first:first + 2]."""
    for r in range(2):
        out[first + r] = work[3 * r] * x + work[3 * r + 1] * y + work[3 * r + 2] * z


@stamp
@entry
def write_axis(here):
    """Write A and bounds of an axis that is to point in a direction, from its error, rates, Jacobian and drift."""
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
    cross_into(target, 0, target, 3, share, work, FIRST)  # sigma
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
    """Write A and bounds of an axis that is to point at a point, from its error, rates, Jacobian and drift."""
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
    """Write the feed-forward acceleration of a sight from the motion of its point, and the drift of a point at rest.

    d is in work[FIRST:], d x c' / rho in work[SECOND:]; both are overwritten. The comments have the equations, which
    :mod:`tasks.frames.look_at` derives.
    """
    v, w = block[at.LINEAR_VELOCITY : at.LINEAR_VELOCITY + 3], block[at.ANGULAR_VELOCITY : at.ANGULAR_VELOCITY + 3]
    passing = dot(work, FIRST, v, 0)  # towards the point
    moving = passing - dot(work, FIRST, target, 3)
    # change = d x (c'' - 2 ((d u) u - (d p') p') / rho) / rho - omega x (d x c') / rho; d x c' / rho is in SECOND
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
    """Write A and bounds of the distance of the origin of a frame from a plane, from its error, rates and drift."""
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
