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
from .compile import inner
from .curved_rows import measured, measured_basis
from .definite import turn, turn_back, upper_factor
from .directions import along, untouched
from .lines import product
from .memory import floats, ints, marks, matrix, vector
from .orthogonal import padded
from .single_lines import add_scaled, clear_line, copy_line
from .sums import add_rows, add_squares, multiply
from .symmetric import NOISE, add_spectrum, bring_forward, eigen

#: Up to this ratio of the curvature to the smallest squared singular value of J, the linearisation is trusted.
TRUSTED = 0.3
#: Added to the Gram matrix of the rows above, relative to its largest diagonal entry: it bounds the multipliers of
#: nearly dependent rows.
DEPENDENT = 1e-10
#: Share of the damping above that counts in these multipliers: the rows of a damped level give way to the levels below
#: less than to what it asks for itself, as soft rows hold them (:mod:`.hand_over`).
YIELDS = 0.1
#: Between these shares of an error that a tick takes away, gain dt, it fades to none: the longer the step, the more of
#: the curvature above it has to know, or it overshoots further every time.
SLOW, FAST = 0.2, 0.4
#: How often the curvatures of the rows above count in the damping. Across these rows x swings, with the lean as a mass
#: and their curvatures as a spring, of which the multipliers tell only a part where the rows give way.
AGAIN = 2.3


@inner
def multipliers(here, k, above, damped):
    """Write the multipliers mu of the `above` rows of the levels above k, as weights ``wanted`` of their curvatures.

    `damped` is the sum of the squared damping strengths above, of which a share is added to the Gram matrix. False if
    all mu are zero.
    """
    head, gram, L, mu = ints(here, 0, plain.HEAD), matrix(here, at.GRAM), matrix(here, at.TRIANGLE), vector(here, at.MU)
    n, all_above, whose, pull = head[plain.N], matrix(here, at.ABOVE), marks(here, at.WHOSE), vector(here, at.PULL)
    of, wanted, weights = marks(here, at.OWN_OF), vector(here, at.WANTED), vector(here, plain.WEIGHTS)
    longest, some, shares = 0.0, False, vector(here, at.PARTS)
    multiply(all_above, above, pull, n, mu)
    for r in range(above):
        some = some or mu[r] != 0.0
        longest = max(longest, gram[r][r])
    for p in range(of[head[at.TOP]], of[k]):
        wanted[marks(here, at.OWN)[p]] = 0.0
    if not some:
        return False
    fade = min(1.0, max(0.0, (FAST - vector(here, at.SHARES)[k]) / (FAST - SLOW)))
    more = fade * YIELDS * damped + DEPENDENT * longest
    for r in range(above):
        gram[r][r] += more
    fine = upper_factor(gram, L, above, shares)
    for r in range(above):
        gram[r][r] -= more
    if not fine:
        return False
    turn(L, mu, above)
    turn_back(L, mu, above)
    for r in range(above):
        wanted[whose[r]] = mu[r] * weights[whose[r]]
    return True


@inner
def contract(here, first, end):
    """Write ``S``, the curvatures of levels first .. end - 1 contracted with ``wanted``; returns its Frobenius norm."""
    calls, of, wanted = marks(here, at.CALLS), marks(here, at.CALLS_OF), vector(here, at.WANTED)
    entries, some = vector(here, at.ALL_OF_S), False
    for i in range(len(entries)):
        entries[i] = 0.0
    for p in range(at.CALL * of[first], at.CALL * of[end], at.CALL):
        begin, count = calls[p + 3], calls[p + 4]
        weights, needed = floats(calls[p + 2], 0, count), False
        for i in range(count):
            weights[i] = wanted[begin + i]
            needed = needed or weights[i] != 0.0
        if needed:
            called(calls[p], calls[p + 1])
            some = True
    return math.sqrt(product(entries, entries, len(entries))) if some else 0.0


@inner
def forget_bounds(here):
    """Have the loops that bound curvatures called again, as for another state, when :func:`bound` needs them."""
    bounded = marks(here, at.BOUNDED)
    for k in range(ints(here, 0, plain.HEAD)[plain.LEVELS]):
        bounded[k] = 0


@inner
def find_bounds(here, first, end):
    """Have these loops, of levels first .. end - 1, write what :func:`bound` reads, unless they have."""
    calls, of, bounded = marks(here, at.CALLS), marks(here, at.CALLS_OF), marks(here, at.BOUNDED)
    for k in range(first, end):
        for p in range(at.CALL * of[k], at.CALL * of[k + 1] if bounded[k] == 0 else 0, at.CALL):
            if calls[p + 5] != 0:
                called(calls[p + 5], calls[p + 6])
        bounded[k] = 1


@inner
def bound(here, first, end):
    r"""An upper bound of the norm that :func:`contract` returns, at a fraction of its cost; infinite if there is none.

    Part by part :math:`\sqrt{w^T F w}`, with the matrices F of :func:`find_bounds`.
    """
    calls, of, wanted, most = marks(here, at.CALLS), marks(here, at.CALLS_OF), vector(here, at.WANTED), 0.0
    find_bounds(here, first, end)
    for p in range(at.CALL * of[first], at.CALL * of[end], at.CALL):
        begin, count, needed, square = calls[p + 3], calls[p + 4], False, 0.0
        for i in range(count):
            needed = needed or wanted[begin + i] != 0.0
        if not needed:
            continue
        if calls[p + 5] == 0:
            return math.inf
        F = floats(calls[p + 7], 0, count * count)
        for i in range(count):
            total = 0.0
            for j in range(count):
                total += F[count * i + j] * wanted[begin + j]
            square += wanted[begin + i] * total
        most += math.sqrt(abs(square))  # below zero by round-off alone
    return most


