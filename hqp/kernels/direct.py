r"""Solves a stage of a curved level without the solver, where nothing but bounds of variables is in its way.

Along Z the levels above are kept, whatever the coordinates y. With the rows of the level, those that are soft, and the
rows of damping, which make the optimum unique, the stage is

.. math:: \min_y \|R y - \rho\|^2, \qquad l \le \bar x + Z^T y \le u, \qquad R = \text{upper triangular},

and w = R y is the point nearest to :math:`\rho` within bounds. Those that are met by B w = c have the multipliers
:math:`(B B^T)^{-1} (c - B \rho)`. They are guessed to be those of the last solve, and corrected a few times. What is
found is the optimum: it keeps all bounds and rows, and every multiplier has the right sign. Else the solver is asked.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .compile import inner, integer
from .curved_rows import value_at
from .definite import cholesky, turn, turn_back, upper_factor
from .directions import add_along, along, take_along
from .lines import product
from .memory import ints, marks, matrix, vector
from .orthogonal import length, padded
from .single_lines import add_scaled, copy_line, reflect_below
from .sums import SHORT, add_long, multiply_long

#: How often the bounds that are met are guessed before the solver is asked.
GUESSES = 6
#: By normal equations, a squared pivot must keep this share of its diagonal.
CLEAR = 1e-8
#: How often y is moved onto the bounds that are met: once would do, but for round-off, as the condition of B B' is the
#: square of that of B.
REFINED = 3
#: A variable that Z moves by less than this is held by the levels above already: at its bound it is by round-off, and
#: to undo that, others that little holds, as a joint that no task feels, would go anywhere.
MOVABLE = 1e-8
#: By this share of its size x may pass a bound, as round-off; it is put back onto it.
ROUNDING = 1e-13
#: The share of its size, and of their values, within which x must keep the rows above: a tenth of what a proof allows.
KEPT = 1e-12


@inner
def equalities(here, k):
    """Whether levels down to k have no inequality below the levels that are never damped."""
    mine, of = marks(here, at.OWN), marks(here, at.OWN_OF)
    lower, upper, same = vector(here, plain.LOWER), vector(here, plain.UPPER), True
    for p in range(of[ints(here, 0, plain.HEAD)[at.TOP]], of[k + 1]):
        same = same and lower[mine[p]] == upper[mine[p]]
    return same


@inner
def write_row(here, d, row, bound, own):
    """Write to own[: d + 1] a row (n,) along Z, and what it lacks at ``reach``."""
    along(here, row, d, own)
    own[d] = bound - value_of(here, row)


@inner
def value_of(here, row):
    """The value of a row (n,) at ``reach``."""
    return product(row, vector(here, at.REACH), ints(here, 0, plain.HEAD)[plain.N])


@inner
def write_rows(here, k, d):
    """Write to ``least_squares`` the rows of damping, those of level k, and the soft ones; returns how many these are.

    Those of damping are K, upper triangular; see :func:`.stage.write_damping`.
    """
    T, K, towards = matrix(here, at.LEAST_SQUARES), matrix(here, at.U), vector(here, at.MU)
    ids, lower, weights = marks(here, at.IDS), vector(here, plain.LOWER), vector(here, plain.WEIGHTS)
    state, stiffness, reached = marks(here, at.STATE), vector(here, at.STIFFNESS), vector(here, at.VALUE)
    head, mine, of, total = ints(here, 0, plain.HEAD), marks(here, at.OWN), marks(here, at.OWN_OF), d
    size, row = matrix(here, at.NORMS)[k][head[at.NUMBER]], vector(here, at.ROW_NOW)
    for p in range(d):
        own = T[p]
        copy_line(K[p], padded(d), own)
        own[d] = towards[p]
    for r in range(head[at.ACTIVE]):
        own = T[total]
        copy_line(matrix(here, at.G)[r], padded(d), own)
        own[d] = weights[ids[r]] * lower[ids[r]] - value_of(here, matrix(here, at.J)[r])
        total += 1
    for s in range(of[head[at.TOP]], of[k]):
        i = mine[s]
        if state[i] == at.SOFT and size > 0.0:
            scale, combined = stiffness[i] * size, matrix(here, at.ROW)[i]
            for j in range(head[plain.N]):
                row[j] = scale * combined[j]
            write_row(here, d, row, scale * reached[i], T[total])
            total += 1
    return total


@inner
def factorise(here, d, total):
    r"""Write R, :math:`R^T R = T^T T`, and :math:`\rho` over the rows T[:d], the K of M = K'K; whether it is accurate.

    By normal equations, at a third of the price of reflections, but for short rows: see :func:`refine`. M is lost.
    """
    T, M, shares, rho = (
        matrix(here, at.LEAST_SQUARES),
        matrix(here, at.M),
        vector(here, at.PARTS),
        vector(here, at.ROW_NOW),
    )
    if d <= SHORT:
        return False
    for p in range(d):
        for r in range(d, total):
            shares[r] = T[r][p]
        add_long(shares, T, d, total, p, d, M[p])
        rho[p] = 0.0
    for r in range(total):
        shares[r] = T[r][d]
    add_long(shares, T, 0, total, 0, d, rho)
    if not upper_factor(M, T, d, shares):
        return False
    for p in range(d):
        if T[p][p] * T[p][p] < CLEAR * M[p][p]:
            return False
    turn(T, rho, d)
    for p in range(d):
        T[p][d] = rho[p]
    return True


@inner
def refine(here, k, d, total):
    r"""Correct :math:`\rho` by the gradient of the rows themselves at the y in ``mu``, which then is as accurate."""
    T, K, y, rho = matrix(here, at.LEAST_SQUARES), matrix(here, at.U), vector(here, at.MU), vector(here, at.ROW_NOW)
    n, damped, left = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.DAMPED), vector(here, at.PARTS)
    multiply_long(T, total, y, d, left)
    for p in range(d):
        T[p][d], rho[p] = left[p], 0.0
    multiply_long(K, d, y, d, left)
    for p in range(d):
        left[p] = damped[k * n + p][n] - left[p]
    for r in range(d, total):
        left[r] = T[r][d] - left[r]
    add_long(left, K, 0, d, 0, d, rho)
    add_long(left, T, d, total, 0, d, rho)
    turn(T, rho, d)
    for p in range(d):
        T[p][d] += rho[p]


@inner
def triangulate(T, d, total, parts):
    """Reflect the rows T[:total, : d + 1], of which the first d are upper triangular, so that all others are zero.

    `parts` (total,) is work space. Columns that are done, and entries below the diagonal, become anything.
    """
    for j in range(d):
        own, square = T[j], 0.0
        for i in range(d, total):
            parts[i] = T[i][j]
            square += parts[i] * parts[i]
        if square == 0.0:
            continue
        size = math.sqrt(square + own[j] * own[j])
        if own[j] > 0.0:
            size = -size
        head = own[j] - size
        reflect_below(T, j, d, total, head, parts, 2.0 / (square + head * head), j, padded(d + 1))
        own[j] = size


@inner
def meet(here, d, first, met):
    """Write to ``mu`` the y that is optimal where the bounds `met` are; whether they are independent.

    Those of variables that are held above leave `met`. ``values`` are the multipliers of the others. B and c are
    written to T, from row `first` on.
    """
    T, M, L = matrix(here, at.LEAST_SQUARES), matrix(here, at.M), matrix(here, at.HALF)
    basis, base, out, y = matrix(here, at.BASIS), vector(here, at.REACH), vector(here, at.VALUES), vector(here, at.MU)
    least, most, count = vector(here, at.LEAST), vector(here, at.MOST), integer(0)
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        if met[j] == 0:
            continue
        row, far = T[first + count], (most[j] if met[j] > 0 else least[j]) - base[j]
        if count == d or abs(far) == math.inf or least[j] > most[j]:
            return False
        for p in range(d):
            row[p] = basis[p][j]
        if length(row, d) < MOVABLE:
            met[j] = 0
            continue
        turn(T, row, d)
        row[d], out[count] = far, 0.0
        for r in range(count + 1):
            M[count][r] = M[r][count] = product(row, T[first + r], d)
        count += 1
    if not cholesky(M, L, count):
        return False
    for p in range(d):
        y[p] = T[p][d]
    for _ in range(REFINED if count > 0 else 0):
        come_nearer(here, d, first, count)
    turn_back(T, y, d)
    return True


@inner
def come_nearer(here, d, first, count):
    """Move w, in ``mu``, onto the `count` bounds B w = c, as B'B allows it; adds the multipliers to ``values``."""
    T, L, out, w, step = (
        matrix(here, at.LEAST_SQUARES),
        matrix(here, at.HALF),
        vector(here, at.VALUES),
        vector(here, at.MU),
        vector(here, at.ROW_NOW),
    )
    for r in range(count):
        row = T[first + r]
        step[r] = row[d] - product(row, w, d)
    for r in range(count):
        for q in range(r):
            step[r] -= L[r][q] * step[q]
        step[r] /= L[r][r]
    for r in range(count - 1, -1, -1):
        for q in range(r + 1, count):
            step[r] -= L[q][r] * step[q]
        step[r] /= L[r][r]
    for r in range(count):
        out[r] += step[r]
        add_scaled(T[first + r], step[r], padded(d), w)


