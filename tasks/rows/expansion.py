"""From the stack that was declared to the one that is solved: a part may stand for several, on levels of their own.

A contact, for one, is a bound on its forces, which stands above all else, a motion that it forbids, which stands where
the contact does, and friction, which stands with the limits. Most parts stand for themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from ..robots.robot import Robot
from .unknowns import Block, Unknowns

if TYPE_CHECKING:
    from .part import Order, Part
    from .stack import Ruled, Stack

    Levels = list[tuple[Part, ...]]


@dataclass(frozen=True)
class Setting:
    """Where a part is to be at work.

    Attributes
    ----------
    robot : Robot
    order : {"velocity", "acceleration", "step"}
    parts : tuple of Part
        All that the stack declares.
    """

    robot: Robot
    order: Order
    parts: tuple[Part, ...]

    @property
    def has_dynamics(self) -> bool:
        """Whether the motion equation is in the stack, so that contacts have forces."""
        return any(part.is_dynamics for part in self.parts)


@dataclass(frozen=True)
class Companions:
    """The parts that one part stands for.

    Attributes
    ----------
    here : tuple of Part
        On its own level.
    top : tuple of Part
        On a level above all others, which all parts share.
    limits : tuple of Part
        On the first level from its own on that limits joints; on a new one below its own, if there is none.
    below : tuple of Part
        On a level right below the limits, which all parts share.
    block : Block, optional
        The unknowns that it brings.
    """

    here: tuple[Part, ...]
    top: tuple[Part, ...] = ()
    limits: tuple[Part, ...] = ()
    below: tuple[Part, ...] = ()
    block: Block | None = None


class Expanded(NamedTuple):
    """A stack as it is solved, what it is solved for, and the parts that each part declared stands for, by its id."""

    stack: Stack
    unknowns: Unknowns
    meant: dict[int, tuple[Part, ...]]


@dataclass
class _Levels:
    """Levels under construction, by the number of the level that was declared."""

    here: list[list[Part]]
    top: list[Part] = field(default_factory=list)
    limits: dict[int, list[Part]] = field(default_factory=dict)
    below: dict[int, list[Part]] = field(default_factory=dict)


def expand(stack: Stack, robot: Robot, order: Order) -> Expanded:
    """Have every part stand for what it stands for on this robot, at this order.

    Raises
    ------
    InvalidInput
        If a part cannot be in this stack.
    """
    setting = Setting(robot, order, tuple(stack))
    found = [[part.companions(setting) for part in level] for level in stack.levels]
    blocks = [each.block for level in found for each in level if each.block is not None]
    unknowns = Unknowns(robot.nv, blocks)
    pairs = zip(stack, (each for level in found for each in level), strict=True)
    meant = {id(part): (*each.top, *each.here, *each.limits, *each.below) for part, each in pairs}
    alone = [each.here for level in found for each in level] == [(part,) for part in stack]
    if alone and not any(each.top for level in found for each in level):
        return Expanded(stack, unknowns, meant)
    return Expanded(_placed(stack, found), unknowns, meant)


def _placed(stack: Stack, found: list[list[Companions]]) -> Stack:
    from .stack import of_levels

    levels = _Levels([[part for each in level for part in each.here] for level in found])
    for k, level in enumerate(found):
        limits = next((i for i in range(k, len(found)) if any(part.limited for part in stack.levels[i])), None)
        for each in level:
            levels.top += each.top
            if each.limits and limits is None:
                levels.limits.setdefault(k, []).extend(each.limits)
            elif limits is not None:
                levels.here[limits] += each.limits
            levels.below.setdefault(k if limits is None else limits, []).extend(each.below)
    ruled: list[Ruled] = [(tuple(levels.top), None)]
    for k, (parts, rule) in enumerate(zip(levels.here, stack.damping, strict=True)):
        ruled += [(tuple(parts), rule), (tuple(levels.limits.get(k, ())), None), (tuple(levels.below.get(k, ())), None)]
    return of_levels(ruled)
