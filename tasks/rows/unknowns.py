"""The unknowns x of a hierarchy: named blocks, first the joint motion, then the contact forces.

Most stacks have one block, the joint velocities or accelerations. A contact brings one more, its forces:

.. math:: x = (a, f_1, f_2, \\dots).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import accumulate

from hqp import InvalidInput


@dataclass(frozen=True, eq=False)
class Block:
    """The unknowns that one part adds to x, such as the forces of a contact.

    Attributes
    ----------
    owner : Part
        The part that brings them.
    name : str
    names, units : tuple of str
        Of each unknown.
    """

    owner: object
    name: str
    names: tuple[str, ...]
    units: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.names)


class Unknowns:
    """The layout of x, block by block.

    Parameters
    ----------
    nv : int
        Of the first block, the motion of the joints.
    blocks : iterable of Block

    Attributes
    ----------
    n : int
        All unknowns.

    Raises
    ------
    InvalidInput
        If two blocks have the same name, by which their forces are asked for.
    """

    def __init__(self, nv: int, blocks: Iterable[Block] = ()) -> None:
        self.nv, self.blocks = nv, tuple(blocks)
        names = [block.name for block in self.blocks]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InvalidInput(f"several parts with forces are named {twice!r}; give each a name of its own: name=...")
        self._ends = tuple(accumulate(map(len, self.blocks), initial=nv))
        self.n = self._ends[-1]

    def of(self, owner: object) -> slice:
        """Where in x the block of a part is."""
        for block, start, end in zip(self.blocks, self._ends, self._ends[1:], strict=False):
            if block.owner is owner:
                return slice(start, end)
        raise KeyError(owner)

    def __contains__(self, owner: object) -> bool:
        """Whether a part brings unknowns."""
        return any(block.owner is owner for block in self.blocks)

    def alike(self, other: Unknowns) -> bool:
        """Whether both are the same numbers, so that points between an x of the one and one of the other have a
        meaning."""
        mine, theirs = ([block.owner for block in unknowns.blocks] for unknowns in (self, other))
        return self.nv == other.nv and len(mine) == len(theirs) and all(map(_same, mine, theirs))


def _same(one: object, other: object) -> bool:
    return one is other
