r"""From which size on a multiplier has a sign: less than that may be round-off, and counts as zero.

What may be wrong with the multipliers of a level is what the certificate allows it to leave unbalanced, a share of the
forces in it. Where the rows that balance it are nearly dependent, round-off of all their forces together is magnified
by one over the share that the others leave of the weakest of them.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .memory import marks, matrix, vector

#: Shares of the forces in a level: multipliers below the first are zero, those beyond the second are not, and in
#: between round-off decides.
CLEAR, CLEAREST = 1e-11, 1e-9
#: A row that holds a level with less than this share of its forces may not hold it in the eyes of the certificate.
HELD_FIRMLY = 2e-8
#: Round-off of a sum of forces, relative to their sizes.
ROUND_OFF = 16 * 2.0**-52


@inner
def clear_sign(forces, total, weakest):
    """Below this a multiplier is zero: of a level with these forces, balanced by others of this total.

    `weakest` is the smallest share that a row has added to the basis.
    """
    return min(max(CLEAR * forces, ROUND_OFF * (forces + total) / weakest), CLEAREST * forces)


@inner
def clear_of_basis(here, low, high, forces):
    """The same for the multipliers that :func:`.working_set.balance` has found for rows low .. high of the basis."""
    pivot, norm, multiplier = marks(here, at.PIVOT), vector(here, at.NORM), vector(here, at.MULTIPLIER)
    L = matrix(here, at.L)
    total, weakest = 0.0, 1.0
    for q in range(low, high):
        i = pivot[q]
        total += abs(multiplier[q]) * norm[i]
        weakest = min(weakest, L[i][q] / norm[i])
    return clear_sign(forces, total, weakest)
