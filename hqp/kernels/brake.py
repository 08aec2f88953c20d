r"""Brakes what lags: the lean of a level is a mass, which would carry x past what its rows ask for, and swing.

Along an eigenvector u of :math:`G^T G + P`, with its eigenvalue W, the lean :math:`w^2 (W + F)` towards the last x, and
the part s of :math:`G^T G` in W, the closed loop of an error is

.. math:: w^2 \Delta t (W + F) \dot x + W x = s K e, \qquad \dot e = -x,

which swings where s is small beside F: its damping ratio is :math:`W / (2 w \sqrt{\alpha (W + F) s})`, with
:math:`\alpha = K \Delta t`. The first task lags too little for that.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .compile import inner, integer
from .directions import along, take_along
from .lines import product
from .memory import ints, marks, matrix, vector
from .orthogonal import length, padded
from .single_lines import add_scaled, clear_line
from .sums import add_rows, multiply
from .symmetric import NOISE, eigen

#: The damping ratio to which a direction is braked.
RATIO = 1.0
#: The most directions in which a drag is computed, and the share of the entries of A that makes a vector one more.
DIRECTIONS, SPANNED = 3, 1e-12
#: Power with which the brake is let go as x becomes as fast as its rows ask for.
LET_GO = 4


@inner
def lags(here, lean, least):
    """Whether any direction can have a drag D, for the w of a level times the root of its gain dt.

    `least` is a lower bound of every W that is not 0. As s is at most W, D is 0 where that is large beside F.
    """
    so_far, share = vector(here, at.SO_FAR), (2.0 * RATIO * lean) ** 2
    return lean > 0.0 and (1.0 - share) * least < share * so_far[at.ALIKE] * so_far[at.SIZE] ** 2


@inner
def note_asked(here, count, d, x):
    """Write ``pull`` = Z J' (b - J x_a): what a level pulls at, where x_a is the part of x (n,) that is held above."""
    n, J = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J)
    ids, lower, weights = marks(here, at.IDS), vector(here, plain.LOWER), vector(here, plain.WEIGHTS)
    held, moved, pull = vector(here, at.REACH), vector(here, at.MU), vector(here, at.PULL)
    take_along(here, x, d, pull, held)
    clear_line(moved, padded(n))
    for r in range(count):
        lacks = weights[ids[r]] * lower[ids[r]] - product(J[r], held, n)
        add_scaled(J[r], lacks, padded(n), moved)
    along(here, moved, d, pull)


@inner
def pulled_along(here, d, u, weight):
    """The s of a direction u (d,) with the eigenvalue `weight`: the square of the length of J Z' u = G u."""
    if vector(here, at.SO_FAR)[at.STRENGTH] == 0.0:  # P is zero
        return weight
    count, moved = ints(here, 0, plain.HEAD)[at.ACTIVE], matrix(here, at.HALF)[0]
    multiply(matrix(here, at.G), count, u, d, moved)
    return product(moved, moved, count)


@inner
def spread(A, v, size, d, basis, T):
    """Write orthonormal rows that span v, A v, A A v, and T = B A B' for these rows B; returns how many there are.

    `size` is the length of v (d,). By Lanczos, each row cleared of all before it.
    """
    count, most, largest = integer(0), min(d, DIRECTIONS), 0.0
    for p in range(d):
        basis[0][p] = v[p] / size
        for q in range(d):
            largest = max(largest, abs(A[p][q]))
    while True:
        own, left = basis[count], basis[count + 1]
        multiply(A, d, own, d, left)
        for turn in range(2):
            for q in range(count, -1, -1):
                along = product(basis[q], left, d)
                add_scaled(basis[q], -along, padded(d), left)
                if turn == 0:
                    T[count][q] = T[q][count] = along
        count += 1
        rest = length(left, d)
        if count == most or not rest > SPANNED * largest:
            return count
        for p in range(d):
            left[p] /= rest


@inner
def brake(here, k, d):
    r"""Subtract a drag D v from ``mu``, the right side of level k, while x is faster than its rows ask for.

    D is what W lacks of the damping ratio :data:`RATIO`, along the eigenvectors of :math:`G^T G + P` (in E, which is
    overwritten) within the directions that v leads to under it (:func:`spread`): beside these, D v has hardly any part.
    How fast x goes beside what is asked for, ``pull`` / W, is one ratio for all directions, each counting with its D:
    it does not hang on which eigenvectors are taken where some have the same eigenvalue.
    """
    so_far, E, U, values = vector(here, at.SO_FAR), matrix(here, at.E), matrix(here, at.U), vector(here, at.VALUES)
    last, now, basis = vector(here, at.REACH), vector(here, at.ROW_NOW), matrix(here, at.LEAST_SQUARES)
    floor, lean = so_far[at.ALIKE] * so_far[at.SIZE] ** 2, so_far[at.LEAN] * math.sqrt(vector(here, at.SHARES)[k])
    along(here, vector(here, at.LAST), d, last)
    size, asked, goes = length(last, d), 0.0, 0.0
    if not size > 0.0:
        return
    count = spread(E, last, size, d, basis, matrix(here, at.KEPT))
    eigen(matrix(here, at.KEPT), U, values, count, NOISE)
    for i in range(count):
        weight, drag, u = values[i], 0.0, E[i]
        clear_line(u, padded(d))
        add_rows(U[i], basis, 0, count, d, u)
        now[i], to = size * U[i][0], product(u, vector(here, at.PULL), d)
        if weight > 0.0:
            drag = 2.0 * RATIO * lean * math.sqrt((weight + floor) * pulled_along(here, d, u, weight)) - weight
        if drag > 0.0:
            asked += drag * now[i] * to / weight
            goes += drag * now[i] * now[i]
        now[i] *= max(drag, 0.0)
    if asked < goes:
        share = (max(asked, 0.0) / goes) ** LET_GO - 1.0
        for i in range(count):
            now[i] *= share
        add_rows(now, E, 0, count, d, vector(here, at.MU))
