r"""Error and Jacobian of tasks of the joints: postures and couplings.

A *posture* has one row a joint, of the identity, and by its joint's kind

.. math:: e = q^d - q \quad\text{or, on a circle,}\quad e = \angle \bigl( (c, s), (c^d, s^d) \bigr)
    = \operatorname{atan2}(c s^d - s c^d, \; c c^d + s s^d) .

A *coupling* has one row, f, of the factors of the joints: :math:`e = s^d - f^T q`. *Linear relations* have a matrix of
them, and ways from a configuration, which are errors of a posture turned round: :math:`e = b - A (q \ominus q_0)`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...rows.kernels import law as of

#: Of a posture: the table of its law; q, and how many numbers it has; the steps that Python measures; the target, its
#: velocity and acceleration, and how many numbers each of them has; and of every row (5 x rows) what its joint is,
#: where it is in q and in the target, and which velocity of the joints and of the target is its own (-1: none).
LAW, Q, NQ, STEPS, TARGET, SIZE, JOINTS = range(7)
KIND, PLACE, GOAL, COLUMN, RATE = range(5)
JOINT_FIELDS = 5
#: What a joint is: one number of q, two on a circle, or on a manifold whose steps Python measures.
LINE, CIRCLE, MANIFOLD = range(3)
#: Of a coupling: q, and how many numbers it has; the target, its velocity and acceleration; and of all joints the
#: factors, and where they are in q.
SUM, FACTORS, PLACES = range(3, 6)
#: Of linear relations: q, and how many numbers it has; the ways of all joints, to work in; b, its velocity and
#: acceleration; q0; and what the joints are.
WAYS, WANTED, START, KINDS = range(3, 7)


@inner
def angle_between(q, here, target, there):
    """The way on a circle from one point, cosine and sine, to another."""
    c, s, to_c, to_s = q[here], q[here + 1], target[there], target[there + 1]
    return math.atan2(c * to_s - s * to_c, c * to_c + s * to_s)


@stamp
@entry
def write_posture(here):
    """Error, rates and Jacobian of a posture."""
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
    """Error, rates and Jacobian of a linear combination of joint positions."""
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
    """Sums of the ways of all joints from a configuration."""
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
