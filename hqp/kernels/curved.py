r"""Solves a hierarchy with curved levels in one call: from the first damped level on, every level is its own stage.

How strongly a level is damped is decided in :mod:`.bend`. A stage is a plain hierarchy (:mod:`.stage`): the levels
above, held at the values that they reached, and this level, with the soft rows of the levels above (:mod:`.hand_over`)
and rows of damping. It is solved directly (:mod:`.direct`), or by the compiled solver, which is called by its address.
If no level is damped, the hierarchy is solved as it is given.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .active_set import OPTIMAL
from .bend import TRUSTED, bend, forget_bounds
from .brake import lags, note_asked
from .call import called_on
from .compile import entry, inner, integer, stamp
from .crowding import crowd, crowded, knows_last
from .curved_rows import apart, demand, gather, kept, measure, norm_of, note_bounds, project, stack_above
from .direct import solve_directly
from .hand_over import freeze, hold
from .lacking import leave_off_above, note_lacking
from .memory import floats, given, ints, marks, matrix, vector
from .redundant import least_apart
from .solver import SUSPECT
from .stage import write_damping, write_stage
from .trust import quiet
from .valid import valid

#: Added to the number of sweeps that is told of an answer in stages.
STAGED = 1 << 31
#: Ratio of the curvature to the smallest squared singular value of the rows from which the lean has its full weight.
DOUBTED = 2.5
#: Power with which it fades in from the ratio that is trusted on.
FADED = 1.5
#: Weight of the lean, which pulls a level towards the last x, relative to its rows and damping, times the root of
#: gain dt: on the first level that has a curvature, and below it. The lean makes x lag by its square over the gain; at
#: 1/2 the closed loop is critically damped.
LEAN, LEAN_BELOW = 0.0316, 0.6
#: Weight of the brake below the first level that has a curvature, relative to the longest row and to the soft rows
#: above, times the square of the gate: at acceleration order it pulls all directions to the aim of that first level.
#: Bends of an arm that is nearly straight are hardly felt by its rows, so that nothing else keeps the levels below from
#: swinging these; and soft rows turn and stiffen with the joints, which is a spring without a damper.
BRAKED = 0.2
#: The c in the metric of the lean, G'G + P + c |J|^2: as a rule; and if the last x moves along bounds, on the first
#: level and below it. Near bounds it is in between, as their geometric mean: the lag of weak directions grows like c.
ALIKE, ALIKE_AT_BOUNDS, ALIKE_BELOW = 0.06, 0.85, 1.0


@inner
def begin(here):
    """Reset a block: Z all its directions, their metric L the identity; then hold what is held above its levels."""
    head, basis, metric = ints(here, 0, plain.HEAD), matrix(here, at.BASIS), matrix(here, at.METRIC)
    columns, so_far = marks(here, at.COLUMNS), vector(here, at.SO_FAR)
    for p in range(len(basis)):
        row, other = basis[p], metric[p]
        for j in range(head[plain.N]):
            row[j] = 1.0 if j == columns[p] else 0.0
        for q in range(len(basis)):
            other[q] = 1.0 if p == q else 0.0
    head[at.STIFF] = head[at.OPEN] = head[at.STACKED] = 0
    head[at.FIRST_TASK], so_far[at.ABOVE_DAMPED] = 1, 0.0
    so_far[at.AT_BOUNDS] = crowded(here, vector(here, at.LAST))
    head[at.LEFT] = head[at.FREE] = hold_above(here)


@inner
def note_errors(here):
    """Write ``errors``: how far the error of every row is outside its band, times the scale (rate) of the row."""
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
def solve_stage(here, k):
    """Write the stage of level k and solve it; returns the outcome, and x goes to ``points[k]``."""
    head, point, blocks = ints(here, 0, plain.HEAD), matrix(here, at.POINTS)[k], marks(here, at.BLOCKS)
    head[at.STAGE], first, damped = k, integer(0), False
    for block in blocks:
        damped = write_damping(block, k, first)
        first += len(matrix(block, at.BASIS))
    if damped and head[at.QUICK] != 0 and len(blocks) == 1:
        if k == head[at.OPENED]:
            above = vector(marks(here, at.DIRECTORIES)[head[plain.LEVELS]], plain.X)
        else:
            above = matrix(here, at.POINTS)[k - 1]
        if solve_directly(here, k, above):
            head[at.SWEEPS] += 1
            return integer(OPTIMAL)
    write_stage(here, k)
    directory = marks(here, at.DIRECTORIES)[k]
    outcome = called_on(head[at.SOLVE], directory, marks(here, at.NUMBERS)[k])
    x, told = vector(directory, plain.X), ints(directory, 0, plain.HEAD)
    head[at.SWEEPS] += told[plain.SWEEPS]
    head[at.ITERATIONS] += told[plain.ITERATIONS]
    for j in range(head[plain.N]):
        point[j] = x[j]
    return outcome


@inner
def spare(here, d):
    """Set P to 0, and return what :func:`.bend.bend` returns for a level without damping."""
    P = matrix(here, at.P)
    for i in range(d):
        for j in range(d):
            P[i][j] = 0.0
    return 0.0, 0.0


@inner
def hold_above(here):
    """Hold the equalities of the levels above the first curved one, a frozen joint, say; returns what is left."""
    head, ids, J = ints(here, 0, plain.HEAD), marks(here, at.IDS), matrix(here, at.J)
    lower, upper, d = vector(here, plain.LOWER), vector(here, plain.UPPER), integer(len(matrix(here, at.BASIS)))
    for k in range(head[at.TOP]):
        for r in range(gather(here, k)):
            if lower[ids[r]] == upper[ids[r]]:
                d = hold(here, J[r], d)
    return d


@inner
def prepare(here, k, x):
    """Decide on level k of a block, below x (n,), how strongly it is damped and leans; whether it takes its own stage.

    Where it does not, its rows are held. Else the stage is written from what is noted here.
    """
    head, so_far, of = ints(here, 0, plain.HEAD), vector(here, at.SO_FAR), marks(here, at.CALLS_OF)
    d, above, free, opened, firmer = head[at.LEFT], head[at.STACKED], head[at.FREE], head[at.OPEN] != 0, 1.0
    if head[at.LOOKS_AHEAD] != 0 and k > head[at.TOP]:
        leave_off_above(here, x, d)
        note_lacking(here, k)
    count, J = gather(here, k), matrix(here, at.J)
    if count == 0 and (not opened or kept(here, k, x)):  # it asks for nothing
        head[at.ACTIVE], matrix(here, at.NORMS)[k][head[at.NUMBER]] = 0, 0.0
        return opened
    least, size = project(here, count, d), 0.0
    shortest = least
    spared = marks(here, at.CURVED)[k] == at.SPARED
    if k + 1 < head[plain.LEVELS] or not apart(here, count, free):
        head[at.STACKED] = stack_above(here, count, above, free)
    if not spared:
        least = least_apart(here, k, count, d, above, least)
    if opened:
        # bounds that x would pass: as firm as above
        size = norm_of(here, count, above, free) if count > 0 else so_far[at.SIZE]
        firmer = math.sqrt(demand(here, k, count, size)) if size > 0.0 else 1.0
        head[at.STIFF] = 1 if measure(here, k, d, firmer) else 0
    if spared:
        strength, ratio = spare(here, d)
    else:
        strength, ratio = bend(here, k, count, d, above, least, so_far[at.ABOVE_DAMPED])
    so_far[at.STRENGTH] = strength
    fade = min(1.0, max(0.0, (ratio - TRUSTED) / (DOUBTED - TRUSTED))) ** FADED
    if k == head[at.TOP]:
        so_far[at.FADE] = fade
    gate = so_far[at.GATE] = max(so_far[at.GATE], fade)
    head[at.ACTIVE] = count
    first = head[at.FIRST_TASK]  # a level without curvature, a joint held by a posture, say, is not the first task
    head[at.FIRST_TASK] = 1 if first != 0 and of[k + 1] == of[k] else 0
    if strength == 0.0 and (gate == 0.0 or spared) and not opened:
        for r in range(count):
            d = hold(here, J[r], d)
        head[at.LEFT] = d
        return False
    if not opened:
        size = norm_of(here, count, above, free)
    known = not spared and knows_last(here)
    lean = math.sqrt(gate) * (LEAN if first != 0 else LEAN_BELOW) if known else 0.0
    so_far[at.LEAN] = lean / math.sqrt(vector(here, at.SHARES)[k])
    so_far[at.ALIKE] = ALIKE * ((ALIKE_AT_BOUNDS if first != 0 else ALIKE_BELOW) / ALIKE) ** so_far[at.AT_BOUNDS]
    so_far[at.FIRM] = BRAKED * gate * gate if head[at.LOOKS_AHEAD] != 0 and first == 0 else 0.0
    so_far[at.SIZE], head[at.OPEN] = size, 1
    head[at.LAGS] = 1 if first == 0 and lags(here, lean, 0.0 if strength > 0.0 else shortest) else 0
    if head[at.LAGS] != 0:
        note_asked(here, count, d, x)
    matrix(here, at.NORMS)[k][head[at.NUMBER]] = firmer * size
    vector(here, at.STRENGTHS)[k] = max(vector(here, at.STRENGTHS)[k], math.sqrt(strength))
    so_far[at.ABOVE_DAMPED] += strength
    return True


@inner
def open_blocks(here):
    """Begin with the stages: nothing is damped or held yet but what is held above the curved levels."""
    head, state = ints(here, 0, plain.HEAD), marks(here, at.STATE)
    head[at.OPENED] = head[plain.LEVELS]
    head[at.SWEEPS] = head[at.ITERATIONS] = 0
    if head[at.LOOKS_AHEAD] != 0:  # as quiet() has done
        note_errors(here)
    for i in range(head[plain.ROWS]):
        state[i] = at.GIVEN
    for block in marks(here, at.BLOCKS):
        begin(block)


@inner
def prepare_all(here, k):
    """Prepare level k in all blocks; whether any of them takes its own stage."""
    vector(here, at.STRENGTHS)[k], some = 0.0, False
    strict = vector(marks(here, at.DIRECTORIES)[ints(here, 0, plain.HEAD)[plain.LEVELS]], plain.X)
    for block in marks(here, at.BLOCKS):
        own = ints(block, 0, plain.HEAD)
        if k >= own[at.TOP]:
            x = matrix(here, at.POINTS)[k - 1] if own[at.OPEN] != 0 else strict
            some = prepare(block, k, x) or some
    return some


@inner
def solve_stages(here, begun):
    """Solve stage by stage from the first level on that is damped or leans; returns the outcome of the last stage.

    The blocks come with their gates, from 0 to 1, which scale the lean of all levels. OPENED is set to the first level
    with a stage of its own. `begun` tells that the first curved level is prepared, and takes one.
    """
    head, blocks, outcome = ints(here, 0, plain.HEAD), marks(here, at.BLOCKS), integer(OPTIMAL)
    levels = head[plain.LEVELS]
    if not begun:
        open_blocks(here)
    for k in range(head[at.TOP], levels):
        if not (begun and k == head[at.TOP]) and not prepare_all(here, k):
            continue
        head[at.OPENED] = min(head[at.OPENED], k)
        outcome = solve_stage(here, k)
        if outcome != OPTIMAL:
            return outcome
        for block in blocks:
            own = ints(block, 0, plain.HEAD)
            if own[at.OPEN] != 0 and k + 1 < levels:
                x, size = matrix(here, at.POINTS)[k], vector(block, at.SO_FAR)[at.SIZE]
                own[at.LEFT] = freeze(block, k, own[at.ACTIVE], own[at.LEFT], x, size)
    return outcome


@inner
def look(here):
    """Note how far off the rows are; what bounds their curvatures is found when it is needed."""
    note_errors(here)
    forget_bounds(here)
    for block in marks(here, at.BLOCKS):
        forget_bounds(block)


@inner
def needs_no_strict(here):
    """Whether the strict answer matters to no stage; the first curved level is then prepared.

    Of the strict answer stages take how much it jumps at bounds, which matters to a gate below 1, and what is held
    above the first of them. So it is left out where neither is the case, if that was so in the last solve, too.
    """
    head, so_far = ints(here, 0, plain.HEAD), vector(here, at.SO_FAR)
    if head[at.QUICK] == 0 or len(marks(here, at.BLOCKS)) > 1 or so_far[at.FADE] < 1.0 or not valid(here):
        return False
    note_bounds(here)
    so_far[at.GATE] = 0.0
    open_blocks(here)
    if head[at.LEFT] < len(matrix(here, at.BASIS)):
        return False
    return prepare_all(here, head[at.TOP]) and so_far[at.GATE] == 1.0


@inner
def solve_all(here, numbers):
    """Solve the strict hierarchy, then in stages if a level has to be damped; returns the outcome of the last solve."""
    head = ints(here, 0, plain.HEAD)
    levels = head[plain.LEVELS]
    look(here)
    fits = head[at.QUICK] != 0 and head[at.OPENED] == levels  # else stages were needed, and most likely are again
    if not fits and needs_no_strict(here):
        return solve_stages(here, True)
    if head[at.QUICK] != 0:
        ints(marks(here, at.DIRECTORIES)[levels], 0, plain.HEAD)[plain.BASIS] = 1 if fits else 0
        cut = marks(marks(here, at.DIRECTORIES)[levels], plain.CUT)
        for k in range(levels + 1):
            cut[k] = -1
    strict = called_on(head[at.SOLVE], marks(here, at.DIRECTORIES)[levels], numbers)
    if strict == SUSPECT:
        return strict
    if crowd(here, strict) == 0.0 and fits and strict == OPTIMAL and quiet(here, marks(here, at.DIRECTORIES)[levels]):
        head[at.OPENED] = levels
        return strict
    outcome = solve_stages(here, False)
    return outcome if head[at.OPENED] < levels else strict


@inner
def note_stages(here):
    """Note with what is told of the stages which levels have one, and what their damping pulled to."""
    head, span, aims, aimed = (
        ints(here, 0, plain.HEAD),
        marks(here, at.SPAN),
        matrix(here, at.AIMS),
        matrix(here, at.AIMED),
    )
    span[0], span[1] = head[at.OPENED], head[at.STAGE]
    for k in range(head[plain.LEVELS]):
        for j in range(head[plain.N]):
            aimed[k][j] = aims[k][j]


@inner
def tell_stages(here):
    """Tell x and the work of all stages where those of the strict answer are told."""
    head = ints(here, 0, plain.HEAD)
    there, point = marks(here, at.DIRECTORIES)[head[plain.LEVELS]], matrix(here, at.POINTS)[head[plain.LEVELS] - 1]
    told, x = ints(there, 0, plain.HEAD), vector(there, plain.X)
    told[plain.SWEEPS], told[plain.ITERATIONS] = head[at.SWEEPS] + STAGED, head[at.ITERATIONS]
    for j in range(head[plain.N]):
        x[j] = point[j]


@stamp
@entry
def solve_curved(here, numbers):
    """Solve the hierarchy at the address `numbers`, with the curved levels of the directory; returns the outcome.

    Where the native solver solves, x and the work are told in the directory of the strict hierarchy.
    """
    head = ints(here, 0, plain.HEAD)
    given(here, numbers)
    for block in marks(here, at.BLOCKS):
        given(block, numbers)
    outcome = solve_all(here, numbers)
    if head[at.OPENED] < head[plain.LEVELS]:
        note_stages(here)
        if head[at.QUICK] != 0:
            tell_stages(here)
    return outcome
