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
from .bend import NONE, bend, gather, project
from .call import called_on
from .compile import entry, inner, integer, stamp
from .memory import floats, given, ints, marks, matrix, vector
from .orthogonal import length

#: What has become of a row: as it is given; a combination of its level, held, or soft; or nothing is left of it.
GIVEN, HELD, SOFT, LOST = 0, 1, 2, 3
#: How much stiffer against the levels below a soft row is than its damping.
STIFF = 15.0
#: How strongly a level leans on the last x, relative to its rows, times the root of gain dt.
LEAN = 0.0316
#: A row further from its bounds than this, relative to both, is violated.
VIOLATED = 1e-9


@inner
def extend(here, i, row, own, c):
    """Hold one more row below: `row` is what V[:c] leaves of it, combined from rows as COMBINED[c] says."""
    n = ints(here, 0, plain.HEAD)[plain.N]
    V, T = matrix(here, at.V), matrix(here, at.T)
    direction, along = V[c], T[c]
    scale = 1.0 / length(row, n)
    for j in range(n):
        direction[j] = scale * row[j]
    for q in range(c + 1):
        other, total = V[q], 0.0
        for j in range(n):
            total += own[j] * other[j]
        along[q] = total


@inner
def hold(here, i, r, c):
    """Hold the r-th row of the level at hand, number i, as it is: how many rows V has then."""
    n, m = ints(here, 0, plain.HEAD)[plain.N], ints(here, 0, plain.HEAD)[plain.ROWS]
    own, row, V = matrix(here, at.J)[r], matrix(here, at.G)[r], matrix(here, at.V)
    if c == n:
        return c
    for j in range(n):
        row[j] = own[j]
    for _ in range(2):
        for q in range(c):
            direction, along = V[q], 0.0
            for j in range(n):
                along += row[j] * direction[j]
            for j in range(n):
                row[j] -= along * direction[j]
    if not length(row, n) > NONE * length(own, n):
        return c
    combined = matrix(here, at.COMBINED)[c]
    for j in range(m):
        combined[j] = 0.0
    combined[i] = vector(here, plain.WEIGHTS)[i]
    extend(here, i, row, own, c)
    return c + 1


@inner
def freeze(here, k, count, c, x):
    """What of level k is held, or soft, below it, where x is its answer: how many rows V has then."""
    head, ptr, ids, state = ints(here, 0, plain.HEAD), marks(here, plain.PTR), marks(here, at.IDS), marks(here, at.STATE)
    n, lower, upper = head[plain.N], vector(here, plain.LOWER), vector(here, plain.UPPER)
    weights, value_of, rows = vector(here, plain.WEIGHTS), vector(here, at.VALUE), matrix(here, at.ROW)
    J, mixed = matrix(here, at.J), False
    for i in range(ptr[k], ptr[k + 1]):
        state[i] = GIVEN
    for r in range(count):
        mixed = mixed or lower[ids[r]] != upper[ids[r]]
    if not mixed:
        return soften(here, k, count, c, x)
    for r in range(count):
        i, value = ids[r], 0.0
        for j in range(n):
            rows[i][j] = J[r][j]
            value += J[r][j] * x[j]
        low, high = weights[i] * lower[i], weights[i] * upper[i]
        off = max(value - high, low - value)
        if lower[i] == upper[i] or off > VIOLATED * (abs(value) + off):
            state[i], value_of[i] = HELD, value
            c = hold(here, i, r, c)
    return c


@inner
def soften(here, k, count, c, x):
    """The same of a level of equalities: combined by its singular vectors, one by one held or soft."""
    n, m = ints(here, 0, plain.HEAD)[plain.N], ints(here, 0, plain.HEAD)[plain.ROWS]
    ids, state, weights = marks(here, at.IDS), marks(here, at.STATE), vector(here, plain.WEIGHTS)
    reached, rows, strength = vector(here, at.VALUE), matrix(here, at.ROW), vector(here, at.STRENGTH)
    J, G, Q, squares = matrix(here, at.J), matrix(here, at.G), matrix(here, at.Q), vector(here, at.SQUARES)
    U, values, left = matrix(here, at.U), vector(here, at.VALUES), vector(here, at.MU)
    largest = 0.0
    for r in range(count):
        largest = max(largest, squares[r])
    for r in range(count):
        i, q, row, value = ids[r], Q[r], rows[ids[r]], 0.0
        for j in range(n):
            row[j] = left[j] = 0.0
        for p in range(count):
            for j in range(n):
                row[j] += q[p] * J[p][j]
                left[j] += q[p] * G[p][j]
        for j in range(n):
            value += row[j] * x[j]
        reached[i], state[i] = value, LOST
        if not squares[r] > NONE * NONE * largest or c == n:
            continue
        damping = 0.0
        for p in range(n):
            if values[p] > 0.0:
                along = 0.0
                for j in range(n):
                    along += U[p][j] * left[j]
                damping += values[p] * along * along / squares[r]
        if damping > squares[r]:
            state[i], strength[i] = SOFT, math.sqrt(damping)
            continue
        state[i], combined = HELD, matrix(here, at.COMBINED)[c]
        for j in range(m):
            combined[j] = 0.0
        for p in range(count):
            combined[ids[p]] = weights[ids[p]] * q[p]
        extend(here, i, left, row, c)
        c += 1
    return c


