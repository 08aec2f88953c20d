"""The rows of a curved level: those that count, along the directions that are left; stacked for the levels below."""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .compile import inner, integer
from .definite import cholesky, smallest
from .directions import along
from .lines import product
from .memory import ints, marks, matrix, vector
from .orthogonal import padded
from .single_lines import add_scaled, clear_line, copy_line
from .sums import add_rows, add_squares, multiply
from .symmetric import largest

#: A row is violated if it is further from its bounds than this, relative to its value and that distance.
VIOLATED = 1e-9


@inner
def value_at(here, i, x):
    """A_i x: the value of row i at x (n,)."""
    column = marks(here, plain.COL)[i]
    if column >= 0:
        return x[column]
    return product(matrix(here, plain.A)[marks(here, plain.ROW_OF)[i]], x, ints(here, 0, plain.HEAD)[plain.N])


@inner
def kept(here, k, x):
    """Whether x (n,) keeps the bounds of all rows of level k."""
    mine, of = marks(here, at.OWN), marks(here, at.OWN_OF)
    lower, upper = vector(here, plain.LOWER), vector(here, plain.UPPER)
    for p in range(of[k], of[k + 1]):
        value = value_at(here, mine[p], x)
        low, high = lower[mine[p]] - value, value - upper[mine[p]]
        if max(low, high) > VIOLATED * (abs(value) + max(low, high)):
            return False
    return True


@inner
def write_weighted(here, i, out):
    """Write row i, times its weight, to `out` (n,)."""
    n, column, weight = (
        ints(here, 0, plain.HEAD)[plain.N],
        marks(here, plain.COL)[i],
        vector(here, plain.WEIGHTS)[i],
    )
    if column >= 0:
        for j in range(n):
            out[j] = 0.0
        out[column] = weight
    else:
        row = matrix(here, plain.A)[marks(here, plain.ROW_OF)[i]]
        for j in range(n):
            out[j] = weight * row[j]


@inner
def gather(here, k):
    """Collect the equalities of level k, and its inequalities that have an error; returns how many these are.

    Writes their numbers ``ids``, weighted rows ``J``, the weights ``wanted`` of their curvatures (by row number), and
    ``pull`` = J' e, with the errors weighted like the rows.
    """
    n, mine, of, ids = (
        ints(here, 0, plain.HEAD)[plain.N],
        marks(here, at.OWN),
        marks(here, at.OWN_OF),
        marks(here, at.IDS),
    )
    lower, upper, weights = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, plain.WEIGHTS)
    errors, wanted, pull = vector(here, at.ERRORS), vector(here, at.WANTED), vector(here, at.PULL)
    J, count = matrix(here, at.J), integer(0)
    clear_line(pull, padded(n))
    for p in range(of[k], of[k + 1]):
        i = mine[p]
        wanted[i] = 0.0
        if not (lower[i] == upper[i] or (errors[i] != 0.0 and (lower[i] > -math.inf or upper[i] < math.inf))):
            continue
        row, weight = J[count], weights[i]
        write_weighted(here, i, row)
        if errors[i] != 0.0:
            wanted[i] = -weight * weight * errors[i]
            add_scaled(row, weight * errors[i], padded(n), pull)
        ids[count] = i
        count += 1
    return count


@inner
def project(here, count, d):
    """Write ``G`` = J Z', shape (count, d); returns a lower bound of its smallest squared singular value."""
    basis, J, G = matrix(here, at.BASIS), matrix(here, at.J), matrix(here, at.G)
    col, ids, gram = marks(here, plain.COL), marks(here, at.IDS), matrix(here, at.E)
    half, shares = matrix(here, at.HALF), vector(here, at.VALUES)
    for i in range(count):
        row, j = G[i], col[ids[i]]
        if j < 0:
            along(here, J[i], d, row)
        else:
            for p in range(d):
                row[p] = J[i][j] * basis[p][j]
    if count > d:
        write_gram(here, count, d)
        return smallest(matrix(here, at.GRAM_OF_G), matrix(here, at.U), half, shares, d)
    for i in range(count):
        multiply(G, i + 1, G[i], d, shares)
        for r in range(i + 1):
            gram[r][i] = shares[r]
    return smallest(gram, matrix(here, at.U), half, shares, count)


