r"""The base class of limits on the distances of convex shapes, one linear inequality a pair.

With the witnesses p_1 and p_2 of a pair, n the unit normal from the second to the first,

.. math:: n^T (J_1 - J_2) x \ge -K (d - d_{min}),

and the same of the velocity at the end of the tick at acceleration order.
Shapes are convex, meshes by their hulls, and their distances come from Coal, by the method of E. G. Gilbert, D. W.
Johnson and S. S. Keerthi, "A fast procedure for computing the distance between complex objects in three-dimensional
space", IEEE Journal on Robotics and Automation 4(2), 1988. The witness of two flat faces may jump within a tick, and
no reserve is kept for that: the curvature of the motion in one tick may violate the margin, for a Panda at 0.01 s by
up to a millimetre. If that matters, use a larger margin or a shorter tick.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hqp import Label
from hqp.checks import of_type, whole_number

from ..base.checks import Array, not_negative, positive_scalar, scalar
from ..base.live import number
from ..robots.robot import Robot, RobotState
from ..rows.alone import write_alone
from ..rows.part import PER, Order, Part, Tick
from .body_shapes import Shapes
from .distance import check_rate, told

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class ShapesLimit(Part):
    """Base of the limits that keep pairs of convex shapes apart.

    Parameters
    ----------
    margin : float
        The least distance [m]; not negative.
    gain : float
        K [1/s]: the rate at which the margin is neared; at most 1/dt.
    rows : int
        Number of rows, one for each of the nearest pairs.
    name : str
    """

    is_limit: ClassVar[bool] = True

    def __init__(self, *, margin: float, gain: float, rows: int, name: str) -> None:
        self.name = of_type(name, str, f"name of a {type(self).__name__}")
        self.margin, self.gain = margin, gain
        self.rows = whole_number(rows, f"{self.full_name()}: rows", least=1)
        self.weight = 1.0
        self._bound: tuple[Robot, tuple[Any, ...], Shapes] | None = None

    @number
    def margin(self, value: float) -> float:
        """The least distance [m]; not negative."""
        return scalar(not_negative(value, f"{self.full_name()}: margin", unit="m"), f"{self.full_name()}: margin")

    @number
    def gain(self, value: float) -> float:
        """K [1/s]: the rate at which the margin is neared."""
        return positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    def found(self, robot: Robot) -> Shapes:
        """The pairs of this robot, computed anew.

        Raises
        ------
        InvalidInput
            If there is none.
        """
        raise NotImplementedError

    def numbers(self) -> tuple[Any, ...]:
        """The objects that the pairs depend on, compared by identity."""
        return (self.margin,)

    def shapes(self, robot: Robot) -> Shapes:
        """The pairs of this robot."""
        bound, numbers = self._bound, self.numbers()
        if bound is None or bound[0] is not robot or any(a is not b for a, b in zip(bound[1], numbers, strict=True)):
            bound = self._bound = robot, numbers, self.found(robot)
        return bound[2]

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_bound": None}

    def size(self, robot: Robot) -> int:
        assert self.rows is not None
        return min(self.rows, len(self.shapes(robot)))

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        shapes = self.shapes(robot)
        whole = self.size(robot) == len(shapes)
        rows = shapes.names() if whole else [f"nearest {i + 1}" for i in range(self.size(robot))]
        return [Label(self.name, row, "m" + PER[order]) for row in rows]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        check_rate(self.full_name(), self.gain, order, dt)
        self.shapes(robot)

    def distances(self, robot: Robot, state: RobotState) -> Array:
        """The distances of the pairs [m], in the order of ``shapes(robot).names()``."""
        return self.shapes(robot).distances(state)

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        assert A is not None
        write_alone(self, tick, A, lower, upper)

    def plan(self, site: Site) -> Plan:
        """Coal finds the contacts, and a loop makes rows of them."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels import rows as loops

        site.bounds = True
        shapes, rows = self.shapes(site.shared.robot), site.rows
        contacts, bodies = np.zeros((rows, loops.CONTACT)), np.zeros((rows, 2), dtype=np.int64)
        blocks = {name: site.frame(name) for name in dict.fromkeys(name for pair in shapes.pairs for name in pair)}
        sides = [tuple(blocks[name].ctypes.data for name in pair) for pair in shapes.pairs]

        def measure(tick: Tick) -> None:
            for row, k in enumerate(sorted(shapes.closest(tick.state, rows))):
                bodies[row] = sides[k]
                shapes.contact(k, contacts[row])

        call = Call(loops.write_bodies, *told(site, [self.margin, self.gain]), contacts, bodies)
        return Plan((call,), python=measure, why="the distances of its shapes come from Coal")

    def __repr__(self) -> str:
        return f"{type(self).__name__}(margin={self.margin:g}, gain={self.gain:g}, rows={self.rows})"
