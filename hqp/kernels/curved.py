r"""Curved levels: each a stage of its own from the first on that is damped (:mod:`.bend`), in one call.

A stage is a plain hierarchy: the levels above, held where they are, and this one, with rows for what of those above is
soft, and rows of damping. The compiled solver that solves it is called by its address. Where no level is damped, the
hierarchy is solved as it stands.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .active_set import OPTIMAL
from .bend import bend, gather, project
from .call import called_on
from .compile import entry, inner, integer, stamp
from .memory import floats, given, ints, marks, matrix, vector
from .orthogonal import length
from .rows import INACTIVE
from .symmetric import cholesky, eigen

#: What has become of a row: as it is given; a combination of its level, held, or soft; or nothing is left of it.
GIVEN, HELD, SOFT, LOST = 0, 1, 2, 3
#: How much stiffer against the levels below a soft row is than its damping.
STIFF = 15.0
#: And at most.
STIFFEST = 1e4
#: How strongly a level leans on the last x, relative to its rows, times the root of gain dt.
LEAN = 0.0316
#: A combination of rows that is so much shorter is none; and what is added to a matrix that has to be definite.
NONE, REGULAR = 1e-7, 1e-13
#: A row further from its bounds than this, relative to both, is violated.
VIOLATED = 1e-9


@inner
def set_aside(here, i, row, own, d):
    """Hold one more row below: `row` is what of it is along Z, `own` itself. Of Z one direction less is left."""
    n, basis, T = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS), matrix(here, at.T)
    size, reach = length(row, d), vector(here, at.REACH)
    # The reflection that brings the last direction to where the row is, I - 2 u u' / |u|^2.
    sign = -1.0 if row[d - 1] > 0.0 else 1.0
    for j in range(n):
        reach[j] = 0.0
    total = 0.0
    for p in range(d):
        u = row[p] / size - (sign if p == d - 1 else 0.0)
        total += u * u
        direction = basis[p]
        for j in range(n):
            reach[j] += u * direction[j]
    for p in range(d):
        u = (row[p] / size - (sign if p == d - 1 else 0.0)) * 2.0 / total
        direction = basis[p]
        for j in range(n):
            direction[j] -= u * reach[j]
    along = T[n - d]
    for q in range(n - d + 1):
        direction, total = basis[n - 1 - q], 0.0
        for j in range(n):
            total += own[j] * direction[j]
        along[q] = total


@inner
def hold(here, i, r, d):
    """Hold the r-th row of the level at hand, number i, as it is: how many directions are left."""
    head, own, row = ints(here, 0, plain.HEAD), matrix(here, at.J)[r], matrix(here, at.G)[r]
    n, m, basis = head[plain.N], head[plain.ROWS], matrix(here, at.BASIS)
    if d == 0:
        return d
    for p in range(d):
        direction, along = basis[p], 0.0
        for j in range(n):
            along += own[j] * direction[j]
        row[p] = along
    if not length(row, d) > NONE * length(own, n):
        return d
    combined = matrix(here, at.COMBINED)[n - d]
    for j in range(m):
        combined[j] = 0.0
    combined[i] = vector(here, plain.WEIGHTS)[i]
    set_aside(here, i, row, own, d)
    return d - 1


@inner
def freeze(here, k, count, d, x):
    """What of level k is held, or soft, below it, where x is its answer: how many directions are left."""
    head, ids, state = ints(here, 0, plain.HEAD), marks(here, at.IDS), marks(here, at.STATE)
    n, lower, upper = head[plain.N], vector(here, plain.LOWER), vector(here, plain.UPPER)
    weights, value_of, rows = vector(here, plain.WEIGHTS), vector(here, at.VALUE), matrix(here, at.ROW)
    J, mixed = matrix(here, at.J), False
    for r in range(count):
        mixed = mixed or lower[ids[r]] != upper[ids[r]]
    if not mixed:
        return soften(here, count, d, x)
    for r in range(count):
        i, value = ids[r], 0.0
        for j in range(n):
            rows[i][j] = J[r][j]
            value += J[r][j] * x[j]
        low, high = weights[i] * lower[i], weights[i] * upper[i]
        off = max(value - high, low - value)
        if lower[i] == upper[i] or off > VIOLATED * (abs(value) + off):
            state[i], value_of[i] = HELD, value
            d = hold(here, i, r, d)
    return d


@inner
def shares_met(here, count, d):
    """What share of it the level meets of each combination of its rows: eigenvalues and eigenvectors of G M^-1 G'."""
    G, M, L, W = matrix(here, at.G), matrix(here, at.E), matrix(here, at.M), matrix(here, at.HALF)
    damped, directions = vector(here, at.VALUES), matrix(here, at.U)
    trace = 0.0
    for p in range(d):
        for q in range(p + 1):
            total = 0.0
            for r in range(count):
                total += G[r][p] * G[r][q]
            for r in range(d):
                total += damped[r] * directions[r][p] * directions[r][q]
            M[p][q] = M[q][p] = total
        trace += M[p][p]
    for p in range(d):
        M[p][p] += REGULAR * trace
    cholesky(M, L, d)
    for r in range(count):
        row, own = W[r], G[r]
        for p in range(d):
            total = own[p]
            for q in range(p):
                total -= L[p][q] * row[q]
            row[p] = total / L[p][p]
        for q in range(r + 1):
            other, total = W[q], 0.0
            for p in range(d):
                total += row[p] * other[p]
            M[r][q] = M[q][r] = total
    eigen(M, matrix(here, at.U), vector(here, at.VALUES), count)


