"""Decides whether the strict answer of a curved hierarchy can be taken unchanged, as in almost every tick.

It can if no level needs damping by its curvature, and x does not jump at bounds (:mod:`.crowding`).
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .bend import TRUSTED, bound, contract
from .compile import inner, integer
from .curved_rows import gather
from .lacking import note_lacking
from .memory import ints, marks, matrix, vector
from .redundant import BALANCED, across, has_unknown, longest, weight_of


@inner
def note_triangle(here, there, c):
    """Write 1 over the diagonal of the first c rows of the triangle L to ``row_now``.

    Returns how many variables are free; -1 if an active row is an inequality.
    """
    pivot, pinned, L = marks(there, plain.PIVOT), marks(there, plain.PINNED), matrix(there, plain.L)
    lower, upper, over = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, at.ROW_NOW)
    free, equal = integer(0), True
    for q in range(c):
        i = pivot[q]
        over[q] = 1.0 / L[i][q]
        equal = equal and lower[i] == upper[i]
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        i = pinned[j]
        if i < 0:
            free += 1
        else:
            equal = equal and lower[i] == upper[i]
    return free if equal else integer(-1)


@inner
def weigh(here, k):
    """Write the weights ``wanted`` of the curvatures of level k, as :func:`.curved_rows.gather` does.

    Returns how many of its rows are equalities; -1 if another one has an error.
    """
    ptr, lower, upper = marks(here, plain.PTR), vector(here, plain.LOWER), vector(here, plain.UPPER)
    errors, weights, wanted, count = (
        vector(here, at.ERRORS),
        vector(here, plain.WEIGHTS),
        vector(here, at.WANTED),
        integer(0),
    )
    for i in range(ptr[k], ptr[k + 1]):
        wanted[i] = 0.0
        if lower[i] == upper[i]:
            wanted[i] = -weights[i] * weights[i] * errors[i]
            count += 1
        elif errors[i] != 0.0 and (lower[i] > -math.inf or upper[i] < math.inf):
            return integer(-1)
    return count


@inner
def inverse_of(here, there, first, end):
    """An upper bound of 1 over the smallest squared singular value of the triangle first .. end - 1 of L.

    It is the inverse of :func:`.definite.smallest`, but from the inverse of the triangle that is there.
    """
    L, pivot, over, X = matrix(there, plain.L), marks(there, plain.PIVOT), vector(here, at.ROW_NOW), matrix(here, at.E)
    n, trace, squares = end - first, 0.0, 0.0
    for c in range(n):  # row c gets column c of the inverse
        column = X[c]
        column[c] = over[first + c]
        for r in range(c + 1, n):
            row, value = L[pivot[first + r]], 0.0
            for q in range(c, r):
                value -= row[first + q] * column[q]
            column[r] = value * over[first + r]
    for i in range(n):
        one = X[i]
        for j in range(i + 1):
            other, value = X[j], 0.0
            for p in range(i, n):
                value += one[p] * other[p]
            if j == i:
                trace += value
                squares += value * value
            else:
                squares += 2.0 * value * value
    return (trace + math.sqrt(max(n * squares - trace * trace, 0.0) * (n - 1))) / max(n, 1)


@inner
def hand_up(here, there, k, c):
    """Write the multipliers of the rows above level k as weights ``wanted`` of their curvatures.

    As :func:`.bend.multipliers`, but from the triangle of the first c rows of V, along which ``mu`` is J' e.
    """
    L, pivot, over, mu = (
        matrix(there, plain.L),
        marks(there, plain.PIVOT),
        vector(here, at.ROW_NOW),
        vector(here, at.MU),
    )
    ptr, weights, wanted = marks(here, plain.PTR), vector(here, plain.WEIGHTS), vector(here, at.WANTED)
    for i in range(ptr[ints(here, 0, plain.HEAD)[at.TOP]], ptr[k]):
        wanted[i] = 0.0
    for q in range(c - 1, -1, -1):
        i, own = pivot[q], mu[q] * over[q]
        row = L[i]
        for r in range(q):
            mu[r] -= row[r] * own
        wanted[i] = own * weights[i]


@inner
def pull_along(here, there, c, f):
    """Write ``pull`` along the first c rows of V, which are over the f free variables, to ``mu``."""
    V, free, pull, mu = matrix(there, plain.V), marks(there, plain.FREE), vector(here, at.PULL), vector(here, at.MU)
    for q in range(c):
        direction, total = V[q], 0.0
        for t in range(f):
            total += direction[t] * pull[free[t]]
        mu[q] = total


@inner
def rows_along(here, there, k, c):
    """The same for the J' e of level k, whose rows the solver has written along V, in L; from its ``wanted``."""
    ptr, L, norm, mu = marks(here, plain.PTR), matrix(there, plain.L), vector(there, plain.NORM), vector(here, at.MU)
    errors, weights, wanted = vector(here, at.ERRORS), vector(here, plain.WEIGHTS), vector(here, at.WANTED)
    for q in range(c):
        mu[q] = 0.0
    for i in range(ptr[k], ptr[k + 1]):
        if wanted[i] != 0.0 and norm[i] > 0.0:
            row, share = L[i], weights[i] * errors[i]
            for q in range(c):
                mu[q] += share * row[q]


