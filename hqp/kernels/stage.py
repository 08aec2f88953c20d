"""The stage of a curved level, written as a plain hierarchy: levels above, own rows, soft rows, rows of damping."""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .compile import inner
from .memory import floats, ints, marks, matrix, vector
from .symmetric import cholesky

#: What is added to a matrix that has to be definite, relative to its trace.
REGULAR = 1e-12


@inner
def give(here, i, place, row, A, lower, upper, weights):
    """Row i of the hierarchy as it is, in a stage."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    col, row_of = marks(here, plain.COL), marks(here, plain.ROW_OF)
    if row >= 0:
        own = floats(A, row * n, n)
        for j in range(n):
            own[j] = 0.0
        if col[i] >= 0:
            own[col[i]] = 1.0
        else:
            given_row = matrix(here, plain.A)[row_of[i]]
            for j in range(n):
                own[j] = given_row[j]
    lower[place], upper[place] = vector(here, plain.LOWER)[i], vector(here, plain.UPPER)[i]
    weights[place] = vector(here, plain.WEIGHTS)[i]


@inner
def write_above(here, k, A, lower, upper, weights):
    """The levels above k in its stage."""
    head, ptr, state = ints(here, 0, plain.HEAD), marks(here, plain.PTR), marks(here, at.STATE)
    n, levels = head[plain.N], head[plain.LEVELS]
    first, dense = marks(here, at.FIRST), marks(here, at.DENSE)
    rows, reached = matrix(here, at.ROW), vector(here, at.VALUE)
    for level in range(k):
        place, row = first[k * levels + level], dense[k * levels + level]
        for i in range(ptr[level], ptr[level + 1]):
            if state[i] == at.GIVEN:
                give(here, i, place, row, A, lower, upper, weights)
            else:
                own = floats(A, row * n, n)
                held = state[i] == at.HELD
                for j in range(n):
                    own[j] = rows[i][j] if held else 0.0
                weights[place] = 1.0
                lower[place] = reached[i] if held else -math.inf
                upper[place] = reached[i] if held else math.inf
            place += 1
            if row >= 0:  # else the level has no rows of A
                row += 1


@inner
def write_damping(here, k, d, address, place, row, lower, upper, weights, lean):
    r"""Rows of damping, one a direction: :math:`(y - r)^T L P L^T (y - r) + w^2 |y - v|^2`, x being :math:`Z^T y`."""
    n, basis, L, P = (
        ints(here, 0, plain.HEAD)[plain.N],
        matrix(here, at.BASIS),
        matrix(here, at.METRIC),
        matrix(here, at.P),
    )
    M, K, half = matrix(here, at.M), matrix(here, at.U), matrix(here, at.HALF)
    aim, last, towards, damped = (
        matrix(here, at.AIMS)[k],
        vector(here, at.LAST),
        vector(here, at.MU),
        matrix(here, at.DAMPED),
    )
    for p in range(d):
        for q in range(d):
            half[p][q] = 0.0
        for r in range(p + 1):
            for q in range(d):
                half[p][q] += L[p][r] * P[r][q]
    trace = 0.0
    for p in range(d):
        for q in range(p + 1):
            total = 0.0
            for r in range(q + 1):
                total += half[p][r] * L[q][r]
            M[p][q] = M[q][p] = total
        trace += M[p][p]
    for p in range(d):
        own, away = 0.0, 0.0
        for q in range(d):
            direction, total = basis[q], 0.0
            for j in range(n):
                total += direction[j] * aim[j]
            own += M[p][q] * total
        if lean > 0.0:
            for j in range(n):
                away += basis[p][j] * last[j]
        towards[p] = own + lean * lean * away
    more, some = lean * lean + REGULAR * trace, trace > 0.0 or lean > 0.0
    for p in range(d):
        M[p][p] += more
    some = some and cholesky(M, K, d)
    for p in range(n):
        own, written, value = damped[k * n + p], floats(address, row * n, n), 0.0
        for j in range(n):
            own[j] = 0.0
        if some and p < d:
            for q in range(p, d):
                direction, part = basis[q], K[q][p]
                for j in range(n):
                    own[j] += part * direction[j]
            for q in range(p):
                towards[p] -= K[p][q] * towards[q]
            towards[p] /= K[p][p]
            value = towards[p]
        own[n] = value
        for j in range(n):
            written[j] = own[j]
        weights[place], lower[place], upper[place] = 1.0, value, value
        place, row = place + 1, row + 1


@inner
def write_stage(here, k, d, size, lean):
    """The stage of level k."""
    head, ptr, state = ints(here, 0, plain.HEAD), marks(here, plain.PTR), marks(here, at.STATE)
    n, levels, curved = head[plain.N], head[plain.LEVELS], marks(here, at.CURVED)
    address, sizes = marks(here, at.NUMBERS)[k], marks(here, at.SIZES)
    entries, m = sizes[2 * k] * n, sizes[2 * k + 1]
    lower, upper = floats(address, entries, m), floats(address, entries + m, m)
    weights = floats(address, entries + 2 * m, m)
    write_above(here, k, address, lower, upper, weights)
    place, row = marks(here, at.FIRST)[k * levels + k], marks(here, at.DENSE)[k * levels + k]
    for i in range(ptr[k], ptr[k + 1]):
        give(here, i, place, row, address, lower, upper, weights)
        place, row = place + 1, row + 1
    rows, reached, stiffness = matrix(here, at.ROW), vector(here, at.VALUE), vector(here, at.STIFFNESS)
    for level in range(k):
        for i in range(ptr[level], ptr[level + 1] if curved[level] != 0 else ptr[level]):
            own, soft = floats(address, row * n, n), state[i] == at.SOFT
            scale = stiffness[i] * size if soft else 0.0
            for j in range(n):
                own[j] = scale * rows[i][j] if soft else 0.0
            weights[place] = 1.0
            lower[place] = scale * reached[i] if soft else -math.inf
            upper[place] = scale * reached[i] if soft else math.inf
            place, row = place + 1, row + 1
    write_damping(here, k, d, address, place, row, lower, upper, weights, lean * size)
