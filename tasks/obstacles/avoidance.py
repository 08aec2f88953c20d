r"""The point nearest to an obstacle is driven away: the one-dimensional task.

.. math::

    \lambda\, n^T J x = \lambda\, (n^T \dot o + \lambda v_0), \qquad
    \lambda = s^2 (3 - 2 s), \quad s = \min(\max(1 - d / d_i, 0), 1)

of the nearest pair: away at the speed v_0 where it touches, not at all where it is as far as the influence distance
d_i. That the motion away from an obstacle takes one degree of freedom, not three, is due to L. Zlajpah and B. Nemec,
"Kinematic control algorithms for on-line obstacle avoidance for redundant manipulators", IEEE/RSJ IROS 2002; the
task itself to A. A. Maciejewski and C. A. Klein, "Obstacle avoidance for kinematically redundant manipulators in
dynamically varying environments", International Journal of Robotics Research 4(3), 1985.

Unlike :class:`tasks.DistanceLimit` it keeps no margin: it pushes when there is room, knows one pair, and between two
ticks another pair may be the nearest. Scaled rows fade in beside others of their level, such as a Damping; strictly
above a task the row takes its degree of freedom, however small its scale.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from hqp import Label
from hqp.checks import of_type

from .._checks import Array, positive, positive_scalar
from ..part import PER, Order, Part, Tick
from ..robots.robot import Robot
from .links import LinkCapsule
from .pairs import Pairs
from .shapes import Obstacle


class AvoidanceTask(Part):
    """Drive the nearest point of the links away from its obstacle; see :mod:`tasks.obstacles.avoidance`.

    Parameters
    ----------
    links : sequence of LinkCapsule
    obstacles : sequence of Sphere and Capsule
    influence : float
        d_i: the distance at which it begins [m].
    speed : float
        v_0: how fast it moves away where it touches [m/s].
    gain : float
        At acceleration order, the rate [1/s] at which that speed is reached.
    weight : float
    name : str

    Raises
    ------
    InvalidInput
        If a number is not positive, or a link is none of the robot's.
    """

    rows = 1

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
        self.pairs = Pairs(links, obstacles, self.label())
        self.influence = positive_scalar(influence, f"{self.label()}: influence", unit="m")
        self.speed = positive_scalar(speed, f"{self.label()}: speed", unit="m/s")
        self.gain = positive_scalar(gain, f"{self.label()}: gain", unit="1/s")
        self.weight = positive(weight, f"{self.label()}: weight")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(self.name, "nearest", "m" + PER[order])]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.pairs.bind(robot)

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        assert A is not None
        pairs = self.pairs.at(tick.state, self.pairs.bind(tick.robot), tick.t)
        k = int(np.argmin([pair.distance for pair in pairs]))
        pair, obstacle, v = pairs[k], self.pairs.obstacles[k % len(self.pairs.obstacles)], tick.state.v
        s = min(max(1.0 - pair.distance / self.influence, 0.0), 1.0)
        fade = s * s * (3.0 - 2.0 * s)
        J, n = pair.gradient, pair.normal
        wanted = float(n @ obstacle.velocity(tick.t)) + fade * self.speed
        if tick.order == "acceleration":
            wanted = self.gain * (wanted - float(J @ v))
            wanted -= float(n @ (pair.place.drift(v) - obstacle.acceleration(tick.t)))
        A[0], lower[0], upper[0] = fade * J, fade * wanted, fade * wanted

    def __repr__(self) -> str:
        return f"AvoidanceTask({len(self.pairs)} pairs, influence={self.influence:g}, speed={self.speed:g})"
