"""The native solver: plain loops, compiled by Numba. Its entry point is :func:`hqp.kernels.solver.solve`.

Terms. Rows, bounds and slacks are *weighted* here, :math:`a_i = d_i A_i`. The *force* of a violated row is
:math:`\\|a_i\\| |w_i|`, the forces of a level are the sum of these; multipliers, times the length of their row, are
compared with that sum. A level is *met* if all its slacks are within their tolerances. A *frozen* row keeps its value
on all lower levels. A *hard* row is a satisfied inequality of a higher level, which must stay satisfied. The *working
set* is the set of hard rows that are kept at a bound.

Arguments that most kernels share:

here : int
    Address of the directory of all arrays (:mod:`.layout`). Names such as ``side`` or ``V`` are arrays of it.
last : int
    The implicit last level ``min ||x - x_0||``; the levels above it are 0 .. last - 1.
k : int
    The level at hand; its rows are PTR[k] .. PTR[k + 1] - 1.
i : int
    A row, by its number in the whole hierarchy.
c : int
    How many rows of the orthonormal basis V are in use: V[:c].
f : int
    How many variables are not fixed by bounds of level 0.
frozen, working : int
    V[:frozen] spans the frozen rows; the `working` rows of V behind it belong to the working set.
tau : float
    A row counts as dependent if projection leaves no more than this share of its length.
"""
