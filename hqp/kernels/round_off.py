"""What round-off in the basis may leave unbalanced, in the compiled certificate (:mod:`.proof`)."""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner
from .memory import ints, marks, matrix, vector

#: Round-off in the direction of a remainder, relative to the length of its row.
TURNS = 8 * 2.0**-52


@inner
def blur(here, force, base, c):
    """A bound on what round-off in V[:c] may leave unbalanced of a force (n,); a row with a small remainder adds much.

    If V[:c] spans all n directions, nothing is left, unless a row of V may be mere round-off of a row that came in an
    earlier block. `base` is the number of rows of V that span the free normals.
    """
    n, pivot, norm = ints(here, 0, at.HEAD)[at.N], marks(here, at.PIVOT), vector(here, at.NORM)
    V, L, block = matrix(here, at.V), matrix(here, at.L), marks(here, at.QUEUE)
    total, least, before, all_there = 0.0, 1.0, 1.0, c == n
    for q in range(c):
        direction, along, share = V[q], 0.0, L[pivot[q]][q] / norm[pivot[q]]
        for j in range(n):
            along += direction[j] * force[j]
        if q == base or (q < base and q == block[q]):
            before = least
        if share * before <= TURNS:
            all_there, share = False, TURNS
        least = min(least, share)
        total += abs(along) / share
    return 0.0 if all_there else TURNS * total


@inner
def weakest(here, base, working):
    """An upper bound of the smallest singular value of the normals that balance the level, from their parts along V."""
    pivot = marks(here, at.PIVOT)
    norm, spread, along = vector(here, at.NORM), vector(here, at.BALANCE), vector(here, at.SCRATCH)
    L, least = matrix(here, at.L), 1.0
    for q in range(base + working):
        along[q] = spread[q] if q < base else 0.0
    for q in range(base, base + working):
        row, square = L[pivot[q]], 0.0
        for p in range(base, q + 1):
            square += row[p] * row[p]
        for p in range(base, q + 1):
            along[p] += row[p] * row[p] / square
        least = min(least, math.sqrt(square) / norm[pivot[q]])
    for q in range(base + working):
        least = min(least, math.sqrt(along[q]))
    return least
