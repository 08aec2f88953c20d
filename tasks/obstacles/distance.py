r"""Limit: links keep a distance from obstacles, one linear inequality a pair, safe within the tick.

With the distance d of a link to an obstacle, n the unit normal from the obstacle to the link and J the Jacobian of the
witness, :math:`\dot d = n^T (J \dot q - \dot o)`. This holds at the beginning of the tick. The
distance lost in the tick through the rotation of the link and the curvature of its path is at most a reserve
:math:`\rho` (:mod:`tasks.obstacles.kernels.reserve`). With
:math:`e = d - d_{min} - \rho` and the displacement :math:`\Delta o` of the obstacle in the tick,

.. math::

    n^T J x \ge \frac{n^T \Delta o}{dt} +
    \begin{cases} -K e & e \ge 0 \\ \min(-e, \rho) / dt + K \max(-e - \rho, 0) & e < 0 \end{cases}

Where the row is met, :math:`d \ge d_{min}` now gives :math:`d^+ \ge d_{min}` at the next tick: for
:math:`e \ge 0` and :math:`K dt \le 1` it is :math:`d^+ \ge d - K dt\, e - \rho \ge d_{min}`, and otherwise
:math:`d^+ \ge d - e - \rho = d_{min}`. From inside the margin it comes back at the rate K. The idea of the row is the
velocity damper of B. Faverjon and P. Tournassoud, "A local based approach for path planning of manipulators with a
high number of degrees of freedom", IEEE ICRA 1987; the reserve makes it hold in discrete time.

At acceleration order, with b the right side, the velocity at the end of the tick obeys the same law, and the mean
velocity of the tick its strictest form b', that of K = 1/dt, so that the next distance is proved there too:

.. math:: n^T J a \ge \max\left( (b - \dot d) / dt - n^T \dot J v,\ 2 (b' - \dot d) / dt \right).

As a step of the joints, for inverse kinematics, there is neither gain nor reserve:
:math:`n^T J\, dq \ge -(d - d_{min})`.

The proof covers one tick. Whether the row can be met depends on the levels above it: braking needs an acceleration of
the order of K times the speed, which acceleration limits may not allow; a smaller K then keeps a larger distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type, whole_number

from ..base.checks import Array, not_negative, per_row, positive_scalar, scalar
from ..base.live import number, structure
from ..base.telling import tell
from ..robots.robot import Robot, RobotState, base
from ..rows.alone import write_alone
from ..rows.part import PER, Order, Part, Tick
from .links import LinkCapsule
from .pair_arrays import PairArrays
from .pairs import Pairs
from .shapes import Obstacle

if TYPE_CHECKING:
    from ..base.loops import Entry
    from ..rows.plan import Plan
    from ..rows.site import Site


class DistanceLimit(Part):
    """Keep links at a distance from obstacles; see :mod:`tasks.obstacles.distance`.

    Put it below the joint limits and above the tasks that must give way. On the level of the joint limits both share
    what cannot be met at once, and joints become too fast. The reserve is computed from the largest joint speeds that
    the limits allow: at velocity order the stack needs a JointVelocityLimit or a JointAccelerationLimit.

    Parameters
    ----------
    links : sequence of LinkCapsule
        Of a planar arm, ``planar_links(arm, radius)``.
    obstacles : sequence of Sphere and Capsule
    margin : float
        The least distance of the surfaces [m]; not negative.
    gain : float
        K [1/s]: the rate at which the margin is neared; at most 1/dt.
    nearest : int, optional
        Number of rows, one for each of the nearest pairs (default: a row for every pair).
    weight : float or array, shape (rows,)
    name : str

    Raises
    ------
    InvalidInput
        If the margin is negative, the gain is not positive or exceeds 1/dt, the controller has no dt, a link does not
        belong to the robot, or nothing limits the joint speeds.

    Examples
    --------
    >>> from tasks import Controller, DistanceLimit, JointVelocityLimit, PlanarArm, PositionTask, Sphere, planar_links
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> clear = DistanceLimit(planar_links(arm, 0.02), [Sphere([0.9, 0.2], 0.1)], margin=0.02, gain=5.0)
    >>> stack = JointVelocityLimit(2.0) + clear >> PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, stack, dt=0.01)(q).v.round(3)
    array([ 0.972, -2.   ,  0.251])
    """

    is_limit: ClassVar[bool] = True
    pairs: Pairs = structure()

    def __init__(
        self,
        links: Sequence[LinkCapsule],
        obstacles: Sequence[Obstacle],
        *,
        margin: float,
        gain: float,
        nearest: int | None = None,
        weight: ArrayLike = 1.0,
        name: str = "distance",
    ) -> None:
        self.name = of_type(name, str, "name of a DistanceLimit")
        self.pairs = Pairs(links, obstacles, self.full_name())
        self.margin, self.gain = margin, gain
        self.rows = len(self.pairs)
        if nearest is not None:
            self.rows = min(whole_number(nearest, f"{self.full_name()}: nearest", least=1), self.rows)
        self.weight = weight
        self._renew()

    @number
    def margin(self, value: float) -> float:
        """The least distance of the surfaces [m]; not negative."""
        return scalar(not_negative(value, f"{self.full_name()}: margin", unit="m"), f"{self.full_name()}: margin")

    @number
    def gain(self, value: float) -> float:
        """K [1/s]: the rate at which the margin is neared."""
        return positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    def _renew(self) -> None:
        assert self.rows is not None
        per_row(self.weight, self.rows, f"{self.full_name()}: weight")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        whole = self.rows == len(self.pairs)
        rows = self.pairs.names() if whole else [f"nearest {i + 1}" for i in range(self.size(robot))]
        return [Label(self.name, row, "m" + PER[order]) for row in rows]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        check_rate(self.full_name(), self.gain, order, dt)
        self.pairs.bind(robot)

    def check_beside(self, tick: Tick) -> None:
        if tick.order == "displacement":
            return
        assert tick.envelope is not None
        rate = tick.envelope.braking_rate()
        if rate < np.inf and any(obstacle.moves for obstacle in self.pairs.obstacles):
            tell(
                f"{self.full_name()}: an obstacle moves, and the joints take up to {1.0 / rate:.3g} s to stop: where it"
                f" comes nearer by 1 m/s the margin may be passed by up to {0.5 / rate:.3g} m"
            )
        lower, upper = np.zeros((2, len(self.pairs)))
        write_alone(self, tick, np.zeros((len(lower), tick.robot.nv)), lower, upper)
        if np.isnan(lower).any():
            raise InvalidInput(
                f"{self.full_name()}: nothing keeps the joints from turning a link by a quarter within a tick of"
                f" {tick.dt:g} s; add a JointVelocityLimit(2.0), in rad/s, to the stack, above it or on its level"
            )

    def distances(self, robot: Robot, state: RobotState, t: float = 0.0) -> Array:
        """The distances between the surfaces [m], one a pair, at time t [s]."""
        return self.pairs.measure(robot, state, t)[:, 0]

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        assert A is not None
        write_alone(self, tick, A, lower, upper)

    def plan(self, site: Site) -> Plan:
        """One loop: all pairs, the nearest of them, and their rows; obstacles are asked where they move."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels import rows as loops

        robot, n = site.shared.robot, site.shared.n
        site.bounds = True
        arrays = PairArrays(self.pairs, robot, site.frame, dt=site.shared.dt)
        call = Call(
            loops.write_limit,
            *told(site, [self.margin, self.gain]),
            arrays.table,
            *fastest(site),
            base(robot),
            np.zeros(3 * n),
            np.zeros(len(self.pairs), dtype=np.int64),
        )
        return Plan((call,), arrays.moves)

    def __repr__(self) -> str:
        return f"DistanceLimit({len(self.pairs)} pairs, margin={self.margin:g}, gain={self.gain:g})"


