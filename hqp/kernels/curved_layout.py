"""The directory of a hierarchy with curved levels, for :mod:`.curved`: as :mod:`.layout` says, with places of its own.

The first eight places are those of any hierarchy: PTR, COL, ROW_OF, A, LOWER, UPPER, WEIGHTS (:mod:`.layout`).
"""

from __future__ import annotations

#: Numbers at the head beside N and LEVELS of any hierarchy: the first level that was solved in a stage of its own (as
#: many as there are levels: none), the outcome, its stage, the loop that solves a hierarchy, how many
#: parts measure errors, and the first level that is curved.
OPENED, OUTCOME, STAGE, SOLVE, MEASURES, TOP = 5, 6, 7, 8, 9, 10

#: Which levels are curved. For every level, the directory of its stage, and of the whole as it is; its numbers; how
#: many rows of A and rows these have; of every level above it, where its rows begin there, and those of A (-1: none).
CURVED = 1
(DIRECTORIES, NUMBERS, SIZES, FIRST, DENSE) = range(8, 13)
# Loops that contract curvatures, level by level: address, table, address of the weights, row, rows.
(CALLS, CALLS_OF) = range(13, 15)
# What the caller keeps up to date: gain dt of the levels, aims of their damping, last x. Part by part, the addresses of
# its errors and of its band, below and above, row, rows; and what comes of them, the errors of all rows.
(SHARES, AIMS, LAST, MEASURED, ERRORS) = range(15, 20)
# Of the level at hand: its rows in play, weighted, and these along the directions that are left; weights of curvatures.
(IDS, J, G, WANTED) = range(20, 24)
# An orthonormal basis: first the directions Z that are left, then, the last first, V, along which rows are held:
# COMBINED A = T V, with the pull of them.
(BASIS, T, COMBINED, MU) = range(24, 28)
# Curvature; symmetric matrices of work; eigenvectors and eigenvalues.
(S, E, U, VALUES, M, HALF, KEPT, REACH) = range(28, 36)
# What has become of every row: how it is held, the row itself, its value, how stiff it is.
(STATE, ROW, VALUE, STIFFNESS) = range(36, 40)
# What every level has reached, and how strongly it was damped, along which directions.
(POINTS, DAMPED, DIRECTIONS) = range(40, 43)
PLACES = 43


def shapes(n, levels, m, widest):
    """Shape of every array of work, integers and numbers apart: two dicts by place."""
    ints, wide = {IDS: (widest, 1), STATE: (m, 1)}, max(n, widest)
    reals = {J: (widest, n), G: (widest, n), WANTED: (m, 1), COMBINED: (n, m), MU: (wide, 1), VALUES: (wide, 1)}
    reals |= dict.fromkeys((BASIS, T, KEPT), (n, n)) | dict.fromkeys((E, U, M, HALF), (wide, wide))
    reals |= {ERRORS: (m, 1), REACH: (n, 1), ROW: (m, n), VALUE: (m, 1), STIFFNESS: (m, 1)}
    reals |= {POINTS: (levels, n), DAMPED: (levels, n), DIRECTIONS: (levels * n, n)}
    return ints, reals
