r"""The directions in which a damped level was softened, by the stage that it was solved in.

For a level :math:`G y = b` in the null space of the levels above, with rows of damping D beside it, the answer meets

.. math:: T b, \qquad T = G (G^T G + D^T D)^{-1} G^T,

the eigenvectors of T are directions among its rows, and the eigenvalues the shares of the target that are met there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..arrays import Array, length
from ..certificate import row_space
from ..hierarchy import Hierarchy, Label

#: Where more than this share is met, a direction counts as strict.
MET = 0.99
#: Rows so much shorter than the longest one, in any direction, leave x hardly a way to move the level there.
SHORT = 0.5
#: What is at most this long beside the longest row cannot be moved, and is no matter of damping.
NONE = 1e-9
#: Directions whose shares differ by less are softened alike: each direction between them is one too. Rows whose shares
#: in a direction differ by less are told in their own order.
ALIKE = 1e-6
#: Rows with less of a share in a direction are not named.
NAMED = 0.2
#: Why a level is damped, if not for directions in which x cannot move it.
SMOOTH = "so that the answer changes smoothly"


@dataclass(frozen=True, eq=False)
class Softened:
    """One direction in which a level was softened.

    Attributes
    ----------
    direction : array, shape (rows,)
        Of unit length, among the weighted rows of the level.
    share : float
        The share of the target that is met along it; the rest is given up for smoothness.
    cause : {"singular", "above", "calm"}
        "singular": x hardly moves the level in this direction; "above": it would if the levels above permitted it;
        "calm": the damping is for the curvature of the rows, or pulls to the last x.
    """

    direction: Array
    share: float
    cause: Literal["singular", "above", "calm"]


def softened(stage: Hierarchy, own: int) -> tuple[Softened, ...]:
    """The directions of the lowest level of a stage, the weakest first; its first `own` rows are its own."""
    k = len(stage.levels) - 1
    begin, level = stage.pointers[k], stage.levels[k]
    norms = np.linalg.norm(stage.dense(), axis=1)
    held = np.flatnonzero((stage.lower == stage.upper) & (norms > 0.0))
    held = held[held < begin]
    _, Z, _ = row_space(stage.dense()[held] / norms[held, None], NONE)
    weighted = level.weights[:, None] * stage.matrix(k)
    J, D = weighted[:own], weighted[own:] @ Z
    G, longest = J @ Z, float(np.linalg.norm(J, 2)) if J.size else 0.0
    if not G.size or longest == 0.0:
        return ()
    shares, directions = np.linalg.eigh(G @ np.linalg.pinv(G.T @ G + D.T @ D, hermitian=True) @ G.T)
    found = list[Softened]()
    for share, direction in zip(shares, directions.T, strict=True):
        size, left = length(J.T @ direction), length(G.T @ direction)
        if share <= MET and left > NONE * longest:
            singular = size < SHORT * longest
            cause: Literal["singular", "above", "calm"] = (
                "singular" if singular else "above" if left < SHORT * size else "calm"
            )
            found.append(Softened(direction, max(float(share), 0.0), cause))
    return tuple(found)


def strongest(softs: Sequence[Softened], missing: Array) -> Softened | None:
    """The direction in which most of what a level lacks is given up, of unit length; None if it lacks nothing there.

    Parameters
    ----------
    softs : sequence of Softened
        Those of the level, by their shares.
    missing : array, shape (rows,)
        What its rows lack, times their weights.
    """
    found, most = None, 0.0
    for first in (i for i, soft in enumerate(softs) if i == 0 or soft.share > softs[i - 1].share + ALIKE):
        alike = [soft for soft in softs[first:] if soft.share <= softs[first].share + ALIKE]
        along = sum(((soft.direction @ missing) * soft.direction for soft in alike), np.zeros(len(missing)))
        if length(along) > most:
            found, most = replace(alike[0], direction=along / length(along)), length(along)
    return found


def unmoved(A: Array, missing: Array) -> Array:
    """The part of what a level lacks, both weighted, that nothing in x moves: ``A^T`` of it is zero; shape (rows,)."""
    U, sizes, _ = np.linalg.svd(A)
    rank = int((sizes > NONE * sizes.max(initial=0.0)).sum())
    return np.asarray(U[:, rank:] @ (U[:, rank:].T @ missing))


def in_words(soft: Softened, labels: list[Label], singular: str) -> str:
    """Why a level was softened in a direction, with that direction in the labels of its rows."""
    said = {
        "singular": singular,
        "above": "the levels above leave little to move it by in this direction",
        "calm": f"{SMOOTH} in this direction",
    }[soft.cause]
    return f"{said} ({direction_in_words(soft.direction, labels)})"


def direction_in_words(direction: Array, labels: list[Label]) -> str:
    """A direction of unit length among the rows of a level, as in ``0.9 x, -0.44 z``; one row alone has no number.

    Rows with equal shares are in their own order, which round-off does not change.
    """
    order = np.argsort(-np.round(np.abs(direction) / ALIKE), kind="stable")
    main = [i for i in map(int, order) if abs(direction[i]) >= NAMED] or [int(order[0])]
    sign = 1.0 if direction[main[0]] > 0.0 else -1.0
    names = [labels[i].row or labels[i].part for i in main[:3]]
    if len(main) == 1:
        return names[0]
    return ", ".join(f"{sign * direction[i]:.2g} {name}" for i, name in zip(main, names, strict=False))