@inner
def keep(here, place):
    """Copy S to a place that has room for whole lines; returns it."""
    n, S, out = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.S), matrix(here, place)
    for i in range(n):
        own, row = S[i], out[i]
        for j in range(n):
            row[j] = own[j]
    return place


@inner
def bent_along(here, d, Z, given, out):
    """Write M = Z S Z' (d, d) to place `out`, for the S at place `given`; returns its Frobenius norm.

    Z (d, n) are the directions in the metric of the soft rows above: see :func:`.curved_rows.measured_basis`. U is work
    space.
    """
    n, M, half, norm = ints(here, 0, plain.HEAD)[plain.N], matrix(here, out), matrix(here, at.HALF)[0], 0.0
    whole = untouched(here, d) and ints(here, 0, plain.HEAD)[at.STIFF] == 0
    S = matrix(here, keep(here, at.U) if given == at.S and not whole else given)
    for p in range(d):
        row = M[p]
        if whole:
            along(here, S[marks(here, at.COLUMNS)[p]], d, row)
        else:
            clear_line(half, padded(n))
            add_rows(Z[p], S, 0, n, n, half)
            multiply(Z, p + 1, half, n, row)
        for q in range(p):
            M[q][p] = row[q]
            norm += 2.0 * row[q] * row[q]
        norm += row[p] * row[p]
    return math.sqrt(norm)


@inner
def add_bent(here, d, given, negative):
    """Add to E the matrix M (d, d) at place `given`, with its negative eigenvalues multiplied by ``-negative``.

    M is overwritten.
    """
    M, U, E, values = matrix(here, given), matrix(here, at.U), matrix(here, at.E), vector(here, at.VALUES)
    for i in range(d):
        add_scaled(M[i], 1.0, padded(d), E[i])
    eigen(M, U, values, d, NOISE)
    add_spectrum(U, values, d, bring_forward(U, values, d, -1.0), -1.0 - negative, matrix(here, at.HALF)[0], E)


@inner
def bend(here, k, count, d, above, least, damped):
    r"""Write the damping ``P`` of level k (d, d): :math:`P = [2.3 |S_u| + [S_o]_+ + \sqrt\alpha [S_o]_- - G^T G]_+`.

    `least` is the smallest squared singular value of G. Where the norms of the curvatures alone, or their bounds, are
    small enough, P is 0 and nothing else is computed; bounds that were of no use in the last solve are left out.
    Returns the largest eigenvalue of P, and the ratio of the curvature to `least`, 0 where that is known to be trusted.
    """
    head, E, P = ints(here, 0, plain.HEAD), matrix(here, at.E), matrix(here, at.P)
    loose, more, root = marks(here, at.LOOSE), 0.0, math.sqrt(vector(here, at.SHARES)[k])
    for i in range(d):
        clear_line(P[i], padded(d))
    pushed = above > 0 and multipliers(here, k, above, damped)
    if loose[k] == 0 and bound(here, k, k + 1) + (bound(here, head[at.TOP], k) if pushed else 0.0) <= TRUSTED * least:
        return 0.0, 0.0
    own = contract(here, k, k + 1)
    if pushed:
        if own > 0.0:
            keep(here, at.Q)
        more = contract(here, head[at.TOP], k)
    ratio = ratio_of(own + more, least)
    loose[k] = 1 if ratio > TRUSTED else 0
    if ratio <= TRUSTED:
        return 0.0, ratio
    for i in range(d):
        clear_line(E[i], padded(d))
    Z, more_along, own_along = matrix(here, measured_basis(here, d)), 0.0, 0.0
    if more > 0.0:
        more_along = bent_along(here, d, Z, at.S, at.M)
    if own > 0.0:
        own_along = bent_along(here, d, Z, at.Q if pushed else at.S, at.KEPT)
    ratio = ratio_of(more_along + max(1.0, root) * own_along, least)  # the norms again, now along Z alone
    if ratio <= TRUSTED:
        return 0.0, ratio
    M = matrix(here, at.M)
    if more > 0.0:
        add_bent(here, d, at.M, 1.0)
        for i in range(d):
            copy_line(E[i], padded(d), M[i])  # |S_u|
    if own > 0.0:
        add_bent(here, d, at.KEPT, root)
    total = 0.0  # and that of their sum
    for i in range(d):
        total += product(E[i], E[i], d)
    ratio = ratio_of(math.sqrt(total), least)
    if ratio <= TRUSTED:
        return 0.0, ratio
    for i in range(d if more > 0.0 else 0):  # the gate counts them once
        add_scaled(M[i], AGAIN - 1.0, padded(d), E[i])
    return where_larger(here, count, d), ratio


@inner
def where_larger(here, count, d):
    """Write P, the positive part of E - G'G, with G in the metric of the soft rows above; returns its largest value."""
    U, values, shares, E = (
        matrix(here, at.U),
        vector(here, at.VALUES),
        matrix(here, at.HALF)[0],
        matrix(here, at.E),
    )
    add_squares(shares, matrix(here, measured(here, count, d)), count, d, -1.0, E)
    eigen(E, U, values, d, NOISE)
    positive, most = bring_forward(U, values, d, 1.0), 0.0
    for p in range(positive):
        most = max(most, values[p])
    add_spectrum(U, values, d, positive, 1.0, shares, matrix(here, at.P))
    return most


@inner
def ratio_of(bent, least):
    """The ratio of a curvature to the smallest squared singular value of the rows."""
    return bent / least if least > 0.0 else math.inf if bent > 0.0 else 0.0
