r"""Momentum of the whole robot, about its centre of mass: :math:`h = A_G(q)\, v`.

The centroidal momentum h, linear [kg m/s] and angular [kg m^2/s] along the axes of the world, converges to its target
at the rate K:

.. math:: A_G a = \dot h^d + K (h^d - h) - \dot A_G v, \qquad A_G v = h^d \text{ at velocity order.}
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import one_of

from ..base.checks import Array
from ..base.live import number, structure
from ..robots import abilities as able
from ..robots.robot import Robot
from ..rows.loop_task import LoopTask
from ..rows.part import Order
from ..targets.trajectories import Trajectory, as_trajectory

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site

#: Which part of the momentum a task controls.
Kind = Literal["both", "linear", "angular"]
#: Units of a momentum, and of its rate.
UNITS = {"velocity": ("kg m/s", "kg m^2/s"), "acceleration": ("N", "N m"), "displacement": ("kg m", "kg m^2")}


class MomentumTask(LoopTask):
    """Bring the momentum of the robot to a target; zero angular momentum keeps it from spinning.

    Parameters
    ----------
    target : array, shape (3,) or (6,), or Trajectory, optional
        Linear [kg m/s], then angular [kg m^2/s] (default: 0).
    kind : {"both", "linear", "angular"}
    gain : float or array, shape (rows,)
        K [1/s].
    weight : float or array, shape (rows,)
        Weight of the rows inside their level.
    name : str, optional
        Used in messages, tables and records.

    Raises
    ------
    InvalidInput
        If the kind is unknown, or the target has a wrong size; with a robot, if it does not provide its momentum.

    Examples
    --------
    >>> from tasks import MomentumTask
    >>> MomentumTask(kind="angular", gain=5.0)
    MomentumTask([0.0, 0.0, 0.0], kind='angular', gain=5)
    """

    kind: Kind = structure()
    cap: Array | None = structure(None)  # an error of momentum is not shortened
    deceleration: float | None = structure(None)

    def __init__(
        self,
        target: ArrayLike | Trajectory | None = None,
        *,
        kind: Kind = "both",
        gain: ArrayLike,
        weight: ArrayLike = 1.0,
        name: str | None = None,
    ) -> None:
        self._call(name)
        one_of(kind, get_args(Kind), f"{self.full_name()}: kind")
        self.kind, self.rows = kind, 6 if kind == "both" else 3
        self.target = np.zeros(self.rows) if target is None else target
        super().__init__(gain=gain, weight=weight, name=name)

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The momentum [kg m/s], [kg m^2/s]."""
        return as_trajectory(value, self.rows, self.full_name())

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if not {able.Sourced, able.Centroidal} <= _abilities(robot):
            raise InvalidInput(f"{self.full_name()}: {robot!r} does not tell its momentum; robots of Pinocchio do")
        if order == "displacement":
            raise InvalidInput(f"{self.full_name()}: a step of inverse kinematics has no momentum")
        super().check(robot, order, dt)

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        linear, angular = UNITS[order]
        rows = [(axis, linear) for axis in "xyz"] + [(f"about {axis}", angular) for axis in "xyz"]
        return [Label(self.name, row, unit) for row, unit in rows[self._first : self._first + self.size(robot)]]

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [(label.row, label.unit) for label in self.labels(robot, "velocity")]

    @property
    def _first(self) -> int:
        return 3 if self.kind == "angular" else 0

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.balance import write_momentum

        target = np.zeros((3, site.rows))
        moves = site.keep_up(self, "target", *target)
        map_of, drift = site.shared.blocks.momentum()
        return Plan((Call(write_momentum, site.law(self), map_of, drift, self._first, target),), moves)

    def _shown(self) -> list[str]:
        return [repr(self.target), f"kind={self.kind!r}"]


def _abilities(robot: Robot) -> set[type]:
    return {kind for kind in (able.Sourced, able.Centroidal) if able.has(robot, kind)}