@inner
def longest(here, count):
    """The length of the rows of the level at hand, as one number."""
    n, J = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J)
    total = 0.0
    for r in range(count):
        total = max(total, length(J[r], n))
    return total


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
def write_stage(here, k, count, lean):
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
    rows, reached, strength = matrix(here, at.ROW), vector(here, at.VALUE), vector(here, at.STRENGTH)
    size = longest(here, count)
    for level in range(k):
        for i in range(ptr[level], ptr[level + 1] if curved[level] != 0 else ptr[level]):
            own, soft = floats(address, row * n, n), state[i] == SOFT
            scale = STIFF / strength[i] * size if soft else 0.0
            for j in range(n):
                own[j] = scale * rows[i][j] if soft else 0.0
            weights[place] = 1.0
            lower[place] = scale * reached[i] if soft else -math.inf
            upper[place] = scale * reached[i] if soft else math.inf
            place, row = place + 1, row + 1
    write_damping(here, k, address, place, row, lower, upper, weights, lean * size)


@inner
def write_damping(here, k, address, place, row, lower, upper, weights, lean):
    r"""Rows of damping: :math:`\sum_p p (u_p^T (x - r))^2 + w^2 |x - v|^2`, one row for each direction :math:`u_p`."""
    n, U, values = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.U), vector(here, at.VALUES)
    aim, last = matrix(here, at.AIMS)[k], vector(here, at.LAST)
    for p in range(n):
        own, total = floats(address, row * n, n), values[p] + lean * lean
        scale, towards, onwards = math.sqrt(total), 0.0, 0.0
        for j in range(n):
            own[j] = scale * U[p][j]
            towards += U[p][j] * aim[j]
            onwards += U[p][j] * last[j]
        value = 0.0
        if total > 0.0:
            value = (values[p] * towards + (lean * lean * onwards if lean > 0.0 else 0.0)) / scale
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
def solve_stages(here, numbers):
    """All of it: the outcome of the last solve."""
    head = ints(here, 0, plain.HEAD)
    n, levels, curved = head[plain.N], head[plain.LEVELS], marks(here, at.CURVED)
    directories, stages, points = marks(here, at.DIRECTORIES), marks(here, at.NUMBERS), matrix(here, at.POINTS)
    ptr, state, ids, damped = marks(here, plain.PTR), marks(here, at.STATE), marks(here, at.IDS), matrix(here, at.DAMPED)
    U, values, last = matrix(here, at.U), vector(here, at.VALUES), vector(here, at.LAST)
    outcome, c, opened = integer(OPTIMAL), integer(0), False
    head[at.OPENED] = levels
    note_errors(here)
    for i in range(ptr[levels]):
        state[i] = GIVEN
    for k in range(levels):
        if curved[k] == 0:
            continue
        count = gather(here, k)
        largest = project(here, count, c)
        bent = bend(here, k, count, c, largest)
        if not bent and not opened:
            for r in range(count):
                c = hold(here, ids[r], r, c)
            continue
        if not opened:
            head[at.OPENED], opened = k, True
        if not bent:
            for p in range(n):
                values[p] = 0.0
                for j in range(n):
                    U[p][j] = 1.0 if j == p else 0.0
        for p in range(n):
            damped[k][p] = values[p]
        lean = LEAN / math.sqrt(vector(here, at.SHARES)[k]) if last[0] == last[0] else 0.0
        write_stage(here, k, count, lean)
        outcome = called_on(head[at.SOLVE], directories[k], stages[k])
        head[at.STAGE] = k
        if outcome != OPTIMAL:
            return outcome
        x = vector(directories[k], plain.X)
        for j in range(n):
            points[k][j] = x[j]
        c = freeze(here, k, count, c, x)
    if not opened:
        outcome = called_on(head[at.SOLVE], directories[levels], numbers)
    return outcome


@stamp
@entry
def solve_curved(here, numbers):
    """Solve the hierarchy at the address `numbers`, with the curved levels that the directory lists."""
    head = ints(here, 0, plain.HEAD)
    given(here, numbers)
    head[at.OUTCOME] = solve_stages(here, numbers)
    return head[at.OUTCOME]
