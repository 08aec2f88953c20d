r"""The rows that a curved level hands over to the levels below: *held* rows, which are hard, and *soft* rows.

If nothing of a level is damped, all its rows are held. Else they are replaced by combinations. With
:math:`G = U S V^T`, the rows along Z, and D, the damping there, the eigenvectors of :math:`S^{-1} V^T D V S^{-1}`
combine the rows; an eigenvalue is the ratio of the part of its combination that is missed to the part that is met. The
stiffness of a soft row is inverse to the root of this ratio, and to the length of the row in the metric of the soft
rows above: it grows as the damping fades, and no row jumps where another one is held.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .compile import inner, integer
from .curved_rows import VIOLATED, measured, write_weighted
from .definite import cholesky
from .directions import along
from .lines import product
from .memory import ints, marks, matrix, vector
from .orthogonal import length, padded
from .single_lines import clear_line
from .sums import add_rows, add_to_each, multiply
from .symmetric import eigen

#: Stiffness of a soft row that is half met; and the stiffness above which a row is held instead: levels below move it
#: by the inverse of its square.
STIFF, STIFFEST = 30.0, 80.0
#: The least share of a row's squared length that must be left of it across the rows before it to invert a Gram matrix.
WELL = 1e-7
#: A row, or a combination of rows, that is shorter than this share is dropped as round-off.
NONE = 1e-9


@inner
def set_aside(here, row, d):
    """Turn the d directions Z so that the last one is along `row` (d,), and only the first d - 1 are left.

    Uses the reflection :math:`I - 2 u u^T / |u|^2` that turns the last direction onto the row; `row` is overwritten.
    """
    n, basis, turned = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS), vector(here, at.REACH)
    size, total = length(row, d), 0.0
    row[d - 1] += size if row[d - 1] > 0.0 else -size
    clear_line(turned, padded(n))
    add_rows(row, basis, 0, d, n, turned)
    for p in range(d):
        total += row[p] * row[p]
    for p in range(d):
        row[p] *= -2.0 / total
    add_to_each(basis, d, row, turned, n)


@inner
def hold(here, row, d):
    """Hold a row (n,) on the levels below: take its direction out of Z; returns how many directions are left."""
    left = vector(here, at.MU)
    along(here, row, d, left)
    if d > 0 and length(left, d) > NONE * length(row, ints(here, 0, plain.HEAD)[plain.N]):
        set_aside(here, left, d)
        return d - 1
    return d


@inner
def combine_nothing(here, k, i):
    """Set the combination of rows of level k that replaces row i, ``combined[i]``, to zero."""
    ptr, own = marks(here, plain.PTR), matrix(here, at.COMBINED)[i]
    for p in range(ptr[k + 1] - ptr[k]):
        own[p] = 0.0


@inner
def gives_way(here):
    """Whether anything of the level is damped, or pushed by soft rows above."""
    return ints(here, 0, plain.HEAD)[at.STIFF] != 0 or vector(here, at.SO_FAR)[at.STRENGTH] > 0.0


@inner
def freeze(here, k, count, d, x, size):
    """Hand the `count` active rows of level k, solved by x, to the levels below; returns how many directions are left.

    A level with inequalities, SPARED, or of which nothing is damped: its equalities and violated rows are held, one by
    one. Else: :func:`soften`. `size` is the norm of the rows.
    """
    n, ids, state = ints(here, 0, plain.HEAD)[plain.N], marks(here, at.IDS), marks(here, at.STATE)
    lower, upper, weights = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, plain.WEIGHTS)
    reached, rows = vector(here, at.VALUE), matrix(here, at.ROW)
    one_by_one = marks(here, at.CURVED)[k] == at.SPARED or not gives_way(here)
    for r in range(count):
        one_by_one = one_by_one or lower[ids[r]] != upper[ids[r]]
    if not one_by_one:
        return soften(here, k, count, d, x, size)
    mine, of = marks(here, at.OWN), marks(here, at.OWN_OF)
    for p in range(of[k], of[k + 1]):  # those too that have no error now, if this x violates them
        i = mine[p]
        write_weighted(here, i, rows[i])
        value = product(rows[i], x, n)
        low, high = weights[i] * lower[i], weights[i] * upper[i]
        off = max(value - high, low - value)
        if lower[i] == upper[i] or off > VIOLATED * (abs(value) + off):
            combine_nothing(here, k, i)
            matrix(here, at.COMBINED)[i][i - marks(here, plain.PTR)[k]] = 1.0
            state[i], reached[i] = at.HELD, value
            d = hold(here, rows[i], d)
    return d


@inner
def invert(M, G, L, half, count, d, least):
    """Write M^-1 G, of shape (count, d), to `half`, and the identity to L; False if M = G G' is ill-conditioned.

    A row that is not longer than `least`, as one that is held above already, is round-off, of whatever direction.
    """
    if not cholesky(M, L, count):
        return False
    for r in range(count):
        if not M[r][r] > least * least or L[r][r] * L[r][r] < WELL * M[r][r]:
            return False
    for r in range(count):
        row, over = half[r], 1.0 / L[r][r]
        for p in range(d):
            row[p] = over * G[r][p]
        for q in range(r):
            other, part = half[q], over * L[r][q]
            for p in range(d):
                row[p] -= part * other[p]
    for r in range(count - 1, -1, -1):
        row, over = half[r], 1.0 / L[r][r]
        for p in range(d):
            row[p] *= over
        for q in range(r):
            other, part = half[q], L[r][q]
            for p in range(d):
                other[p] -= part * row[p]
    for r in range(count):
        for q in range(count):
            L[r][q] = 1.0 if q == r else 0.0
    return True


@inner
def separate(here, count, d, size):
    r"""Write combinations of rows U, and the x along Z that each of them alone is one for, to HALF; returns how many.

    The rows themselves and :math:`(G G^T)^{-1} G`, if :math:`G G^T` is well conditioned. Else the left singular vectors
    of G, and :math:`S^{-1} V^T`, at most d: :math:`G G^T` has further eigenvalues, which are round-off, and their
    combinations are the last rows of U. A singular value is the length of its combination of rows; the root of an
    eigenvalue is less accurate by orders of magnitude.
    """
    G, M, U = matrix(here, measured(here, count, d)), matrix(here, at.M), matrix(here, at.U)
    half, values = matrix(here, at.HALF), vector(here, at.VALUES)
    for r in range(count):
        multiply(G, r + 1, G[r], d, M[r])
        for q in range(r):
            M[q][r] = M[r][q]
    if count <= d and invert(M, G, U, half, count, d, NONE * size):
        return integer(count)
    eigen(M, U, values, count, 0.0)
    rank = integer(0)
    for r in range(count):
        own, row, larger = U[r], half[rank], integer(0)
        for i in range(count):
            if values[i] > values[r] or (values[i] == values[r] and i < r):
                larger += 1
        if larger >= d:
            continue
        clear_line(row, padded(d))
        add_rows(own, G, 0, count, d, row)
        reach = length(row, d)
        if not reach > NONE * size:  # nor where it is no number
            continue
        for p in range(d):
            row[p] /= reach * reach
        first = U[rank]
        for i in range(count):
            first[i], own[i] = own[i], first[i]
        rank += 1
    return rank


@inner
def compliance(here, count, d, size):
    """Write combinations Q of the rows, and as ``values`` the eigenvalues of S^-1 V' D V S^-1, where G = U' S V'.

    D is the damping of the level plus the effect of the soft rows above. Returns how many combinations there are that x
    along Z moves; the others follow in Q.
    """
    P, L, M = matrix(here, at.P), matrix(here, at.METRIC), matrix(here, at.M)
    U, Q, E, half, values = (
        matrix(here, at.U),
        matrix(here, at.Q),
        matrix(here, at.E),
        matrix(here, at.HALF),
        vector(here, at.VALUES),
    )
    rank, moved = separate(here, count, d, size), vector(here, at.MU)
    damped, stiff = vector(here, at.SO_FAR)[at.STRENGTH] > 0.0, ints(here, 0, plain.HEAD)[at.STIFF] != 0
    for r in range(rank if stiff else 0):  # D = P + |J|^2 (1 - L^-1 L^-T): rows times L^-1, to E
        row, own = E[r], half[r]
        for p in range(d):
            row[p] = own[p]
        for p in range(d - 1, -1, -1):
            factor = L[p]
            row[p] /= factor[p]
            for q in range(p):
                row[q] -= row[p] * factor[q]
    for r in range(rank):
        for j in range(d):
            moved[j] = size * size * half[r][j] if stiff else 0.0
        if damped:
            add_rows(half[r], P, 0, d, d, moved)
        multiply(half, r + 1, moved, d, M[r])
        if stiff:
            multiply(E, r + 1, E[r], d, moved)
            for q in range(r + 1):
                M[r][q] -= size * size * moved[q]
        for q in range(r):
            M[q][r] = M[r][q]
    eigen(M, P, values, rank, 0.0)  # P is no longer needed
    for r in range(rank):
        row = Q[r]
        clear_line(row, padded(count))
        add_rows(P[r], U, 0, rank, count, row)
    for r in range(rank, count):
        for i in range(count):
            Q[r][i] = U[r][i]
    return rank


@inner
def combined_length(here, combination, count, d):
    """The length of a combination of the `count` rows G, along d directions in the metric of the soft rows above."""
    G = matrix(here, at.G if ints(here, 0, plain.HEAD)[at.STIFF] == 0 else at.G_MEASURED)
    along_all = matrix(here, at.HALF)[0]
    clear_line(along_all, padded(d))
    add_rows(combination, G, 0, count, d, along_all)
    return length(along_all, d)


@inner
def soften(here, k, count, d, x, size):
    """:func:`freeze` for a level of equalities: its rows are combined by :func:`compliance`, each then held or soft.

    What no direction moves is held, too: a bound above may have taken the direction, and levels below may leave it.
    """
    n, ids, state = ints(here, 0, plain.HEAD)[plain.N], marks(here, at.IDS), marks(here, at.STATE)
    reached, rows, stiffness = vector(here, at.VALUE), matrix(here, at.ROW), vector(here, at.STIFFNESS)
    J, left, Q, soft = matrix(here, at.J), vector(here, at.MU), matrix(here, at.Q), vector(here, at.VALUES)
    rank, first, directions = compliance(here, count, d, size), marks(here, plain.PTR)[k], d
    for r in range(count):
        i = ids[r]
        row, own = rows[i], matrix(here, at.COMBINED)[i]
        combine_nothing(here, k, i)
        clear_line(row, padded(n))
        for p in range(count):
            own[ids[p] - first] = Q[r][p]
        add_rows(Q[r], J, 0, count, n, row)
        reached[i] = product(row, x, n)
        along(here, row, d, left)
        if r < rank and soft[r] > (STIFF / STIFFEST) ** 2 and d > 0 and length(left, d) > NONE * size:
            long = combined_length(here, Q[r], count, directions)
            state[i], stiffness[i] = at.SOFT, STIFF / (math.sqrt(soft[r]) * long)
            continue
        state[i] = at.HELD if length(row, n) > NONE * size else at.LOST
        if r < rank and d > 0 and length(left, d) > NONE * size:
            set_aside(here, left, d)
            d -= 1
    return d
