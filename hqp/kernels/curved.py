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
from .bend import TRUSTED, bend, gather, measure, norm_of, project, quiet, stack_above
from .call import called_on
from .compile import entry, inner, integer, stamp
from .memory import floats, given, ints, marks, matrix, vector
from .orthogonal import length
from .solver import SUSPECT
from .symmetric import cholesky, eigen

#: So stiff against the levels below are soft rows that are met as well as missed, times gain dt; and above the second
#: number they are held.
STIFF, STIFFEST = 6.0, 1e4
#: From where on curvatures count so much, beside the least square of the rows, that levels lean with all their weight.
DOUBTED = 2.5
#: How strongly a level leans on the last x, relative to its rows, times the root of gain dt: the first one, and those
#: below it.
LEAN, LEAN_BELOW = 0.0316, 0.8
#: A combination of rows that is so much shorter is none; and what is added to a matrix that has to be definite.
NONE, REGULAR = 1e-9, 1e-12
#: A bound counts from so much of the room on.
NEAR = 0.05
#: A row further from its bounds than this, relative to both, is violated.
VIOLATED = 1e-9


@inner
def begin(here):
    """All is as it is given, and all directions are left."""
    head, basis, metric = ints(here, 0, plain.HEAD), matrix(here, at.BASIS), matrix(here, at.METRIC)
    state = marks(here, at.STATE)
    for i in range(head[plain.ROWS]):
        state[i] = at.GIVEN
    for i in range(head[plain.N]):
        row, other = basis[i], metric[i]
        for j in range(head[plain.N]):
            row[j] = other[j] = 1.0 if i == j else 0.0


@inner
def set_aside(here, row, d):
    """Hold one more row below, which is `row` along Z: of Z, one direction less is left.

    By the reflection that brings the last direction to where the row is, :math:`I - 2 u u^T / |u|^2`.
    """
    n, basis, turned = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS), vector(here, at.REACH)
    size, total = length(row, d), 0.0
    row[d - 1] += size if row[d - 1] > 0.0 else -size
    for j in range(n):
        turned[j] = 0.0
    for p in range(d):
        direction = basis[p]
        total += row[p] * row[p]
        for j in range(n):
            turned[j] += row[p] * direction[j]
    for p in range(d):
        direction, share = basis[p], 2.0 * row[p] / total
        for j in range(n):
            direction[j] -= share * turned[j]


@inner
def along(here, row, d, out):
    """A row along the directions Z that are left; its length there, and its own."""
    n, basis = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS)
    for p in range(d):
        direction, total = basis[p], 0.0
        for j in range(n):
            total += row[j] * direction[j]
        out[p] = total
    return length(out, d), length(row, n)


@inner
def hold(here, row, d):
    """Hold a row below: how many directions are left."""
    left = vector(here, at.MU)
    size, whole = along(here, row, d, left)
    if d > 0 and size > NONE * whole:
        set_aside(here, left, d)
        return d - 1
    return d


@inner
def freeze(here, k, count, d, x, size):
    """What of level k is held, or soft, below it, where x is its answer: how many directions are left."""
    n, ids, state = ints(here, 0, plain.HEAD)[plain.N], marks(here, at.IDS), marks(here, at.STATE)
    lower, upper, weights = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, plain.WEIGHTS)
    reached, rows, J, mixed = (
        vector(here, at.VALUE),
        matrix(here, at.ROW),
        matrix(here, at.J),
        marks(here, at.CURVED)[k] == at.SPARED,
    )
    for r in range(count):
        mixed = mixed or lower[ids[r]] != upper[ids[r]]
    if not mixed:
        return soften(here, count, d, x, size)
    for r in range(count):
        i, value = ids[r], 0.0
        for j in range(n):
            rows[i][j] = J[r][j]
            value += J[r][j] * x[j]
        low, high = weights[i] * lower[i], weights[i] * upper[i]
        off = max(value - high, low - value)
        if lower[i] == upper[i] or off > VIOLATED * (abs(value) + off):
            state[i], reached[i] = at.HELD, value
            d = hold(here, J[r], d)
    return d


