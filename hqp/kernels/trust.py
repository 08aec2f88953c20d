"""Decides whether the strict answer of a curved hierarchy can be taken unchanged, as in almost every tick.

It can if no level needs damping by its curvature, and x does not move along bounds.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .bend import TRUSTED, contract, gather
from .compile import inner
from .memory import ints, marks, matrix, vector
from .solver import levels_that_count

#: Share of its range within which a row is near a bound, and the power with which the nearness counts.
NEAR, SOONER = 0.1, 3


@inner
def crowded(here, x):
    """How close x moves along bounds of the levels above the curved ones: 0 away from them (or x NaN), 1 at a bound."""
    head = ints(here, 0, plain.HEAD)
    n, col, row_of, A = head[plain.N], marks(here, plain.COL), marks(here, plain.ROW_OF), matrix(here, plain.A)
    lower, upper, gate = vector(here, plain.LOWER), vector(here, plain.UPPER), 0.0
    for i in range(marks(here, plain.PTR)[head[at.TOP]]):
        room = upper[i] - lower[i]
        if not room > 0.0 or room == math.inf:
            continue
        value = 0.0
        if col[i] >= 0:
            value = x[col[i]]
        else:
            row = A[row_of[i]]
            for j in range(n):
                value += row[j] * x[j]
        near = min(value - lower[i], upper[i] - value) / room
        if near < NEAR:  # a row at rest at its bound does not count
            moving = min(1.0, 2.0 * abs(value) / max(abs(lower[i]), abs(upper[i])))
            gate = max(gate, moving * min(1.0, 1.0 - near / NEAR) ** SOONER)
    return gate


@inner
def least_of(L, pivot, first, end, column):
    """A lower bound of the smallest squared singular value of the triangle first .. end - 1 of L: 1 / ||inverse||_F^2.

    `column` is work space.
    """
    total = 0.0
    for c in range(first, end):
        for r in range(c, end):
            row = L[pivot[r]]
            value = 1.0 if r == c else 0.0
            for q in range(c, r):
                value -= row[q] * column[q - first]
            value /= row[r]
            column[r - first] = value
            total += value * value
    return 1.0 / total if total > 0.0 else math.inf


@inner
def pushed(here, there, k, c, n):
    """Write the multipliers of the rows above level k as weights ``wanted`` of their curvatures; whether there are any.

    As :func:`.bend.multipliers`, but from the triangle of the first c rows of V in the directory `there`.
    """
    V, L, pivot = matrix(there, plain.V), matrix(there, plain.L), marks(there, plain.PIVOT)
    pull, mu, wanted = vector(here, at.PULL), vector(here, at.MU), vector(here, at.WANTED)
    ptr, weights, some = marks(here, plain.PTR), vector(here, plain.WEIGHTS), False
    for i in range(ptr[ints(here, 0, plain.HEAD)[at.TOP]], ptr[k]):
        wanted[i] = 0.0
    for j in range(n):
        some = some or pull[j] != 0.0
    if not some:
        return False
    for q in range(c):
        direction, total = V[q], 0.0
        for j in range(n):
            total += direction[j] * pull[j]
        mu[q] = total
    for q in range(c - 1, -1, -1):
        row = L[pivot[q]]
        mu[q] /= row[q]
        for r in range(q):
            mu[r] -= row[r] * mu[q]
        wanted[pivot[q]] = mu[q] * weights[pivot[q]]
    return True


@inner
def quiet(here, there):
    """Whether the strict answer needs no damping, from the basis that the solver has left in the directory `there`.

    It must come from one sweep, with no active inequality. The ratios are those of :func:`.bend.bend`, but computed
    from the triangles of that basis, which costs less than the sweep.
    """
    head, ptr = ints(here, 0, plain.HEAD), marks(here, plain.PTR)
    n, levels, last, cut = head[plain.N], head[plain.LEVELS], levels_that_count(there), marks(there, plain.CUT)
    pivot, L, weights = marks(there, plain.PIVOT), matrix(there, plain.L), vector(here, plain.WEIGHTS)
    lower, upper, ids = vector(here, plain.LOWER), vector(here, plain.UPPER), marks(here, at.IDS)
    if cut[last] < 0 or ints(there, 0, plain.HEAD)[plain.SWEEPS] != 1:  # no basis, or one of another guess
        return False
    for q in range(cut[last]):
        if lower[pivot[q]] != upper[pivot[q]]:
            return False
    for k in range(head[at.TOP], levels):
        count, least = gather(here, k), math.inf
        if marks(here, at.CURVED)[k] == at.SPARED:
            continue
        for r in range(count):
            if lower[ids[r]] != upper[ids[r]]:
                return False
        first = cut[min(k, last)]
        if k >= last:
            for i in range(ptr[k], ptr[k + 1]):
                least = min(least, weights[i] * weights[i])
        elif cut[k + 1] - first < count:  # some of the rows depend on others
            return False
        else:
            least = least_of(L, pivot, first, cut[k + 1], vector(here, at.VALUES))
        bent = contract(here, k, k + 1)
        if first > 0 and pushed(here, there, k, first, n):
            bent += contract(here, head[at.TOP], k)
        if bent > TRUSTED * least:
            return False
    return True
