"""The directory of a hierarchy with curved levels, for :mod:`.curved`: built like that of :mod:`.layout`.

The first eight places are those of any hierarchy, except that WHOLE is CURVED here: PTR, COL, ROW_OF, A, LOWER, UPPER,
WEIGHTS.
"""

from __future__ import annotations

from .layout import padded

#: Numbers at the head, beside N, LEVELS and ROWS: the first level that was solved in its own stage (LEVELS: none); the
#: last stage that was solved; the address of the loop that solves a hierarchy; how many parts measure errors; the first
#: curved level; and whether the solver leaves the basis of the strict answer in memory. Whether METRIC is more than the
#: identity; sweeps and iterations of all stages; and whether any row has a WORTH.
OPENED, STAGE, SOLVE, MEASURES, TOP, QUICK = 5, 6, 7, 8, 9, 10
STIFF, SWEEPS, ITERATIONS, LOOKS_AHEAD = 11, 12, 13, 14
#: Of a block, on the way down its levels: its number; whether a level of it has a stage of its own; whether none of
#: them had a curvature; directions that are left, and were at first; active rows of all levels above, and of this one;
#: and whether this one may have to be braked.
NUMBER, OPEN, FIRST_TASK, LEFT, FREE, STACKED, ACTIVE, LAGS = 15, 16, 17, 18, 19, 20, 21, 22

#: Which levels are curved: not 0 if a level may be damped, SPARED if it is always left strict. Then for the stage of
#: every level: its directory (one more at the end: that of the strict hierarchy); its numbers; how many dense rows and
#: rows it has; where the rows of each level begin in it; where the dense rows of each level begin (-1: it has none).
CURVED = 1
(DIRECTORIES, NUMBERS, SIZES, FIRST, DENSE) = range(8, 13)
# Loops that contract curvatures, CALL numbers each: loop, its table, address of its weights, first row, rows; and the
# loop that bounds them (0: there is none), its table, address of what it writes. CALLS_OF: where the loops of each
# level begin.
CALL = 8
(CALLS, CALLS_OF) = range(13, 15)
# What the caller keeps up to date: gain dt of the levels, aims of their damping, last x; five numbers for each part:
# addresses of its errors, of the lower and the upper end of its band, first row, rows. ERRORS: errors of all rows.
(SHARES, AIMS, LAST, MEASURED, ERRORS) = range(15, 20)
# Of the level at hand: numbers of its active rows, the weighted rows J, G = J Z'; weights of curvatures, by row number;
# and J' e.
(IDS, J, G, WANTED, PULL) = range(20, 25)
# All active rows of the levels above, their row numbers, their Gram matrix, its Cholesky factor, and multipliers.
(ABOVE, WHOSE, GRAM, TRIANGLE, MU) = range(25, 30)
# An orthonormal basis of all directions, its first d rows are Z; Cholesky factor L of the metric of Z; work space.
(BASIS, METRIC, REACH) = range(30, 33)
# Curvature S; damping P; symmetric matrices to work in, eigenvectors U and eigenvalues; Q, combinations of rows.
(S, P, E, U, VALUES, M, HALF, KEPT, Q) = range(33, 42)
# What every row is below its level: its state (GIVEN .. LOST), the row, its value, and its stiffness if it is SOFT.
(STATE, ROW, VALUE, STIFFNESS) = range(42, 46)
# Of every level: the x of its stage, and the root of its largest damping. SCALES: of every row, the scale of its error.
(POINTS, STRENGTHS, SCALES) = range(46, 49)
# How a level was softened, for the record in the solution: its rows of damping, each with its bound; the norm of its
# rows, by which soft rows and lean are scaled; and for every row that is handed over, its combination of weighted rows.
(DAMPED, NORMS, COMBINED) = range(49, 52)
# Of every row, the error that a unit of its bound is worth; 0: its error is as it is measured.
WORTH = 52
# Of every row, whether it is not linear and its curvature is not known.
UNKNOWN = 53
# Of every variable, the tightest bounds of all rows above the curved levels.
(LEAST, MOST) = range(54, 56)
# Independent blocks of variables: the directory of each (its own address, if there is but one), in which the work
# arrays and the structure are those of the block; the number of the block of every row; the rows of this block, by
# level, and where those of each level begin; its variables; and numbers on the way down its levels.
(BLOCKS, BLOCK_OF, OWN, OWN_OF, COLUMNS, SO_FAR) = range(56, 62)
# A stage that is solved at once: the rows of its least squares, with their right side; a row to work in; and for every
# level and variable, which of its bounds was met by the last solve: 1 the upper, -1 the lower one, 0 none.
(LEAST_SQUARES, ROW_NOW, MET) = range(62, 65)
# Of the level at hand, what is computed from G: G'G, and G L^-T; L^-1 Z.
(GRAM_OF_G, G_MEASURED, MEASURED_BASIS) = range(65, 68)
# Of a stage that is solved at once, a column of its least squares.
PARTS = 68
# What a softened answer also tells: the first and the last level with a stage, and a copy of the AIMS.
SPAN, AIMED = 69, 70
# Of every level: whether its curvatures were bounded in this solve; whether their bounds were of no use in the last.
BOUNDED, LOOSE = 71, 72
# S again, as one row.
ALL_OF_S = 73
PLACES = 74

