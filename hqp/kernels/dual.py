r"""The active rows of a weighted problem, by a dual active set.

With softness :math:`\delta_i > 0` instead of priorities the rows of a hierarchy become one strictly convex problem
that always has an answer,

.. math:: \min_x \tfrac12 \|x - x_0\|^2 + \sum_i \frac{w_i^2}{2 \delta_i},
   \qquad (A_W A_W^T + \operatorname{diag} \delta_W)\, \lambda = A_W x_0 - b_W, \qquad x = x_0 - A_W^T \lambda,

with W the rows at a bound; their slacks are :math:`w = \delta \lambda`. The row that is violated most joins W, and
rows whose multiplier comes to push the wrong way leave it (Goldfarb and Idnani 1983; in this form Arnstrom, Bemporad
and Axehill 2022). Joining appends one row to a Cholesky factor. What the softness is, is a :mod:`.guess`.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, matrix, vector
from .sweep import INACTIVE, LOWER, UPPER

#: What counts as violated, relative to the bound and the length of x.
VIOLATED = 1e-9
#: Rows join together if they are violated by at least this share of the worst.
SHARE = 0.95


@inner
def products(rows, c, out, here):
    """Inner products of row number c of W with those before it."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    col, row_of = marks(here, at.COL), marks(here, at.ROW_OF)
    norm = vector(here, at.NORM)
    B = matrix(here, at.B)
    i = rows[c]
    for r in range(c):
        other = rows[r]
        total = 0.0
        if col[i] >= 0 and col[other] >= 0:
            if col[i] == col[other]:
                total = norm[i] * norm[other]
        elif col[i] >= 0:
            total = norm[i] * B[row_of[other]][col[i]]
        elif col[other] >= 0:
            total = norm[other] * B[row_of[i]][col[other]]
        else:
            mine, theirs = B[row_of[i]], B[row_of[other]]
            for j in range(n):
                total += mine[j] * theirs[j]
        out[r] = total


@inner
def settle(here, end, count, known):
    """Solve the weighted problem of the rows before `end`.

    W has `count` rows, of which the first `known` are in the Gram matrix.

    Returns
    -------
    count : int
        Rows of W then, or -1 if there are more than fit.
    """
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    col, row_of, side = marks(here, at.COL), marks(here, at.ROW_OF), marks(here, at.SIDE)
    rows, held = marks(here, at.MEMBERS), marks(here, at.DECIDED)
    lo, hi, norm, x0 = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.X0)
    x, soft, multiplier = vector(here, at.X), vector(here, at.VALUE), vector(here, at.W)
    goal, excess, inverse = vector(here, at.LOW), vector(here, at.SLOPE), vector(here, at.DIAGONAL)
    z, d = vector(here, at.Z), vector(here, at.WANTED)
    B, gram, chol = matrix(here, at.B), matrix(here, at.GRAM), matrix(here, at.CHOLESKY)
    across = matrix(here, at.ACROSS)
    most = len(rows)
    entered = integer(0)  # rows of W that are in the factor of the Gram matrix
    for j in range(n):
        x[j] = x0[j]
    for _ in range(4 * most + 4):
        for c in range(known, count):
            products(rows, c, gram[c], here)
        known = count
        for c in range(entered, count):
            i = rows[c]
            mine, factor = gram[c], chol[c]
            right = -goal[i]
            if col[i] >= 0:
                right += norm[i] * x0[col[i]]
            else:
                given = B[row_of[i]]
                for j in range(n):
                    right += given[j] * x0[j]
            square = norm[i] * norm[i] + soft[i]
            for r in range(c):
                factor[r] = mine[r]
            for r in range(c):
                entry = factor[r] * inverse[r]
                below = across[r]
                for q in range(r + 1, c):
                    factor[q] -= entry * below[q]
                factor[r] = below[c] = entry
                square -= entry * entry
                right -= entry * z[r]
            inverse[c] = 1.0 / math.sqrt(max(square, 0.1 * soft[i], 1e-15 * norm[i] * norm[i]))
            z[c] = right * inverse[c]
        entered = count

        # What W wants, and how far on the way there all multipliers push the right way.
        for c in range(count):
            d[c] = z[c]
        for c in range(count - 1, -1, -1):
            factor = chol[c]
            d[c] *= inverse[c]
            for r in range(c):
                d[r] -= factor[r] * d[c]
        reach, leaves = 1.0, -1
        for c in range(count):
            i = rows[c]
            if held[i] == 0 and d[c] * side[i] < 0.0:
                ratio = multiplier[i] / (multiplier[i] - d[c])
                if ratio < reach:
                    reach, leaves = ratio, c
        for c in range(count):
            i = rows[c]
            multiplier[i] += reach * (d[c] - multiplier[i])
        if leaves >= 0:
            side[rows[leaves]] = INACTIVE
            multiplier[rows[leaves]] = 0.0
            for c in range(leaves, count - 1):
                rows[c] = rows[c + 1]
                mine, next_one = gram[c], gram[c + 1]
                for r in range(leaves):
                    mine[r] = next_one[r]
                for r in range(leaves, c):
                    mine[r] = next_one[r + 1]
            count -= 1
            known, entered = count, leaves
            continue

        # The row that is violated most joins.
        for j in range(n):
            x[j] = x0[j]
        for c in range(count):
            i = rows[c]
            if col[i] >= 0:
                x[col[i]] -= multiplier[i] * norm[i]
            else:
                given, much = B[row_of[i]], multiplier[i]
                for j in range(n):
                    x[j] -= much * given[j]
        size = 0.0
        for j in range(n):
            size = max(size, abs(x[j]))
        worst = 0.0
        for i in range(end):
            excess[i] = 0.0
            if side[i] != INACTIVE or norm[i] == 0.0:
                continue
            if col[i] >= 0:
                value = norm[i] * x[col[i]]
            else:
                given, value = B[row_of[i]], 0.0
                for j in range(n):
                    value += given[j] * x[j]
            over, under = value - hi[i], lo[i] - value
            if over > VIOLATED * (abs(hi[i]) + norm[i] * size):
                excess[i] = over / norm[i]
            elif under > VIOLATED * (abs(lo[i]) + norm[i] * size):
                excess[i] = -under / norm[i]
            worst = max(worst, abs(excess[i]))
        if worst == 0.0:
            return count
        for i in range(end):
            if abs(excess[i]) >= SHARE * worst:
                if count == most:
                    return integer(-1)
                side[i], goal[i] = (UPPER, hi[i]) if excess[i] > 0.0 else (LOWER, lo[i])
                rows[count] = i
                count += 1
    return count
