"""What kernels work on: a problem and the memory to solve it, cut from four blocks that the caller keeps.

The layout of a structure is written once, in integers: sizes, then for every level where its rows begin and whether
it bounds each variable once, then for every row the variable that it bounds, or -1, and its place in A, or -1.
"""

from __future__ import annotations

from collections import namedtuple

from .compile import part
from .memory import floats, ints, matrix

#: Head of the layout.
N, LEVELS, ROWS, DENSE, WIDEST, BOXED, LAYOUT_HEAD = 0, 1, 2, 3, 4, 5, 8
#: Head of the float memory, before x_ref and x, each (n,).
TAU, TOL, BUDGET, LIMIT, MEMORY_HEAD = 0, 1, 2, 3, 4
#: Head of the integer memory, before the side of every row.
LEVEL, SWEEPS, ITERATIONS, WARM, TRUSTED, MARKS_HEAD = 0, 1, 2, 3, 4, 8

#: The hierarchy as it is solved.
#:
#: n, m, levels: sizes; ptr (levels + 1,): rows of level k are ptr[k] .. ptr[k + 1]
#: boxed: whether level 0 bounds distinct variables; whole (levels,): whether a level bounds every variable once
#: col, row_of (m,): variable of a plain bound, or -1; row of B, or -1
#: A (dense, n), lower, upper, weights (m,): as given
#: B (dense, n), lo, hi, norm (m,): weighted rows, bounds and lengths; the weight of a plain bound is its length
#: x_ref, x0 (n,): as given, and what the last level that counts wants
#: tau, tol: relative tolerances on rank and on rows
Problem = namedtuple(
    "Problem", "n m levels ptr boxed whole col row_of A lower upper weights B lo hi norm x_ref x0 tau tol"
)

#: Where it is solved.
#:
#: x (n,), w (m,): the point, and the slack of the rows
#: side, follow (m,): a guess, and what contradicts it; decided (m,): rows whose multiplier has a clear sign
#: V (n, n), L (m, n), R (deep, n), H (n, deep), pivot (n,): see :mod:`.orthogonal`; deep = n + most rows of a level
#: ids, slots, lengths, rhs (deep,): rows of one level, in order
#: the rest: scratch of its kernel, of length n if it goes by variables, m if by rows
Work = namedtuple(
    "Work",
    "x w side follow decided V L R H pivot ids slots lengths rhs y g G pinned free cut forces"
    " v slope low high allowed kind held queue d multiplier share scratch safe"
    " rows gram chol across diagonal z wanted",
)


def sizes(n, levels, m, dense, widest):
    """Lengths of the float and of the integer memory."""
    deep = widest + n
    many = min(m, 2 * n + 8)
    reals = MEMORY_HEAD + 3 * many * (many + 1) + (dense + n + m + 2 * deep + 12) * n + 9 * m + 2 * deep + levels
    marks = MARKS_HEAD + 5 * m + 4 * n + 2 * deep + levels + 1 + many
    return reals, marks


@part
def unpack(numbers, layout, memory, marks):
    """The problem and the work space at these addresses."""
    head = ints(layout, 0, LAYOUT_HEAD)
    n, levels, m, dense, widest = head[N], head[LEVELS], head[ROWS], head[DENSE], head[WIDEST]
    deep = widest + n
    o = LAYOUT_HEAD
    ptr, whole = ints(layout, o, levels + 1), ints(layout, o + levels + 1, levels)
    o += 2 * levels + 1
    col, row_of = ints(layout, o, m), ints(layout, o + m, m)

    o = dense * n
    A, lower = matrix(numbers, 0, dense, n), floats(numbers, o, m)
    upper, weights = floats(numbers, o + m, m), floats(numbers, o + 2 * m, m)

    option = floats(memory, 0, MEMORY_HEAD)
    o = MEMORY_HEAD
    x_ref, x, x0 = floats(memory, o, n), floats(memory, o + n, n), floats(memory, o + 2 * n, n)
    o += 3 * n
    y, g, G = floats(memory, o, n), floats(memory, o + n, n), floats(memory, o + 2 * n, n)
    o += 3 * n
    d, multiplier, share = floats(memory, o, n), floats(memory, o + n, n), floats(memory, o + 2 * n, n)
    o += 3 * n
    scratch, safe = floats(memory, o, n), floats(memory, o + n, n)
    o += 3 * n
    B, V = matrix(memory, o, dense, n), matrix(memory, o + dense * n, n, n)
    o += (dense + n) * n
    L, R = matrix(memory, o, m, n), matrix(memory, o + m * n, deep, n)
    o += (m + deep) * n
    H = matrix(memory, o, n, deep)
    o += n * deep
    lo, hi, norm = floats(memory, o, m), floats(memory, o + m, m), floats(memory, o + 2 * m, m)
    o += 3 * m
    w, v, slope = floats(memory, o, m), floats(memory, o + m, m), floats(memory, o + 2 * m, m)
    o += 3 * m
    low, high, allowed = floats(memory, o, m), floats(memory, o + m, m), floats(memory, o + 2 * m, m)
    o += 3 * m
    lengths, rhs, forces = floats(memory, o, deep), floats(memory, o + deep, deep), floats(memory, o + 2 * deep, levels)

    o += 2 * deep + levels
    many = min(m, 2 * n + 8)
    gram, chol = matrix(memory, o, many, many), matrix(memory, o + many * many, many, many)
    o += 2 * many * many
    across, diagonal = matrix(memory, o, many, many), floats(memory, o + many * many, many)
    o += many * (many + 1)
    z, wanted = floats(memory, o, many), floats(memory, o + many, many)

    o = MARKS_HEAD
    side, follow, decided = ints(marks, o, m), ints(marks, o + m, m), ints(marks, o + 2 * m, m)
    o += 3 * m
    kind, held = ints(marks, o, m), ints(marks, o + m, m)
    o += 2 * m
    pinned, free, pivot, queue = (
        ints(marks, o, n),
        ints(marks, o + n, n),
        ints(marks, o + 2 * n, n),
        ints(marks, o + 3 * n, n),
    )
    o += 4 * n
    ids, slots, cut = ints(marks, o, deep), ints(marks, o + deep, deep), ints(marks, o + 2 * deep, levels + 1)

    rows = ints(marks, o + 2 * deep + levels + 1, many)

    problem = Problem(
        n, m, levels, ptr, head[BOXED] != 0, whole, col, row_of, A, lower, upper, weights, B, lo, hi, norm,
        x_ref, x0, option[TAU], option[TOL],
    )  # fmt: skip
    work = Work(
        x, w, side, follow, decided, V, L, R, H, pivot, ids, slots, lengths, rhs, y, g, G, pinned, free, cut, forces,
        v, slope, low, high, allowed, kind, held, queue, d, multiplier, share, scratch, safe,
        rows, gram, chol, across, diagonal, z, wanted,
    )  # fmt: skip
    return problem, work
