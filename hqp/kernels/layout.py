"""The one address that kernels are handed: a directory of everything they work on.

Fifty arrays as arguments cost more than a small solve, and most of the time of compilation. So the arrays lie in
memory that the caller keeps, and a directory of integers says where: first some numbers, then for every array its
address, rows and columns. A kernel asks for the arrays that it uses, by name (:mod:`.memory`).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

#: Numbers at the head of the directory: the structure,
N, LEVELS, ROWS, BOXED = 0, 1, 2, 3
#: what a solve is told (whether the sides are a guess; that long rows were looked at), and what it reports,
WARM, TRUSTED, LEVEL, SWEEPS, ITERATIONS, OUTCOME = 4, 5, 6, 7, 8, 15
#: and for many hierarchies in one call their number (0: one), how many numbers each has, and the addresses of their
#: x_ref (0: the same for all), x, sides and outcomes.
COUNT, STRIDE, REFERENCES, POINTS, SIDES, OUTCOMES = 9, 10, 11, 12, 13, 14
#: When the call began, by the clock of :mod:`.memory` (0: when the kernel does). And what a solve notes for itself:
#: when it must end, and whether the sides at the end of each level mean something. And how many levels are damped, the
#: address of the directory with rows for that, and whether these levels have aims of their own (0: x_ref). And whether
#: a rank was decided that could be another: see :mod:`.doubt`.
BEGAN, DEADLINE, HISTORY, DAMPED, TWIN, AIMED, DOUBT, HEAD = 16, 17, 18, 19, 20, 21, 22, 23

#: Places in OPTION: relative tolerances on rank and on rows, most iterations, most seconds; and, of each solve, what
#: round-off in x0 adds to the length of x where a tolerance is relative to it.
TAU, TOL, BUDGET, LIMIT, BLUR = 0, 1, 2, 3, 4
#: Numbers in a rule of damping: its kind, and what it is told.
RULE = 3

# The structure. PTR: rows of level k are PTR[k] .. PTR[k + 1]. WHOLE: whether level k bounds every variable once.
# COL: variable of a plain bound, or -1. ROW_OF: row of A, or -1.
# The hierarchy as given (A, LOWER, UPPER, WEIGHTS, X_REF), and as it is solved: weighted rows B, bounds LO, HI,
# lengths NORM (a plain bound's is its weight), and what the last level that counts wants, X0.
(PTR, WHOLE, COL, ROW_OF, A, LOWER, UPPER, WEIGHTS, B, LO, HI, NORM, X_REF, X0, OPTION) = range(15)
# The point X and the slack W of the rows; a guess SIDE, what contradicts it, FOLLOW, and rows whose multiplier has a
# clear sign, DECIDED. The basis V, the coefficients L of the rows, what is left of them, R, reflections H, and the
# rows PIVOT that the basis was made of: see :mod:`.orthogonal`. IDS .. RHS: rows of one level, in order.
(X, W, SIDE, FOLLOW, DECIDED, V, L, R, H, PIVOT, IDS, SLOTS, LENGTHS, RHS) = range(15, 29)
# Scratch, by variable,
(Y, G, BALANCE, PINNED, FREE, QUEUE, D, MULTIPLIER, SHARE, SCRATCH, SAFE) = range(29, 40)
# by level, by row,
(CUT, FORCES, VALUE, SLOPE, LOW, HIGH, ALLOWED, KIND, HELD) = range(40, 49)
# of the level that is being solved, see :mod:`.levels`: where it starts, the exact point of the levels above, the point
# of the dual; the sides at the end of each level, (levels + 1, m); the rows less their part along V, P, and how many
# rows of V that means; and their multipliers,
(ANCHOR, EXACT, APPROACH, SAVED, P, DEPTH, LAMBDA) = range(49, 56)
# and the members of the dual active set, in order, see :mod:`.members`.
(MEMBERS, FACTOR, DIAGONAL, Z, WANTED, RIGHT, SOFT, FORCE, CARRY, SHED) = range(56, 66)
# And of damped levels, see :mod:`.damped`: which ones; kind and numbers of the rule of each; the sides at the end of
# each stage, (2 damped + 1, m); of each level lambda, whether x_a was asked for, x_a and x_k; and its aim.
(WHICH, RULES, STAGES, PASSED, AIMS) = range(66, 71)


def shapes(n, levels, m, dense, widest, damped):
    """Shape of every array that is not the caller's own, integers and numbers apart: two dicts by place."""
    deep, many, spare = widest + n, min(m, 2 * n + 8), n if damped else 0
    ints = dict.fromkeys((SIDE, FOLLOW, DECIDED, KIND, HELD), (m, 1))
    ints |= dict.fromkeys((PINNED, FREE, PIVOT, QUEUE), (n, 1))
    ints |= dict.fromkeys((IDS, SLOTS), (deep, 1)) | {CUT: (levels + 1, 1), MEMBERS: (many, 1)}
    ints |= {SAVED: ((levels + 1) * m, 1), DEPTH: (m, 1)}
    ints |= {STAGES: ((2 * damped + 1) * m if damped else 0, 1)}
    reals = dict.fromkeys((LO, HI, NORM, VALUE, SLOPE, LOW, HIGH, ALLOWED), (m, 1)) | {W: (m + spare, 1)}
    reals |= dict.fromkeys((X_REF, X0, X, Y, G, BALANCE, D, MULTIPLIER, SHARE, SCRATCH, SAFE), (n, 1))
    reals |= {B: (dense, n), V: (n, n), L: (m + spare, n), R: (deep, n), H: (n, deep)}
    reals |= {FORCES: (levels, 1), OPTION: (5, 1)}
    reals |= dict.fromkeys((LENGTHS, RHS), (deep, 1))
    reals |= dict.fromkeys((ANCHOR, EXACT, APPROACH), (n, 1)) | {P: (m + n, n), LAMBDA: (m, 1), FACTOR: (many, many)}
    reals |= dict.fromkeys((DIAGONAL, Z, WANTED, RIGHT, SOFT, FORCE, CARRY, SHED), (many, 1))
    reals |= {RULES: (damped, RULE), PASSED: (damped, 2 + 2 * n), AIMS: (damped, n)}
    return ints, reals


