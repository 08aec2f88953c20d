"""Expansion of the declared stack into the levels that are solved: a part may stand for several, on several levels.

A contact, for example, becomes three parts: bounds on its forces, above all other levels; rows of its motion, on the
level of the contact; and friction, on the level of the limits. Most parts are not expanded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from ..robots.robot import Robot
from .levels import Levels, Rule
from .row_writer import RowWriter
from .tick import Order
from .unknowns import Block, Unknowns


@dataclass(frozen=True)
class Setting:
    """The robot, order and stack that a part is used in.

    Attributes
    ----------
    robot : Robot
    order : {"velocity", "acceleration", "displacement"}
    parts : tuple of Part
        All that the stack declares.
    """

    robot: Robot
    order: Order
    parts: tuple[RowWriter, ...]

    @property
    def has_dynamics(self) -> bool:
        """Whether the motion equation is in the stack, so that contacts have forces."""
        return any(part.is_dynamics for part in self.parts)


@dataclass(frozen=True)
class Companions:
    """The parts that one declared part is replaced by, and the levels where they belong.

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

    here: tuple[RowWriter, ...]
    top: tuple[RowWriter, ...] = ()
    limits: tuple[RowWriter, ...] = ()
    below: tuple[RowWriter, ...] = ()
    block: Block | None = None


class Expanded(NamedTuple):
    """A stack as it is solved, what it is solved for, and the parts that each declared part stands for, by its id."""

    levels: Levels
    unknowns: Unknowns
    meant: dict[int, tuple[RowWriter, ...]]


@dataclass
class _Draft:
    """Levels under construction, by the number of the declared level."""

    here: list[list[RowWriter]]
    top: list[RowWriter] = field(default_factory=list)
    limits: dict[int, list[RowWriter]] = field(default_factory=dict)
    below: dict[int, list[RowWriter]] = field(default_factory=dict)


def expand(declared: Levels, companions: Sequence[Sequence[Companions]]) -> Levels:
    """The levels that are solved: every part replaced by what it stands for, each on the level where that belongs.

    Parameters
    ----------
    declared : Levels
    companions : sequence of sequences of Companions
        Of every part, level by level.
    """
    draft = _Draft([[part for each in level for part in each.here] for level in companions])
    for k, level in enumerate(companions):
        limits = next((i for i in range(k, len(companions)) if any(p.limited for p in declared.parts[i])), None)
        for each in level:
            draft.top += each.top
            if each.limits and limits is None:
                draft.limits.setdefault(k, []).extend(each.limits)
            elif limits is not None:
                draft.here[limits] += each.limits
            draft.below.setdefault(k if limits is None else limits, []).extend(each.below)
    found: list[tuple[list[RowWriter], Rule]] = [(draft.top, None)]
    for k, (parts, rule) in enumerate(zip(draft.here, declared.damping, strict=True)):
        found += [(parts, rule), (draft.limits.get(k, []), None), (draft.below.get(k, []), None)]
    kept = [(tuple(parts), rule) for parts, rule in found if parts]
    return Levels(tuple(parts for parts, _ in kept), tuple(rule for _, rule in kept))