#: Places in SO_FAR: the gate of the lean; how close the last x moves along bounds; the sum of the squared damping
#: strengths above; of this level the norm of its rows, the weight of the lean, its c, and its squared strength; what
#: the first curved level makes of the gate; and of this level the weight of the brake at acceleration order.
GATE, AT_BOUNDS, ABOVE_DAMPED, SIZE, LEAN, ALIKE, STRENGTH, FADE, FIRM = range(9)

#: Value of CURVED: the level counts as curved, but is left strict.
SPARED = 2
#: State of a row below its level: as it is given; replaced by a combination of rows that is held, or soft; or dropped.
GIVEN, HELD, SOFT, LOST = 0, 1, 2, 3


def shapes(n, levels, m, widest, own, blocks):
    """Shapes of all work arrays, place -> (rows, columns), as two dicts: of integers and of floats.

    `m` is the number of all rows, `widest` that of the largest level; `own` variables are those of the block. Rows, and
    arrays of one axis, have room for whole lines.
    """
    ints, wide = {IDS: (widest, 1), STATE: (m, 1), WHOSE: (m, 1), MET: (levels * n, 1)}, max(n, widest)
    ints |= dict.fromkeys((BOUNDED, LOOSE), (levels, 1))
    lengths = {WANTED: m, PULL: n, ERRORS: m, MU: max(m, n), VALUES: wide, REACH: n, LEAST: n, MOST: n}
    lengths |= {SO_FAR: FIRM + 1, ROW_NOW: n + 1, PARTS: m + n, VALUE: m, STIFFNESS: m, STRENGTHS: levels}
    reals = {J: (widest, n), G: (widest, n), G_MEASURED: (widest, n), ABOVE: (m, n), GRAM: (m, m), TRIANGLE: (m, m)}
    reals |= {BASIS: (own, n), MEASURED_BASIS: (own, n), LEAST_SQUARES: (m + n, n + 1)}
    reals |= dict.fromkeys((METRIC, KEPT, GRAM_OF_G), (n, n)) | dict.fromkeys((E, M, HALF, Q, P, U), (wide, wide))
    reals |= {ROW: (m, n), POINTS: (levels, n), DAMPED: (levels * n, n + 1), NORMS: (levels, blocks)}
    reals |= {COMBINED: (m, widest), AIMED: (levels, n)}
    vectors = {place: (padded(count), 1) for place, count in lengths.items()}
    return ints, vectors | {place: (rows, padded(columns)) for place, (rows, columns) in reals.items()}