@inner
def soften(here, count, d, x):
    """The same of a level of equalities: combined as it meets them, each held or soft by how well it is met."""
    head, ids, state = ints(here, 0, plain.HEAD), marks(here, at.IDS), marks(here, at.STATE)
    n, m, weights = head[plain.N], head[plain.ROWS], vector(here, plain.WEIGHTS)
    reached, rows, stiffness = vector(here, at.VALUE), matrix(here, at.ROW), vector(here, at.STIFFNESS)
    J, left = matrix(here, at.J), vector(here, at.MU)
    shares_met(here, count, d)
    Q, shares, basis = matrix(here, at.U), vector(here, at.VALUES), matrix(here, at.BASIS)
    for r in range(count):
        i, q, row, value = ids[r], Q[r], rows[ids[r]], 0.0
        for j in range(n):
            row[j] = 0.0
        for p in range(count):
            for j in range(n):
                row[j] += q[p] * J[p][j]
        for p in range(d):
            direction, along = basis[p], 0.0
            for j in range(n):
                along += row[j] * direction[j]
            left[p] = along
        for j in range(n):
            value += row[j] * x[j]
        reached[i], state[i] = value, LOST
        size, missed = length(left, d), max(1.0 - shares[r], 0.0)
        if not size > NONE * length(row, n) or d == 0:
            continue
        if STIFF * shares[r] <= STIFFEST * missed:
            stiff = STIFF * shares[r] / missed / size
            state[i], stiffness[i] = SOFT, stiff
            continue
        state[i], combined = HELD, matrix(here, at.COMBINED)[n - d]
        for j in range(m):
            combined[j] = 0.0
        for p in range(count):
            combined[ids[p]] = weights[ids[p]] * q[p]
        set_aside(here, i, left, row, d)
        d -= 1
    return d


@inner
def norm_of(here, count):
    """The largest singular value of J."""
    n, J, M = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), matrix(here, at.M)
    values, most = vector(here, at.VALUES), 0.0
    for r in range(count):
        for q in range(r + 1):
            one, other, total = J[r], J[q], 0.0
            for j in range(n):
                total += one[j] * other[j]
            M[r][q] = M[q][r] = total
    eigen(M, matrix(here, at.U), values, count)
    for r in range(count):
        most = max(most, values[r])
    return math.sqrt(most)


@inner
def write_above(here, k, A, lower, upper, weights):
    """The levels above k in its stage."""
    head, ptr, state = ints(here, 0, plain.HEAD), marks(here, plain.PTR), marks(here, at.STATE)
    n, levels = head[plain.N], head[plain.LEVELS]
    first, dense = marks(here, at.FIRST), marks(here, at.DENSE)
    rows, reached = matrix(here, at.ROW), vector(here, at.VALUE)
    for level in range(k):
        place, row = first[k * levels + level], dense[k * levels + level]
        for i in range(ptr[level], ptr[level + 1]):
            if state[i] == GIVEN:
                give(here, i, place, row, A, lower, upper, weights)
            else:
                own = floats(A, row * n, n)
                held = state[i] == HELD
                for j in range(n):
                    own[j] = rows[i][j] if held else 0.0
                weights[place] = 1.0
                lower[place] = reached[i] if held else -math.inf
                upper[place] = reached[i] if held else math.inf
            place += 1
            row += 1


