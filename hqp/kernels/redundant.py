r"""Recognises rows of a level that repeat others: a combination of rows that is constant, not only to first order.

Where a combination :math:`u^T J` of rows of level k is one of rows held above, :math:`u^T J = c^T J_a`, the smallest
singular value of the level is zero for one of two reasons. Either the arm is singular: the combination has a curvature,
and its linearisation misleads. Or the rows say again what others say, as the position in a pose below a position task,
or the corners of a sole: then the curvatures balance too,

.. math:: \sum_i u_i H_i = \sum_j c_j H_j,

and the singular value says nothing of the arm. One combination u with fixed, unequal weights is tested for all, as the
difference of the two sides is linear in u. If a row in it has a curvature that is not known, such as that of a wheel
that rolls, its combination is taken for redundant: damping is for singularities that are known.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .bend import contract, multipliers
from .compile import inner, integer
from .curved_rows import gather
from .memory import ints, marks, matrix, vector
from .symmetric import eigen

#: Squared singular values up to this share of the squared length of the longest row may be those of redundant rows.
REPEATED = 1e-10
#: Curvatures balance up to this share of the length of rows and combination. (Where a direction is held above and a
#: whole orientation below, they do so but for the error that is left.)
BALANCED = 1e-2
#: The weights in the combination that is tested are 1 plus the fractions of multiples of this, the golden ratio.
UNEQUAL = 0.6180339887498949


@inner
def weight_of(r):
    """The weight of row r in the combination that is tested, from 1 to 2."""
    share = UNEQUAL * (r + 1)
    return 1.0 + share - math.floor(share)


@inner
def longest(here, count):
    """The squared length of the longest of the `count` rows J."""
    n, J, most = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), 0.0
    for r in range(count):
        total = 0.0
        for j in range(n):
            total += J[r][j] * J[r][j]
        most = max(most, total)
    return most


@inner
def has_unknown(here, k):
    """Whether a row whose curvature is not known has a weight in ``wanted``, of levels up to k."""
    head, of, unknown = ints(here, 0, plain.HEAD), marks(here, at.OWN_OF), marks(here, at.UNKNOWN)
    wanted, weights, found = vector(here, at.WANTED), vector(here, plain.WEIGHTS), False
    for p in range(of[head[at.TOP]], of[k + 1]):
        i = marks(here, at.OWN)[p]
        found = found or (unknown[i] != 0 and abs(wanted[i]) > BALANCED * weights[i])
    return found


@inner
def across(here, rows, first, end, n):
    """The Frobenius norm of S (n, n) across the orthonormal rows first .. end - 1, in their complement.

    S is overwritten.
    """
    S, norm = matrix(here, at.S), 0.0
    for turn in range(2):  # S (I - V'V), then the same of its transpose
        for i in range(n):
            own = S[i]
            for q in range(first, end):
                row, along = rows[q], 0.0
                for j in range(n):
                    along += own[j] * row[j]
                for j in range(n):
                    own[j] -= along * row[j]
        for i in range(n if turn == 0 else 0):
            for j in range(i):
                S[i][j], S[j][i] = S[j][i], S[i][j]
    for i in range(n):
        for j in range(n):
            norm += S[i][j] * S[i][j]
    return math.sqrt(norm)


@inner
def least_apart(here, k, count, d, above, least):
    """The smallest squared singular value of G that is not one of rows which repeat others; infinite if all do.

    `least` is a lower bound of the smallest of all, returned where it is not close to zero, and where the rows are
    singular.
    """
    whole = longest(here, count)
    if least > REPEATED * whole:
        return least
    n, J, G, ids = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), matrix(here, at.G), marks(here, at.IDS)
    M, U, values, u = matrix(here, at.M), matrix(here, at.U), vector(here, at.VALUES), vector(here, at.MU)
    pull, wanted, weights = vector(here, at.PULL), vector(here, at.WANTED), vector(here, plain.WEIGHTS)
    for r in range(count):
        u[r] = weight_of(r)
        for q in range(r + 1):
            total = 0.0
            for p in range(d):
                total += G[r][p] * G[q][p]
            M[r][q] = M[q][r] = total
    eigen(M, U, values, count, 0.0)
    own, repeating = math.inf, integer(0)
    for p in range(count):
        if values[p] <= REPEATED * whole:
            repeating += 1
            continue
        own, along = min(own, values[p]), 0.0
        for r in range(count):
            along += U[p][r] * u[r]
        for r in range(count):
            u[r] -= along * U[p][r]
    if repeating == 0:
        return own
    size = 0.0
    for j in range(n):
        pull[j] = 0.0
    for r in range(count):
        size += u[r] * u[r]
        wanted[ids[r]] = -u[r] * weights[ids[r]]
        for j in range(n):
            pull[j] += u[r] * J[r][j]
    multipliers(here, k, above, 0.0)
    most = BALANCED * math.sqrt(whole * size)
    balanced = has_unknown(here, k) or contract(here, ints(here, 0, plain.HEAD)[at.TOP], k + 1) <= most
    balanced = balanced or across(here, matrix(here, at.BASIS), d, len(matrix(here, at.BASIS)), n) <= most
    gather(here, k)  # as it was
    return own if balanced else least
