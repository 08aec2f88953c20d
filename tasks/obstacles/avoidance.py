r"""Task: drive the link point nearest to an obstacle away from it, one row.

.. math::

    \lambda\, n^T J x = \lambda\, (n^T \dot o + \lambda v_0), \qquad
    \lambda = s^2 (3 - 2 s), \quad s = \min(\max(1 - d / d_i, 0), 1)

for the nearest pair: the link moves away at speed v_0 if it touches, and not at all at the influence distance d_i.
That the motion away from an obstacle takes one degree of freedom, not three, is due to L. Zlajpah and B. Nemec,
"Kinematic control algorithms for on-line obstacle avoidance for redundant manipulators", IEEE/RSJ IROS 2002; the
task itself to A. A. Maciejewski and C. A. Klein, "Obstacle avoidance for kinematically redundant manipulators in
dynamically varying environments", International Journal of Robotics Research 4(3), 1985.

Unlike :class:`tasks.DistanceLimit` it guarantees no margin: it moves the link only if higher levels permit, uses one
pair, and the nearest pair may change between two ticks. The scale lambda fades the row in only beside other rows of its
level, such as a Damping; strictly above a task, the row takes its degree of freedom however small lambda is. As a step
of the joints it asks for the displacement of one second.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from hqp import Label
from hqp.checks import of_type

from ..base.checks import Array, per_row, positive_scalar
from ..base.live import number, structure
from ..robots.robot import Robot
from ..rows.alone import write_alone
from ..rows.part import PER, Order, Part, Tick
from .distance import told
from .links import LinkCapsule
from .pair_arrays import PairArrays
from .pairs import Pairs
from .shapes import Obstacle

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class AvoidanceTask(Part):
    """Drive the nearest point of the links away from its obstacle; see :mod:`tasks.obstacles.avoidance`.

    Parameters
    ----------
    links : sequence of LinkCapsule
    obstacles : sequence of Sphere and Capsule
    influence : float
        d_i: the distance at which it begins [m].
    speed : float
        v_0: the speed away from the obstacle at contact [m/s].
    gain : float
        At acceleration order, the rate [1/s] at which that speed is reached.
    weight : float
    name : str

    Raises
    ------
    InvalidInput
        If a number is not positive, or a link does not belong to the robot.

    Examples
    --------
    >>> from tasks import AvoidanceTask, Controller, PlanarArm, PositionTask, Sphere, planar_links
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> away = AvoidanceTask(planar_links(arm, 0.02), [Sphere([0.6, 0.7], 0.1)], influence=0.2, speed=0.5)
    >>> Controller(arm, PositionTask([1.0, 0.2], gain=2.0) >> away)(q).v.round(3)
    array([ 0.543, -0.008, -0.194])
    """

    rows = 1
    pairs: Pairs = structure()

    def __init__(
        self,
        links: Sequence[LinkCapsule],
        obstacles: Sequence[Obstacle],
        *,
        influence: float,
        speed: float,
        gain: float = 10.0,
        weight: ArrayLike = 1.0,
        name: str = "avoidance",
    ) -> None:
        self.name = of_type(name, str, "name of an AvoidanceTask")
        self.pairs = Pairs(links, obstacles, self.full_name())
        self.influence, self.speed, self.gain, self.weight = influence, speed, gain, weight
        self._renew()

    @number
    def influence(self, value: float) -> float:
        """d_i: the distance at which it begins [m]."""
        return positive_scalar(value, f"{self.full_name()}: influence", unit="m")

    @number
    def speed(self, value: float) -> float:
        """v_0: the speed away from the obstacle at contact [m/s]."""
        return positive_scalar(value, f"{self.full_name()}: speed", unit="m/s")

    @number
    def gain(self, value: float) -> float:
        """At acceleration order, the rate [1/s] at which that speed is reached."""
        return positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    def _renew(self) -> None:
        per_row(self.weight, 1, f"{self.full_name()}: weight")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(self.name, "nearest", "m" + PER[order])]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.pairs.bind(robot)

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        assert A is not None
        write_alone(self, tick, A, lower, upper)

    def plan(self, site: Site) -> Plan:
        """One loop: all pairs, and the row of the nearest; obstacles are asked where they move."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels import rows as loops

        arrays = PairArrays(self.pairs, site.shared.robot, site.frame, rates=True)
        numbers = [self.influence, self.speed, self.gain]
        return Plan((Call(loops.write_avoidance, *told(site, numbers), arrays.table),), arrays.moves)

    def __repr__(self) -> str:
        return f"AvoidanceTask({len(self.pairs)} pairs, influence={self.influence:g}, speed={self.speed:g})"
