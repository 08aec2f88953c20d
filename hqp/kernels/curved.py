r"""Curved levels: each a stage of its own from the first on that is damped (:mod:`.bend`), in one call.

A stage is a plain hierarchy (:mod:`.stage`): the levels above, held where they are, and this one, with rows for what of
those above is soft (:mod:`.hand_over`), and rows of damping. The compiled solver that solves it is called by its
address. Where no level is damped, the hierarchy is solved as it stands.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .active_set import OPTIMAL
from .bend import TRUSTED, bend, gather, measure, norm_of, project, stack_above
from .call import called_on
from .compile import entry, inner, integer, stamp
from .hand_over import freeze, hold
from .memory import floats, given, ints, marks, matrix, vector
from .solver import SUSPECT
from .stage import write_stage
from .trust import crowded, quiet

#: From where on curvatures count so much, beside the least square of the rows, that levels lean with all their weight.
DOUBTED = 2.5
#: How strongly a level leans on the last x, relative to its rows and its damping, times the root of gain dt: the first
#: one, and those below it. A lean is a lag of its square over the gain: at 1/2 the closed loop is critically damped.
LEAN, LEAN_BELOW = 0.0316, 0.6
#: What the lean takes every direction for at least, relative to the longest row, squared; and what where the last x is
#: at bounds: on the first level, and below it.
ALIKE, ALIKE_AT_BOUNDS, ALIKE_BELOW = 0.08, 0.3, 1.0


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
def solve_stage(here, k, d, count, size, lean, alike):
    """The stage of level k: its outcome."""
    head, point = ints(here, 0, plain.HEAD), matrix(here, at.POINTS)[k]
    if vector(here, at.LAST)[0] != vector(here, at.LAST)[0]:
        lean = 0.0
    write_stage(here, k, d, count, size, lean / math.sqrt(vector(here, at.SHARES)[k]), alike)
    head[at.STAGE], vector(here, at.NORMS)[k] = k, size
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
    at_bounds = crowded(here, vector(here, at.LAST))
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
        lean = 0.0 if spared else math.sqrt(gate) * (LEAN if first else LEAN_BELOW)
        alike = max(ALIKE, at_bounds * (ALIKE_AT_BOUNDS if first else ALIKE_BELOW))
        first = False
        outcome = solve_stage(here, k, d, count, size, lean, alike)
        if outcome != OPTIMAL:
            return outcome
        opened, strengths[k] = True, math.sqrt(strength)
        damped += strength
        if k + 1 < levels:
            d = freeze(here, k, count, d, matrix(here, at.POINTS)[k], size)
    return outcome


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
        answer = vector(marks(here, at.DIRECTORIES)[levels], plain.X)
        gate = crowded(here, answer) if strict == OPTIMAL else 1.0
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
