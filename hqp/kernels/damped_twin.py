"""Stages of damped levels as plain hierarchies, in a twin directory: there the rows of damping are ordinary rows."""

from __future__ import annotations

from . import layout as at
from .active_set import OPTIMAL
from .apart import proves
from .attempts import COLD, WARM, seed, work_out
from .compile import inner, integer
from .memory import ints, marks, vector
from .rows import EQUALITY, INACTIVE
from .solver import UNEVEN


@inner
def lend(here, last, level, damping):
    """Write x, ``side`` and the stage of damped `level`, levels 0 .. last - 1, to the twin directory; or of STRICT.

    There the rows of damping are ordinary rows, so that the stage is a plain hierarchy.
    """
    head = ints(here, 0, at.HEAD)
    there, n, damped = head[at.TWIN], head[at.N], head[at.DAMPED]
    ptr, which = marks(here, at.PTR), marks(here, at.WHICH)
    x, x0, side, weights = vector(here, at.X), vector(here, at.X0), marks(here, at.SIDE), vector(here, at.WEIGHTS)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    sides, points, heavy = marks(there, at.SIDE), vector(there, at.X), vector(there, at.WEIGHTS)
    low, high, norms = vector(there, at.LO), vector(there, at.HI), vector(there, at.NORM)
    zero, reference = vector(there, at.X0), vector(there, at.X_REF)
    lower, upper = vector(there, at.LOWER), vector(there, at.UPPER)
    ints(there, 0, at.HEAD)[at.LEVELS] = last
    for j in range(n):
        points[j], zero[j], reference[j] = x[j], x0[j], x0[j]
    r, d = integer(0), integer(0)
    for k in range(last):
        for i in range(ptr[k], ptr[k + 1]):
            sides[r], low[r], high[r], norms[r], heavy[r] = side[i], lo[i], hi[i], norm[i], weights[i]
            lower[r] = lo[i] / norm[i] if norm[i] > 0.0 else lo[i]
            upper[r] = hi[i] / norm[i] if norm[i] > 0.0 else hi[i]
            r += 1
        if d < damped and which[d] == k:
            for j in range(n):
                norms[r], sides[r], heavy[r] = (damping, EQUALITY, damping) if k == level else (0.0, INACTIVE, 1.0)
                low[r] = high[r] = damping * x0[j]
                lower[r] = upper[r] = x0[j]
                r += 1
            d += 1
    for i in range(r, len(norms)):
        norms[i], sides[i], heavy[i] = 0.0, INACTIVE, 1.0


@inner
def with_rows(here, last, level, damping, warm):
    """Solve the stage of damped `level` in the twin directory, where its rows of damping are ordinary rows.

    Writes ``x`` and ``side``, and returns a status of :mod:`.active_set`, or UNEVEN. `warm` as of
    :func:`.attempts.work_out`.
    """
    head = ints(here, 0, at.HEAD)
    there, n, damped = head[at.TWIN], head[at.N], head[at.DAMPED]
    twin, ptr, which = ints(there, 0, at.HEAD), marks(here, at.PTR), marks(here, at.WHICH)
    x, side, sides, points = vector(here, at.X), marks(here, at.SIDE), marks(there, at.SIDE), vector(there, at.X)
    lend(here, last, level, damping)
    for place in (at.DEADLINE, at.SWEEPS, at.ITERATIONS):
        twin[place] = head[place]
    vector(there, at.OPTION)[at.BLUR] = vector(here, at.OPTION)[at.BLUR]
    seed(there, last)
    status, _ = work_out(there, last, integer(WARM if warm else COLD), warm)
    for place in (at.SWEEPS, at.ITERATIONS):
        head[place] = twin[place]
    for j in range(n):
        x[j] = points[j]
    r, d = integer(0), integer(0)
    for k in range(last):
        for i in range(ptr[k], ptr[k + 1]):
            side[i] = sides[r]
            r += 1
        if d < damped and which[d] == k:
            r += n
            d += 1
    return UNEVEN if status == OPTIMAL and twin[at.DOUBT] != 0 else status


@inner
def stage_proves(here, last, level, damping):
    """Whether the certificate accepts x as the answer of a stage; `level` is the damped one, or STRICT."""
    lend(here, last, level, damping)
    return proves(ints(here, 0, at.HEAD)[at.TWIN])
