"""Writes the stage of a curved level as a plain hierarchy: levels above, own rows, soft rows, rows of damping."""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .brake import brake
from .compile import inner
from .curved_rows import write_gram
from .definite import upper_factor
from .directions import add_along, along
from .lines import product
from .memory import floats, ints, marks, matrix, vector
from .orthogonal import padded
from .single_lines import add_scaled, clear_line, copy_line
from .sums import add_rows, multiply

#: Regularisation of a matrix before its Cholesky factorisation, relative to its trace.
REGULAR = 1e-12
#: The same relative to the squared length of the longest row, where nothing leans: along a direction that neither rows
#: nor damping feel, as a joint that only turns the hand about the axis of a task, round-off would decide, and that
#: hangs on where a solve starts.
DECIDED = 1e-9


@inner
def give(here, i, place, row, A, lower, upper, weights):
    """Copy row i of the hierarchy to a stage: as its row `place`, and dense row `row` of A (-1: it is a plain bound).

    `A` is an address; `lower`, `upper` and `weights` are arrays of the stage.
    """
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
    """Write the levels above k into its stage: rows as given, held rows, and empty ones in place of all others."""
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
def out_of_metric(here, d):
    """Write M = L P L' (d, d), for the metric factor L; zero if P is."""
    L, P, M, row = matrix(here, at.METRIC), matrix(here, at.P), matrix(here, at.M), matrix(here, at.HALF)[0]
    damped, stiff = vector(here, at.SO_FAR)[at.STRENGTH] > 0.0, ints(here, 0, plain.HEAD)[at.STIFF] != 0
    for p in range(d):
        for q in range(d):
            M[p][q] = P[p][q] if damped and not stiff else 0.0
    for p in range(d if damped and stiff else 0):
        clear_line(row, padded(d))
        add_rows(L[p], P, 0, p + 1, d, row)
        for q in range(p + 1):
            factor, total = L[q], 0.0
            for r in range(q + 1):
                total += row[r] * factor[r]
            M[p][q] = M[q][p] = total


@inner
def brake_all(here, d, firm):
    """Add firm L L' to M and firm L L' r to ``mu``, for the metric factor L and the r (d,) in ``values``."""
    M, L, there, towards = matrix(here, at.M), matrix(here, at.METRIC), vector(here, at.VALUES), vector(here, at.MU)
    stiff = ints(here, 0, plain.HEAD)[at.STIFF] != 0  # else L is the identity, and not written
    for p in range(d):
        for q in range(p + 1):
            weight = firm if p == q and not stiff else 0.0
            for r in range(q + 1 if stiff else 0):
                weight += firm * L[p][r] * L[q][r]
            M[p][q] += weight
            towards[p] += weight * there[q]
            if q < p:
                M[q][p] += weight
                towards[q] += weight * there[p]


@inner
def draw(here, k, d, lean):
    r"""Write M = L P L' + W of damping and lean, and ``mu`` = L P L' r + W v, aim r, last x v; whether M is not 0.

    The weight of the lean, :math:`W = w^2 (G^T G + L P L^T + c |J|^2)`, is relative to the rows and the damping, so
    that directions with small weights do not lag longer than others. What lags is braked: see :mod:`.brake`. Where
    nothing leans, as at acceleration order, levels below the first one brake towards its aim, in the metric L L'.
    """
    head, so_far, M, E = ints(here, 0, plain.HEAD), vector(here, at.SO_FAR), matrix(here, at.M), matrix(here, at.E)
    there, towards, trace = vector(here, at.VALUES), vector(here, at.MU), 0.0
    out_of_metric(here, d)
    along(here, matrix(here, at.AIMS)[k], d, there)
    multiply(M, d, there, d, towards)
    if lean > 0.0:
        if head[at.ACTIVE] <= d:  # else it is written
            write_gram(here, head[at.ACTIVE], d)
        gram, floor = matrix(here, at.GRAM_OF_G), so_far[at.ALIKE] * so_far[at.SIZE] * so_far[at.SIZE]
        along(here, vector(here, at.LAST), d, there)
        for p in range(d):
            row, own = M[p], E[p]
            copy_line(row, padded(d), own)
            add_scaled(gram[p], 1.0, padded(d), own)
            add_scaled(own, lean * lean, padded(d), row)
            row[p] += lean * lean * floor
            towards[p] += lean * lean * (floor * there[p] + product(own, there, d))
        if head[at.LAGS] != 0:
            brake(here, k, d)
    unit = so_far[at.SIZE] * so_far[at.SIZE]
    firm = so_far[at.FIRM] * unit
    if firm > 0.0:  # towards the aim of the first level, whose damping the levels below would else undo
        along(here, matrix(here, at.AIMS)[head[at.TOP]], d, there)
        brake_all(here, d, firm)
    for p in range(d):
        trace += M[p][p]
    least = DECIDED * unit if trace > 0.0 and lean == 0.0 else 0.0
    for p in range(d):
        M[p][p] += REGULAR * trace + least
    return trace > 0.0


