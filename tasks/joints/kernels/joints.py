r"""Error and Jacobian of tasks of the joints: postures and couplings.

A *posture* has one row of the identity for each joint. Its error, by the kind of the joint, is

.. math:: e = q^d - q \quad\text{or, on a circle,}\quad e = \angle \bigl( (c, s), (c^d, s^d) \bigr)
    = \operatorname{atan2}(c s^d - s c^d, \; c c^d + s s^d) .

A *coupling* has one row, the factors f of the joints: :math:`e = s^d - f^T q`. *Linear relations* have a matrix A of
such rows: :math:`e = b - A (q \ominus q_0)`, where :math:`q \ominus q_0` is minus the error of a posture.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...rows.kernels import law as of

#: Table of a posture: the table of its law; q, its size; the errors that Python measures; the target with its velocity
#: and acceleration, the size of each; and of every row (5 x rows) the kind of its joint, its place in q and in the
#: target, its place in the joint velocities, and in the velocities of the target (-1: none).
LAW, Q, NQ, STEPS, TARGET, SIZE, JOINTS = range(7)
KIND, PLACE, GOAL, COLUMN, RATE = range(5)
JOINT_FIELDS = 5
#: Kinds of joints: one number of q; two numbers, on a circle; or on a manifold, where Python measures the error.
LINE, CIRCLE, MANIFOLD = range(3)
#: Table of a coupling, after NQ: the target with its velocity and acceleration (3,); the factors of all joints, and
#: their places in q.
SUM, FACTORS, PLACES = range(3, 6)
#: Table of linear relations, after NQ: work space for q - q0 of all joints; b with its velocity and acceleration; q0;
#: and the kinds and places of the joints, as of a posture.
WAYS, WANTED, START, KINDS = range(3, 7)


@inner
def angle_between(q, here, target, there):
    """The angle [rad] from the point (cos, sin) at q[here:] on the unit circle to that at target[there:]."""
    c, s, to_c, to_s = q[here], q[here + 1], target[there], target[there + 1]
    return math.atan2(c * to_s - s * to_c, c * to_c + s * to_s)


@stamp
@entry
def write_posture(here):
    """Write the bounds of a posture, from its error and rates; its rows are plain bounds."""
    told = ints(here, 0, 7)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n, size = law[of.ROWS], law[of.N], told[SIZE]
    joints, v = ints(told[JOINTS], 0, JOINT_FIELDS * rows), floats(law[of.V], 0, n)
    q, steps, target = floats(told[Q], 0, told[NQ]), floats(told[STEPS], 0, rows), floats(told[TARGET], 0, 3 * size)
    measured = floats(law[of.MEASURED], 0, of.KINDS * rows)
    for r in range(rows):
        kind, place, goal = joints[r], joints[PLACE * rows + r], joints[GOAL * rows + r]
        if kind == LINE:
            measured[r] = target[goal] - q[place]
        elif kind == CIRCLE:
            measured[r] = angle_between(q, place, target, goal)
        else:
            measured[r] = steps[r]
        rate = joints[RATE * rows + r]
        if rate >= 0:
            measured[rows + r], measured[2 * rows + r] = target[size + rate], target[2 * size + rate]
        measured[of.NOW * rows + r] = v[joints[COLUMN * rows + r]]
    of.law(told[LAW])
    return 0


@stamp
@entry
def write_coupling(here):
    """Write A and bounds of a coupling, a linear combination of joint positions."""
    told = ints(here, 0, 6)
    law = ints(told[LAW], 0, of.LENGTH)
    n = law[of.N]
    q, target = floats(told[Q], 0, told[NQ]), floats(told[SUM], 0, 3)
    factors, places = floats(told[FACTORS], 0, n), ints(told[PLACES], 0, n)
    A, measured = floats(law[of.MATRIX], 0, n), floats(law[of.MEASURED], 0, of.KINDS)
    total = 0.0
    for j in range(n):
        A[j] = factors[j]
        if factors[j] != 0.0 and places[j] >= 0:
            total += factors[j] * q[places[j]]
    measured[of.ERROR] = target[0] - total
    measured[of.RATE], measured[of.CHANGE] = target[1], target[2]
    of.moving(told[LAW])
    of.law(told[LAW])
    return 0


@stamp
@entry
def write_linear(here):
    """Write the bounds of linear relations, A (q - q0) = b; A is there already."""
    told = ints(here, 0, 7)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n = law[of.ROWS], law[of.N]
    joints, q, start = (
        ints(told[KINDS], 0, JOINT_FIELDS * n),
        floats(told[Q], 0, told[NQ]),
        floats(told[START], 0, told[NQ]),
    )
    ways, wanted = floats(told[WAYS], 0, n), floats(told[WANTED], 0, 3 * rows)
    A, measured = floats(law[of.MATRIX], 0, rows * n), floats(law[of.MEASURED], 0, of.KINDS * rows)
    for j in range(n):
        kind, place, goal = joints[j], joints[PLACE * n + j], joints[GOAL * n + j]
        if kind == LINE:
            ways[j] = q[place] - start[goal]
        elif kind == CIRCLE:
            ways[j] = angle_between(start, goal, q, place)
        else:
            ways[j] = 0.0
    for r in range(rows):
        total = 0.0
        for j in range(n):
            total += A[r * n + j] * ways[j]
        measured[r] = wanted[r] - total
        measured[of.RATE * rows + r], measured[of.CHANGE * rows + r] = wanted[rows + r], wanted[2 * rows + r]
    of.moving(told[LAW])
    of.law(told[LAW])
    return 0
