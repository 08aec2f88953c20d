r"""Links stay away from obstacles: one linear inequality a pair, safe within the tick.

With the distance d of a link to an obstacle, n the unit normal from the obstacle to the link and J the Jacobian of the
witness, :math:`\dot d = n^T (J \dot q - \dot o)`. That is linear now, not at the end of the tick: what the turn of the
link and the bend of its way can take is at most a reserve :math:`\rho` (:mod:`tasks.obstacles.reserve`). With
:math:`e = d - d_{min} - \rho` and the way :math:`\Delta o` of the obstacle within the tick,

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

What is proved is one tick. Whether the row can be met is a matter of the levels above it: acceleration limits may
leave too little to brake with, in the order of K times the speed, and then a smaller K keeps farther away.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type, whole_number

from .._checks import Array, finite_scalar, per_row, positive, positive_scalar
from .._telling import tell
from ..part import PER, Order, Part, Tick
from ..robots.robot import Robot, RobotState, base
from .links import LinkCapsule
from .pairs import Distance, Pairs
from .reserve import fastest, reserve
from .shapes import Obstacle


class DistanceLimit(Part):
    """Keep links at a distance from obstacles; see :mod:`tasks.obstacles.distance`.

    It stands below the joint limits, or on their level, and above what must give way. The limits tell how fast the
    joints may turn, which the reserve is computed from: at velocity order the stack needs a JointVelocityLimit or a
    JointAccelerationLimit.

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
        Rows for so many pairs only, those which are nearest (default: a row for every pair).
    weight : float or array, shape (rows,)
    name : str

    Raises
    ------
    InvalidInput
        If the margin is negative, the gain not positive or more than 1/dt, the controller has no dt, or a link is
        none of the robot's, or if nothing limits the joint speeds.
    """

    is_limit: ClassVar[bool] = True

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
        self.pairs = Pairs(links, obstacles, self.label())
        self.margin = finite_scalar(margin, f"{self.label()}: margin")
        if self.margin < 0.0:
            raise InvalidInput(f"{self.label()}: margin = {self.margin:g} m must not be negative")
        self.gain = positive_scalar(gain, f"{self.label()}: gain", unit="1/s")
        self.rows = len(self.pairs)
        if nearest is not None:
            self.rows = min(whole_number(nearest, f"{self.label()}: nearest", least=1), self.rows)
        self.weight = positive(weight, f"{self.label()}: weight")
        per_row(self.weight, self.rows, f"{self.label()}: weight")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        whole = self.rows == len(self.pairs)
        rows = self.pairs.names() if whole else [f"nearest {i + 1}" for i in range(self.size(robot))]
        return [Label(self.name, row, "m" + PER[order]) for row in rows]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        check_rate(self.label(), self.gain, dt)
        self.pairs.bind(robot)

    def check_beside(self, tick: Tick) -> None:
        assert tick.envelope is not None
        rate = tick.envelope.braking_rate(tick)
        if rate < np.inf and any(obstacle.moves for obstacle in self.pairs.obstacles):
            tell(
                f"{self.label()}: an obstacle moves, and the joints take up to {1.0 / rate:.3g} s to stop: where it"
                f" comes nearer by 1 m/s the margin may be passed by up to {0.5 / rate:.3g} m"
            )
        pairs = self.pairs.at(tick.state, self.pairs.bind(tick.robot), tick.t)
        for k, pair in enumerate(pairs):
            if np.isnan(self._least(tick, pair, self.pairs.obstacles[k % len(self.pairs.obstacles)])):
                raise InvalidInput(
                    f"{self.label()}: nothing keeps the joints from turning a link by a quarter within a tick of"
                    f" {tick.dt:g} s; add a JointVelocityLimit(2.0), in rad/s, to the stack, above it or on its level"
                )

    def distances(self, robot: Robot, state: RobotState, t: float = 0.0) -> Array:
        """Of the surfaces, one a pair [m], at time t [s]."""
        return np.array([pair.distance for pair in self.pairs.at(state, self.pairs.bind(robot), t)])

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        assert A is not None
        pairs = self.pairs.at(tick.state, self.pairs.bind(tick.robot), tick.t)
        chosen = range(len(pairs))
        if len(lower) < len(pairs):  # in their own order, so that rows seldom change places
            order = np.argsort([pair.distance for pair in pairs], kind="stable")
            chosen = sorted(order[: len(lower)].tolist())  # type: ignore[assignment]
        for row, k in enumerate(chosen):
            A[row] = pairs[k].gradient
            lower[row] = self._least(tick, pairs[k], self.pairs.obstacles[k % len(self.pairs.obstacles)])
        upper[:] = np.inf

    def _least(self, tick: Tick, pair: Distance, obstacle: Obstacle) -> float:
        """The least n^T J x [m/s], [m/s^2]."""
        dt, n, v = tick.dt, pair.normal, tick.state.v
        assert dt is not None  # checked before the first tick
        w = fastest(tick)
        if tick.order == "acceleration":
            w = np.where(np.isfinite(w), np.maximum(w, np.abs(v)), np.abs(v))
        shift = obstacle.core(tick.t + dt)[0] - obstacle.core(tick.t)[0]
        gaps = pair.witness - pair.core
        rho = reserve(pair.place, n, gaps, w, dt, shift=float(np.linalg.norm(shift)), base=base(tick.robot))
        if not rho < np.inf:
            return np.nan  # a link may be anywhere: the solver says that nothing is known
        e, along = pair.distance - self.margin - rho, float(n @ shift) / dt
        gain = self.gain
        if tick.envelope is not None and (rate := tick.envelope.braking_rate(tick)) < np.inf:
            gain = min(gain, rate)  # and what the bend of the way takes until the joints stand
            bend = 0.5 * max(-float(n @ pair.place.drift(v)), 0.0) * (1.0 / gain + dt) / gain
            e = max(e - bend, min(e, 0.0))
        back = min(max(-e, 0.0), rho) / dt + gain * max(-e - rho, 0.0)
        end = along + back - gain * max(e, 0.0)
        if tick.order == "velocity":
            return end
        now = float(pair.gradient @ v)
        mean = along + back - max(e, 0.0) / dt
        return max((end - now) / dt - float(n @ pair.place.drift(v)), 2.0 * (mean - now) / dt)

    def __repr__(self) -> str:
        return f"DistanceLimit({len(self.pairs)} pairs, margin={self.margin:g}, gain={self.gain:g})"


def check_rate(what: str, gain: float, dt: float | None) -> None:
    """Refuse a rate that passes the margin within a tick, and a tick that is not known.

    Raises
    ------
    InvalidInput
    """
    if dt is None:
        raise InvalidInput(f"{what}: it needs the tick; give the controller dt in s")
    if gain * dt > 1.0 + 1e-9:
        raise InvalidInput(
            f"{what}: gain = {gain:g} 1/s passes the margin within a tick of {dt:g} s; it must be at most {1.0 / dt:g}"
        )
