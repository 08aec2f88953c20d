r"""A Pinocchio model as loops, states and tasks ask for it: its joints, frames, chains and dynamics.

Nothing here depends on limits or on where the robot starts; see :class:`tasks.robots.pinocchio.PinocchioRobot`.
"""

from __future__ import annotations

from math import hypot

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import of_type
from hqp.guard import Guard

from ..base.checks import Array, suggestion
from ..base.live import Live, structure
from . import pinocchio_dynamics as dynamics
from .chain import APART
from .closure import Closure
from .frame_names import frame_numbers
from .joint_axes import NONE, base_of, joint_axes, sequence, unit_parts
from .kinematics import Kinematics
from .state import RobotState
from .verification import tell_of_inertias, verify

#: Error of a norm against 1: up to the first it stays as it is, up to the second it is corrected as round-off.
EXACT, ROUND_OFF = 1e-15, 1e-6


class PinocchioModel(Live):
    """The base of :class:`tasks.robots.pinocchio.PinocchioRobot`, which documents the attributes.

    Parameters
    ----------
    model : pinocchio.Model
    tip : str or None
    name : str or None

    Raises
    ------
    InvalidInput
        If there is no such frame, or the model has no joints, or invalid names, axes or numbers.
    """

    model: pin.Model = structure()
    name: str = structure()
    nq: int = structure()
    nv: int = structure()
    base: int = structure()
    joint_names: tuple[str, ...] = structure()
    joint_units: tuple[str, ...] = structure()
    frame_names: tuple[str, ...] = structure()
    tip: str | None = structure()
    kinematics: Kinematics = structure()
    guard: Guard = structure()
    _frame_numbers: dict[str, int]
    _frames: dict[str | None, int]
    _instead = "load or make another robot"

    def __init__(self, model: pin.Model, tip: str | None, name: str | None) -> None:
        self.model = of_type(model, pin.Model, "model")
        self.name = str(model.name) if name is None else of_type(name, str, "name of a robot")
        self.nq, self.nv = int(model.nq), int(model.nv)
        verify(model, repr(self))
        tell_of_inertias(model, repr(self))
        self._base, self.base = base_of(model)
        self._axes = joint_axes(model)
        self.joint_names = tuple(axis.name for axis in self._axes)
        self.joint_units = tuple(axis.unit for axis in self._axes)
        self._units = unit_parts(model)
        places = np.array([axis.q_index for axis in self._axes], dtype=np.intp)
        self._columns = np.flatnonzero(places != NONE)
        self._q_indices = places[self._columns]
        self._support: dict[int, list[tuple[int, int]]] = {}
        self.closures: tuple[Closure, ...] = ()
        self.springs: dict[str, tuple[float, float]] = {}
        self.change_model(model)
        self.tip = None if tip is None else self.check_frame(of_type(tip, str, "tip"))

    def change_model(self, model: pin.Model) -> None:
        """Take a model of the same joints, with a workspace of its own: its frames may be others."""
        vars(self).update(
            model=model,
            kinematics=Kinematics(model, repr(self)),
            guard=Guard(f"the workspace of {self!r}"),
            frame_names=tuple(dict.fromkeys(frame.name for frame in model.frames)),
            _frame_numbers=frame_numbers(model),
            _frames={},
        )

    def at(self, q: ArrayLike, v: ArrayLike | None = None) -> RobotState:
        """The state at (q, v), or at rest."""
        raise NotImplementedError

    # Configurations.

    def integrate(self, q: Array, step: Array) -> Array:
        """The configuration after a step of the joints."""
        return np.asarray(pin.integrate(self.model, q, step))

    def difference(self, start: Array, end: Array) -> Array:
        """The step, shape (nv,), that leads from one configuration to another."""
        return np.asarray(pin.difference(self.model, start, end))

    def on_manifold(self, q: Array) -> tuple[Array, str | None]:
        """q with its circles and quaternions normalised, and an error message if a norm is too far from 1, else None.

        An error of at most 1e-6 is taken as round-off. NaN is accepted: the solver reports it.
        """
        for name, first, count in self._units:
            part = q[first : first + count]
            norm = hypot(*part.tolist())
            if abs(norm - 1.0) <= EXACT or norm != norm:
                continue
            if not abs(norm - 1.0) <= ROUND_OFF:
                what = "quaternion" if count == 4 else "cosine and sine"
                return q, (
                    f"q[{first}:{first + count}], the {what} of joint {name!r}, has norm {norm:g};"
                    f" it must be 1, as of robot.integrate and robot.configuration"
                )
            q = np.array(q)
            q[first : first + count] = part / norm
        return q, None

    # Joints and chains.

    @property
    def data(self) -> pin.Data:
        """Pinocchio's data, with the results of the last computation."""
        return self.kinematics.data

    def positions(self, q: Array) -> Array:
        """The position of each joint that has one, 0 elsewhere, shape (nv,)."""
        if self.nq == self.nv:
            return q
        positions = np.zeros(self.nv)
        positions[self._columns] = q[self._q_indices]
        return positions

    def position_indices(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """The index in q of the position of each of these velocities, shape (k,); -1 if it has none of its own."""
        places = np.full(self.nv, -1, dtype=np.int64)
        places[self._columns] = self._q_indices
        return places[columns]

    def circles(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """The index in q of the cosine of each of these joints, before its sine, shape (k,); -1 if on no circle."""
        return np.array([self._axes[i].circle for i in columns], dtype=np.int64)

    def support(self, joint: int) -> list[tuple[int, int]]:
        """Columns of Pinocchio's joint Jacobian that move the body of a joint, and the velocity of each.

        A mimic joint has a column of its own, with the velocity of its leader.
        """
        found = self._support.get(joint)
        if found is None:
            joints = [self.model.joints[i] for i in self.model.supports[joint]][1:]
            found = [(joint.idx_vExtended + i, joint.idx_v + i) for joint in joints for i in range(joint.nvExtended)]
            self._support[joint] = found
        return found

    def chain_order(self, frame: str | None, relative_to: str | None = None) -> NDArray[np.int64] | None:
        """The place of every velocity in the chain to a frame; see :func:`tasks.robots.chain.chain_order`."""
        start, end = ([] if relative_to is None else self._supports(relative_to)), self._supports(frame)
        steps = [(joint, True) for joint in reversed(start) if joint not in end]
        return self._places_of([*steps, *((joint, False) for joint in end if joint not in start)])

    def tree_order(self) -> NDArray[np.int64] | None:
        """The order of all velocities along their chains; see :class:`tasks.robots.chain.Branched`."""
        rows = []
        for index in range(1, self.model.njoints):
            places = self._places_of([(joint, False) for joint in list(self.model.supports[index])[1:]])
            if places is None:
                return None
            rows += [places] * int(self.model.joints[index].nv)
        return np.array(rows) if len(rows) == self.nv and not len(self.model.mimicking_joints) else None

    def _places_of(self, steps: list[tuple[int, bool]]) -> NDArray[np.int64] | None:
        """The place of every velocity, from the joints in order and whether each is passed backwards."""
        places, free = np.full(self.nv, APART, dtype=np.int64), 0
        for index, backwards in steps:
            joint = self.model.joints[index]
            own = sequence(joint)
            if own is None or (backwards and len(own) > len(set(own))):
                return None
            for i, place in enumerate(own):
                if places[joint.idx_v + i] != APART:  # one number moves two joints
                    return None
                places[joint.idx_v + i] = free + (max(own) - place if backwards else place)
            free += 1 + max(own)
        return places

    def _supports(self, frame: str | None) -> list[int]:
        """The joints that carry a frame, from the base on."""
        return list(self.model.supports[self.model.frames[self.frame_index(frame)].parentJoint])[1:]

    # Frames.

    def has_frame(self, name: str) -> bool:
        """Whether this names a frame, plainly or by kind, as in ``"joint:gripper"``."""
        return name in self._frame_numbers

    def check_frame(self, name: str) -> str:
        """`name`, which must be a frame of this robot.

        Raises
        ------
        InvalidInput
            If it is not one; the message lists the nearest names.
        """
        if not self.has_frame(name):
            raise InvalidInput(f"{name!r} is no frame of {self!r}{suggestion(str(name), self.frame_names)}")
        return name

    def frame_index(self, name: str | None) -> int:
        """Pinocchio's number of a frame; of the tip, if no name is given."""
        found = self._frames.get(name)
        if found is None:
            if name is None and self.tip is None:
                raise InvalidInput(f"{self!r} has no tip; name a frame")
            found = self._frames[name] = self._frame_numbers[self.check_frame(name or str(self.tip))]
        return found

    # Dynamics.

    def compute_center_of_mass(self, q: Array) -> None:
        """Compute the centre of mass at q and its Jacobian into the data."""
        self.kinematics.center_of_mass(q)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """M(q) [kg m^2; kg m and kg where joints slide], symmetric, shape (..., nv, nv)."""
        return dynamics.mass_matrix(self.model, self.kinematics.apart, *dynamics.batches_of(self, q=q))

    def bias(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Torques [N m], forces [N] at zero acceleration: Coriolis, centripetal, gravity, shape (..., nv)."""
        return dynamics.bias(self.model, self.kinematics.apart, *dynamics.batches_of(self, q=q, v=v))

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Joint torques [N m], forces [N] for accelerations a, gravity included, shape (..., nv)."""
        return dynamics.inverse_dynamics(self.model, self.kinematics.apart, *dynamics.batches_of(self, q=q, v=v, a=a))

    def momentum(self, q: Array, v: Array) -> Array:
        """Linear [kg m/s] before angular momentum [kg m^2/s] about the centre of mass, along the axes of the world."""
        return np.array(pin.computeCentroidalMomentum(self.model, self.kinematics.apart, q, v).vector)

    def __repr__(self) -> str:
        return f"PinocchioRobot({self.name!r}, {self.nv} degrees of freedom)"
