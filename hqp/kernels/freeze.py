"""Freezes the rows that a level solved by :mod:`.levels` decides: they keep their value on the levels below."""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .doubt import WEAK, is_free, turns
from .extent import extent
from .members import list_part
from .memory import ints, marks, matrix, vector
from .orthogonal import padded, pivots
from .rows import EQUALITY, INACTIVE, target
from .signs import HELD_FIRMLY, clear_of_basis
from .threads import told
from .working_set import FROZEN, HARD


@inner
def freeze(here, k, frozen, hard, rank, own, own_rank, pull):
    """Freeze equalities and violated rows of level k, and the hard rows that hold it back; its other rows become hard.

    `hard`, `rank`, `own` and `own_rank` are those of :func:`.polish.polish`, which has left x, w and V; `pull` are the
    forces of the level, 0 if it is met.

    Returns
    -------
    frozen : int
        Rows of V that span the frozen rows. ``anchor``, x_E, is moved to the nearest point with the values of these.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    n, tol = head[at.N], option[at.TOL]
    ptr, side, kind = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.KIND)
    ids, pivot = marks(here, at.IDS), marks(here, at.PIVOT)
    lo, hi, norm, w = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.W)
    x, anchor, softness = vector(here, at.X), vector(here, at.ANCHOR), vector(here, at.VALUE)
    multiplier, carried = vector(here, at.MULTIPLIER), vector(here, at.LAMBDA)
    queue, threads, opens = marks(here, at.QUEUE), integer(0), integer(0)
    size, all_frozen, clear = extent(x, here), rank == hard, 0.0
    for i in range(ptr[k], ptr[k + 1]):
        kind[i], softness[i] = HARD, 0.0
        if side[i] == INACTIVE:
            w[i] = 0.0
    if pull > 0.0:  # rows above with a clearly positive multiplier stay at their bound: implicit equalities
        clear = clear_of_basis(here, frozen, frozen + rank, pull)
        for q in range(frozen, frozen + rank):
            i = pivot[q]
            says = multiplier[q] * side[i] * norm[i]
            if says > clear:
                kind[i] = FROZEN
                if side[i] != EQUALITY and says <= HELD_FIRMLY * pull:
                    queue[threads] = q
                    threads += 1
            else:
                all_frozen = False
                opens += 1
                queue[n - opens] = q
        for i in range(ptr[k + 1]):
            carried[i] = 0.0
        if threads > 0 and head[at.DOUBT] == 0:
            end, held = frozen + rank + own_rank, False
            for q in range(frozen):
                held = held or not is_free(here, pivot[q], size)
            for q in range(frozen + rank, end):
                if not is_free(here, pivot[q], size):
                    opens += 1
                    queue[n - opens] = q
            if not told(here, threads, opens, hard + own_rank, hard + own, frozen, end, end == n and not held):
                head[at.DOUBT] = 1
    else:
        all_frozen = all_frozen and hard == 0
    for r in range(hard, hard + own):
        i = ids[r]
        goal = target(side[i], lo[i], hi[i])
        felt = pull > 0.0 and abs(w[i]) > tol * (abs(goal) + norm[i] * size)
        counts = pull > 0.0 and norm[i] * abs(w[i]) > clear
        if counts != felt and (counts or side[i] != EQUALITY):
            head[at.DOUBT] = 1  # of the level and the row, only one can tell this slack from round-off
        if side[i] == EQUALITY or felt:
            kind[i] = FROZEN
        else:
            all_frozen, w[i] = False, 0.0
        if pull == 0.0:
            w[i] = 0.0
    if all_frozen:  # V spans them already
        for j in range(n):
            anchor[j] = x[j]
        return frozen + rank + own_rank
    return frozen + refactor(here, frozen, hard, own)


@inner
def refactor(here, frozen, hard, own):
    """Rebuild V and x_E from the frozen ones of the `hard` + `own` listed rows; returns how many rows V gains."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    kind, ids, slots, pivot = marks(here, at.KIND), marks(here, at.IDS), marks(here, at.SLOTS), marks(here, at.PIVOT)
    norm, lengths, tau = vector(here, at.NORM), vector(here, at.LENGTHS), vector(here, at.OPTION)[at.TAU]
    x, y, anchor = vector(here, at.X), vector(here, at.Y), vector(here, at.ANCHOR)
    V, L, R = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    count = integer(0)
    for r in range(hard + own):
        i = ids[r]
        if kind[i] == FROZEN:
            list_part(i, count, count, here)
            count += 1
    gained = pivots(ids, count, slots, lengths, R, norm, V, L, frozen, padded(n), tau)
    for r in range(gained):
        direction, step = V[frozen + r], 0.0
        for j in range(n):
            step += direction[j] * (x[j] - anchor[j])
        y[frozen + r] = step
        pivot[frozen + r] = ids[r]
    for r in range(count):  # of fewer rows than those that solved the level, which are not in doubt
        i, left = ids[r], lengths[r]
        if left < WEAK * norm[i] if r < gained else turns(here, i, left, frozen, frozen + gained):
            head[at.DOUBT] = 1
    for r in range(gained):
        direction, step = V[frozen + r], y[frozen + r]
        for j in range(n):
            anchor[j] += step * direction[j]
    return gained
