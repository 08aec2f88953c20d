r"""The LDL' factor of the members, the active set of the dual method (:mod:`.dual`), with its updates and solves.

Member c is a row b with softness :math:`\delta`, at a bound g. With P, the row projected onto the null space of the
frozen rows (:func:`prepare`), the multipliers of all members solve

.. math:: (P P^T + \operatorname{diag} \delta)\, \lambda = B x_E - g = r, \qquad P P^T + \operatorname{diag} \delta
   = L D L^T, \qquad z = L^{-1} r .

Joining appends a row to L; leaving is a rank-one update of the block behind it (Gill, Golub, Murray, Saunders 1974).
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, matrix, vector
from .metric import convert
from .orthogonal import CANCELLED, length, padded, project
from .rows import EQUALITY, value_of


@inner
def prepare(i, frozen, here):
    """Write P_i, row i projected onto the null space of V[:frozen].

    V only grows, so the projection continues from the rows of V that were taken off before, V[:DEPTH[i]].
    """
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    depth, scratch = marks(here, at.DEPTH), vector(here, at.SCRATCH)
    P, V = matrix(here, at.P), matrix(here, at.V)
    row = P[i]
    if depth[i] < 0:
        depth[i] = 0
        convert(i, row, here)
        for j in range(n, padded(n)):
            row[j] = 0.0
    if depth[i] < frozen:
        wide = padded(n)
        before = length(row, wide)
        project(row, wide, V, depth[i], frozen, scratch)
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
    mine, row = P[i], R[place]
    for j in range(wide):
        row[j] = mine[j]
    marks(here, at.IDS)[place], marks(here, at.SLOTS)[place] = i, slot
    vector(here, at.LENGTHS)[place] = length(row, wide)


@inner
def start_of(i, goal, here):
    """The right-hand side r_i = b_i x_E - g of row i, where g is `goal`."""
    return value_of(i, vector(here, at.ANCHOR), here) - goal


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
        for r in range(count):
            other = P[members[r]]
            total = 0.0
            for j in range(wide):
                total += mine[j] * other[j]
            row[r] = total
    pivot, rest = square + soft[count], right[count]
    for r in range(count):
        above = F[r]
        total = row[r]
        for q in range(r):
            total -= above[q] * row[q]
        row[r] = total
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
        row, total = F[c], right[c]
        for r in range(c):
            total -= row[r] * z[r]
        z[c] = total


@inner
def wants(count, here):
    """Solve L^T ``wanted`` = D^-1 z: multipliers with all members as equalities; returns the objective, sum z^2 / D."""
    D, z, wanted = vector(here, at.DIAGONAL), vector(here, at.Z), vector(here, at.WANTED)
    F = matrix(here, at.FACTOR)
    objective = 0.0
    for c in range(count):
        wanted[c] = z[c] / D[c]
        objective += z[c] * wanted[c]
    for c in range(count - 1, -1, -1):
        row, own = F[c], wanted[c]
        for r in range(c):
            wanted[r] -= row[r] * own
    return objective


@inner
def sign_of(c, here):
    """The sign that the multiplier of member c must have: 1 at an upper bound, -1 at a lower one, 0 for an equality."""
    m, i = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.MEMBERS)[c]
    if i >= m:
        return 0
    side = marks(here, at.SIDE)[i]
    return 0 if side == EQUALITY else side