@inner
def write_gram(here, count, d):
    """Write G'G, of shape (d, d), for the `count` rows G."""
    gram = matrix(here, at.GRAM_OF_G)
    for i in range(d):
        clear_line(gram[i], padded(d))
    add_squares(vector(here, at.VALUES), matrix(here, at.G), count, d, 1.0, gram)


@inner
def stack_above(here, count, above, free):
    """Append the `count` rows J to the `above` rows of the levels above, and to their Gram matrix; returns the sum.

    They are taken along the first `free` directions of the basis.
    """
    n, J, ids = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), marks(here, at.IDS)
    all_above, whose, gram = matrix(here, at.ABOVE), marks(here, at.WHOSE), matrix(here, at.GRAM)
    for r in range(count):
        row, own = all_above[above], J[r]
        copy_line(own, padded(n), row)
        for b in range(free, len(matrix(here, at.BASIS))):
            direction = matrix(here, at.BASIS)[b]
            add_scaled(direction, -product(direction, row, n), padded(n), row)
        whose[above] = ids[r]
        multiply(all_above, above + 1, row, n, gram[above])
        for q in range(above):
            gram[q][above] = gram[above][q]
        above += 1
    return above


@inner
def only_entry(here, i):
    """The column of the only entry of row i that is not zero, or -1 if it has others: it bounds that variable alone.

    So do the bounds of joints that share a level with rows of other kinds.
    """
    column, only = marks(here, plain.COL)[i], integer(-1)
    if column >= 0:
        return column
    row = matrix(here, plain.A)[marks(here, plain.ROW_OF)[i]]
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        if row[j] != 0.0:
            if only >= 0:
                return integer(-1)
            only = integer(j)
    return only


@inner
def note_bounds(here):
    """Write the tightest bounds of every variable, of all rows above the curved levels, to ``least`` and ``most``."""
    head, col, least, most = (
        ints(here, 0, plain.HEAD),
        marks(here, plain.COL),
        vector(here, at.LEAST),
        vector(here, at.MOST),
    )
    lower, upper = vector(here, plain.LOWER), vector(here, plain.UPPER)
    for j in range(head[plain.N]):
        least[j], most[j] = -math.inf, math.inf
    for p in range(marks(here, at.OWN_OF)[head[at.TOP]]):
        i = marks(here, at.OWN)[p]
        j, low, high = only_entry(here, i), lower[i], upper[i]
        if j < 0:
            continue
        if col[i] < 0:
            entry = matrix(here, plain.A)[marks(here, plain.ROW_OF)[i]][j]
            low, high = low / entry, high / entry
            if entry < 0.0:
                low, high = high, low
        least[j], most[j] = max(least[j], low), min(most[j], high)


@inner
def demand(here, k, count, size):
    r"""How many times more level k asks for than its bounds leave room for, at least 1.

    It asks for :math:`J^T r / |J|^2`, where r is what its rows lack at the x of the level above; the room is the
    diagonal of the bounds. Variables that are not bounded on both sides do not count.
    """
    n, J, ids, x = (
        ints(here, 0, plain.HEAD)[plain.N],
        matrix(here, at.J),
        marks(here, at.IDS),
        matrix(here, at.POINTS)[k - 1],
    )
    lower, upper, weights = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, plain.WEIGHTS)
    asked, least, most = vector(here, at.VALUES), vector(here, at.LEAST), vector(here, at.MOST)
    clear_line(asked, padded(n))
    for r in range(count):
        row, weight = J[r], weights[ids[r]]
        value = product(row, x, n)
        lacking = max(weight * lower[ids[r]] - value, 0.0) + min(weight * upper[ids[r]] - value, 0.0)
        add_scaled(row, lacking / (size * size), padded(n), asked)
    far, room = 0.0, 0.0
    for j in range(n):
        width = most[j] - least[j]
        if width > 0.0 and width < math.inf:
            far += asked[j] * asked[j]
            room += width * width
    return max(1.0, math.sqrt(far / room)) if room > 0.0 else 1.0


