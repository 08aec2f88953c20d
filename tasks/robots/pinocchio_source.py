"""Frames of a Pinocchio robot for compiled loops: one kinematics pass a tick, and the addresses of its results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ..base.checks import Array

if TYPE_CHECKING:
    from ..base.loops import Call
    from .pinocchio_model import PinocchioModel
    from .pinocchio_state import PinocchioState
    from .source import Flag


class PinocchioSource:
    """Frames and dynamics of one robot for loops, computed on demand; see :class:`tasks.robots.source.Source`.

    Parameters
    ----------
    robot : PinocchioModel
    q, v : array, shapes (nq,) and (nv,)
        They hold the state of the tick.
    """

    def __init__(self, robot: PinocchioModel, q: Array, v: Array) -> None:
        self._robot, self._model, self._data = robot, robot.model, robot.data
        self._q, self._v, self._still = q, v, np.zeros(robot.nv)
        self._centre = self._inertia = self._momentum = False
        self._matrices: list[Array] = []  # arrays that Pinocchio does not keep itself
        self._biases: list[Array] = []
        self._kept: list[Any] = []

    def frame(self, name: str | None, block: Array, drifts: Flag) -> Call:
        from ..base.loops import Call
        from .kernels.frames import joint_frame

        robot, data = self._robot, self._data
        frame = self._model.frames[robot.frame_index(name)]
        joint = int(frame.parentJoint)
        placement, motion, change = data.oMi[joint], data.v[joint], data.a[joint]
        self._kept += [placement, motion, change]
        mounted = np.concatenate([np.ravel(frame.placement.rotation), frame.placement.translation])
        support = np.ascontiguousarray(np.array(robot.support(joint), dtype=np.int64).reshape(-1, 2).T)
        return Call(
            joint_frame,
            robot.nv,
            block,
            drifts,
            placement.rotation,
            placement.translation,
            mounted,
            np.asarray(data.J),
            support.shape[1],
            support,
            motion.vector,
            change.vector,
        )

    def center_of_mass(self, block: Array, drifts: Flag) -> Call:
        from ..base.loops import Call
        from .kernels.frames import point_frame

        self._centre = True
        data = self._robot.kinematics.overwritten()
        pin.centerOfMass(self._model, data, self._q, self._v, self._still)  # allocates the arrays
        pin.jacobianCenterOfMass(self._model, data, self._q)
        return Call(point_frame, self._robot.nv, block, drifts, data.com[0], data.Jcom, data.vcom[0], data.acom[0])

    def axes(self) -> Array | None:
        J = np.reshape(self._data.J, (6, -1))  # for nv = 1 it is a vector
        return J if J.shape[1] == self._robot.nv and not len(self._model.mimicking_joints) else None

    def mass_matrix(self, M: Array) -> Call | None:
        if len(self._model.mimicking_joints):  # where crba is wrong, see pinocchio_dynamics
            self._matrices.append(M)
            return None
        from ..base.loops import Call
        from .kernels.frames import symmetric

        self._inertia = True
        pin.crba(self._model, self._robot.kinematics.overwritten(), pin.neutral(self._model))  # allocates the array
        return Call(symmetric, self._robot.nv, np.asarray(self._data.M), M)

    def bias(self, b: Array) -> None:
        self._biases.append(b)

    def momentum(self, G: Array, drift: Array) -> Call | None:
        from ..base.loops import Call
        from .kernels.frames import momentum_map

        if len(self._model.mimicking_joints):
            raise InvalidInput(f"{self._robot!r}: momentum is not told of robots whose joints follow others")
        self._momentum = True
        data = self._robot.kinematics.overwritten()
        pin.computeCentroidalMapTimeVariation(self._model, data, pin.neutral(self._model), self._still)
        return Call(momentum_map, self._robot.nv, data.Ag, data.dAg, self._v, G, drift)

    def update(self, state: PinocchioState, drifts: bool) -> None:
        """One pass over the joints; later computations read its results and do not overwrite them."""
        model, data, q, v = self._model, self._data, self._q, self._v
        for M in self._matrices:
            M[:] = self._robot.mass_matrix(q)
        if drifts:
            self._robot.kinematics.accelerations(state)
        else:
            self._robot.kinematics.jacobians(state)
        if self._centre:
            if drifts:
                pin.centerOfMass(model, data, pin.ACCELERATION, False)
            pin.jacobianCenterOfMass(model, data, False)
        if self._inertia:
            pin.crba(model, data, q)
        for b in self._biases:
            b[:] = pin.nonLinearEffects(model, data, q, v)
        if self._momentum:
            pin.computeCentroidalMapTimeVariation(model, data, q, v)
