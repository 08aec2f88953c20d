r"""How a curved level is damped: from what its linearisation leaves out.

A level asks for :math:`J x = b` because something is off by :math:`e`, and J is how that changes: a Gauss-Newton step,
which leaves out how J itself changes. Where e is large beside the square of the smallest singular value of J, such
steps overshoot, tick after tick. What is left out are the curvatures H of the own rows, contracted with their errors,
and of the rows that are held above, contracted with what those push with:

.. math:: S_o = -\sum_i e_i H_i, \qquad S_u = \sum_j \mu_j H_j, \qquad \mu = \arg\min |J_a^T \mu - J^T e|.

All of that in the directions Z that the rows held above leave. See :mod:`hqp.solver.curved` for the law.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .call import called
from .compile import inner, integer
from .memory import floats, ints, marks, matrix, vector
from .symmetric import eigen, smallest

#: Damping that is so much smaller than the square of the longest row is round-off.
ROUND_OFF = 1e-12


@inner
def gather(here, k):
    """The rows of level k that are in play, weighted, to J, and the weights of their curvatures: how many."""
    head, ptr, col = ints(here, 0, plain.HEAD), marks(here, plain.PTR), marks(here, plain.COL)
    n, row_of, ids = head[plain.N], marks(here, plain.ROW_OF), marks(here, at.IDS)
    lower, upper, weights = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, plain.WEIGHTS)
    errors, wanted = vector(here, at.ERRORS), vector(here, at.WANTED)
    A, J = matrix(here, plain.A), matrix(here, at.J)
    count = integer(0)
    for i in range(ptr[k], ptr[k + 1]):
        wanted[i] = 0.0
        if not (lower[i] == upper[i] or (errors[i] != 0.0 and (lower[i] > -math.inf or upper[i] < math.inf))):
            continue
        row = J[count]
        if col[i] >= 0:
            for j in range(n):
                row[j] = 0.0
            row[col[i]] = weights[i]
        else:
            own = A[row_of[i]]
            for j in range(n):
                row[j] = weights[i] * own[j]
        wanted[i] = -weights[i] * weights[i] * errors[i]
        ids[count] = i
        count += 1
    return count


@inner
def project(here, count, d):
    """J along the directions Z that are left, to G; a bound from below for the square of its smallest singular value.

    And the square of its longest row.
    """
    n, basis = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS)
    J, G, gram = matrix(here, at.J), matrix(here, at.G), matrix(here, at.E)
    longest, few = 0.0, count <= d
    for i in range(count):
        row, own = G[i], J[i]
        for p in range(d):
            direction, along = basis[p], 0.0
            for j in range(n):
                along += own[j] * direction[j]
            row[p] = along
    side = count if few else d
    for i in range(side):
        for r in range(i + 1):
            total = 0.0
            if few:
                one, other = G[i], G[r]
                for p in range(d):
                    total += one[p] * other[p]
            else:
                for p in range(count):
                    total += G[p][i] * G[p][r]
            gram[i][r] = gram[r][i] = total
        longest = max(longest, gram[i][i])
    return smallest(gram, matrix(here, at.U), side), longest


@inner
def multipliers(here, k, count, d):
    """The weights of the curvatures above level k, by what the rows held there push with; False if they do not."""
    head, basis, T = ints(here, 0, plain.HEAD), matrix(here, at.BASIS), matrix(here, at.T)
    n, first, end = head[plain.N], marks(here, plain.PTR)[head[at.TOP]], marks(here, plain.PTR)[k]
    mu, J, ids = vector(here, at.MU), matrix(here, at.J), marks(here, at.IDS)
    wanted, weights, errors = vector(here, at.WANTED), vector(here, plain.WEIGHTS), vector(here, at.ERRORS)
    combined, pull, some = matrix(here, at.COMBINED), vector(here, at.VALUES), False
    for j in range(n):
        pull[j] = 0.0
    for r in range(count):
        i, row = ids[r], J[r]
        for j in range(n):
            pull[j] += weights[i] * errors[i] * row[j]
    for i in range(first, end):
        wanted[i] = 0.0
    for q in range(n - d - 1, -1, -1):  # V are the last rows of the basis, the first of them last
        direction, total = basis[n - 1 - q], 0.0
        for j in range(n):
            total += direction[j] * pull[j]
        for r in range(q + 1, n - d):
            total -= T[r][q] * mu[r]
        mu[q] = total / T[q][q]
        some = some or mu[q] != 0.0
        own = combined[q]
        for i in range(first, end):
            wanted[i] += mu[q] * own[i]
    return some


@inner
def contract(here, first, end):
    """The curvatures of levels first .. end, contracted with the weights that are wanted, to S; its norm."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    calls, of, wanted, S = marks(here, at.CALLS), marks(here, at.CALLS_OF), vector(here, at.WANTED), matrix(here, at.S)
    for i in range(n):
        row = S[i]
        for j in range(n):
            row[j] = 0.0
    some = False
    for p in range(of[first], of[end]):
        begin, count = calls[5 * p + 3], calls[5 * p + 4]
        weights, needed = floats(calls[5 * p + 2], 0, count), False
        for i in range(count):
            weights[i] = wanted[begin + i]
            needed = needed or weights[i] != 0.0
        if needed:
            called(calls[5 * p], calls[5 * p + 1])
            some = True
    total = 0.0
    if some:
        for i in range(n):
            row = S[i]
            for j in range(n):
                total += row[j] * row[j]
    return math.sqrt(total)


