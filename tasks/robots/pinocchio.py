r"""Spatial robots, with their kinematics and dynamics by Pinocchio: arms, mobile bases, humanoids.

A configuration q lies on the manifold of the robot: a joint that turns without end is a point on a circle, a floating
base a position and a quaternion. Velocities v have nv <= nq numbers: those of a floating base are its linear and
angular velocity along its own axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput, MissingPackage
from hqp.checks import of_type
from hqp.guard import Guard

from ..base.checks import Array, finite, finite_scalar, nearest, own_numbers
from ..base.live import Live, number, structure
from .robot import joint_index

try:
    import pinocchio as pin
except ImportError as error:  # pragma: no cover
    raise MissingPackage("spatial robots need Pinocchio: pip install 'hqp[robots]'") from error

from . import pinocchio_dynamics as dynamics
from .axes import NONE, axes, base_of, sequence, unit_parts
from .chain import APART
from .files.ties import Room
from .files.xml import root_of
from .frame_names import frame_numbers
from .keeping import Kept, Recipe
from .kinematics import Kinematics
from .pinocchio_source import PinocchioSource
from .pinocchio_state import PinocchioState
from .ranges import SAME, both_ways, largest, no_faster, no_position, within
from .ranges import position_limit as limits_of
from .verification import tell_of_inertias, verify

#: How far a norm may be from 1: what is as good as 1, and what is round-off.
EXACT, ROUND_OFF = 1e-15, 1e-6
#: The unit of a limit for a joint that turns, and for one that slides.
SPEED = {"rad": "rad/s", "m": "m/s"}
ACCELERATION = {"rad": "rad/s^2", "m": "m/s^2"}
TORQUE = {"rad": "N m", "m": "N"}


#: A limit of all joints, or of those that are named.
Limit = ArrayLike | Mapping[str, float]
Range = tuple[ArrayLike, ArrayLike] | Mapping[str, tuple[float, float]]


class PinocchioRobot(Live):
    """A robot with a Pinocchio model. One robot serves one thread; copies share the model.

    Parameters
    ----------
    model : pinocchio.Model
    tip : str, optional
        The frame that tasks mean which name none.
    name : str, optional
        Default: the model's own.
    position_limit : pair of float or array, shape (nv,), or dict of name to pair, optional
        Lowest and highest joint positions [rad], [m] (default: the model's). Numbers count for all joints that have a
        position, arrays are infinite for the others; a dict changes the joints that it names. A joint whose ends are
        equal is held there.
    velocity_limit : float, array, shape (nv,), or dict of name to float, optional
        Largest joint speed [rad/s], [m/s] (default: the model's); 0 holds a joint.
    acceleration_limit : float, array, shape (nv,), or dict of name to float, optional
        Largest joint acceleration [rad/s^2], [m/s^2]; a model has none.
    torque_limit : float, array, shape (nv,), or dict of name to float, optional
        Largest joint torque [N m], force [N] (default: the model's).
    rooms : dict of str to Room, optional
        What those that follow a joint leave to it; its limits are no wider.

    Attributes
    ----------
    base : int
        How many velocities are those of a base that moves freely: 6, 3 in the plane, or 0.
    joint_names : tuple of str
        One a velocity; a joint of several has them numbered, as in ``"root_joint[0]"``.
    joint_units : tuple of str
        "rad" or "m", one a velocity.
    frame_names : tuple of str
        Links, sites, joints. Where two have one name it means the link; ``"joint:name"`` asks for the joint.
    neutral : array, shape (nq,)
        The configuration from which the model counts, moved into the position limits where it lies outside.
    home : array, shape (nq,)
        A configuration to start from: that of the library, one that the file names "home", or the neutral one.
    kinematics : Kinematics
        The workspace that its states share, and whose it is at the moment.
    left_out : tuple of str
        What its file has that is no part of it.
    recipe : Recipe or None
        How the ties of its model were made, for copies; see :mod:`tasks.robots.keeping`.
    source : pathlib.Path or None
        The file that it was loaded from, for its shapes; see :meth:`geometry`.

    Raises
    ------
    InvalidInput
        If there is no such frame, a limit is not positive, lowest above highest, or of a joint without position, or the
        model moves nothing or has names, axes or numbers that mean nothing; names the joint.
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
    home: Array
    _instead = "load or make another robot"

    def __init__(
        self,
        model: pin.Model,
        *,
        tip: str | None = None,
        name: str | None = None,
        position_limit: Range | None = None,
        velocity_limit: Limit | None = None,
        acceleration_limit: Limit | None = None,
        torque_limit: Limit | None = None,
        rooms: Mapping[str, Room] | None = None,
    ) -> None:
        self.model = of_type(model, pin.Model, "model")
        self.name = str(model.name) if name is None else of_type(name, str, "name of a robot")
        self.nq, self.nv = int(model.nq), int(model.nv)
        verify(model, repr(self))
        tell_of_inertias(model, repr(self))
        self.kinematics = Kinematics(model, repr(self))
        self._base, self.base = base_of(model)
        self._axes = axes(model)
        self.joint_names = tuple(axis.name for axis in self._axes)
        self.joint_units = tuple(axis.unit for axis in self._axes)
        self._units = unit_parts(model)
        self._frame_numbers = frame_numbers(model)
        self.frame_names = tuple(dict.fromkeys(frame.name for frame in model.frames))
        places = np.array([axis.place for axis in self._axes], dtype=np.intp)
        self._columns = np.flatnonzero(places != NONE)
        self._places = places[self._columns]
        self._frames: dict[str | None, int] = {}
        self._support: dict[int, list[tuple[int, int]]] = {}
        self.guard = Guard(f"the workspace of {self!r}")
        self._rooms: Mapping[str, Room] = rooms or {}
        self._loaded = rooms is not None
        self.position_limit, self.velocity_limit = position_limit, velocity_limit
        self.acceleration_limit, self.torque_limit = acceleration_limit, torque_limit
        self.tip = None if tip is None else self.check_frame(of_type(tip, str, "tip"))
        self.left_out: tuple[str, ...] = ()
        self.recipe: Recipe | None = None
        self.start_from(pin.neutral(model))
        self.source: Path | None = None
        self._geometry: pin.GeometryModel | None = None
        self._visuals: pin.GeometryModel | None = None

    @number
    def position_limit(self, value: Range | None) -> Array | None:
        """Lowest and highest joint positions [rad], [m], shape (2, nv); set to None, those of the model."""
        limits = limits_of(self.model, value, repr(self), zero_is_none=not self._loaded)
        return within(limits, self.joint_names, self._rooms, repr(self), told=value is not None)

    @number
    def velocity_limit(self, value: Limit | None) -> Array | None:
        """Largest joint speeds [rad/s], [m/s], shape (nv,); set to None, those of the model."""
        model, what = self.model, f"{self!r}: velocity limit"
        own = both_ways(model.lowerVelocityLimit, model.upperVelocityLimit, self.joint_names, what)
        return no_faster(largest(model, value, own, what, SPEED, zero_holds=True), self.joint_names, self._rooms)

    @number
    def acceleration_limit(self, value: Limit | None) -> Array | None:
        """Largest joint accelerations [rad/s^2], [m/s^2], shape (nv,), or None."""
        return largest(self.model, value, None, f"{self!r}: acceleration limit", ACCELERATION)

    @number
    def torque_limit(self, value: Limit | None) -> Array | None:
        """Largest joint torques [N m], [N], shape (nv,); set to None, those of the model."""
        model, what = self.model, f"{self!r}: torque limit"
        return largest(
            model,
            value,
            both_ways(model.lowerEffortLimit, model.upperEffortLimit, self.joint_names, what),
            what,
            TORQUE,
        )

    def _renew(self) -> None:
        self._neutral, self.home = self._inside(self._begun), self._inside(self.home)

    @property
    def neutral(self) -> Array:
        """The configuration from which the model counts, inside the position limits."""
        return self._neutral

    def start_from(self, neutral: Array) -> None:
        """Take this configuration as neutral, and as home unless the model names one."""
        self._begun, self._neutral = neutral, self._inside(neutral)
        self.home = self._named("home") if "home" in self.configurations else self._neutral

    def geometry(self) -> pin.GeometryModel:
        """The collision shapes of its file, read when first asked for; meshes become their convex hulls.

        Raises
        ------
        InvalidInput
            If there is no URDF file, or a mesh of it cannot be read.
        """
        if self._geometry is None:
            from .geometry import collision_geometry

            self._geometry = collision_geometry(self.model, self._urdf())
        return self._geometry

    def visuals(self) -> pin.GeometryModel:
        """What its file says it looks like, read when first asked for.

        Raises
        ------
        InvalidInput
            If there is no URDF file, or a mesh of it cannot be read.
        """
        if self._visuals is None:
            from .geometry import visual_geometry

            self._visuals = visual_geometry(self.model, self._urdf())
        return self._visuals

    def _urdf(self) -> Path:
        if self.source is None or root_of(self.source, repr(self)) != "robot":
            raise InvalidInput(f"{self!r} has no URDF file to read shapes from; use load_robot, or set its source")
        return self.source

    # The configuration.

    def integrate(self, q: Array, step: Array) -> Array:
        """The configuration after a step of the joints."""
        return np.asarray(pin.integrate(self.model, q, step))

    def difference(self, start: Array, end: Array) -> Array:
        """The step, shape (nv,), that leads from one configuration to another."""
        return np.asarray(pin.difference(self.model, start, end))

    def _inside(self, q: Array) -> Array:
        """The same configuration with every joint inside its range."""
        q = np.array(q)
        if self.position_limit is not None:
            low, high = self.position_limit[:, self._columns]
            q[self._places] = np.clip(q[self._places], low, high)
        q.flags.writeable = False
        return q

    @property
    def configurations(self) -> tuple[str, ...]:
        """The names of the configurations that the model has, such as the keyframes of an MJCF."""
        return tuple(str(entry.key()) for entry in self.model.referenceConfigurations)

    def _named(self, name: str) -> Array:
        return self._inside(np.array(self.model.referenceConfigurations[name]))

    def configuration(self, joints: str | Mapping[str, float]) -> Array:
        """A configuration that the model names, or the neutral one with these joints at these positions [rad], [m].

        Named ones are moved into the position limits where they lie outside.

        Raises
        ------
        InvalidInput
            If there is no such configuration or joint, or a joint has no single position or is put outside its range.
        """
        if isinstance(joints, str):
            if joints not in self.configurations:
                raise InvalidInput(f"{joints!r} is no configuration of {self!r}{nearest(joints, self.configurations)}")
            return np.array(self._named(joints))
        q = np.array(self.neutral)
        for name, position in of_type(joints, Mapping, "joints").items():
            column = joint_index(self.joint_names, name, "joint")
            axis, value = self._axes[column], finite_scalar(position, f"position of {name!r}")
            if axis.place != NONE:
                low, high = (-np.inf, np.inf) if self.position_limit is None else self.position_limit[:, column]
                if not low - SAME <= value <= high + SAME:
                    raise InvalidInput(
                        f"position of {name!r} = {value:g} {axis.unit} is outside its range, {low:g} .. {high:g}"
                    )
                q[axis.place] = value
            elif axis.circle != NONE:
                q[axis.circle : axis.circle + 2] = np.cos(value), np.sin(value)
            else:
                raise InvalidInput(f"joint {name!r}: {no_position(axis)}; write its numbers into q")
        return q

    def near(self, joints: Mapping[str, float]) -> Array:
        """The same as :meth:`configuration`, with positions outside the limits moved into them."""
        q = np.array(self.neutral)
        for name, position in joints.items():
            q[self._axes[self.joint_names.index(name)].place] = position
        return np.array(self._inside(q))

    def describe(self, q: Array) -> list[tuple[str, float, float, float]]:
        """Name, position and range of every joint that has a single position; of one that turns without end, its angle.

        All in [rad] or [m]; the range is infinite where there is none.
        """
        q = finite(q, "q")
        if q.shape != (self.nq,):
            raise InvalidInput(f"q has shape {q.shape}; {self!r} takes ({self.nq},)")
        told, low, high = [], *np.array([[-np.inf], [np.inf]]).repeat(self.nv, axis=1)
        if self.position_limit is not None:
            low, high = self.position_limit
        for column, axis in enumerate(self._axes):
            if axis.place != NONE or axis.circle != NONE:
                cosine, sine = q[axis.circle : axis.circle + 2] if axis.circle != NONE else (1.0, 0.0)
                position = q[axis.place] if axis.place != NONE else np.arctan2(sine, cosine)
                told.append((axis.name, float(position), float(low[column]), float(high[column])))
        return told

    def random(self, rng: np.random.Generator) -> Array:
        """A configuration from the whole range of every joint; half a turn to either side where there is none."""
        rng = of_type(rng, np.random.Generator, "rng")
        low, high = np.full(self.nq, -1.0), np.full(self.nq, 1.0)
        if self.position_limit is None:
            ends = np.array([[-np.pi], [np.pi]]).repeat(len(self._columns), axis=1)
        else:
            least, most = self.position_limit[:, self._columns]
            turn = 2.0 * np.pi  # of joints with one end, so much from it; of those with none, half to either side
            ends = np.array(
                [
                    np.maximum(least, np.minimum(most - turn, -np.pi)),
                    np.minimum(most, np.maximum(least + turn, np.pi)),
                ]
            )
        low[self._places], high[self._places] = ends
        pin.seed(int(rng.integers(2**31)))
        return np.asarray(pin.randomConfiguration(self.model, low, high))

    def on_base(self, base: Array, joints: Array) -> Array:
        """The configuration whose base stands as in the first one, and whose joints stand as in the second."""
        return np.concatenate([base[: self._base], joints[self._base :]])

    @property
    def data(self) -> pin.Data:
        """Pinocchio's data, which hold what was last computed."""
        return self.kinematics.data

    def positions(self, q: Array) -> Array:
        """The position of each joint that has one, 0 elsewhere, shape (nv,)."""
        if self.nq == self.nv:
            return q
        positions = np.zeros(self.nv)
        positions[self._columns] = q[self._places]
        return positions

    def places(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """Where in q the positions of these velocities are, shape (k,); -1 for one that has none of its own."""
        places = np.full(self.nv, -1, dtype=np.int64)
        places[self._columns] = self._places
        return places[columns]

    def circles(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """Where in q the cosines of these joints are, each before its sine, shape (k,); -1 for one on no circle."""
        return np.array([self._axes[i].circle for i in columns], dtype=np.int64)

    def support(self, joint: int) -> list[tuple[int, int]]:
        """What moves that which a joint of the model carries: columns of Pinocchio's Jacobian of the joints, and the
        velocity of each. A joint that follows another one has a column of its own, and the velocity of that one."""
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
        steps += [(joint, False) for joint in end if joint not in start]
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

    # The state.

    def has_frame(self, name: str) -> bool:
        """Whether this names a frame, plainly or by kind, as in ``"joint:gripper"``."""
        return name in self._frame_numbers

    def check_frame(self, name: str) -> str:
        """`name`, which must be a frame of this robot.

        Raises
        ------
        InvalidInput
            Tells the nearest names.
        """
        if not self.has_frame(name):
            raise InvalidInput(f"{name!r} is no frame of {self!r}{nearest(str(name), self.frame_names)}")
        return name

    def frame_index(self, name: str | None) -> int:
        """Pinocchio's number of a frame; of the tip, if no name is given."""
        found = self._frames.get(name)
        if found is None:
            if name is None and self.tip is None:
                raise InvalidInput(f"{self!r} has no tip; name a frame")
            found = self._frames[name] = self._frame_numbers[self.check_frame(name or str(self.tip))]
        return found

    def on_manifold(self, q: Array) -> tuple[Array, str | None]:
        """q with its circles and quaternions of norm 1, and what is wrong if one is farther from it than by round-off.

        A norm that is off by at most 1e-6 is taken as round-off. NaN passes: the solver reports it.
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

    def at(self, q: ArrayLike, v: ArrayLike) -> PinocchioState:
        """Everything that tasks ask for at (q, v), each quantity computed when first asked for.

        Raises
        ------
        InvalidInput
            If q or v has not the numbers of this robot, or a circle or quaternion of q has not norm 1 to 1e-6. NaN
            passes: the solver reports it.
        """
        state = self.state(q, v)
        if self._units:
            state.q, fault = self.on_manifold(state.q)
            if fault is not None:
                raise InvalidInput(fault)
        return state

    def state(self, q: ArrayLike, v: ArrayLike) -> PinocchioState:
        """The same as :meth:`at`, for a q whose circles and quaternions have been looked at.

        Raises
        ------
        InvalidInput
            If q or v has not the numbers of this robot.
        """
        position, velocity = own_numbers(q, "q"), own_numbers(v, "v")
        if position.shape != (self.nq,) or velocity.shape != (self.nv,):
            what, given, size = ("q", position, self.nq) if position.shape != (self.nq,) else ("v", velocity, self.nv)
            raise InvalidInput(f"{what} has shape {given.shape}; {self!r} takes ({size},)")
        return PinocchioState(self, position, velocity)

    def frame_source(self, q: Array, v: Array) -> PinocchioSource:
        """Its frames for loops; q and v hold the state of the tick."""
        return PinocchioSource(self, q, v)

    def compute_center_of_mass(self, q: Array) -> None:
        """Have the data hold the centre of mass at q, and its Jacobian."""
        self.kinematics.center_of_mass(q)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """M(q) [kg m^2; kg m and kg where joints slide], symmetric, shape (..., nv, nv)."""
        return dynamics.mass_matrix(self.model, self.kinematics.overwritten(), *dynamics.rows_of(self, q=q))

    def bias(self, q: ArrayLike, v: ArrayLike) -> Array:
        """What torques [N m], forces [N] hold without acceleration: Coriolis, centripetal, gravity, shape (..., nv)."""
        return dynamics.bias(self.model, self.kinematics.overwritten(), *dynamics.rows_of(self, q=q, v=v))

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Joint torques [N m], forces [N] for accelerations a, gravity included, shape (..., nv)."""
        return dynamics.inverse_dynamics(
            self.model, self.kinematics.overwritten(), *dynamics.rows_of(self, q=q, v=v, a=a)
        )

    def __getstate__(self) -> dict[str, Any]:
        own = dict(self.__dict__, model=Kept(self.model, self.recipe), kinematics=None, guard=None)
        return dict(own, _geometry=None, _visuals=None)

    def __setstate__(self, state: dict[str, Any]) -> None:
        own = vars(self)
        own.update(state, model=state["model"].model)
        own.update(kinematics=Kinematics(self.model, repr(self)), guard=Guard(f"the workspace of {self!r}"))

    def __repr__(self) -> str:
        return f"PinocchioRobot({self.name!r}, {self.nv} degrees of freedom)"
