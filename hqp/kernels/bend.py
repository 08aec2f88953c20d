r"""How strongly a curved level is damped: computed from the curvature that its linearisation leaves out.

A level asks for :math:`J x = b` to reduce an error :math:`e` whose Jacobian is J: a Gauss-Newton step, which ignores
that J changes. Where the curvature is large compared with the square of the smallest singular value of J, such steps
overshoot, tick after tick. Ignored are the curvatures H of the rows of the level, contracted with their errors, and
those of the rows above, contracted with their multipliers:

.. math:: S_o = -\sum_i e_i H_i, \qquad S_u = \sum_j \mu_j H_j, \qquad \mu = \arg\min |J_a^T \mu - J^T e|.

All this is projected onto Z, an orthonormal basis (its d rows) of the null space of the rows held above. The law itself
is :func:`bend`; `docs/theory.md` derives it.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .call import called
from .compile import inner, integer
from .memory import floats, ints, marks, matrix, vector
from .orthogonal import length
from .symmetric import cholesky, eigen, smallest

#: Up to this ratio of the curvature to the smallest squared singular value of J, the linearisation is trusted.
TRUSTED = 0.3
#: Added to the Gram matrix of the rows above, relative to its largest diagonal entry: it bounds the multipliers of
#: nearly dependent rows.
DEPENDENT = 1e-10


@inner
def gather(here, k):
    """Collect the equalities of level k, and its inequalities that have an error; returns how many these are.

    Writes their numbers ``ids``, weighted rows ``J``, the weights ``wanted`` of their curvatures (by row number), and
    ``pull`` = J' e, with the errors weighted like the rows.
    """
    head, ptr, col = ints(here, 0, plain.HEAD), marks(here, plain.PTR), marks(here, plain.COL)
    n, row_of, ids = head[plain.N], marks(here, plain.ROW_OF), marks(here, at.IDS)
    lower, upper, weights = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, plain.WEIGHTS)
    errors, wanted, pull = vector(here, at.ERRORS), vector(here, at.WANTED), vector(here, at.PULL)
    A, J = matrix(here, plain.A), matrix(here, at.J)
    count = integer(0)
    for j in range(n):
        pull[j] = 0.0
    for i in range(ptr[k], ptr[k + 1]):
        wanted[i] = 0.0
        if not (lower[i] == upper[i] or (errors[i] != 0.0 and (lower[i] > -math.inf or upper[i] < math.inf))):
            continue
        row, weight = J[count], weights[i]
        if col[i] >= 0:
            for j in range(n):
                row[j] = 0.0
            row[col[i]] = weight
        else:
            own = A[row_of[i]]
            for j in range(n):
                row[j] = weight * own[j]
        if errors[i] != 0.0:
            wanted[i] = -weight * weight * errors[i]
            for j in range(n):
                pull[j] += weight * errors[i] * row[j]
        ids[count] = i
        count += 1
    return count


@inner
def project(here, count, d):
    """Write ``G`` = J Z', shape (count, d); returns a lower bound of its smallest squared singular value."""
    n, basis = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS)
    J, G, gram = matrix(here, at.J), matrix(here, at.G), matrix(here, at.E)
    for i in range(count):
        row, own = G[i], J[i]
        for p in range(d):
            direction, along = basis[p], 0.0
            for j in range(n):
                along += own[j] * direction[j]
            row[p] = along
    few = count <= d
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
    return smallest(gram, matrix(here, at.U), side)


@inner
def stack_above(here, count, above):
    """Append the `count` rows J to the `above` rows of the levels above, and to their Gram matrix; returns the sum."""
    n, J, ids = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), marks(here, at.IDS)
    all_above, whose, gram = matrix(here, at.ABOVE), marks(here, at.WHOSE), matrix(here, at.GRAM)
    for r in range(count):
        row, own = all_above[above], J[r]
        for j in range(n):
            row[j] = own[j]
        whose[above] = ids[r]
        for q in range(above + 1):
            other, total = all_above[q], 0.0
            for j in range(n):
                total += row[j] * other[j]
            gram[above][q] = gram[q][above] = total
        above += 1
    return above