@inner
def compliance(here, count, d, size):
    """How softly the level gives way in each combination Q of its rows: eigenvalues of S^-1 V' D V S^-1, G = U' S V'.

    D is its damping, and what soft rows above it add. Returns how many combinations there are.
    """
    G, P, L, M = matrix(here, at.G), matrix(here, at.P), matrix(here, at.METRIC), matrix(here, at.M)
    U, Q, E, half, values = (
        matrix(here, at.U),
        matrix(here, at.Q),
        matrix(here, at.E),
        matrix(here, at.HALF),
        vector(here, at.VALUES),
    )
    for i in range(d):  # D = P + |J|^2 (1 - L^-1 L^-T); by columns of L^-1
        for j in range(d):
            E[i][j] = P[i][j] + (size * size if i == j else 0.0)
    for c in range(d):
        column = half[0]
        for p in range(c, d):
            total = 1.0 if p == c else 0.0
            for q in range(c, p):
                total -= L[p][q] * column[q]
            column[p] = total / L[p][p]
        for i in range(c, d):
            for j in range(c, d):
                E[i][j] -= size * size * column[i] * column[j]
    for r in range(count):
        for q in range(r + 1):
            one, other, total = G[r], G[q], 0.0
            for p in range(d):
                total += one[p] * other[p]
            M[r][q] = M[q][r] = total
    eigen(M, U, values, count)
    rank = integer(0)
    for r in range(count):
        if values[r] > NONE * NONE * size * size and rank < d:
            row, own = half[rank], U[r]
            for p in range(d):
                row[p] = 0.0
            for i in range(count):
                for p in range(d):
                    row[p] += own[i] / values[r] * G[i][p]
            for i in range(count):
                U[rank][i] = own[i]
            rank += 1
    for r in range(rank):
        for q in range(r + 1):
            total = 0.0
            for i in range(d):
                row, part = E[i], half[r][i]
                for j in range(d):
                    total += part * row[j] * half[q][j]
            M[r][q] = M[q][r] = total
    eigen(M, P, values, rank)  # P is no longer needed
    for r in range(rank):
        row = Q[r]
        for i in range(count):
            row[i] = 0.0
        for q in range(rank):
            for i in range(count):
                row[i] += P[r][q] * U[q][i]
    return rank


