r"""How a curved level is damped: from what its linearisation leaves out.

A level asks for :math:`J x = b` because something is off by :math:`e`, and J is how that changes: a Gauss-Newton step,
which leaves out how J itself changes. Where e is large beside the smallest singular value of J, such steps overshoot,
tick after tick. What is left out are the curvatures H of the own rows, contracted with their errors, and of the rows
that are held above, contracted with what those push with:

.. math:: S_o = -\sum_i e_i H_i, \qquad S_u = \sum_j \mu_j H_j, \qquad \mu = \arg\min |J_a^T \mu - J^T e|.

See :mod:`hqp.damping.curved` for what becomes of them.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .call import called
from .compile import inner, integer
from .memory import floats, ints, marks, matrix, vector
from .symmetric import eigen

#: A combination of rows that is so much shorter than the longest is none.
NONE = 1e-7
#: Damping that is so much smaller than the squares of the rows is round-off.
ROUND_OFF = 1e-12


@inner
def gather(here, k):
    """The rows of level k that are in play, weighted, to J, and the weights of their curvatures: how many."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    ptr, col, row_of, ids = marks(here, plain.PTR), marks(here, plain.COL), marks(here, plain.ROW_OF), marks(here, at.IDS)
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
def project(here, count, c):
    """What V[:c] leaves of J, to G, its Gram matrix, and that one's eigenvalues and eigenvectors: the largest."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    V, J, G, gram = matrix(here, at.V), matrix(here, at.J), matrix(here, at.G), matrix(here, at.GRAM)
    Q, squares = matrix(here, at.Q), vector(here, at.SQUARES)
    for i in range(count):
        row, own = G[i], J[i]
        for j in range(n):
            row[j] = own[j]
        for _ in range(2):
            for q in range(c):
                direction, along = V[q], 0.0
                for j in range(n):
                    along += row[j] * direction[j]
                for j in range(n):
                    row[j] -= along * direction[j]
        for r in range(i + 1):
            other, total = G[r], 0.0
            for j in range(n):
                total += row[j] * other[j]
            gram[i][r] = gram[r][i] = total
    eigen(gram, Q, squares, count)
    largest = 0.0
    for i in range(count):
        largest = max(largest, squares[i])
    return largest


@inner
def multipliers(here, k, count, c):
    """What the rows held above push with, as weights of their curvatures: False if nothing does."""
    head, V, T = ints(here, 0, plain.HEAD), matrix(here, at.V), matrix(here, at.T)
    n, ptr = head[plain.N], marks(here, plain.PTR)
    mu, J, ids = vector(here, at.MU), matrix(here, at.J), marks(here, at.IDS)
    wanted, weights, errors = vector(here, at.WANTED), vector(here, plain.WEIGHTS), vector(here, at.ERRORS)
    combined, pull = matrix(here, at.COMBINED), vector(here, at.VALUES)
    for j in range(n):
        pull[j] = 0.0
    for r in range(count):
        i, row = ids[r], J[r]
        for j in range(n):
            pull[j] += weights[i] * errors[i] * row[j]
    some = 0.0
    for q in range(c - 1, -1, -1):
        direction, total = V[q], 0.0
        for j in range(n):
            total += direction[j] * pull[j]
        for r in range(q + 1, c):
            total -= T[r][q] * mu[r]
        mu[q] = total / T[q][q]
        some += abs(mu[q])
    for i in range(ptr[k]):
        wanted[i] = 0.0
    for q in range(c):
        own = combined[q]
        for i in range(ptr[k]):
            wanted[i] += mu[q] * own[i]
    return some > 0.0


@inner
def contract(here, first, end):
    """The curvatures of levels first .. end, contracted with the weights that are wanted, to S."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    calls, of, wanted, S = marks(here, at.CALLS), marks(here, at.CALLS_OF), vector(here, at.WANTED), matrix(here, at.S)
    for i in range(n):
        row = S[i]
        for j in range(n):
            row[j] = 0.0
    for p in range(of[first], of[end]):
        weights, begin, count = floats(calls[5 * p + 2], 0, calls[5 * p + 4]), calls[5 * p + 3], calls[5 * p + 4]
        some = False
        for i in range(count):
            weights[i] = wanted[begin + i]
            some = some or weights[i] != 0.0
        if some:
            called(calls[5 * p], calls[5 * p + 1])


@inner
def within(here, c):
    """Project S on what V[:c] leaves, from both sides; the square of its Frobenius norm."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    S, V = matrix(here, at.S), matrix(here, at.V)
    for i in range(n):
        row = S[i]
        for q in range(c):
            direction, along = V[q], 0.0
            for j in range(n):
                along += row[j] * direction[j]
            for j in range(n):
                row[j] -= along * direction[j]
    total = 0.0
    for q in range(c):
        direction = V[q]
        for j in range(n):
            along = 0.0
            for i in range(n):
                along += S[i][j] * direction[i]
            for i in range(n):
                S[i][j] -= along * direction[i]
    for i in range(n):
        row, other = S[i], 0.0
        for j in range(i + 1):
            other = 0.5 * (row[j] + S[j][i])
            row[j] = S[j][i] = other
            total += other * other if j == i else 2.0 * other * other
    return total


@inner
def add_bent(here, positive, negative):
    """Add to E what S is along its eigenvectors, in size, times these shares."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    S, U, E, values = matrix(here, at.S), matrix(here, at.U), matrix(here, at.E), vector(here, at.VALUES)
    eigen(S, U, values, n)
    for p in range(n):
        size = positive * values[p] if values[p] > 0.0 else -negative * values[p]
        if size == 0.0:
            continue
        direction = U[p]
        for i in range(n):
            row, part = E[i], size * direction[i]
            for j in range(n):
                row[j] += part * direction[j]


@inner
def bend(here, k, count, c, largest):
    """How level k is to be damped: along the rows of U, by their VALUES; False if not at all."""
    head = ints(here, 0, plain.HEAD)
    n, U, values = head[plain.N], matrix(here, at.U), vector(here, at.VALUES)
    E, G, squares = matrix(here, at.E), matrix(here, at.G), vector(here, at.SQUARES)
    smallest = largest
    for r in range(count):
        if squares[r] > NONE * NONE * largest:
            smallest = min(smallest, squares[r])
    for i in range(n):
        row = E[i]
        for j in range(n):
            row[j] = 0.0
    contract(here, k, k + 1)
    size = math.sqrt(within(here, c))
    if size > 0.0:
        add_bent(here, 1.0, math.sqrt(vector(here, at.SHARES)[k]))
    if c > 0 and multipliers(here, k, count, c):
        contract(here, 0, k)
        more = math.sqrt(within(here, c))
        if more > 0.0:
            size += more
            add_bent(here, 1.0, 1.0)
    if size <= smallest:
        return False
    for r in range(count):
        own = G[r]
        for i in range(n):
            row = E[i]
            for j in range(n):
                row[j] -= own[i] * own[j]
    eigen(E, U, values, n)
    some = False
    for p in range(n):
        if values[p] > ROUND_OFF * largest:
            some = True
        else:
            values[p] = 0.0
    return some