@inner
def multipliers(here, k, above, damped):
    """Write the multipliers mu of the `above` rows of the levels above k, as weights ``wanted`` of their curvatures.

    `damped` is the sum of the squared damping strengths above, added to the Gram matrix. False if all mu are zero.
    """
    head, gram, L, mu = ints(here, 0, plain.HEAD), matrix(here, at.GRAM), matrix(here, at.TRIANGLE), vector(here, at.MU)
    n, all_above, whose, pull = head[plain.N], matrix(here, at.ABOVE), marks(here, at.WHOSE), vector(here, at.PULL)
    ptr, wanted, weights = marks(here, plain.PTR), vector(here, at.WANTED), vector(here, plain.WEIGHTS)
    longest, some = 0.0, False
    for r in range(above):
        row, total = all_above[r], 0.0
        for j in range(n):
            total += row[j] * pull[j]
        mu[r] = total
        some = some or total != 0.0
        longest = max(longest, gram[r][r])
    for i in range(ptr[head[at.TOP]], ptr[k]):
        wanted[i] = 0.0
    if not some:
        return False
    more = damped + DEPENDENT * longest
    for r in range(above):
        gram[r][r] += more
    fine = cholesky(gram, L, above)
    for r in range(above):
        gram[r][r] -= more
    if not fine:
        return False
    for r in range(above):
        for q in range(r):
            mu[r] -= L[r][q] * mu[q]
        mu[r] /= L[r][r]
    for r in range(above - 1, -1, -1):
        for q in range(r + 1, above):
            mu[r] -= L[q][r] * mu[q]
        mu[r] /= L[r][r]
        wanted[whose[r]] = mu[r] * weights[whose[r]]
    return True


