r"""The size below which a multiplier may be round-off and counts as zero; above it, its sign is clear.

The error of the multipliers of a level is what the certificate allows the level to leave unbalanced, a share of its
forces. If the rows that balance it are nearly dependent, the round-off of all forces together is divided by the
smallest share of its length that projection left of one of these rows.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .memory import marks, matrix, vector

#: Shares of the forces of a level: multipliers below the first are zero, those above the second are not; in between the
#: round-off of this level is the limit.
CLEAR, CLEAREST = 1e-11, 1e-9
#: If the multiplier of a row is below this share of the forces, the certificate may not count the row as holding the
#: level back.
HELD_FIRMLY = 2e-8
#: Round-off of a sum of forces, relative to their sizes.
ROUND_OFF = 16 * 2.0**-52


@inner
def clear_sign(forces, total, weakest):
    """The size below which the multipliers of a level count as zero, times the length of their row.

    `forces` are those of the level, `total` is the sum of its multipliers in the same measure, `weakest` the smallest
    share of its length that projection left of a row in the basis.
    """
    return min(max(CLEAR * forces, ROUND_OFF * (forces + total) / weakest), CLEAREST * forces)


@inner
def clear_of_basis(here, low, high, forces):
    """:func:`clear_sign` for the multipliers of rows low .. high - 1 of V, from :func:`.working_set.balance`."""
    pivot, norm, multiplier = marks(here, at.PIVOT), vector(here, at.NORM), vector(here, at.MULTIPLIER)
    L = matrix(here, at.L)
    total, weakest = 0.0, 1.0
    for q in range(low, high):
        i = pivot[q]
        total += abs(multiplier[q]) * norm[i]
        weakest = min(weakest, L[i][q] / norm[i])
    return clear_sign(forces, total, weakest)