@inner
def give(here, i, place, row, A, lower, upper, weights):
    """Row i of the hierarchy as it is, in a stage."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    col, row_of = marks(here, plain.COL), marks(here, plain.ROW_OF)
    if row >= 0:
        own = floats(A, row * n, n)
        for j in range(n):
            own[j] = 0.0
        if col[i] >= 0:
            own[col[i]] = 1.0
        else:
            given_row = matrix(here, plain.A)[row_of[i]]
            for j in range(n):
                own[j] = given_row[j]
    lower[place], upper[place] = vector(here, plain.LOWER)[i], vector(here, plain.UPPER)[i]
    weights[place] = vector(here, plain.WEIGHTS)[i]


@inner
def write_stage(here, k, d, size, lean):
    """The stage of level k."""
    head, ptr, state = ints(here, 0, plain.HEAD), marks(here, plain.PTR), marks(here, at.STATE)
    n, levels, curved = head[plain.N], head[plain.LEVELS], marks(here, at.CURVED)
    address, sizes = marks(here, at.NUMBERS)[k], marks(here, at.SIZES)
    entries, m = sizes[2 * k] * n, sizes[2 * k + 1]
    lower, upper = floats(address, entries, m), floats(address, entries + m, m)
    weights = floats(address, entries + 2 * m, m)
    write_above(here, k, address, lower, upper, weights)
    place, row = marks(here, at.FIRST)[k * levels + k], marks(here, at.DENSE)[k * levels + k]
    for i in range(ptr[k], ptr[k + 1]):
        give(here, i, place, row, address, lower, upper, weights)
        place, row = place + 1, row + 1
    rows, reached, stiffness = matrix(here, at.ROW), vector(here, at.VALUE), vector(here, at.STIFFNESS)
    for level in range(k):
        for i in range(ptr[level], ptr[level + 1] if curved[level] != 0 else ptr[level]):
            own, soft = floats(address, row * n, n), state[i] == SOFT
            scale = stiffness[i] * size if soft else 0.0
            for j in range(n):
                own[j] = scale * rows[i][j] if soft else 0.0
            weights[place] = 1.0
            lower[place] = scale * reached[i] if soft else -math.inf
            upper[place] = scale * reached[i] if soft else math.inf
            place, row = place + 1, row + 1
    write_damping(here, k, d, address, place, row, lower, upper, weights, lean * size)


@inner
def write_damping(here, k, d, address, place, row, lower, upper, weights, lean):
    r"""Rows of damping: :math:`\sum_p p (u_p^T (x - r))^2 + w^2 |x - v|^2`, one row for each direction :math:`u_p`."""
    n, U, values = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.U), vector(here, at.VALUES)
    aim, last, basis = matrix(here, at.AIMS)[k], vector(here, at.LAST), matrix(here, at.BASIS)
    for p in range(n):
        own, value = floats(address, row * n, n), 0.0
        for j in range(n):
            own[j] = 0.0
        total = values[p] + lean * lean if p < d else 0.0
        if total > 0.0:
            scale = math.sqrt(total)
            for q in range(d):
                direction, part = basis[q], scale * U[p][q]
                for j in range(n):
                    own[j] += part * direction[j]
            for j in range(n):
                value += own[j] * (values[p] * aim[j] + (lean * lean * last[j] if lean > 0.0 else 0.0)) / total
        weights[place], lower[place], upper[place] = 1.0, value, value
        place, row = place + 1, row + 1


@inner
def note_errors(here):
    """By how much every row is off: its error, as far as that is outside its band."""
    errors, calls, of = vector(here, at.ERRORS), marks(here, at.MEASURED), ints(here, 0, plain.HEAD)[at.MEASURES]
    for p in range(of):
        count, begin = calls[5 * p + 4], calls[5 * p + 3]
        error, below = floats(calls[5 * p], 0, count), floats(calls[5 * p + 1], 0, count)
        above = floats(calls[5 * p + 2], 0, count)
        for i in range(count):
            low, high = error[i] + below[i], error[i] + above[i]
            errors[begin + i] = low if low > 0.0 else high if high < 0.0 else 0.0


@inner
def begin(here):
    """All is as it is given, and all directions are left."""
    head, basis, state = ints(here, 0, plain.HEAD), matrix(here, at.BASIS), marks(here, at.STATE)
    for i in range(head[plain.ROWS]):
        state[i] = GIVEN
    for i in range(head[plain.N]):
        row = basis[i]
        for j in range(head[plain.N]):
            row[j] = 1.0 if i == j else 0.0


@inner
def solve_stage(here, k, count, d, bent):
    """The stage of level k: its outcome."""
    head, U, values = ints(here, 0, plain.HEAD), matrix(here, at.U), vector(here, at.VALUES)
    n, damped, point = head[plain.N], matrix(here, at.DAMPED)[k], matrix(here, at.POINTS)[k]
    directions, most = matrix(here, at.DIRECTIONS), 0.0
    for p in range(n):
        damped[p] = values[p] if bent and p < d else 0.0
        most = max(most, damped[p])
        for j in range(d):
            directions[k * n + p][j] = U[p][j] if bent and p < d else (1.0 if j == p else 0.0)
    size = norm_of(here, count)
    for p in range(n):
        values[p] = damped[p]
        for j in range(d):
            U[p][j] = directions[k * n + p][j]
    lean = 0.0
    if vector(here, at.LAST)[0] == vector(here, at.LAST)[0]:
        lean = LEAN / math.sqrt(vector(here, at.SHARES)[k])
    write_stage(here, k, d, size, lean)
    head[at.STAGE] = k
    directory = marks(here, at.DIRECTORIES)[k]
    outcome = called_on(head[at.SOLVE], directory, marks(here, at.NUMBERS)[k])
    x = vector(directory, plain.X)
    for j in range(n):
        point[j] = x[j]
    return outcome


@inner
def solve_stages(here, forced):
    """The stages from the first level on that is damped, or that is forced to be: the outcome of the last."""
    head = ints(here, 0, plain.HEAD)
    d, levels, curved, ids = head[plain.N], head[plain.LEVELS], marks(here, at.CURVED), marks(here, at.IDS)
    outcome, opened = integer(OPTIMAL), False
    head[at.OPENED] = levels
    begin(here)
    for k in range(head[at.TOP], levels):
        count = gather(here, k)
        least, longest = project(here, count, d)
        bent = curved[k] == 1 and bend(here, k, count, d, 0.0 if opened else least, longest)
        if not bent and not opened and k < forced:
            for r in range(count):
                d = hold(here, ids[r], r, d)
            continue
        if not opened:
            head[at.OPENED], opened = k, True
        outcome = solve_stage(here, k, count, d, bent)
        if outcome != OPTIMAL:
            return outcome
        if k + 1 < levels:
            d = freeze(here, k, count, d, matrix(here, at.POINTS)[k])
    return outcome


@inner
def at_limits(here):
    """Whether the strict answer is at a bound of the levels above those that are curved."""
    head, lower, upper = ints(here, 0, plain.HEAD), vector(here, plain.LOWER), vector(here, plain.UPPER)
    side = marks(marks(here, at.DIRECTORIES)[head[plain.LEVELS]], plain.SIDE)
    some = False
    for i in range(marks(here, plain.PTR)[head[at.TOP]]):
        some = some or (side[i] != INACTIVE and lower[i] != upper[i])
    return some


@inner
def solve_all(here, numbers):
    """Strict where nothing speaks against it, else in stages: the outcome of the last solve."""
    head = ints(here, 0, plain.HEAD)
    levels = head[plain.LEVELS]
    note_errors(here)
    outcome = solve_stages(here, levels)
    if outcome != OPTIMAL or head[at.OPENED] < levels:
        return outcome
    outcome = called_on(head[at.SOLVE], marks(here, at.DIRECTORIES)[levels], numbers)
    if outcome == OPTIMAL and vector(here, at.LAST)[0] == vector(here, at.LAST)[0] and at_limits(here):
        return solve_stages(here, head[at.TOP])
    return outcome


@stamp
@entry
def solve_curved(here, numbers):
    """Solve the hierarchy at the address `numbers`, with the curved levels that the directory lists."""
    head = ints(here, 0, plain.HEAD)
    given(here, numbers)
    head[at.OUTCOME] = solve_all(here, numbers)
    return head[at.OUTCOME]
