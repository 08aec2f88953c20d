"""The order of joints along a kinematic chain, on which the derivative of a Jacobian depends."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from .abilities import Robot

#: The place of a joint that does not move a frame.
APART = -1


@runtime_checkable
class Chained(Protocol):
    """A robot that knows the order of its joints."""

    def chain_order(self, frame: str | None, relative_to: str | None = None) -> NDArray[np.int64] | None:
        """See :func:`chain_order`; None where that order does not say how a frame's Jacobian changes."""
        ...


def chain_order(robot: Robot, frame: str | None, relative_to: str | None = None) -> NDArray[np.int64] | None:
    """The place of every joint in the chain from the world, or from `relative_to`, to a frame.

    Joints that move as one, as those of a ball, have the same place; those that do not move the frame have -1.

    Returns
    -------
    places : int array, shape (nv,), or None
        None if the robot does not tell it; if one number moves two joints of the chain, because one follows the
        other; or if a joint of several degrees of freedom carries `relative_to` and not the frame.
    """
    return robot.chain_order(frame, relative_to) if isinstance(robot, Chained) else None


def closed_form(robot: Robot, frame: str | None, relative_to: str | None = None) -> bool:
    """Whether the gradient of a measure of this frame's Jacobian has a closed form."""
    return chain_order(robot, frame, relative_to) is not None


@runtime_checkable
class Branched(Protocol):
    """A robot that knows the order of all its joints, on whatever branch."""

    def tree_order(self) -> NDArray[np.int64] | None:
        """The place of every velocity (columns) in the chain to what each velocity (rows) moves, shape (nv, nv)."""
        ...


def carried(places: NDArray[np.int64]) -> NDArray[np.int64]:
    """Pairs of velocities of a chain whose first carries the second (or is it), and if they are one joint; (k, 3).

    In the order of the first.
    """
    own = np.flatnonzero(places != APART)
    return np.array(
        [
            (a, b, int(places[a] == places[b] and a != b))
            for a in own
            for b in own
            if places[a] < places[b] or (places[a] == places[b] and a <= b)
        ],
        dtype=np.int64,
    ).reshape(-1, 3)


def carried_in_tree(tree: NDArray[np.int64]) -> NDArray[np.int64]:
    """The pairs of all chains of a robot; see :func:`carried`."""
    pairs = [tuple(pair) for b, places in enumerate(tree) for pair in carried(places) if pair[1] == b]
    return np.array(sorted(pairs), dtype=np.int64).reshape(-1, 3)


def joint_by_joint(pairs: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """What :func:`carried` or :func:`carried_in_tree` tells, joint by joint, each after those that carry it.

    Returns
    -------
    chain : array of int, shape (joints, 3)
        The joint that carries each directly, -1 if none does, and where its velocities begin and end.
    velocities : array of int
    """
    above: dict[int, set[int]] = {b: set() for b in pairs[:, 1].tolist()}
    first = {b: b for b in above}
    for a, b, one in pairs.tolist():
        if one:
            first[b] = min(first[b], a)
        elif a != b:
            above[b].add(a)
    velocities = sorted(above, key=lambda b: (len(above[b]), first[b], b))
    heads = [p for p, b in enumerate(velocities) if first[b] == b]
    number = {velocities[p]: joint for joint, p in enumerate(heads)}
    chain = [
        (number[first[max(above[velocities[p]], key=lambda a: len(above[a]))]] if above[velocities[p]] else -1, p, end)
        for p, end in zip(heads, [*heads, len(velocities)][1:], strict=True)
    ]
    return np.array(chain, dtype=np.int64).reshape(-1, 3), np.array(velocities, dtype=np.int64)
