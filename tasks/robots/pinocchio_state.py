"""The state of a Pinocchio robot and its frames; each quantity is computed when first asked for, and once."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..base.checks import Array
from .frame import FixedFrame, without_round_off
from .transforms import Transforms

if TYPE_CHECKING:
    from .pinocchio_model import PinocchioModel


class PinocchioState(Transforms):
    """A robot at one instant; see :class:`tasks.RobotState`."""

    def __init__(self, robot: PinocchioModel, q: Array, v: Array) -> None:
        self.robot, self.q, self.v = robot, q, v

    @cached_property
    def _frames(self) -> dict[str | None, PinocchioFrame]:
        """Those that were asked for: most ticks of a controller ask for none."""
        return {}

    @cached_property
    def joints(self) -> Array:
        """The position of each joint that has one, 0 elsewhere, shape (nv,)."""
        return self.robot.positions(self.q)

    def frame(self, name: str | None = None) -> PinocchioFrame:
        """The frame of that name, by default the tip.

        Raises
        ------
        InvalidInput
            If there is no such frame; the message lists the nearest names.
        """
        found = self._frames.get(name)
        if found is None:
            found = self._frames[name] = PinocchioFrame(self, self.robot.frame_index(name))
        return found

    @cached_property
    def pose(self) -> Array:
        """The pose of the tip for records: position [m] and rotation vector [rad], shape (6,); empty without a tip."""
        if self.robot.tip is None:
            return np.zeros(0)
        tip = self.frame()
        return np.concatenate([tip.position, pin.log3(tip.rotation)])

    @cached_property
    def center_of_mass(self) -> FixedFrame:
        """The centre of mass: a frame along the axes of the world."""
        model, kinematics = self.robot.model, self.robot.kinematics
        data = kinematics.overwritten()
        pin.centerOfMass(model, data, self.q, self.v, np.zeros(model.nv))
        drift = np.array(data.acom[0])
        kinematics.center_of_mass(self.q)
        position, linear = np.array(data.com[0]), np.array(data.Jcom).reshape(3, -1)
        return FixedFrame(position, np.eye(3), linear, np.zeros_like(linear), drift, np.zeros(3))

    def ready(self) -> pin.Data:
        """Pinocchio's data with the joint Jacobians of this state: computed once, until another state is used."""
        return self.robot.kinematics.jacobians(self)

    def accelerated(self) -> pin.Data:
        """The data of :meth:`ready`, with the accelerations at zero joint acceleration."""
        return self.robot.kinematics.accelerations(self)


class PinocchioFrame:
    """A frame at one instant; see :class:`tasks.robots.frame.Frame`."""

    def __init__(self, state: PinocchioState, index: int) -> None:
        self._state, self._index = state, index
        model, data = state.robot.model, state.ready()
        place = pin.updateFramePlacement(model, data, index)
        self.position, self.rotation = np.array(place.translation), np.array(place.rotation)
        jacobian = pin.getFrameJacobian(model, data, index, pin.LOCAL_WORLD_ALIGNED)
        self._jacobian = without_round_off(np.asarray(jacobian).reshape(6, -1))  # Pinocchio gives a vector for nv = 1

    @property
    def linear(self) -> Array:
        return self._jacobian[:3]

    @property
    def angular(self) -> Array:
        return self._jacobian[3:]

    @cached_property
    def _drift(self) -> Array:
        robot, data = self._state.robot, self._state.accelerated()
        return np.array(
            pin.getFrameClassicalAcceleration(robot.model, data, self._index, pin.LOCAL_WORLD_ALIGNED).vector
        )

    @property
    def linear_drift(self) -> Array:
        return self._drift[:3]

    @property
    def angular_drift(self) -> Array:
        return self._drift[3:]