@inner
def soften(here, count, d, x, size):
    """The same of a level of equalities: combined by how softly it gives way, each held or soft."""
    n, ids, state = ints(here, 0, plain.HEAD)[plain.N], marks(here, at.IDS), marks(here, at.STATE)
    reached, rows, stiffness = vector(here, at.VALUE), matrix(here, at.ROW), vector(here, at.STIFFNESS)
    J, left, Q, soft = matrix(here, at.J), vector(here, at.MU), matrix(here, at.Q), vector(here, at.VALUES)
    rank = compliance(here, count, d, size)
    for r in range(count):
        i = ids[r]
        state[i] = at.LOST
        if r >= rank:
            continue
        row, value = rows[i], 0.0
        for j in range(n):
            row[j] = 0.0
        for p in range(count):
            for j in range(n):
                row[j] += Q[r][p] * J[p][j]
        for j in range(n):
            value += row[j] * x[j]
        reached[i] = value
        reach, _ = along(here, row, d, left)
        if d == 0 or not reach > 0.0:
            continue
        stiff = STIFF / vector(here, at.SHARES)[ints(here, 0, plain.HEAD)[at.TOP]]
        if soft[r] * STIFFEST > stiff:
            state[i], stiffness[i] = at.SOFT, stiff / (soft[r] * reach)
        else:
            state[i] = at.HELD
            set_aside(here, left, d)
            d -= 1
    return d


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
            if state[i] == at.GIVEN:
                give(here, i, place, row, A, lower, upper, weights)
            else:
                own = floats(A, row * n, n)
                held = state[i] == at.HELD
                for j in range(n):
                    own[j] = rows[i][j] if held else 0.0
                weights[place] = 1.0
                lower[place] = reached[i] if held else -math.inf
                upper[place] = reached[i] if held else math.inf
            place += 1
            if row >= 0:  # else the level has no rows of A
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
            own, soft = floats(address, row * n, n), state[i] == at.SOFT
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
    r"""Rows of damping, one a direction: :math:`(y - r)^T L P L^T (y - r) + w^2 |y - v|^2`, x being :math:`Z^T y`."""
    n, basis, L, P = (
        ints(here, 0, plain.HEAD)[plain.N],
        matrix(here, at.BASIS),
        matrix(here, at.METRIC),
        matrix(here, at.P),
    )
    M, K, half = matrix(here, at.M), matrix(here, at.U), matrix(here, at.HALF)
    aim, last, towards = matrix(here, at.AIMS)[k], vector(here, at.LAST), vector(here, at.MU)
    for p in range(d):
        for q in range(d):
            half[p][q] = 0.0
        for r in range(p + 1):
            for q in range(d):
                half[p][q] += L[p][r] * P[r][q]
    trace = 0.0
    for p in range(d):
        for q in range(p + 1):
            total = 0.0
            for r in range(q + 1):
                total += half[p][r] * L[q][r]
            M[p][q] = M[q][p] = total
        trace += M[p][p]
    for p in range(d):
        own, away = 0.0, 0.0
        for q in range(d):
            direction, total = basis[q], 0.0
            for j in range(n):
                total += direction[j] * aim[j]
            own += M[p][q] * total
        if lean > 0.0:
            for j in range(n):
                away += basis[p][j] * last[j]
        towards[p] = own + lean * lean * away
    more, some = lean * lean + REGULAR * trace, trace > 0.0 or lean > 0.0
    for p in range(d):
        M[p][p] += more
    some = some and cholesky(M, K, d)
    for p in range(n):
        own, value = floats(address, row * n, n), 0.0
        for j in range(n):
            own[j] = 0.0
        if some and p < d:
            for q in range(p, d):
                direction, part = basis[q], K[q][p]
                for j in range(n):
                    own[j] += part * direction[j]
            for q in range(p):
                towards[p] -= K[p][q] * towards[q]
            towards[p] /= K[p][p]
            value = towards[p]
        weights[place], lower[place], upper[place] = 1.0, value, value
        place, row = place + 1, row + 1


@inner
def note_errors(here):
    """By how much every row is off: its error, as far as that is outside its band, and as fast as it is to go."""
    scales = vector(here, at.SCALES)
    errors, calls, of = vector(here, at.ERRORS), marks(here, at.MEASURED), ints(here, 0, plain.HEAD)[at.MEASURES]
    for p in range(of):
        count, begin = calls[5 * p + 4], calls[5 * p + 3]
        error, below = floats(calls[5 * p], 0, count), floats(calls[5 * p + 1], 0, count)
        above = floats(calls[5 * p + 2], 0, count)
        for i in range(count):
            low, high = error[i] + below[i], error[i] + above[i]
            errors[begin + i] = scales[begin + i] * (low if low > 0.0 else high if high < 0.0 else 0.0)


@inner
def solve_stage(here, k, d, size, lean):
    """The stage of level k: its outcome."""
    head, point = ints(here, 0, plain.HEAD), matrix(here, at.POINTS)[k]
    if vector(here, at.LAST)[0] != vector(here, at.LAST)[0]:
        lean = 0.0
    write_stage(here, k, d, size, lean / math.sqrt(vector(here, at.SHARES)[k]))
    head[at.STAGE] = k
    directory = marks(here, at.DIRECTORIES)[k]
    outcome = called_on(head[at.SOLVE], directory, marks(here, at.NUMBERS)[k])
    x = vector(directory, plain.X)
    for j in range(head[plain.N]):
        point[j] = x[j]
    return outcome


@inner
def spare(here, d):
    """No damping: what :func:`hqp.kernels.bend.bend` gives of a level that is left strict."""
    P = matrix(here, at.P)
    for i in range(d):
        for j in range(d):
            P[i][j] = 0.0
    return 0.0, 0.0


