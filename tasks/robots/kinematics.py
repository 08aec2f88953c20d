"""Pinocchio's workspace for one robot, and the state whose kinematics it holds: all frames share one pass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ..base.checks import Array

if TYPE_CHECKING:
    from .state import RobotState


class Kinematics:
    """The data of a model, filled for one state at a time.

    Parameters
    ----------
    model : pinocchio.Model
    what : str
        The robot, for messages.

    Attributes
    ----------
    data : pinocchio.Data

    Raises
    ------
    InvalidInput
        If the model is too large.
    """

    def __init__(self, model: pin.Model, what: str) -> None:
        self.model = model
        try:
            self.data = model.createData()
        except MemoryError:
            raise InvalidInput(f"{what} has {model.njoints - 1} joints; it is too large for Pinocchio") from None
        self._still = np.zeros(model.nv)
        self._apart: pin.Data | None = None
        self._holder: RobotState | None = None
        self._accelerated = False

    def jacobians(self, state: RobotState) -> pin.Data:
        """The data with the joint Jacobians of this state: computed once, until another state is used."""
        if self._holder is not state:
            pin.computeJointJacobians(self.model, self.data, state.q)
            self._holder, self._accelerated = state, False
        return self.data

    def accelerations(self, state: RobotState) -> pin.Data:
        """The data with joint Jacobians, and the accelerations of the joints' frames at zero joint acceleration."""
        data, known = self.data, self._holder is state
        if not (known and self._accelerated):
            pin.forwardKinematics(self.model, data, state.q, state.v, self._still)
            if not known:
                pin.computeJointJacobians(self.model, data)  # from the placements of the line above
            self._holder, self._accelerated = state, True
        return data

    def center_of_mass(self, q: Array) -> pin.Data:
        """The data with the centre of mass at q, and its Jacobian."""
        pin.jacobianCenterOfMass(self.model, self.overwritten(), q)
        return self.data

    @property
    def apart(self) -> pin.Data:
        """Separate data of the same model, for computations that would overwrite this one."""
        if self._apart is None:
            self._apart = self.model.createData()
        return self._apart

    def overwritten(self) -> pin.Data:
        """The data, for a computation that overwrites them."""
        self._holder = None
        return self.data