@inner
def measure(here, k, d, firmer):
    """Write L, L L' = I + R' R for the soft rows R above along Z; whether there are any.

    `firmer` is the factor of their stiffness.
    """
    head, of, state = ints(here, 0, plain.HEAD), marks(here, at.OWN_OF), marks(here, at.STATE)
    L, M = matrix(here, at.METRIC), matrix(here, at.M)
    rows, stiffness, left, some = matrix(here, at.ROW), vector(here, at.STIFFNESS), vector(here, at.VALUES), False
    for p in range(d):
        for q in range(d):
            M[p][q] = 1.0 if p == q else 0.0
    for s in range(of[head[at.TOP]], of[k]):
        i = marks(here, at.OWN)[s]
        if state[i] != at.SOFT:
            continue
        some = True
        along(here, rows[i], d, left)
        for p in range(d):
            left[p] *= firmer * stiffness[i]
        for p in range(d):
            row, share = M[p], left[p]
            for q in range(p + 1):
                row[q] += share * left[q]
    if some:
        cholesky(M, L, d)
    return some


@inner
def measured(here, count, d):
    """Where G is in the metric L of the soft rows above, G L^-T, of shape (count, d): it is written there."""
    if ints(here, 0, plain.HEAD)[at.STIFF] == 0:
        return integer(at.G)
    G, L, out = matrix(here, at.G), matrix(here, at.METRIC), matrix(here, at.G_MEASURED)
    for r in range(count):
        row, own = out[r], G[r]
        for p in range(d):
            factor, total = L[p], own[p]
            for q in range(p):
                total -= factor[q] * row[q]
            row[p] = total / factor[p]
    return integer(at.G_MEASURED)


@inner
def measured_basis(here, d):
    """Where the directions Z are in the metric L of the soft rows above, L^-1 Z, of shape (d, n): written there."""
    if ints(here, 0, plain.HEAD)[at.STIFF] == 0:
        return integer(at.BASIS)
    Z, L, out = matrix(here, at.BASIS), matrix(here, at.METRIC), matrix(here, at.MEASURED_BASIS)
    n, shares = ints(here, 0, plain.HEAD)[plain.N], vector(here, at.VALUES)
    for p in range(d):
        row, over = out[p], 1.0 / L[p][p]
        for q in range(p):
            shares[q] = -L[p][q]
        for j in range(n):
            row[j] = Z[p][j]
        add_rows(shares, out, 0, p, n, row)
        for j in range(n):
            row[j] *= over
    return integer(at.MEASURED_BASIS)


@inner
def apart(here, count, free):
    """Whether each of the `count` rows J has a variable of its own, as in a posture, and nothing is held above."""
    col, ids, last = marks(here, plain.COL), marks(here, at.IDS), -1
    alone = free == len(matrix(here, at.BASIS))
    for r in range(count):
        alone = alone and col[ids[r]] > last
        last = col[ids[r]]
    return alone


@inner
def norm_of(here, count, above, free):
    """The largest singular value of the `count` rows J along the first `free` directions of the basis.

    They are stacked behind `above` others, where they are not :func:`apart`.
    """
    J, M, gram, most = matrix(here, at.J), matrix(here, at.M), matrix(here, at.GRAM), 0.0
    if apart(here, count, free):
        for r in range(count):
            most = max(most, abs(J[r][marks(here, plain.COL)[marks(here, at.IDS)[r]]]))
        return most
    for r in range(count):
        row, own = M[r], gram[above + r]
        for q in range(count):
            row[q] = own[above + q]
    return math.sqrt(largest(M, vector(here, at.VALUES), count))