@inner
def add_bent(here, d, positive, negative):
    """Add to E what S is in the directions that are left, each of its eigenvectors by its size, times these shares."""
    n, basis = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS)
    S, U, E, values = matrix(here, at.S), matrix(here, at.U), matrix(here, at.E), vector(here, at.VALUES)
    M, half = matrix(here, at.M), matrix(here, at.HALF)
    for p in range(d):
        direction, row = basis[p], half[p]
        for j in range(n):
            row[j] = 0.0
        for i in range(n):
            other, share = S[i], direction[i]
            for j in range(n):
                row[j] += share * other[j]
    for p in range(d):
        for q in range(p + 1):
            direction, row, total = basis[q], half[p], 0.0
            for j in range(n):
                total += row[j] * direction[j]
            M[p][q] = M[q][p] = total
    eigen(M, U, values, d)
    for p in range(d):
        size = positive * values[p] if values[p] > 0.0 else -negative * values[p]
        direction = U[p]
        for i in range(d):
            row, part = E[i], size * direction[i]
            for j in range(d):
                row[j] += part * direction[j]


@inner
def bend(here, k, count, d, least, longest):
    """How level k is to be damped: along the rows of U, directions of Z, by their VALUES. False if not at all."""
    head, U, values = ints(here, 0, plain.HEAD), matrix(here, at.U), vector(here, at.VALUES)
    E, G, kept = matrix(here, at.E), matrix(here, at.G), matrix(here, at.KEPT)
    n = head[plain.N]
    own = contract(here, k, k + 1)
    more = 0.0
    if d < n and multipliers(here, k, count, d):
        if own > 0.0:  # both are needed, one after the other
            for i in range(n):
                for j in range(n):
                    kept[i][j] = matrix(here, at.S)[i][j]
        more = contract(here, head[at.TOP], k)
    if own + more <= least:
        return False
    for i in range(d):
        for j in range(d):
            E[i][j] = 0.0
    if more > 0.0:
        add_bent(here, d, 1.0, 1.0)
        if own > 0.0:
            for i in range(n):
                for j in range(n):
                    matrix(here, at.S)[i][j] = kept[i][j]
    if own > 0.0:
        add_bent(here, d, 1.0, math.sqrt(vector(here, at.SHARES)[k]))
    for r in range(count):
        row = G[r]
        for i in range(d):
            for j in range(d):
                E[i][j] -= row[i] * row[j]
    eigen(E, U, values, d)
    some = False
    for p in range(d):
        if values[p] > ROUND_OFF * longest:
            some = True
        else:
            values[p] = 0.0
    return some