@inner
def let_go(here, met):
    """Take those bounds out of `met` whose multiplier, in ``values``, has the wrong sign; whether there are any."""
    values, count, some = vector(here, at.VALUES), integer(0), False
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        if met[j] != 0:
            if not values[count] * met[j] <= 0.0:
                met[j], some = 0, True
            count += 1
    return some


@inner
def arrive(here, d, met, x):
    """Write x = reach + Z' y; bounds that it passes, by more than round-off, join `met`. Whether there are any."""
    n, base, y = ints(here, 0, plain.HEAD)[plain.N], vector(here, at.REACH), vector(here, at.MU)
    least, most, some = vector(here, at.LEAST), vector(here, at.MOST), False
    copy_line(base, padded(n), x)
    add_along(here, y, 0, d, x)
    near = ROUNDING * length(x, n)
    for j in range(n):
        if met[j] != 0:
            x[j] = most[j] if met[j] > 0 else least[j]
        elif not x[j] <= most[j] + near:
            met[j], some = 1, True
        elif not x[j] >= least[j] - near:
            met[j], some = -1, True
        else:
            x[j] = min(max(x[j], least[j]), most[j])
    return some


@inner
def keeps_rows(here, k, above, x):
    """Whether x keeps the levels above k: inequalities, held rows, and the values of given ones at the x `above`.

    Along Z they do not change, but where x is smaller than `above` by far, what is round-off there is none here.
    """
    head, state, reached = ints(here, 0, plain.HEAD), marks(here, at.STATE), vector(here, at.VALUE)
    lower, upper, col = vector(here, plain.LOWER), vector(here, plain.UPPER), marks(here, plain.COL)
    n, row_of, good = head[plain.N], marks(here, plain.ROW_OF), True
    size = length(x, n)
    for p in range(marks(here, at.OWN_OF)[k]):
        i = marks(here, at.OWN)[p]
        if state[i] == at.HELD:
            row, wanted = matrix(here, at.ROW)[i], reached[i]
            value = product(row, x, n)
            near = KEPT * length(row, n) * size
        elif state[i] != at.GIVEN or (col[i] >= 0 and lower[i] != upper[i]):
            continue  # of no matter here; or a bound, which is kept
        else:
            value = value_at(here, i, x)
            if lower[i] != upper[i]:
                good = good and lower[i] <= value <= upper[i]
                continue
            wanted = value_at(here, i, above)
            near = KEPT * size * (1.0 if col[i] >= 0 else length(matrix(here, plain.A)[row_of[i]], n))
        good = good and abs(value - wanted) <= near + KEPT * abs(wanted)
    return good


@inner
def solve_directly(here, k, above):
    """Solve the stage of level k, whose rows of damping are written, below the x `above`; False if the solver must."""
    d, n = ints(here, 0, plain.HEAD)[at.LEFT], ints(here, 0, plain.HEAD)[plain.N]
    met, x = marks(here, at.MET)[k * n : (k + 1) * n], matrix(here, at.POINTS)[k]
    if not equalities(here, k):
        return False
    take_along(here, above, d, vector(here, at.VALUES), vector(here, at.REACH))  # there y is 0
    total = write_rows(here, k, d)
    refined = not factorise(here, d, total)
    if refined:
        if d > SHORT:
            write_rows(here, k, d)
        triangulate(matrix(here, at.LEAST_SQUARES), d, total, vector(here, at.PARTS))
    for _ in range(GUESSES):
        if not meet(here, d, total, met):
            break
        if let_go(here, met) or arrive(here, d, met, x):
            continue
        if refined:
            return keeps_rows(here, k, above, x)
        refine(here, k, d, total)
        refined = True
    for j in range(n):
        met[j] = 0
    return False
