"""The directory of all arrays that kernels work on; its address is the one argument `here` of every kernel.

Passing fifty arrays as arguments would cost more than a small solve, and most of the time of compilation. So the arrays
lie in memory that the caller keeps, and a directory of integers tells where: first HEAD single numbers, then for every
array its address, rows and columns. A kernel takes the arrays that it needs by the names below (:mod:`.memory`).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

#: Numbers at the head of the directory. The structure: unknowns, levels, rows, and whether level 0 is plain bounds on
#: distinct variables.
N, LEVELS, ROWS, BOXED = 0, 1, 2, 3
#: Input of a solve: whether SIDE holds a guess, and whether the entries of very long rows were checked before. Output:
#: the level of the status, sweeps, iterations, outcome.
WARM, TRUSTED, LEVEL, SWEEPS, ITERATIONS, OUTCOME = 4, 5, 6, 7, 8, 15
#: For many hierarchies in one call: how many (0: one); how many numbers each has; and the addresses of their x_ref (0:
#: the same for all), x, sides and outcomes.
COUNT, STRIDE, REFERENCES, POINTS, SIDES, OUTCOMES = 9, 10, 11, 12, 13, 14
#: When the call began, by the clock of :mod:`.memory` (0: when the kernel begins); when the solve must end; what SAVED
#: has of the last solve (:mod:`.attempts`; 0: nothing); how many levels are damped; the address of a second directory,
#: in which rows of damping are ordinary rows; whether damped levels have aims of their own (0: x_ref); and whether the
#: rank of a level is in doubt (:mod:`.doubt`); whether the last level asks for single variables (:mod:`.closing`);
#: and whether the caller needs a basis of all levels from the sweep.
BEGAN, DEADLINE, HISTORY, DAMPED, TWIN, AIMED, DOUBT, CLOSES, BASIS = 16, 17, 18, 19, 20, 21, 22, 23, 24
#: 1 + the number of variables that are not asked, while :mod:`.levels` works in the metric of the last level; else 0.
#: For the certificate (:mod:`.proof`): whether it judges all levels, and what it has found: the first level that fails,
#: PASSES or UNJUDGED. Of the kernels that are called by them (:mod:`.apart`), the addresses, 0 while one is not ready,
#: and whether one was called that is not. HEAD is the number of these numbers.
METRIC, ALL, FAILS, CERTIFICATE, SAFE_METHOD, LACKS, HEAD = 25, 26, 27, 28, 29, 30, 31
#: What an iteration adds to what is told of the work of a run in one number: sweeps + ITERATION * iterations.
ITERATION = 1 << 32
#: In place of a level that fails: none does; and x was not judged.
PASSES, UNJUDGED = -1, -2

#: Places in OPTION: relative tolerances on rank and on rows; most iterations; most seconds; the tolerance on rows of
#: the certificate; and BLUR, what the round-off of x_0 adds to the length of x to which tolerances are relative
#: (:mod:`.extent`). OPTIONS is the number of these numbers.
TAU, TOL, BUDGET, LIMIT, JUDGED, BLUR, OPTIONS = 0, 1, 2, 3, 4, 5, 6
#: What the certificate tells of a level, places in a row of VERDICT: whether it is optimal, and how that was seen; the
#: length of its weighted slacks; the sum of its forces; the share of them that nothing balances; the sum of the
#: multipliers of signed rows above, times how far these may be from their bounds; and the largest distance of x from
#: one of its rows. TELLS is the number of these numbers.
ACCEPTED, RESIDUAL, TOTAL, UNBALANCED, GIVES, REACH, TELLS = 0, 1, 2, 3, 4, 5, 6
#: Rows that are orthogonalised have zeros up to a multiple of so many entries: what a vectorised loop leaves over is
#: done one by one, and takes as long as all the rest. As many are a line of the processor's cache: arrays begin with
#: one, so that no step of such a loop reads two.
PAD = 8
#: Numbers of a damping rule: its kind and two parameters.
RULE = 3

# The structure. PTR: the rows of level k are PTR[k] .. PTR[k + 1] - 1. WHOLE: whether level k bounds every variable
# once. COL: the variable of a plain bound, or -1. ROW_OF: the row of A, or -1.
# The hierarchy as given (A, LOWER, UPPER, WEIGHTS, X_REF), and as it is solved: weighted rows B and bounds LO, HI; the
# lengths NORM of the weighted rows (of a plain bound, its weight); and X0, the reference of the implicit last level.
(PTR, WHOLE, COL, ROW_OF, A, LOWER, UPPER, WEIGHTS, B, LO, HI, NORM, X_REF, X0, OPTION) = range(15)
# The point X and the weighted slacks W. The guess SIDE of the active set; FOLLOW, the sides that its contradictions
# suggest; DECIDED, whether the sign of a row's multiplier is clear. The orthonormal basis V; coefficients L of the rows
# along V; their remainders R; Householder reflections H; PIVOT, the row from which each row of V was made: see
# :mod:`.orthogonal`. IDS .. RHS: the active rows of one level, in order.
(X, W, SIDE, FOLLOW, DECIDED, V, L, R, H, PIVOT, IDS, SLOTS, LENGTHS, RHS) = range(15, 29)
# Work arrays with an entry for each variable,
(Y, G, BALANCE, PINNED, FREE, QUEUE, D, MULTIPLIER, SHARE, SCRATCH, SAFE) = range(29, 40)
# and with an entry for each level (CUT, FORCES) or row.
(CUT, FORCES, VALUE, SLOPE, LOW, HIGH, ALLOWED, KIND, HELD) = range(40, 49)
# For :mod:`.levels`: x_E, from which the level starts; the exact point of the levels above; the point of the dual; the
# sides at the end of each level, (levels + 1, m); P, the rows projected onto the null space of V[:DEPTH]; DEPTH, for
# each row; and the multipliers.
(ANCHOR, EXACT, APPROACH, SAVED, P, DEPTH, LAMBDA) = range(49, 56)
# For :mod:`.dual` and :mod:`.members`, in the order of the members: their rows, and the arrays of their factor.
(MEMBERS, FACTOR, DIAGONAL, Z, WANTED, RIGHT, SOFT, FORCE, CARRY, SHED) = range(56, 66)
# For :mod:`.damped`: the damped levels; the rule of each; the sides at the end of each stage, (2 damped + 1, m); of
# each damped level lambda, whether x_a was computed, x_a and x_k; and its aim.
(WHICH, RULES, STAGES, PASSED, AIMS) = range(66, 71)
# For :mod:`.closing` and :mod:`.metric`: the row that asks for each variable, or -1; the metric, 1 for variables that
# are not asked; and a displacement in it.
(ASKS, SCALE, MOVED) = range(71, 74)
# For :mod:`.levels`: where the entries of each row begin and end that are not 0.
(BEGIN, END) = range(74, 76)
# For :mod:`.proof`, if it judges all levels: what it tells of each, and the multipliers of the rows above,
# (levels + 1, m).
(VERDICT, HELD_BY) = range(76, 78)


def padded(count):
    """`count`, rounded up to a multiple of PAD: as many entries do loops over rows take that end in zeros."""
    return (count + PAD - 1) & -PAD


def shapes(n, levels, m, dense, widest, damped):
    """Shapes of all arrays that the caller does not own, place -> (rows, columns): dicts of integer and float arrays.

    `m` is the number of all rows, `dense` that of A, `widest` that of the largest level, `damped` how many are damped.
    """
    deep, many, spare, wide = widest + n, min(m, 2 * n + 8), n if damped else 0, padded(n)
    ints = dict.fromkeys((SIDE, FOLLOW, DECIDED, KIND, HELD, BEGIN, END), (m, 1))
    ints |= dict.fromkeys((PINNED, FREE, PIVOT, QUEUE, ASKS), (n, 1))
    ints |= dict.fromkeys((IDS, SLOTS), (deep, 1)) | {CUT: (levels + 1, 1), MEMBERS: (many, 1)}
    ints |= {SAVED: ((levels + 1) * m, 1), DEPTH: (m, 1)}
    ints |= {STAGES: ((2 * damped + 1) * m if damped else 0, 1)}
    reals = dict.fromkeys((LO, HI, NORM, VALUE, SLOPE, LOW, HIGH, ALLOWED), (m, 1)) | {W: (m + spare, 1)}
    reals |= dict.fromkeys((X_REF, X0, X, Y, G, BALANCE, D, MULTIPLIER, SHARE, SAFE), (n, 1))
    reals |= {B: (dense, n), V: (n, wide), L: (m + spare, n), R: (deep, wide), H: (n, deep)}
    reals |= {FORCES: (levels, 1), OPTION: (OPTIONS, 1)}
    reals |= dict.fromkeys((LENGTHS, RHS), (deep, 1))
    reals |= dict.fromkeys((ANCHOR, EXACT, APPROACH, SCALE), (n, 1)) | dict.fromkeys((SCRATCH, MOVED), (wide, 1))
    reals |= {P: (m + n, wide), LAMBDA: (m, 1), FACTOR: (many, many)}
    reals |= dict.fromkeys((DIAGONAL, Z, WANTED, RIGHT, SOFT, FORCE, CARRY, SHED), (many, 1))
    reals |= {RULES: (damped, RULE), PASSED: (damped, 2 + 2 * n), AIMS: (damped, n)}
    reals |= {VERDICT: (levels + 1, TELLS), HELD_BY: (levels + 1, m)}
    return ints, reals


#: Places of all integer arrays in memory, and of all arrays of floats.
PLACES = tuple(np.array(list(block)) for block in shapes(0, 0, 0, 0, 0, 0))


def lay_out(structure, damped=(), rows_of_damping=False):
    """Make a directory for hierarchies of this structure.

    Parameters
    ----------
    structure : tuple
        As :attr:`hqp.Hierarchy.structure`.
    damped : sequence of int
        The damped levels.
    rows_of_damping : bool
        Whether each of these has one more bound on every variable, as its last rows.

    Returns
    -------
    directory : int64 array
        For the arrays in memory it has the offset in place of the address, which the caller adds.
    owned : dict
        Place -> int64 array of the structure. The directory has their addresses: the caller must keep them.
    sizes : (int, int)
        How many integers and floats of memory are needed.
    """
    n, cuts, has_rows, indices = structure
    columns = np.frombuffer(indices, dtype=np.intp)
    levels = [columns[a:b] for a, b in pairwise(cuts)]
    distinct = [not rows and len(np.unique(own)) == len(own) for rows, own in zip(has_rows, levels, strict=True)]
    whole = [alone and len(own) == n for alone, own in zip(distinct, levels, strict=True)]
    if rows_of_damping:
        levels = [np.append(own, np.arange(n)) if k in damped else own for k, own in enumerate(levels)]
        columns, cuts = np.concatenate(levels), np.cumsum([0, *map(len, levels)])
    if damped:  # their stages have rows of damping, and end with them
        whole = [every and k > damped[-1] for k, every in enumerate(whole)]
        distinct = [alone and k not in damped for k, alone in enumerate(distinct)]
    dense = columns < 0
    owned = {PTR: cuts, WHOLE: whole, COL: columns, ROW_OF: np.where(dense, np.cumsum(dense) - 1, -1)}
    owned |= {WHICH: damped}
    owned = {place: np.array(given, dtype=np.int64) for place, given in owned.items()}

    m, rows = len(columns), int(dense.sum())
    directory = np.zeros(HEAD + 3 * (HELD_BY + 1), dtype=np.int64)
    directory[[N, LEVELS, ROWS, BOXED, DAMPED]] = n, len(levels), m, distinct[:1] == [True], len(damped)
    entries = directory[HEAD:].reshape(-1, 3)
    for place, array in owned.items():
        entries[place] = array.ctypes.data, len(array), 1
    entries[[A, LOWER, UPPER, WEIGHTS], 1:] = (rows, n), (m, 1), (m, 1), (m, 1)
    sizes = []
    for block in shapes(n, len(levels), m, rows, max(map(len, levels), default=0), len(damped)):
        begins = 0
        for place, shape in block.items():
            entries[place] = begins, *shape
            begins += padded(shape[0] * shape[1])
        sizes.append(begins)
    return directory, owned, tuple(sizes)
