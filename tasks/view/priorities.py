"""The levels of a stack as a list that can be reordered, with entries that can be switched off and on."""

from __future__ import annotations

from functools import reduce
from operator import add

from hqp import InvalidInput

from ..rows.damped import Damped
from ..rows.part import Part, Rule, Stack


class Priorities:
    """The levels of a stack, in the order that the user chooses.

    The same order gives the same `Stack` object again, so that a controller can use the rows and the solver that it
    already has.

    Parameters
    ----------
    stack : Stack

    Attributes
    ----------
    names : list of str
        Names of the levels in their present order, the highest first.
    on : list of bool
        Which of them are on.
    """

    def __init__(self, stack: Stack) -> None:
        self._levels = list(zip(stack.levels, stack.damping, strict=True))
        self._all = [True] * len(self._levels)
        self._order = list(range(len(self._levels)))
        self._made: dict[tuple[int, ...], Stack] = {tuple(self._order): stack}

    @property
    def parts(self) -> list[Part]:
        """All parts, also of levels that are off, in the order of the original stack."""
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
            If there is no such level.
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
            If there is no such place, or no level would be on.
        """
        self._check(place)
        if not on and sum(self._all) - self._all[self._order[place]] == 0:
            raise InvalidInput("the last level cannot be switched off; a stack must ask for something")
        self._all[self._order[place]] = on
        return self.stack()

    def stack(self) -> Stack:
        """The stack of the levels that are on, in order."""
        chosen = tuple(k for k in self._order if self._all[k])
        if chosen not in self._made:
            self._made[chosen] = Stack(*(_level(*self._levels[k]) for k in chosen))
        return self._made[chosen]

    def keep(self) -> tuple[list[int], list[bool]]:
        """A copy of order and switches, for :meth:`restore`."""
        return list(self._order), list(self._all)

    def restore(self, kept: tuple[list[int], list[bool]]) -> None:
        """Go back to the order and switches that :meth:`keep` returned."""
        self._order, self._all = list(kept[0]), list(kept[1])

    def _check(self, place: int) -> None:
        if not 0 <= place < len(self._order):
            raise InvalidInput(f"there is no level {place}; it must be 0 .. {len(self._order) - 1}")


def level_name(parts: tuple[Part, ...]) -> str:
    """The name of a level: the names of its parts."""
    return " + ".join(part.name for part in parts)


def _level(parts: tuple[Part, ...], rule: Rule) -> Part | Stack:
    joined = reduce(add, parts[1:], parts[0])
    return joined if rule is None else Damped(joined, rule or None)
