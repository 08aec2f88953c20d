r"""The working set of the safe method, as rows of the basis V behind the frozen ones.

V spans the frozen rows first, then those of the working set, in the order in which they joined. ``pivot`` has the row
from which each row of V was made, and L its coefficients along V. So a row joins by one projection, and the multipliers
follow by one back substitution.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, matrix, vector
from .orthogonal import CANCELLED, length, project
from .rows import copy_row

#: Kind of a row, seen from the level that is being solved: FUTURE, of this level or a lower one; HARD, a satisfied
#: inequality above it; WORKING, a hard row in the working set; FROZEN; IGNORED, a hard row violated by round-off only.
FUTURE, HARD, WORKING, FROZEN, IGNORED = 0, 1, 2, 3, 4


@inner
def append(i, c, here, tau):
    """Append row i to the basis V[:c], as V[c]; False if it depends on V[:c], which then stays the basis."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    pivot = marks(here, at.PIVOT)
    norm = vector(here, at.NORM)
    V, L = matrix(here, at.V), matrix(here, at.L)
    if c >= n:
        return False
    row, coefficients = V[c], L[i]
    copy_row(i, row, here)
    for q in range(c):
        coefficients[q] = 0.0
    size = norm[i]
    for _ in range(3):
        project(row, n, V, integer(0), c, coefficients)
        before, size = size, length(row, n)
        if not size > tau * norm[i]:
            return False
        if size > CANCELLED * before:
            break
    for j in range(n):
        row[j] /= size
    coefficients[c] = size
    pivot[c] = i
    return True


@inner
def remove(place, c, here):
    """Remove the row at position `place` from the basis V[:c], and rebuild the rows of V behind it."""
    pivot = marks(here, at.PIVOT)
    for q in range(place, c - 1):
        append(pivot[q + 1], q, here, 0.0)


@inner
def balance(g, low, high, here):
    """Write the multipliers of rows low .. high - 1 of V: ``g + sum multiplier_i a_i`` is orthogonal to these rows.

    ``multiplier`` is by position in V.
    """
    n, pivot, multiplier = ints(here, 0, at.HEAD)[at.N], marks(here, at.PIVOT), vector(here, at.MULTIPLIER)
    V, L = matrix(here, at.V), matrix(here, at.L)
    for q in range(low, high):
        direction = V[q]
        total = 0.0
        for j in range(n):
            total += direction[j] * g[j]
        multiplier[q] = -total
    for q in range(high - 1, low - 1, -1):
        row = L[pivot[q]]
        multiplier[q] /= row[q]
        for t in range(low, q):
            multiplier[t] -= multiplier[q] * row[t]
