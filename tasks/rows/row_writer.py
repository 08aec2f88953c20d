"""The base class of everything that owns rows of a level, and writes them anew every tick."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import Label
from hqp.checks import whole_number

from ..base.checks import Array, not_negative, per_row
from ..base.live import Live, number, structure
from ..robots.robot import Robot, joint_names, joint_units
from .plan import Plan
from .site import Site
from .tick import PER, Order, Tick

if TYPE_CHECKING:
    from .unknowns import Unknowns


class RowWriter(Live):
    """Some rows of one level, written anew every tick; the base of :class:`tasks.Part`.

    Attributes
    ----------
    rows : int or None
        Number of rows; None for one row a joint velocity.
    plain : bool
        Whether the rows are those of the identity: bounds on x itself, kept without a matrix.
    wide : bool
        Whether its rows are of all unknowns, and not of the motion of the joints alone.
    is_dynamics : bool
        Whether it is the motion equation, by which contacts have forces.
    is_limit : bool
        Whether the rows only bound, and ask for nothing.
    damps : bool
        Whether they damp the tasks beside them.
    reads_limits : bool
        Whether its check or its plan goes by the limits of the robot, beside what it claims: it is then planned anew
        when one of these is set.
    limited : {"motion", "torque"} or None
        What they bound in every joint: x, or the torques that it takes. Records tell when a joint is at a bound.
    name : str
    weight : array, shape () or (rows,)
        Weight of the rows inside their level.
    """

    rows: int | None = structure()
    plain: bool = structure(False)
    wide: ClassVar[bool] = False
    is_dynamics: ClassVar[bool] = False
    is_limit: ClassVar[bool] = False
    damps: ClassVar[bool] = False
    reads_limits: ClassVar[bool] = False
    limited: ClassVar[Literal["motion", "torque"] | None] = None
    #: The methods that say what the rows are: a subclass that overrides one of them is asked in Python.
    says: ClassVar[tuple[str, ...]] = ("write",)
    name: str = structure()
    _instead: ClassVar[str] = "make a new one, and go over to it with controller.change(stack, duration=...)"

    @number
    def weight(self, value: ArrayLike) -> Array:
        """Weight of the rows inside their level, shape () or (rows,); a row of weight 0 asks for nothing."""
        return not_negative(value, f"{self.full_name()}: weight")

    def size(self, robot: Robot) -> int:
        """Number of rows on this robot."""
        return robot.nv if self.rows is None else whole_number(self.rows, f"{self.full_name()}: rows", least=1)

    def weights(self, robot: Robot) -> Array:
        """Weight of every row on this robot."""
        return per_row(self.weight, self.size(robot), f"{self.full_name()}: weight")

    def variables(self, robot: Robot) -> NDArray[np.intp]:
        """The joint velocities that plain rows bound, shape (rows,)."""
        return np.arange(robot.nv)

    def reach(self, robot: Robot) -> NDArray[np.bool_] | None:
        """Which joint velocities may have a part in each row, whatever the numbers of the part, shape (rows, nv).

        None if it is not known: any may have. A part with methods of its own in :attr:`says` is not asked.
        """
        return np.eye(robot.nv, dtype=bool)[self.variables(robot)] if self.plain else None

    def columns(self, unknowns: Unknowns, robot: Robot) -> NDArray[np.intp]:
        """The unknowns that plain rows bound, shape (rows,)."""
        return self.variables(robot)

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        """What explanations call the rows: plain ones are joints, in the units of x."""
        if not self.plain:
            return [Label(self.name, f"row {i}") for i in range(self.size(robot))]
        names, units = joint_names(robot), joint_units(robot)
        return [Label(self.name, names[i], units[i] + PER[order]) for i in self.variables(robot)]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        """Refuse, once and before the first tick, what cannot work with this robot.

        Raises
        ------
        InvalidInput
        """

    def check_numbers(self, robot: Robot, order: Order, dt: float | None) -> None:
        """Refuse numbers that cannot work here, whenever one has been set; :meth:`check` refuses all else, too.

        Raises
        ------
        InvalidInput
        """
        self.check(robot, order, dt)

    def check_beside(self, tick: Tick) -> None:
        """Refuse, or tell of, what cannot work with the joint limits of the stack; once, at a state of rest.

        Raises
        ------
        InvalidInput
        """

    @property
    def stands_beside(self) -> bool:
        """Whether it has a say in :meth:`check_beside`."""
        return type(self).check_beside is not RowWriter.check_beside

    def decay_rate(self) -> float:
        """The ``zeta K`` [1/s] of its law, half the rate at which that slows a speed; 0 if it asks for no motion.

        At acceleration order what is damped beside it, or with it, is damped towards ``-2 zeta K v``.
        """
        return 0.0

    def claim(self, site: Site) -> None:
        """Tell the envelope, where it is at work, how it limits the joints; before any part is planned."""

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        """Write this tick's rows in place: A (rows, nv), None where the level is plain, and the bounds (rows,).

        Where the part is `wide`, A is (rows, n), of all unknowns.
        """
        raise NotImplementedError

    def plan(self, site: Site) -> Plan:
        """How its rows are written where it is at work: loops, and what they are told; by default in Python."""
        return self.python_plan(site)

    def python_plan(self, site: Site) -> Plan:
        """The plan that calls the methods of :attr:`says` in Python every tick."""

        def write(tick: Tick) -> None:
            self.write(tick, site.A, site.lower, site.upper)

        return Plan(python=write, why=f"{type(self).__name__} is written in Python")