@inner
def pull_of(here, k):
    """Write ``pull`` = J' e of level k, from its ``wanted``."""
    ptr, col, row_of = marks(here, plain.PTR), marks(here, plain.COL), marks(here, plain.ROW_OF)
    n, A, wanted, pull = (
        ints(here, 0, plain.HEAD)[plain.N],
        matrix(here, plain.A),
        vector(here, at.WANTED),
        vector(here, at.PULL),
    )
    for j in range(n):
        pull[j] = 0.0
    for i in range(ptr[k], ptr[k + 1]):
        if col[i] >= 0:
            pull[col[i]] -= wanted[i]
        elif wanted[i] != 0.0:
            row = A[row_of[i]]
            for j in range(n):
                pull[j] -= wanted[i] * row[j]


@inner
def pushes(here, there, k, last, c, f):
    """Whether level k asks for anything along the rows of V above it, its first c: these then have their ``wanted``.

    The solver has written the rows of the levels above `last` along V.
    """
    mu, some = vector(here, at.MU), False
    if k < last:
        rows_along(here, there, k, c)
    else:
        pull_of(here, k)
        pull_along(here, there, c, f)
    for q in range(c):
        some = some or mu[q] != 0.0
    if some:
        hand_up(here, there, k, c)
    return some


@inner
def leave_off(here, there, c, f):
    """Write to ``reach`` where the levels above leave off: the strict x along the first c rows of V alone.

    Variables that are not among the f free ones are held.
    """
    V, x, out, free = matrix(there, plain.V), vector(there, plain.X), vector(here, at.REACH), marks(there, plain.FREE)
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        out[j] = x[j]
    for t in range(f):
        out[free[t]] = 0.0
    for q in range(c):
        direction, along = V[q], 0.0
        for t in range(f):
            along += direction[t] * x[free[t]]
        for t in range(f):
            out[free[t]] += along * direction[t]


@inner
def repeated(here, there, k, count, first, end, f):
    """Whether those of the `count` rows of level k that are none of its rows first .. end - 1 of V repeat others.

    As :func:`.redundant.least_apart` decides, but by the triangle in the directory `there`; f as in :func:`pull_along`.
    False where one of them has an unknown curvature: the triangle has one of two alike, which may be the one that is
    not known, and multipliers by both, as those that decide, then ask for more.
    """
    gather(here, k)
    n, J, ids = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), marks(here, at.IDS)
    pivot, free, weights, size = marks(there, plain.PIVOT), marks(there, plain.FREE), vector(here, plain.WEIGHTS), 0.0
    pull, wanted, S = vector(here, at.PULL), vector(here, at.WANTED), matrix(here, at.S)
    for j in range(n):
        pull[j] = 0.0
    for r in range(count):
        u = weight_of(r)
        for q in range(first, end):
            if pivot[q] == ids[r]:
                u = 0.0
        wanted[ids[r]] = -u * weights[ids[r]]
        size += u * u
        for j in range(n):
            pull[j] += u * J[r][j]
    pull_along(here, there, end, f)
    hand_up(here, there, k, end)
    most = BALANCED * math.sqrt(longest(here, count) * size)
    known = not has_unknown(here, k)
    balanced = known and contract(here, ints(here, 0, plain.HEAD)[at.TOP], k + 1) <= most
    if known and not balanced:
        for i in range(f):
            for j in range(f):
                S[i][j] = S[free[i]][free[j]]
        balanced = across(here, matrix(there, plain.V), 0, first, f) <= most
    weigh(here, k)  # as it was
    return balanced


@inner
def quiet(here, there):
    """Whether the strict answer needs no damping, from the basis that the solver has left in the directory `there`.

    It must come from one sweep, with no active inequality. The ratios are those of :func:`.bend.bend`, but computed
    from the triangles of that basis, which costs less than the sweep.
    """
    head, told, ptr, weights = (
        ints(here, 0, plain.HEAD),
        ints(there, 0, plain.HEAD),
        marks(here, plain.PTR),
        vector(here, plain.WEIGHTS),
    )
    top, last, cut = head[at.TOP], told[plain.LEVEL], marks(there, plain.CUT)
    if cut[last] < 0 or told[plain.SWEEPS] != 1:  # no basis, or one of another guess
        return False
    f = note_triangle(here, there, cut[last])
    if f < 0:
        return False
    for k in range(top, head[plain.LEVELS]):
        first, inverse = cut[min(k, last)], 0.0
        if head[at.LOOKS_AHEAD] != 0 and k > top:
            leave_off(here, there, first, f)
            for block in marks(here, at.BLOCKS):
                note_lacking(block, k)
        if marks(here, at.CURVED)[k] == at.SPARED:
            continue
        count = weigh(here, k)
        if count < 0:
            return False
        if k >= last:
            for i in range(ptr[k], ptr[k + 1]):
                inverse = max(inverse, 1.0 / (weights[i] * weights[i]))
        elif cut[k + 1] - first < count and not repeated(here, there, k, count, first, cut[k + 1], f):
            return False
        else:
            inverse = inverse_of(here, there, first, cut[k + 1])
        some = first > 0 and pushes(here, there, k, last, first, f)
        if (bound(here, k, k + 1) + (bound(here, top, k) if some else 0.0)) * inverse <= TRUSTED:
            continue
        if (contract(here, k, k + 1) + (contract(here, top, k) if some else 0.0)) * inverse > TRUSTED:
            return False
    return True
