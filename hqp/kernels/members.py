r"""The LDL' factor of the members, the active set of the dual method (:mod:`.dual`), with its updates and solves.

Member c is a row b with softness :math:`\delta`, at a bound g. With P, the row projected onto the null space of the
frozen rows (:func:`prepare`), the multipliers of all members solve

.. math:: (P P^T + \operatorname{diag} \delta)\, \lambda = B x_E - g = r, \qquad P P^T + \operatorname{diag} \delta
   = L D L^T, \qquad z = L^{-1} r .

Joining appends a row to L; leaving is a rank-one update of the block behind it (Gill, Golub, Murray, Saunders 1974).
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .lines import multiply_chosen, weigh
from .memory import ints, marks, matrix, vector
from .metric import convert
from .orthogonal import CANCELLED, length, padded, project, split
from .rows import EQUALITY, copy_row, value_of


@inner
def prepare(i, frozen, here):
    """Write P_i, row i projected onto the null space of V[:frozen].

    V only grows, so the projection continues from the rows of V that were taken off before, V[:DEPTH[i]].
    """
    head = ints(here, 0, at.HEAD)
    depth, scratch = marks(here, at.DEPTH), vector(here, at.SCRATCH)
    P, V = matrix(here, at.P), matrix(here, at.V)
    row = P[i]
    if depth[i] < 0:
        depth[i] = 0
        if head[at.METRIC] != 0:
            convert(i, row, here)
        else:
            copy_row(i, row, here)
    if depth[i] < frozen:
        wide = padded(head[at.N])
        before = length(row, wide)
        split(row, wide, V, depth[i], frozen, scratch)
        if length(row, wide) < CANCELLED * before:
            project(row, wide, V, integer(0), frozen, scratch)
        depth[i] = frozen


@inner
def list_part(i, place, slot, here):
    """Put row i at `place` of IDS, SLOTS, LENGTHS, and P_i into R[place], as :func:`.orthogonal.pivots` takes them.

    `slot` is its place relative to the first row of the call of `pivots`.
    """
    wide = padded(ints(here, 0, at.HEAD)[at.N])
    P, R = matrix(here, at.P), matrix(here, at.R)
    marks(here, at.IDS)[place], marks(here, at.SLOTS)[place] = i, slot
    vector(here, at.LENGTHS)[place] = math.sqrt(weigh(P[i], 1.0, wide, R[place]))


@inner
def start_of(i, goal, here):
    """The right-hand side r_i = b_i x_E - g of row i, where g is `goal`."""
    return value_of(i, vector(here, at.ANCHOR), here) - goal


@inner
def substitute(F, row, first, count):
    """Solve L l = row[:count] in place, L being the unit lower triangle F, four rows at a time; l[:first] is known."""
    r = first
    while r + 3 < count:
        f0, f1, f2, f3 = F[r], F[r + 1], F[r + 2], F[r + 3]
        t0, t1, t2, t3 = row[r], row[r + 1], row[r + 2], row[r + 3]
        for q in range(r):
            known = row[q]
            t0 -= f0[q] * known
            t1 -= f1[q] * known
            t2 -= f2[q] * known
            t3 -= f3[q] * known
        t1 -= f1[r] * t0
        t2 -= f2[r] * t0 + f2[r + 1] * t1
        t3 -= f3[r] * t0 + f3[r + 1] * t1 + f3[r + 2] * t2
        row[r], row[r + 1], row[r + 2], row[r + 3] = t0, t1, t2, t3
        r += 4
    while r < count:
        f0, t0 = F[r], row[r]
        for q in range(r):
            t0 -= f0[q] * row[q]
        row[r] = t0
        r += 1


@inner
def substitute_back(F, p, count):
    """Solve L^T l = p[:count] in place, L being the unit lower triangle F: four rows at a time."""
    c = count
    while c > 3:
        c -= 4
        f1, f2, f3 = F[c + 1], F[c + 2], F[c + 3]
        p3 = p[c + 3]
        p2 = p[c + 2] - f3[c + 2] * p3
        p1 = p[c + 1] - f3[c + 1] * p3 - f2[c + 1] * p2
        p0 = p[c] - f3[c] * p3 - f2[c] * p2 - f1[c] * p1
        p[c], p[c + 1], p[c + 2] = p0, p1, p2
        f0 = F[c]
        for r in range(c):
            p[r] -= f0[r] * p0 + f1[r] * p1 + f2[r] * p2 + f3[r] * p3
    while c > 0:
        c -= 1
        f0, p0 = F[c], p[c]
        for r in range(c):
            p[r] -= f0[r] * p0


@inner
def enter(count, here):
    """Append member number `count` to the factor; its row, r and softness are listed already.

    Returns
    -------
    pivot, square : float
        The new entry of D, and ``||P||^2`` of the row. If the pivot is tiny beside `square`, the row is dependent.
    """
    head = ints(here, 0, at.HEAD)
    m, wide = head[at.ROWS], padded(head[at.N])
    members, col, norm = marks(here, at.MEMBERS), marks(here, at.COL), vector(here, at.NORM)
    D, z, right, soft = vector(here, at.DIAGONAL), vector(here, at.Z), vector(here, at.RIGHT), vector(here, at.SOFT)
    P, F = matrix(here, at.P), matrix(here, at.FACTOR)
    i = members[count]
    mine, row = P[i], F[count]
    square = 0.0
    for j in range(wide):
        square += mine[j] * mine[j]
    if i < m and col[i] >= 0 and head[at.METRIC] == 0:
        for r in range(count):
            row[r] = norm[i] * P[members[r]][col[i]]
    else:
        multiply_chosen(P, members, count, mine, wide, row)
    pivot, rest = square + soft[count], right[count]
    substitute(F, row, integer(0), count)
    for r in range(count):
        scaled = row[r] / D[r]
        pivot -= scaled * row[r]
        rest -= scaled * z[r]
        row[r] = scaled
    D[count], z[count] = pivot, rest
    return pivot, square


@inner
def leave(place, count, here):
    """Remove the member at this place from the list of `count` members and from the factor."""
    members = marks(here, at.MEMBERS)
    D, z, right, soft = vector(here, at.DIAGONAL), vector(here, at.Z), vector(here, at.RIGHT), vector(here, at.SOFT)
    force, p, b = vector(here, at.FORCE), vector(here, at.CARRY), vector(here, at.SHED)
    F = matrix(here, at.FACTOR)
    a = D[place]
    for c in range(place + 1, count):
        row, shifted = F[c], F[c - 1]
        for r in range(place):
            shifted[r] = row[r]
        carried = row[place]
        for r in range(place + 1, c):
            carried_on = carried - p[r] * row[r]
            shifted[r - 1] = row[r] + b[r] * carried_on
            carried = carried_on
        p[c] = carried
        grown = D[c] + a * carried * carried
        b[c] = a * carried / grown
        a *= D[c] / grown
        D[c - 1] = grown
        members[c - 1], right[c - 1], soft[c - 1], force[c - 1] = members[c], right[c], soft[c], force[c]
    for c in range(place, count - 1):
        z[c] = right[c]
    substitute(F, z, place, count - 1)


@inner
def wants(count, here):
    """Solve L^T ``wanted`` = D^-1 z: multipliers with all members as equalities; returns the objective, sum z^2 / D."""
    D, z, wanted = vector(here, at.DIAGONAL), vector(here, at.Z), vector(here, at.WANTED)
    F = matrix(here, at.FACTOR)
    objective = 0.0
    for c in range(count):
        wanted[c] = z[c] / D[c]
        objective += z[c] * wanted[c]
    substitute_back(F, wanted, count)
    return objective


@inner
def sign_of(c, here):
    """The sign that the multiplier of member c must have: 1 at an upper bound, -1 at a lower one, 0 for an equality."""
    m, i = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.MEMBERS)[c]
    if i >= m:
        return 0
    side = marks(here, at.SIDE)[i]
    return 0 if side == EQUALITY else side