#: Places of all integer arrays in memory, and of all arrays of numbers.
PLACES = tuple(np.array(list(block)) for block in shapes(0, 0, 0, 0, 0, 0))


def lay_out(structure, damped=(), rows_of_damping=False):
    """A directory for hierarchies of this structure, and the sizes of the memory for integers and numbers.

    With `rows_of_damping`, the levels that are `damped` have a bound on every variable more, their last rows.

    Returns
    -------
    directory : int64 array
        Of every array in memory, instead of its address, where it begins there.
    owned : dict
        Place -> int64 array of the structure, whose addresses are in the directory: to be kept.
    sizes : (int, int)
    """
    n, cuts, has_rows, indices = structure
    columns = np.frombuffer(indices, dtype=np.intp)
    levels = [columns[a:b] for a, b in pairwise(cuts)]
    distinct = [not rows and len(np.unique(own)) == len(own) for rows, own in zip(has_rows, levels, strict=True)]
    whole = [alone and len(own) == n for alone, own in zip(distinct, levels, strict=True)]
    if rows_of_damping:
        levels = [np.append(own, np.arange(n)) if k in damped else own for k, own in enumerate(levels)]
        columns, cuts = np.concatenate(levels), np.cumsum([0, *map(len, levels)])
    if damped:  # whose stages have rows of damping, and end there
        whole = [every and k > damped[-1] for k, every in enumerate(whole)]
        distinct = [alone and k not in damped for k, alone in enumerate(distinct)]
    dense = columns < 0
    owned = {PTR: cuts, WHOLE: whole, COL: columns, ROW_OF: np.where(dense, np.cumsum(dense) - 1, -1)}
    owned |= {WHICH: damped}
    owned = {place: np.array(given, dtype=np.int64) for place, given in owned.items()}

    m, rows = len(columns), int(dense.sum())
    directory = np.zeros(HEAD + 3 * (AIMS + 1), dtype=np.int64)
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
            begins += shape[0] * shape[1]
        sizes.append(begins)
    return directory, owned, tuple(sizes)