@inner
def solve_stages(here, gate):
    """The stages from the first level on that is damped, or leans: the outcome of the last."""
    head, strengths, J = ints(here, 0, plain.HEAD), vector(here, at.STRENGTHS), matrix(here, at.J)
    d, levels = head[plain.N], head[plain.LEVELS]
    outcome, opened, above, damped, first = integer(OPTIMAL), False, integer(0), 0.0, True
    head[at.OPENED] = levels
    begin(here)
    for k in range(head[at.TOP], levels):
        strengths[k] = 0.0
        count = gather(here, k)
        least, size = project(here, count, d), 0.0
        if opened:
            size = norm_of(here, count)
            measure(here, k, d, count, size)
        spared = marks(here, at.CURVED)[k] == at.SPARED
        if spared:
            strength, ratio = spare(here, d)
        else:
            strength, ratio = bend(here, k, count, d, above, least, damped)
        fade = min(1.0, max(0.0, (ratio - TRUSTED) / (DOUBTED - TRUSTED))) ** 3
        gate = max(gate, fade)
        above = stack_above(here, count, above)
        if strength == 0.0 and (gate == 0.0 or spared) and not opened:
            for r in range(count):
                d = hold(here, J[r], d)
            first = False
            continue
        if not opened:
            head[at.OPENED], size = k, norm_of(here, count)
        lean = 0.0 if spared else math.sqrt(fade) * LEAN if first else math.sqrt(gate) * LEAN_BELOW
        first = False
        outcome = solve_stage(here, k, d, size, lean)
        if outcome != OPTIMAL:
            return outcome
        opened, strengths[k] = True, math.sqrt(strength)
        damped += strength
        if k + 1 < levels:
            d = freeze(here, k, count, d, matrix(here, at.POINTS)[k], size)
    return outcome


@inner
def crowded(here):
    """How close the strict answer moves along bounds of the levels above those that are curved: from 0 to 1, at one."""
    head = ints(here, 0, plain.HEAD)
    x = vector(marks(here, at.DIRECTORIES)[head[plain.LEVELS]], plain.X)
    n, col, row_of, A = head[plain.N], marks(here, plain.COL), marks(here, plain.ROW_OF), matrix(here, plain.A)
    lower, upper, gate = vector(here, plain.LOWER), vector(here, plain.UPPER), 0.0
    for i in range(marks(here, plain.PTR)[head[at.TOP]]):
        room = upper[i] - lower[i]
        if not room > 0.0 or room == math.inf:
            continue
        value = 0.0
        if col[i] >= 0:
            value = x[col[i]]
        else:
            row = A[row_of[i]]
            for j in range(n):
                value += row[j] * x[j]
        near = min(value - lower[i], upper[i] - value) / room
        if near < NEAR:  # who rests at a bound is calm
            moving = min(1.0, 2.0 * abs(value) / max(abs(lower[i]), abs(upper[i])))
            gate = max(gate, moving * min(1.0, 1.0 - near / NEAR))
    return gate


@inner
def solve_all(here, numbers):
    """Strict where nothing speaks against it, else in stages: the outcome of the last solve."""
    head = ints(here, 0, plain.HEAD)
    levels, gate = head[plain.LEVELS], 0.0
    if head[at.QUICK] != 0:
        cut = marks(marks(here, at.DIRECTORIES)[levels], plain.CUT)
        for k in range(levels + 1):
            cut[k] = -1
    strict = called_on(head[at.SOLVE], marks(here, at.DIRECTORIES)[levels], numbers)
    if strict == SUSPECT:
        return strict
    note_errors(here)
    if vector(here, at.LAST)[0] == vector(here, at.LAST)[0]:
        gate = crowded(here) if strict == OPTIMAL else 1.0
    if gate == 0.0 and head[at.QUICK] != 0 and quiet(here, marks(here, at.DIRECTORIES)[levels]):
        head[at.OPENED] = levels
        return strict
    outcome = solve_stages(here, gate)
    return outcome if head[at.OPENED] < levels else strict


@stamp
@entry
def solve_curved(here, numbers):
    """Solve the hierarchy at the address `numbers`, with the curved levels that the directory lists."""
    head = ints(here, 0, plain.HEAD)
    given(here, numbers)
    head[at.OUTCOME] = solve_all(here, numbers)
    return head[at.OUTCOME]