@inner
def stay(here, k, d):
    """Write M = K = I and ``mu`` = Z x: a block that asks for nothing on level k stays at the x of the level above.

    Its soft rows have no weight there.
    """
    K, M = matrix(here, at.U), matrix(here, at.M)
    for p in range(d):
        for q in range(d):
            K[p][q] = M[p][q] = 1.0 if p == q else 0.0
    along(here, matrix(here, at.POINTS)[k - 1], d, vector(here, at.MU))
    return True


@inner
def factor(here, k, d):
    """Write K, K' K = M of :func:`draw`, for the block's rows of damping on level k; whether there are any."""
    head, so_far = ints(here, 0, plain.HEAD), vector(here, at.SO_FAR)
    if head[at.OPEN] == 0:
        return False
    if head[at.ACTIVE] == 0 and matrix(here, at.NORMS)[k][head[at.NUMBER]] == 0.0:
        return stay(here, k, d)
    some = draw(here, k, d, so_far[at.LEAN])
    return some and upper_factor(matrix(here, at.M), matrix(here, at.U), d, vector(here, at.VALUES))


@inner
def write_damping(here, k, first):
    r"""Write a block's rows of damping: :math:`(y - r)^T L P L^T (y - r) + |y - v|_W^2`, where y = Z x.

    They are those of ``damped`` from `first` on: as many as the block has variables. Not zero are as many as there are
    directions left, the rows of K Z with the K of :func:`factor`, which lies in U; ``mu`` are their bounds. Returns
    whether there are any.
    """
    n, K = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.U)
    towards, damped, d = vector(here, at.MU), matrix(here, at.DAMPED), ints(here, 0, plain.HEAD)[at.LEFT]
    some = factor(here, k, d)
    for p in range(len(matrix(here, at.BASIS))):
        own = damped[k * n + first + p]
        clear_line(own, padded(n + 1))
        if some and p < d:
            row = K[p]
            add_along(here, row, p, d, own)
            own[n] = towards[p] = towards[p] / row[p]
            for q in range(p + 1, d):  # K' to the left
                towards[q] -= own[n] * row[q]
    return some


@inner
def write_stage(here, k):
    """Write the stage of level k, as :func:`.curved.prepare` has decided in every block: see the module."""
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
    norms, block_of = matrix(here, at.NORMS)[k], marks(here, at.BLOCK_OF)
    for level in range(k):
        for i in range(ptr[level], ptr[level + 1] if curved[level] != 0 else ptr[level]):
            own, soft = floats(address, row * n, n), state[i] == at.SOFT
            scale = stiffness[i] * norms[block_of[i]] if soft else 0.0
            for j in range(n):
                own[j] = scale * rows[i][j] if soft else 0.0
            weights[place] = 1.0
            lower[place] = scale * reached[i] if soft else -math.inf
            upper[place] = scale * reached[i] if soft else math.inf
            place, row = place + 1, row + 1
    for p in range(n):
        own, damped = floats(address, row * n, n), matrix(here, at.DAMPED)[k * n + p]
        for j in range(n):
            own[j] = damped[j]
        weights[place], lower[place], upper[place] = 1.0, damped[n], damped[n]
        place, row = place + 1, row + 1
