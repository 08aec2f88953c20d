"""The directory of a hierarchy with curved levels, for :mod:`.curved`: as :mod:`.layout` says, with places of its own.

The first eight places are those of any hierarchy: PTR, COL, ROW_OF, A, LOWER, UPPER, WEIGHTS (:mod:`.layout`).
"""

from __future__ import annotations

#: Numbers at the head beside N and LEVELS of any hierarchy: the first level that was solved in a stage of its own (as
#: many as there are levels: none), the outcome, its stage, the loop that solves a hierarchy, how many
#: parts measure errors, the first level
#: that is curved, and whether the answer of the whole leaves a basis.
OPENED, OUTCOME, STAGE, SOLVE, MEASURES, TOP, QUICK = 5, 6, 7, 8, 9, 10, 11

#: Which levels are curved: may be damped, or are SPARED, so that they count and are held, but never give way. For every
#: level, the directory of its stage, and of the whole as it is; its numbers; how many rows of A and rows these have; of
#: every level above it, where its rows begin there, and those of A (-1: none).
CURVED = 1
(DIRECTORIES, NUMBERS, SIZES, FIRST, DENSE) = range(8, 13)
# Loops that contract curvatures, level by level: address, table, address of the weights, row, rows.
(CALLS, CALLS_OF) = range(13, 15)
# What the caller keeps up to date: gain dt of the levels, aims of their damping, last x. Part by part, the addresses of
# its errors and of its band, below and above, row, rows; and what comes of them, the errors of all rows.
(SHARES, AIMS, LAST, MEASURED, ERRORS) = range(15, 20)
# Of the level at hand: its rows in play, weighted, and these along the directions that are left; the weights of
# curvatures; and the pull of its errors.
(IDS, J, G, WANTED, PULL) = range(20, 25)
# All rows in play above it, whose they are, their Gram matrix, its triangle, and multipliers.
(ABOVE, WHOSE, GRAM, TRIANGLE, MU) = range(25, 30)
# An orthonormal basis, first of it the directions Z that are left; a triangle that says how stiff these are.
(BASIS, METRIC, REACH) = range(30, 33)
# Curvature; its damping; symmetric matrices of work, eigenvectors and eigenvalues; combinations of rows.
(S, P, E, U, VALUES, M, HALF, KEPT, Q) = range(33, 42)
# What has become of every row: how it is held, the row itself, its value, how stiff it is.
(STATE, ROW, VALUE, STIFFNESS) = range(42, 46)
# What every level has reached, and how strongly it was damped.
(POINTS, STRENGTHS, SCALES) = range(46, 49)
# How a level was softened, as answers tell it: its rows of damping, each with its bound; the norm of its rows, by which
# soft rows and lean are scaled; and of every row, as what it is handed over: a combination of the weighted ones.
(DAMPED, NORMS, COMBINED) = range(49, 52)
PLACES = 52

#: A curved level that is left strict.
SPARED = 2
#: What becomes of a row below its level: as it is given; a combination of its level, held, or soft; or nothing.
GIVEN, HELD, SOFT, LOST = 0, 1, 2, 3


def shapes(n, levels, m, widest):
    """Shape of every array of work, integers and numbers apart: two dicts by place."""
    ints, wide = {IDS: (widest, 1), STATE: (m, 1), WHOSE: (m, 1)}, max(n, widest)
    reals = {J: (widest, n), G: (widest, n), WANTED: (m, 1), PULL: (n, 1), ERRORS: (m, 1)}
    reals |= {ABOVE: (m, n), GRAM: (m, m), TRIANGLE: (m, m), MU: (max(m, n), 1), VALUES: (wide, 1), REACH: (n, 1)}
    reals |= dict.fromkeys((BASIS, METRIC, KEPT), (n, n)) | dict.fromkeys((P, E, U, M, HALF, Q), (wide, wide))
    reals |= {
        ROW: (m, n),
        VALUE: (m, 1),
        STIFFNESS: (m, 1),
        POINTS: (levels, n),
        STRENGTHS: (levels, 1),
        DAMPED: (levels * n, n + 1),
        NORMS: (levels, 1),
        COMBINED: (m, widest),
    }
    return ints, reals
