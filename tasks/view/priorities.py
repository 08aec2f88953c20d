"""The levels of a stack as a list that is reordered, and whose entries are switched off and on."""

from __future__ import annotations

from functools import reduce
from operator import add

from hqp import InvalidInput

from ..rows.damped import Damped
from ..rows.part import Part, Rule, Stack


class Priorities:
    """The levels that a stack began with, in an order of the user's.

    The same order gives the same `Stack` object again, so that a controller goes back to rows and a solver that it has.

    Parameters
    ----------
    stack : Stack

    Attributes
    ----------
    names : list of str
        Of the levels, the highest first, as they stand now.
    on : list of bool
        Which of them count.
    """

    def __init__(self, stack: Stack) -> None:
        self._levels = list(zip(stack.levels, stack.damping, strict=True))
        self._all = [True] * len(self._levels)
        self._order = list(range(len(self._levels)))
        self._made: dict[tuple[int, ...], Stack] = {tuple(self._order): stack}

    @property
    def parts(self) -> list[Part]:
        """All parts, those of levels that are off included, in the order of the stack that it began with."""
        return [part for level, _ in self._levels for part in level]

    @property
    def names(self) -> list[str]:
        return [level_name(self._levels[k][0]) for k in self._order]

    @property
    def on(self) -> list[bool]:
        return [self._all[k] for k in self._order]

    def move(self, place: int, by: int) -> Stack:
        """Exchange the level at a place with the one above (by = -1) or below (by = 1).

        Raises
        ------
        InvalidInput
            If there is none.
        """
        self._check(place)
        self._check(place + by)
        order = self._order
        order[place], order[place + by] = order[place + by], order[place]
        return self.stack()

    def switch(self, place: int, on: bool) -> Stack:
        """Switch the level at a place off or on.

        Raises
        ------
        InvalidInput
            If there is no such place, or nothing would be left.
        """
        self._check(place)
        if not on and sum(self._all) - self._all[self._order[place]] == 0:
            raise InvalidInput("the last level cannot be switched off; a stack must ask for something")
        self._all[self._order[place]] = on
        return self.stack()

    def stack(self) -> Stack:
        """The levels that count, in order."""
        chosen = tuple(k for k in self._order if self._all[k])
        if chosen not in self._made:
            self._made[chosen] = Stack(*(_level(*self._levels[k]) for k in chosen))
        return self._made[chosen]

    def keep(self) -> tuple[list[int], list[bool]]:
        """Order and switches, for :meth:`restore`."""
        return list(self._order), list(self._all)

    def restore(self, kept: tuple[list[int], list[bool]]) -> None:
        """Back to what :meth:`keep` gave."""
        self._order, self._all = list(kept[0]), list(kept[1])

    def _check(self, place: int) -> None:
        if not 0 <= place < len(self._order):
            raise InvalidInput(f"there is no level {place}; it must be 0 .. {len(self._order) - 1}")


def level_name(parts: tuple[Part, ...]) -> str:
    """What a level is called: its parts."""
    return " + ".join(part.name for part in parts)


def _level(parts: tuple[Part, ...], rule: Rule) -> Part | Stack:
    joined = reduce(add, parts[1:], parts[0])
    return joined if rule is None else Damped(joined, rule or None)
