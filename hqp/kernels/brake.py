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
from .compile import inner
from .hand_over import along
from .memory import ints, marks, matrix, vector
from .symmetric import eigen

#: The damping ratio to which a direction is braked.
RATIO = 0.8
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
    n, J, basis = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), matrix(here, at.BASIS)
    ids, lower, weights = marks(here, at.IDS), vector(here, plain.LOWER), vector(here, plain.WEIGHTS)
    held, moved, pull = vector(here, at.REACH), vector(here, at.MU), vector(here, at.PULL)
    along(here, x, d, pull)
    for j in range(n):
        held[j], moved[j] = x[j], 0.0
    for p in range(d):
        direction, part = basis[p], pull[p]
        for j in range(n):
            held[j] -= part * direction[j]
    for r in range(count):
        row, lacks = J[r], weights[ids[r]] * lower[ids[r]]
        for j in range(n):
            lacks -= row[j] * held[j]
        for j in range(n):
            moved[j] += lacks * row[j]
    along(here, moved, d, pull)


@inner
def pulled_along(here, d, u):
    """The s of a direction u (d,): the square of the length of J Z' u = G L' u, for the metric factor L."""
    G, L, turned = matrix(here, at.G), matrix(here, at.METRIC), matrix(here, at.HALF)[0]
    stiff, square = ints(here, 0, plain.HEAD)[at.STIFF] != 0, 0.0
    for p in range(d):
        turned[p] = u[p]
        if stiff:
            turned[p] *= L[p][p]
            for q in range(p + 1, d):
                turned[p] += L[q][p] * u[q]
    for r in range(ints(here, 0, plain.HEAD)[at.ACTIVE]):
        row, total = G[r], 0.0
        for p in range(d):
            total += row[p] * turned[p]
        square += total * total
    return square


@inner
def brake(here, k, d):
    r"""Subtract a drag D v from ``mu``, the right side of level k, while x is faster than its rows ask for.

    D, along the eigenvectors of :math:`G^T G + P` (in E, which is overwritten), is what W lacks of the damping ratio
    :data:`RATIO`. How fast x goes beside what is asked for, ``pull`` / W, is one ratio for all directions, each
    counting with its D: it does not hang on which eigenvectors are taken where some have the same eigenvalue.
    """
    so_far, E, U, values = vector(here, at.SO_FAR), matrix(here, at.E), matrix(here, at.U), vector(here, at.VALUES)
    pull, last, towards = vector(here, at.PULL), vector(here, at.REACH), vector(here, at.MU)
    floor, lean = so_far[at.ALIKE] * so_far[at.SIZE] ** 2, so_far[at.LEAN] * math.sqrt(vector(here, at.SHARES)[k])
    along(here, vector(here, at.LAST), d, last)
    eigen(E, U, values, d)
    force, asked, goes = E[0], 0.0, 0.0
    for p in range(d):
        force[p] = 0.0
    for i in range(d):
        u, weight = U[i], values[i]
        drag = 2.0 * RATIO * lean * math.sqrt(max(weight + floor, 0.0) * pulled_along(here, d, u)) - weight
        if not (drag > 0.0 and weight > 0.0):
            continue
        to, now = 0.0, 0.0
        for p in range(d):
            to += u[p] * pull[p]
            now += u[p] * last[p]
        asked += drag * now * to / weight
        goes += drag * now * now
        for p in range(d):
            force[p] += drag * now * u[p]
    if asked < goes:
        share = 1.0 - (max(asked, 0.0) / goes) ** LET_GO
        for p in range(d):
            towards[p] -= share * force[p]