@inner
def contract(here, first, end):
    """Write ``S``, the curvatures of levels first .. end - 1 contracted with ``wanted``; returns its Frobenius norm."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    calls, of, wanted, S = marks(here, at.CALLS), marks(here, at.CALLS_OF), vector(here, at.WANTED), matrix(here, at.S)
    for i in range(n):
        row = S[i]
        for j in range(n):
            row[j] = 0.0
    some, total = False, 0.0
    for p in range(of[first], of[end]):
        begin, count = calls[5 * p + 3], calls[5 * p + 4]
        weights, needed = floats(calls[5 * p + 2], 0, count), False
        for i in range(count):
            weights[i] = wanted[begin + i]
            needed = needed or weights[i] != 0.0
        if needed:
            called(calls[5 * p], calls[5 * p + 1])
            some = True
    if some:
        for i in range(n):
            row = S[i]
            for j in range(n):
                total += row[j] * row[j]
    return math.sqrt(total)


@inner
def add_bent(here, d, positive, negative):
    """Add to E the matrix M = L^-1 Z S Z' L^-T with its eigenvalues made positive, each times the factor of its sign.

    L is ``metric``. Positive eigenvalues are multiplied by `positive`, negative ones by ``-negative``.
    """
    n, basis, L = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS), matrix(here, at.METRIC)
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
    for _ in range(2):  # L^-1 M L^-T: by columns, by rows
        for q in range(d):
            row = M[q]
            for p in range(d):
                total = row[p]
                for r in range(p):
                    total -= L[p][r] * row[r]
                row[p] = total / L[p][p]
        for p in range(d):
            for q in range(p):
                M[p][q], M[q][p] = M[q][p], M[p][q]
    eigen(M, U, values, d)
    for p in range(d):
        size = positive * values[p] if values[p] > 0.0 else -negative * values[p]
        direction = U[p]
        for i in range(d):
            row, part = E[i], size * direction[i]
            for j in range(d):
                row[j] += part * direction[j]


@inner
def measure(here, k, d, count, size):
    """Write L, L L' = I + R' R for the soft rows R above along Z, and replace G by G L^-T; whether there are any."""
    head, ptr, state = ints(here, 0, plain.HEAD), marks(here, plain.PTR), marks(here, at.STATE)
    n, basis, L, M, G = (
        head[plain.N],
        matrix(here, at.BASIS),
        matrix(here, at.METRIC),
        matrix(here, at.M),
        matrix(here, at.G),
    )
    rows, stiffness, left, some = matrix(here, at.ROW), vector(here, at.STIFFNESS), vector(here, at.VALUES), False
    for p in range(d):
        for q in range(d):
            M[p][q] = 1.0 if p == q else 0.0
    for i in range(ptr[head[at.TOP]], ptr[k]):
        if state[i] != at.SOFT:
            continue
        some = True
        for p in range(d):
            direction, along = basis[p], 0.0
            for j in range(n):
                along += rows[i][j] * direction[j]
            left[p] = stiffness[i] * along
        for p in range(d):
            for q in range(d):
                M[p][q] += left[p] * left[q]
    cholesky(M, L, d)
    if some:
        for r in range(count):
            row = G[r]
            for p in range(d):
                for q in range(p):
                    row[p] -= L[p][q] * row[q]
                row[p] /= L[p][p]
    return some


@inner
def bend(here, k, count, d, above, least, damped):
    r"""Write the damping ``P`` of level k, shape (d, d): :math:`P = [|S_u| + [S_o]_+ + \sqrt\alpha [S_o]_- - G^T G]_+`.

    `least` is the smallest squared singular value of G. Where the norms of the curvatures alone are small enough, P is
    0 and nothing else is computed. Returns the largest eigenvalue of P, and the ratio of the curvature to `least`.
    """
    head, U, values = ints(here, 0, plain.HEAD), matrix(here, at.U), vector(here, at.VALUES)
    E, G, kept, P = matrix(here, at.E), matrix(here, at.G), matrix(here, at.KEPT), matrix(here, at.P)
    n, S, more = head[plain.N], matrix(here, at.S), 0.0
    own = contract(here, k, k + 1)
    if above > 0 and multipliers(here, k, above, damped):
        if own > 0.0:  # both are needed, one after the other
            for i in range(n):
                for j in range(n):
                    kept[i][j] = S[i][j]
        more = contract(here, head[at.TOP], k)
    for i in range(d):
        for j in range(d):
            P[i][j] = 0.0
    ratio = ratio_of(own + more, least)
    if ratio <= TRUSTED:
        return 0.0, ratio
    for i in range(d):
        for j in range(d):
            E[i][j] = 0.0
    if more > 0.0:
        add_bent(here, d, 1.0, 1.0)
        if own > 0.0:
            for i in range(n):
                for j in range(n):
                    S[i][j] = kept[i][j]
    if own > 0.0:
        add_bent(here, d, 1.0, math.sqrt(vector(here, at.SHARES)[k]))
    total = 0.0  # the norm again, now of the curvature along Z alone
    for i in range(d):
        for j in range(d):
            total += E[i][j] * E[i][j]
    ratio = ratio_of(math.sqrt(total), least)
    if ratio <= TRUSTED:
        return 0.0, ratio
    for r in range(count):
        row = G[r]
        for i in range(d):
            for j in range(d):
                E[i][j] -= row[i] * row[j]
    eigen(E, U, values, d)
    most = 0.0
    for p in range(d):
        if values[p] > 0.0:
            most = max(most, values[p])
            direction = U[p]
            for i in range(d):
                row, part = P[i], values[p] * direction[i]
                for j in range(d):
                    row[j] += part * direction[j]
    return most, ratio


@inner
def ratio_of(bent, least):
    """The ratio of a curvature to the smallest squared singular value of the rows."""
    return bent / least if least > 0.0 else math.inf if bent > 0.0 else 0.0


@inner
def norm_of(here, count):
    """The largest singular value of the `count` rows J; if they are more than n, the length of the first."""
    n, J, M = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), matrix(here, at.M)
    values, most, side = vector(here, at.VALUES), 0.0, count if count <= n else n
    if count > n:
        return length(J[0], n)
    for r in range(side):
        for q in range(r + 1):
            one, other, total = J[r], J[q], 0.0
            for j in range(n):
                total += one[j] * other[j]
            M[r][q] = M[q][r] = total
    eigen(M, matrix(here, at.U), values, side)
    for r in range(side):
        most = max(most, values[r])
    return math.sqrt(most)
