r"""Spatial robots, with their kinematics and dynamics by Pinocchio: arms, mobile bases, humanoids.

A configuration q lies on the manifold of the robot: a joint that turns without end is a point on a circle, a floating
base a position and a quaternion. Velocities v have nv <= nq numbers: those of a floating base are its linear and
angular velocity along its own axes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput, MissingPackage
from hqp.checks import of_type

from .._checks import LARGEST, Array, finite_scalar, own_numbers, per_row, position_range, positive
from .robot import joint_index, nearest

try:
    import pinocchio as pin
except ImportError as error:  # pragma: no cover
    raise MissingPackage("spatial robots need Pinocchio: pip install 'hqp[robots]'") from error

from .pinocchio_state import PinocchioState


class PinocchioRobot:
    """A robot with a Pinocchio model. One robot serves one thread; copies share the model.

    Parameters
    ----------
    model : pinocchio.Model
    tip : str, optional
        The frame that tasks mean which name none.
    name : str, optional
        Default: the model's own.
    position_limit : pair of float or array, shape (nv,), optional
        Lowest and highest joint positions [rad], [m] (default: the model's).
    velocity_limit : float or array, shape (nv,), optional
        Largest joint speed [rad/s], [m/s] (default: the model's).
    acceleration_limit : float or array, shape (nv,), optional
        Largest joint acceleration [rad/s^2], [m/s^2]; a model has none.
    torque_limit : float or array, shape (nv,), optional
        Largest joint torque [N m], force [N] (default: the model's).

    Attributes
    ----------
    base : int
        How many velocities are those of a floating base: 6, or 0.
    joint_names : tuple of str
        One a velocity; a joint of several has them numbered, as in ``"root_joint[0]"``.
    joint_units : tuple of str
        "rad" or "m", one a velocity.
    frame_names : tuple of str
    neutral : array, shape (nq,)
        The neutral configuration, moved into the position limits where it lies outside.
    home : array, shape (nq,)
        A configuration to start from: that of the library, or the neutral one.
    source : pathlib.Path or None
        The file that it was loaded from, for its shapes; see :meth:`geometry`.

    Raises
    ------
    InvalidInput
        If there is no such frame, or a limit is not positive, or lowest above highest; names the joint.
    """

    def __init__(
        self,
        model: pin.Model,
        *,
        tip: str | None = None,
        name: str | None = None,
        position_limit: tuple[ArrayLike, ArrayLike] | None = None,
        velocity_limit: ArrayLike | None = None,
        acceleration_limit: ArrayLike | None = None,
        torque_limit: ArrayLike | None = None,
    ) -> None:
        self.model = of_type(model, pin.Model, "model")
        self.data = self.model.createData()
        self.nq, self.nv = int(model.nq), int(model.nv)
        joints = list(model.joints)[1:]
        self.base = 6 if joints and joints[0].nv == 6 else 0
        self.name = str(model.name) if name is None else of_type(name, str, "name of a robot")
        self.joint_names = tuple(_joint_names(model))
        self.joint_units = tuple(_joint_units(model))
        self.frame_names = tuple(dict.fromkeys(frame.name for frame in model.frames))
        self._columns, self._places = _single_joints(model)
        self._frames: dict[str | None, int] = {}
        self._state: PinocchioState | None = None  # whose kinematics the data holds
        self._accelerated = False
        self.position_limit = self._position_limit(position_limit)
        self.velocity_limit = self._own_limit(velocity_limit, model.velocityLimit, "velocity limit", "rad/s")
        self.torque_limit = self._own_limit(torque_limit, model.effortLimit, "torque limit", "N m")
        self.acceleration_limit = None
        if acceleration_limit is not None:
            self.acceleration_limit = self._per_joint(acceleration_limit, "acceleration limit", "rad/s^2")
        self.tip = None if tip is None else self.check_frame(tip)
        self.neutral = self._inside(pin.neutral(model))
        self.home = self.neutral
        self.source: Path | None = None
        self._geometry: pin.GeometryModel | None = None

    def geometry(self) -> pin.GeometryModel:
        """The collision shapes of its file, read when first asked for; meshes become their convex hulls.

        Raises
        ------
        InvalidInput
            If there is no URDF file, or a mesh of it cannot be read.
        """
        if self._geometry is None:
            from .geometry import collision_geometry

            if self.source is None or self.source.suffix != ".urdf":
                raise InvalidInput(f"{self!r} has no URDF file to read shapes from; use load_robot, or set its source")
            self._geometry = collision_geometry(self.model, self.source)
        return self._geometry

    # Limits.

    def _per_joint(self, value: ArrayLike, what: str, unit: str) -> Array:
        return per_row(positive(value, f"{self!r}: {what}", unit=unit), self.nv, f"{self!r}: {what}", "joint")

    def _position_limit(self, given: tuple[ArrayLike, ArrayLike] | None) -> Array | None:
        """Lowest and highest positions of the joints that have one; None if none is limited."""
        limits = np.array([[-np.inf], [np.inf]]).repeat(self.nv, axis=1)
        if given is not None:
            return position_range(given, self.nv, f"{self!r}: position limit")
        for joint, place in zip(self._columns, self._places, strict=True):
            low, high = float(self.model.lowerPositionLimit[place]), float(self.model.upperPositionLimit[place])
            if not low < high:
                raise InvalidInput(
                    f"{self!r}: position limit of {self.joint_names[joint]} from {low:g} to {high:g};"
                    " the lowest must be below the highest"
                )
            limits[:, joint] = low if low > -LARGEST else -np.inf, high if high < LARGEST else np.inf
        return limits if np.isfinite(limits).any() else None

    def _own_limit(self, given: ArrayLike | None, model: Array, what: str, unit: str) -> Array | None:
        """The given limit or the model's; infinite, or none at all, where the model names none."""
        if given is not None:
            return self._per_joint(given, what, unit)
        own = np.array(model)
        own[(own <= 0.0) | (own > LARGEST)] = np.inf  # a model writes 0 where it knows nothing
        return own if np.isfinite(own).any() else None

    def _inside(self, q: Array) -> Array:
        """The same configuration with every joint inside its range."""
        q = np.array(q)
        if self.position_limit is not None:
            low, high = self.position_limit[:, self._columns]
            q[self._places] = np.clip(q[self._places], low, high)
        q.flags.writeable = False
        return q

    # The configuration.

    def integrate(self, q: Array, step: Array) -> Array:
        """The configuration after a step of the joints."""
        return np.asarray(pin.integrate(self.model, q, step))

    def difference(self, start: Array, end: Array) -> Array:
        """The step, shape (nv,), that leads from one configuration to another."""
        return np.asarray(pin.difference(self.model, start, end))

    def configuration(self, joints: Mapping[str, float]) -> Array:
        """The neutral configuration with these joints at these positions [rad], [m].

        Raises
        ------
        InvalidInput
            If a joint is unknown, or has more than one number.
        """
        q = np.array(self.neutral)
        columns = self._columns.tolist()
        for name, position in joints.items():
            column = joint_index(self.joint_names, name, "joint")
            if column not in columns:
                raise InvalidInput(f"joint {name!r} has no single position")
            q[self._places[columns.index(column)]] = position
        return q

    def describe(self, q: Array) -> list[tuple[str, float, float, float]]:
        """Name, position and range of every joint that has a single position; of one that turns without end, its angle.

        All in [rad] or [m]; the range is infinite where there is none.
        """
        told, low, high = [], *np.array([[-np.inf], [np.inf]]).repeat(self.nv, axis=1)
        if self.position_limit is not None:
            low, high = self.position_limit
        for joint in list(self.model.joints)[1:]:
            if joint.nv == 1:
                own, column = q[joint.idx_q : joint.idx_q + joint.nq], joint.idx_v
                position = own[0] if joint.nq == 1 else np.arctan2(own[1], own[0])
                told.append((self.joint_names[column], float(position), float(low[column]), float(high[column])))
        return told

    def random(self, rng: np.random.Generator) -> Array:
        """A configuration from the whole range of every joint; half a turn to either side where there is none."""
        low, high = np.full(self.nq, -1.0), np.full(self.nq, 1.0)
        if self.position_limit is None:
            ends = np.array([[-np.pi], [np.pi]]).repeat(len(self._columns), axis=1)
        else:
            ends = self.position_limit[:, self._columns]
            ends = np.where(np.isfinite(ends), ends, [[-np.pi], [np.pi]])
        low[self._places], high[self._places] = ends
        pin.seed(int(rng.integers(2**31)))
        return np.asarray(pin.randomConfiguration(self.model, low, high))

    def places(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """Where in q the positions of these velocities are, shape (k,); -1 for one that has none of its own."""
        places = np.full(self.nv, -1, dtype=np.int64)
        places[self._columns] = self._places
        return places[columns]

    def support(self, joint: int) -> list[int]:
        """The velocities that move what is carried by a joint of the model."""
        joints = [self.model.joints[i] for i in self.model.supports[joint]][1:]
        return [joint.idx_v + i for joint in joints for i in range(joint.nv)]

    # The state.

    def check_frame(self, name: str) -> str:
        """`name`, which must be a frame of this robot.

        Raises
        ------
        InvalidInput
            Tells the nearest names.
        """
        if name not in self.frame_names:
            raise InvalidInput(f"{name!r} is no frame of {self!r}{nearest(str(name), self.frame_names)}")
        return name

    def frame_index(self, name: str | None) -> int:
        """Pinocchio's number of a frame; of the tip, if no name is given."""
        found = self._frames.get(name)
        if found is None:
            if name is None and self.tip is None:
                raise InvalidInput(f"{self!r} has no tip; name a frame")
            found = self._frames[name] = int(self.model.getFrameId(self.check_frame(name or str(self.tip))))
        return found

    def at(self, q: ArrayLike, v: ArrayLike) -> PinocchioState:
        """Everything that tasks ask for at (q, v), each quantity computed when first asked for.

        Raises
        ------
        InvalidInput
            If q or v has not the numbers of this robot. NaN passes: the solver reports it.
        """
        position, velocity = own_numbers(q, "q"), own_numbers(v, "v")
        if position.shape != (self.nq,) or velocity.shape != (self.nv,):
            what, given, size = ("q", position, self.nq) if position.shape != (self.nq,) else ("v", velocity, self.nv)
            raise InvalidInput(f"{what} has shape {given.shape}; {self!r} takes ({size},)")
        return PinocchioState(self, position, velocity)

    def compute_center_of_mass(self, q: Array) -> None:
        """Have the data hold the centre of mass at q, and its Jacobian."""
        pin.jacobianCenterOfMass(self.model, self.data, q)
        self._state = None  # the rest of the data was overwritten

    def mass_matrix(self, q: ArrayLike) -> Array:
        """M(q) [kg m^2; kg m and kg where joints slide], symmetric, shape (..., nv, nv)."""
        q = np.asarray(q, dtype=np.float64)
        M = np.empty((*q.shape[:-1], self.nv, self.nv))
        for row, own in zip(q.reshape(-1, self.nq), M.reshape(-1, self.nv, self.nv), strict=True):
            upper = np.triu(pin.crba(self.model, self.data, row))  # all that the algorithm promises
            own[:] = upper + np.triu(upper, 1).T
        self._state = None  # the rest of the data was overwritten
        return M

    def bias(self, q: ArrayLike, v: ArrayLike) -> Array:
        """What torques [N m], forces [N] hold without acceleration: Coriolis, centripetal, gravity, shape (..., nv)."""
        q, v = (np.asarray(value, dtype=np.float64) for value in (q, v))
        rows = zip(q.reshape(-1, self.nq), v.reshape(-1, self.nv), strict=True)
        torques = [np.array(pin.nonLinearEffects(self.model, self.data, *row)) for row in rows]
        self._state = None
        return np.array(torques).reshape(v.shape)

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Joint torques [N m], forces [N] for accelerations a, gravity included, shape (..., nv)."""
        q, v, a = (np.asarray(value, dtype=np.float64) for value in (q, v, a))
        rows = [
            pin.rnea(self.model, self.data, *row)
            for row in zip(q.reshape(-1, self.nq), v.reshape(-1, self.nv), a.reshape(-1, self.nv), strict=True)
        ]
        self._state = None
        return np.array(rows).reshape(a.shape)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "data": None, "_state": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.data = self.model.createData()

    def __repr__(self) -> str:
        return f"PinocchioRobot({self.name!r}, {self.nv} degrees of freedom)"


def reduced(model: pin.Model, positions: Mapping[str, float | None], what: str) -> pin.Model:
    """The model with these joints held: at a position, or where neutral if that is None.

    Raises
    ------
    InvalidInput
        If a joint is unknown; tells the nearest names.
    """
    q, held = pin.neutral(model), []
    names = list(model.names)[1:]
    for name, position in positions.items():
        if name not in names:
            raise InvalidInput(f"{what}: {name!r} is no joint{nearest(str(name), names)}")
        index = int(model.getJointId(name))
        joint = model.joints[index]
        if position is not None:
            if joint.nq != 1:
                raise InvalidInput(f"{what}: {name!r} has {joint.nq} numbers; it can only be held at its neutral place")
            q[joint.idx_q] = finite_scalar(position, f"{what}: position of {name!r}")
        held.append(index)
    return pin.buildReducedModel(model, held, q) if held else model


def _joint_names(model: pin.Model) -> Iterable[str]:
    for joint, name in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):  # the first is the universe
        yield from [name] if joint.nv == 1 else (f"{name}[{i}]" for i in range(joint.nv))


def _joint_units(model: pin.Model) -> Iterable[str]:
    for joint in list(model.joints)[1:]:
        kind = joint.shortname().removeprefix("JointModel")
        lengths = {"FreeFlyer": 3, "Planar": 2, "Translation": 3}.get(kind, joint.nv if kind.startswith("P") else 0)
        yield from ["m" if i < lengths else "rad" for i in range(joint.nv)]


def _single_joints(model: pin.Model) -> tuple[Any, Any]:
    """Of the joints with one position and one velocity: which velocity, and which number of q."""
    single = [joint for joint in list(model.joints)[1:] if joint.nq == joint.nv == 1]
    return (
        np.array([joint.idx_v for joint in single], dtype=np.intp),
        np.array([joint.idx_q for joint in single], dtype=np.intp),
    )