def told(site: Site, given: Sequence[float]) -> tuple[Entry, ...]:
    """The first arguments of the loops of all distance parts, see :mod:`tasks.obstacles.kernels.rows`."""
    from ..rows.kernels.law import ORDERS

    assert site.A is not None
    shared = site.shared
    sizes = ORDERS.index(shared.order), site.rows, shared.n
    return *sizes, site.A, site.lower, site.upper, np.array(given), shared.braking, shared.v


def fastest(site: Site) -> tuple[Entry, Entry]:
    """The tightest limits [rad/s], [rad/s^2] that the stack itself has for the joints, 0 where it has none."""
    envelope = site.shared.envelope
    velocity = envelope.velocity if envelope.has_velocity else 0
    return velocity, envelope.acceleration if envelope.has_acceleration else 0


def check_rate(what: str, gain: float, order: Order, dt: float | None) -> None:
    """Refuse a gain above 1/dt, which would pass the margin in one tick, and an unknown dt; steps of joints need none.

    Raises
    ------
    InvalidInput
    """
    if order == "displacement":
        return
    if dt is None:
        raise InvalidInput(f"{what}: it needs the tick; give the controller dt in s")
    if gain * dt > 1.0 + 1e-9:
        raise InvalidInput(
            f"{what}: gain = {gain:g} 1/s passes the margin within a tick of {dt:g} s; it must be at most {1.0 / dt:g}"
        )
