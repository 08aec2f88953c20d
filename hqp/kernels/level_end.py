"""What :mod:`.levels` writes once a level is solved: for the levels below, and for the next solve."""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .extent import extent
from .memory import ints, marks, vector
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, target, value_of
from .working_set import FROZEN


@inner
def remember(here, k, last, count):
    """Save what the dual method ended with: its x as APPROACH, and the multipliers of its `count` members."""
    head = ints(here, 0, at.HEAD)
    n, m, ptr = head[at.N], head[at.ROWS], marks(here, at.PTR)
    members, force = marks(here, at.MEMBERS), vector(here, at.FORCE)
    x, point, carried = vector(here, at.X), vector(here, at.APPROACH), vector(here, at.LAMBDA)
    for j in range(n):
        point[j] = x[j]
    for i in range(ptr[min(k + 1, last)]):
        carried[i] = 0.0
    for c in range(count):
        if members[c] < m:
            carried[members[c]] = force[c]


@inner
def keep(here, k, last):
    """Save ``side``, W at the end of level k, for the next solve; frozen rows are left out."""
    m, ptr = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.PTR)
    side, kind, saved = marks(here, at.SIDE), marks(here, at.KIND), marks(here, at.SAVED)
    for i in range(ptr[min(k + 1, last)]):
        saved[k * m + i] = INACTIVE if kind[i] == FROZEN else side[i]


@inner
def conclude(here, k, last):
    """Write which rows of the levels from k on are active, and their slacks, where the levels above determine x."""
    ptr, side, tol = marks(here, at.PTR), marks(here, at.SIDE), vector(here, at.OPTION)[at.TOL]
    lo, hi, norm, w = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.W)
    x = vector(here, at.X)
    size = extent(x, here)
    for i in range(ptr[k], ptr[last]):
        side[i], w[i] = INACTIVE, 0.0
        if norm[i] == 0.0:
            continue
        value, near = value_of(i, x, here), tol * norm[i] * size
        if lo[i] == hi[i]:
            side[i] = EQUALITY
        elif value > hi[i] + near + tol * abs(hi[i]):
            side[i] = UPPER
        elif value < lo[i] - near - tol * abs(lo[i]):
            side[i] = LOWER
        if side[i] != INACTIVE:
            w[i] = value - target(side[i], lo[i], hi[i])
    for level in range(k, last + 1):
        keep(here, level, last)


@inner
def advance(here):
    """EXACT = x: it is optimal for all levels above the next one."""
    n = ints(here, 0, at.HEAD)[at.N]
    x, exact = vector(here, at.X), vector(here, at.EXACT)
    for j in range(n):
        exact[j] = x[j]
