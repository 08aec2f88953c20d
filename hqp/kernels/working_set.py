r"""The working set of the safe method: rows kept where they are, on top of the rows that are frozen.

The basis V holds the frozen rows, then those of the working set in the order in which they came; ``pivot`` tells which
row is where, and L the coefficients of each, so that a row joins by one projection and the multipliers are one back
substitution.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .memory import ints, marks, matrix, vector
from .orthogonal import CANCELLED, length, project
from .rows import copy_row

#: What a row is to the level that is being solved: below it, satisfied above it, in the working set, decided; satisfied
#: above it as far as round-off lets one say.
FUTURE, HARD, WORKING, FROZEN, IGNORED = 0, 1, 2, 3, 4


@inner
def append(i, c, here, tau):
    """Put row i on top of the basis V[:c]; False, and nothing changed, if it depends on it."""
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
        project(row, n, V, 0, c, coefficients)
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
    """Take the row at position `place` from the basis of c rows, and build the part above it anew."""
    pivot = marks(here, at.PIVOT)
    for q in range(place, c - 1):
        append(pivot[q + 1], q, here, 0.0)


@inner
def balance(low, high, n, here):
    """Multipliers of the rows at low .. high of the basis: ``g + sum multiplier_i a_i`` is orthogonal to them."""
    pivot = marks(here, at.PIVOT)
    multiplier, g = vector(here, at.MULTIPLIER), vector(here, at.G)
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
