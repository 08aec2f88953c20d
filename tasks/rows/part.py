"""Parts, which are tasks and limits, and stacks of parts in order of priority.

``a >> b`` puts b below a, and ``a + b`` both on one level: both operators take parts and stacks, and give stacks.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import get_args
from warnings import warn

from hqp import InvalidInput
from hqp.checks import one_of
from hqp.errors import brief

from ..base.checks import positive_scalar
from ..base.live import Live, structure
from ..robots.robot import Robot, as_robot
from .expansion import Companions, Expanded, Setting, expand
from .hierarchy_writer import HierarchyWriter
from .levels import Levels
from .levels import Rule as Rule
from .row_writer import RowWriter
from .site import Memory
from .tick import PER as PER
from .tick import Command as Command
from .tick import Order as Order
from .tick import Tick as Tick
from .unknowns import Unknowns

#: Former names of orders -> what they are now; each warns, for one version.
_FORMER_ORDERS: dict[str, Order] = {"step": "displacement"}
#: One level, and how it is damped.
Ruled = tuple[tuple["Part", ...], Rule]

ALLOWED = "a stack takes tasks, limits and stacks: a >> b puts b below a, a + b puts both on one level"


class Part(RowWriter):
    """A task or a limit: it owns some rows of one level and writes them anew every tick.

    Parts are ordered by ``a >> b`` (b below a) and joined on one level by ``a + b``; Python's
    precedence reads ``a >> b + c`` as ``a >> (b + c)``.

    Attributes
    ----------
    rows : int or None
        Number of rows; None for one row a joint velocity.
    plain : bool
        Whether the rows are those of the identity: bounds on x itself, kept without a matrix.
    name : str
    weight : array, shape () or (rows,)
        Weight of the rows inside their level.
    """

    def companions(self, setting: Setting) -> Companions:
        """The parts that replace it when the stack is solved; by default the part itself.

        Raises
        ------
        InvalidInput
            If it cannot be in this stack.
        """
        return Companions((self,))

    def __rshift__(self, lower: Part | Stack) -> Stack:
        """``self >> lower``: `lower` may only use the null space of this part."""
        return Stack(self) >> lower

    def __add__(self, other: Part | Stack) -> Stack:
        """``self + other``: both on the same level."""
        return Stack(self) + other


class Stack(Live):
    """Levels of tasks and limits, the highest first.

    ``limits >> position + orientation >> posture`` declares three levels; ``+`` binds tighter than
    ``>>``. ``Stack(a, b, c)`` is ``a >> b >> c``. A stack is a declaration: it holds no numbers of
    any robot or tick and may serve several controllers.

    Parameters
    ----------
    *parts : task, limit or Stack
        The highest priority first.

    Attributes
    ----------
    levels : tuple of tuples of Part
    damping : tuple of DampingRule, False or None
        How each level is damped: by a rule of its own, never, or as the controller does by default.

    Raises
    ------
    InvalidInput
        If there is nothing in it, something is neither a task nor a limit, or one of them comes twice.

    Examples
    --------
    >>> from tasks import JointVelocityLimit, OrientationTask, PositionTask
    >>> limits = JointVelocityLimit(2.0)
    >>> limits >> PositionTask([1.0, 0.2], gain=2.0) + OrientationTask(0.0, gain=2.0)
    JointVelocityLimit(2.0) >> PositionTask([1.0, 0.2], gain=2) + OrientationTask([0.0], gain=2)
    """

    levels: tuple[tuple[Part, ...], ...] = structure()
    damping: tuple[Rule, ...] = structure()
    _instead = "make a new one, and go over to it with controller.change(stack, duration=...)"

    def __init__(self, *parts: Part | Stack) -> None:
        if not parts:
            raise InvalidInput(f"an empty stack asks for nothing; {ALLOWED}")
        self.levels = tuple(level for part in parts for level in _levels_of(part))
        self.damping = tuple(rule for part in parts for rule in (part.damping if isinstance(part, Stack) else (None,)))
        seen: set[int] = set()
        for part in self:
            if id(part) in seen:
                raise InvalidInput(f"{part.full_name()} is in the stack twice; make a second one if both are meant")
            seen.add(id(part))

    def __rshift__(self, lower: Part | Stack) -> Stack:
        return Stack(self, lower)

    def __add__(self, other: Part | Stack) -> Stack:
        mine, theirs = self.levels, _levels_of(other)
        if len(mine) != 1 or len(theirs) != 1:
            raise InvalidInput(
                f"+ joins parts of one level, but got {self!r} + {other!r};"
                " say which level is meant with brackets: a >> (b + c)"
            )
        rules = self.damping + (other.damping if isinstance(other, Stack) else ())
        if any(rule is not None for rule in rules):
            raise InvalidInput(
                f"a level is damped as a whole, but got {self!r} + {other!r}; put the brackets around all of it:"
                " Damped(a + b, rule)"
            )
        return of_levels([(mine[0] + theirs[0], None)])

    @property
    def damps(self) -> bool:
        """Whether it has damping of its own: a level with a rule, or rows of damping beside a task."""
        return self._declared.damps

    def swapped(self, first: Part, second: Part) -> Stack:
        """The stack with two parts exchanged, each with the damping of its level, if it is alone there.

        Raises
        ------
        InvalidInput
            If one of them is not in the stack.
        """
        levels, here, there = list(self._ruled()), self._level(first), self._level(second)
        if len(self.levels[here]) == len(self.levels[there]) == 1:
            levels[here], levels[there] = levels[there], levels[here]
            return of_levels(levels)
        other = {id(first): second, id(second): first}
        return of_levels((tuple(other.get(id(part), part) for part in level), rule) for level, rule in levels)

    def without(self, *parts: Part) -> Stack:
        """The stack without these parts, and without the levels that they leave empty.

        Raises
        ------
        InvalidInput
            If one of them is not in the stack, or nothing is left.
        """
        gone = {id(part) for part in parts if self._level(part) >= 0}
        return of_levels((tuple(part for part in level if id(part) not in gone), rule) for level, rule in self._ruled())

    def inserted(self, part: Part | Stack, *, below: Part | None = None) -> Stack:
        """The stack with a new level, or levels, right below that of another part; without it, at the top.

        Raises
        ------
        InvalidInput
            If `below` is not in the stack, or `part` is in it already.
        """
        place, levels = 0 if below is None else self._level(below) + 1, list(self._ruled())
        new = part._ruled() if isinstance(part, Stack) else [(level, None) for level in _levels_of(part)]
        return of_levels([*levels[:place], *new, *levels[place:]])

    def _level(self, part: Part) -> int:
        """The number of the level that a part is on."""
        for k, level in enumerate(self.levels):
            if any(own is part for own in level):
                return k
        shown = repr(part) if isinstance(part, Part) else brief(part)
        raise InvalidInput(f"{shown} is not in the stack {self!r}")

    @property
    def _declared(self) -> Levels:
        return Levels(self.levels, self.damping)

    def _ruled(self) -> Iterable[Ruled]:
        """Every level with its damping."""
        return zip(self.levels, self.damping, strict=True)

    def __iter__(self) -> Iterator[Part]:
        """All parts, from the highest level down."""
        return (part for level in self.levels for part in level)

    def __contains__(self, part: object) -> bool:
        """Whether this very part is in it."""
        return any(own is part for own in self)

    def __len__(self) -> int:
        """Number of levels."""
        return len(self.levels)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Stack) and (self.levels, self.damping) == (other.levels, other.damping)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return " >> ".join(map(_shown, self.levels, self.damping))

    def build(
        self, robot: Robot, order: Order, dt: float | None = None, memory: Memory | None = None
    ) -> HierarchyWriter:
        """The hierarchy of this stack for one robot, ready to be filled.

        Parameters
        ----------
        robot : Robot
        order : {"velocity", "acceleration", "displacement"}
            Whether x is the joint velocities [rad/s], accelerations [rad/s^2], or displacements [rad].
        dt : float, optional
            Tick [s]; needed by limits of the other order.
        memory : dict, optional
            What parts keep from tick to tick, shared by all stacks of one controller.

        Returns
        -------
        HierarchyWriter
            Its ``.hierarchy`` holds the numbers, its ``.fill(state, t)`` writes them.

        Raises
        ------
        InvalidInput
            If a part does not fit the robot, or the rest of the stack; names the part. If the robot is none, the order
            none of them, or dt not positive.
        """
        robot = as_robot(robot)
        if isinstance(order, str) and order in _FORMER_ORDERS:
            warn(f"order {order!r} is {_FORMER_ORDERS[order]!r} now", DeprecationWarning, stacklevel=2)
            order = _FORMER_ORDERS[order]
        one_of(order, get_args(Order), "order")
        tick = None if dt is None else positive_scalar(dt, "dt", unit="s")
        return HierarchyWriter(self.expanded(robot, order), robot, order, tick, memory)

    def expanded(self, robot: Robot, order: Order) -> Expanded:
        """The levels that are solved, with all that the parts stand for on this robot, at this order.

        Raises
        ------
        InvalidInput
            If a part cannot be in this stack, or none of them asks for anything.
        """
        setting = Setting(robot, order, tuple(self))
        companions = [[part.companions(setting) for part in level] for level in self.levels]
        blocks = [each.block for level in companions for each in level if each.block is not None]
        levels = expand(self._declared, companions)
        if not levels.parts:
            raise InvalidInput(f"an empty stack asks for nothing; {ALLOWED}")
        pairs = zip(self, (each for level in companions for each in level), strict=True)
        meant = {id(part): (*each.top, *each.here, *each.limits, *each.below) for part, each in pairs}
        return Expanded(levels, Unknowns(robot.nv, blocks), meant)


def of_levels(levels: Iterable[Ruled]) -> Stack:
    """A stack of these levels, the empty ones left out."""
    kept = [(level, rule) for level, rule in levels if level]
    stack = object.__new__(Stack)
    stack.levels, stack.damping = tuple(level for level, _ in kept), tuple(rule for _, rule in kept)
    return Stack(stack) if kept else Stack()


def _shown(level: tuple[Part, ...], rule: Rule) -> str:
    parts = " + ".join(map(repr, level))
    return parts if rule is None else f"Damped({parts}, {rule or None!r})"


def _levels_of(part: Part | Stack) -> tuple[tuple[Part, ...], ...]:
    if isinstance(part, Stack):
        return part.levels
    if isinstance(part, Part):
        return ((part,),)
    raise InvalidInput(f"{brief(part)} is a {type(part).__name__}; {ALLOWED}")
