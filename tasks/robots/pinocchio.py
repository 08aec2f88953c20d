r"""Spatial robots, with their kinematics and dynamics by Pinocchio: arms, mobile bases, humanoids.

A configuration q lies on the manifold of the robot: a joint that turns without end is a point on a circle, a floating
base a position and a quaternion. Velocities v have nv <= nq numbers: those of a floating base are its linear and
angular velocity along its own axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, MissingPackage
from hqp.checks import of_type
from hqp.guard import Guard

from ..base.checks import Array, finite, finite_scalar, own_numbers, suggestion
from ..base.live import number
from ..base.telling import tell
from .follower_limits import FollowerLimits
from .refusals import joint_index

try:
    import pinocchio as pin
except ImportError as error:  # pragma: no cover
    raise MissingPackage("spatial robots need Pinocchio: pip install 'hqp[robots]'") from error

from .configurations import Configurations
from .frame_addition import Framed
from .joint_axes import NONE
from .keeping import Kept
from .kinematics import Kinematics
from .pinocchio_source import PinocchioSource
from .pinocchio_state import PinocchioState
from .ranges import SAME, both_ways, held_at_zero, largest, no_faster, no_position, within, without_motors
from .ranges import position_limit as limits_of
from .semantics import Semantic
from .shapes import Shaped

#: The unit of a limit for a joint that turns, and for one that slides.
SPEED = {"rad": "rad/s", "m": "m/s"}
ACCELERATION = {"rad": "rad/s^2", "m": "m/s^2"}
TORQUE = {"rad": "N m", "m": "N"}


#: A limit of all joints, or of those that are named.
Limit = ArrayLike | Mapping[str, float]
Range = tuple[ArrayLike, ArrayLike] | Mapping[str, tuple[float, float]]


class PinocchioRobot(Configurations, Semantic, Shaped, Framed):
    """A robot with a Pinocchio model. One robot serves one thread; copies share the model.

    Parameters
    ----------
    model : pinocchio.Model
    tip : str, optional
        The frame used by tasks that name no frame.
    name : str, optional
    position_limit : pair of float or array, shape (nv,), or dict of name to pair, optional
        Lowest and highest joint positions [rad], [m] (default: the model's). A number holds for all joints that have a
        position, an array must be infinite for the others; a dict changes the joints that it names. A joint with equal
        limits is held there.
    velocity_limit : float, array, shape (nv,), or dict of name to float, optional
        Largest joint speed [rad/s], [m/s] (default: the model's); 0 holds a joint.
    acceleration_limit : float, array, shape (nv,), or dict of name to float, optional
        Largest joint acceleration [rad/s^2], [m/s^2]; a model has none.
    torque_limit : float, array, shape (nv,), or dict of name to float, optional
        Largest joint torque [N m], force [N] (default: the model's); 0 of a joint without a motor.
    follower_limits : dict of str to FollowerLimits, optional
        Limits of a joint that come from its followers; its own limits are no wider.

    Attributes
    ----------
    base : int
        Number of velocities of a free base: 6, 3 in the plane, or 0.
    joint_names : tuple of str
        One per velocity; those of a joint with several are numbered, as in ``"root_joint[0]"``.
    joint_units : tuple of str
        "rad" or "m", one per velocity.
    frame_names : tuple of str
        Links, sites, joints. A name shared by several means the link; ``"joint:name"`` means the joint.
    neutral : array, shape (nq,)
        The zero configuration of the model, moved into the position limits if it lies outside.
    home : array, shape (nq,)
        A configuration to start from: that of the library, one that the file names "home", or the neutral one.
    kinematics : Kinematics
        The workspace that its states share, and the state whose numbers it holds now.
    left_out : tuple of str
        Parts of its file that are not part of the robot.
    closures : tuple of Closure
        Frames that its file holds together, for :meth:`tasks.Loop.of`.
    springs : dict of str to (float, float)
        Springs of its joints, of an MJCF: stiffness [N m/rad], [N/m], and position without force [rad], [m].
    recipe : Recipe or None
        How the mimic joints of its model were made, for copies; see :mod:`tasks.robots.keeping`.
    source : pathlib.Path or None
        The file that it was loaded from, for its shapes; see :meth:`geometry`.
    scene : mujoco.MjModel or None
        The model that MuJoCo compiled.

    Raises
    ------
    InvalidInput
        If there is no such frame; a limit is not positive, has its lowest above its highest, or is for a joint without
        position; or the model has no joints, or invalid names, axes or numbers. The message names the joint.

    Examples
    --------
    >>> import pinocchio as pin
    >>> from tasks import PinocchioRobot
    >>> sample = PinocchioRobot(pin.buildSampleModelManipulator(), tip="effector_body")
    >>> sample.nq, sample.nv
    (6, 6)
    """

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
        follower_limits: Mapping[str, FollowerLimits] | None = None,
    ) -> None:
        super().__init__(model, tip, name)
        self._follower_limits: Mapping[str, FollowerLimits] = follower_limits or {}
        self._loaded = follower_limits is not None
        self.position_limit, self.velocity_limit = position_limit, velocity_limit
        self.acceleration_limit, self.torque_limit = acceleration_limit, torque_limit
        self.left_out: tuple[str, ...] = ()
        self.recipe = None
        self.start_from(pin.neutral(model))
        self.source: Path | None = None
        self.scene: Any = None

    @number
    def position_limit(self, value: Range | None) -> Array | None:
        """Lowest and highest joint positions [rad], [m], shape (2, nv); set to None, those of the model."""
        limits = limits_of(self.model, value, repr(self), zero_is_none=not self._loaded)
        return within(limits, self.joint_names, self._follower_limits, repr(self), told=value is not None)

    @number
    def velocity_limit(self, value: Limit | None) -> Array | None:
        """Largest joint speeds [rad/s], [m/s], shape (nv,); set to None, those of the model."""
        model, what = self.model, f"{self!r}: velocity limit"
        own = both_ways(model.lowerVelocityLimit, model.upperVelocityLimit, self.joint_names, what)
        return no_faster(
            largest(model, value, own, what, SPEED, zero_holds=True), self.joint_names, self._follower_limits
        )

    @number
    def acceleration_limit(self, value: Limit | None) -> Array | None:
        """Largest joint accelerations [rad/s^2], [m/s^2], shape (nv,), or None."""
        return largest(self.model, value, None, f"{self!r}: acceleration limit", ACCELERATION)

    @number
    def torque_limit(self, value: Limit | None) -> Array | None:
        """Largest joint torques [N m], [N], shape (nv,), 0 where there is no motor; set to None, those of the model."""
        model, what = self.model, f"{self!r}: torque limit"
        own = both_ways(model.lowerEffortLimit, model.upperEffortLimit, self.joint_names, what)
        limits = largest(model, value, without_motors(model, own, what), what, TORQUE, zero_holds=True)
        one = value is not None and not isinstance(value, Mapping) and np.ndim(value) == 0  # for all that have a motor
        return held_at_zero(without_motors(model, limits, what) if one else limits)

    @number
    def home(self, value: ArrayLike) -> Array:
        """A configuration to start from, shape (nq,), moved into the position limits."""
        q = finite(value, f"{self!r}: home")
        if q.shape != (self.nq,):
            raise InvalidInput(f"{self!r}: home has shape {q.shape}; it must be ({self.nq},)")
        self._home = q  # as it was given: wider limits bring it back
        return self._inside(q)

    def _renew(self) -> None:
        self._neutral, self.home = self._inside(self._begun), self._home

    @property
    def neutral(self) -> Array:
        """The zero configuration of the model, moved into the position limits."""
        return self._neutral

    def start_from(self, neutral: Array) -> None:
        """Take this configuration as neutral, and as home unless the model names one."""
        self._begun, self._neutral = neutral, self._inside(neutral)
        self.home = self._named("home") if "home" in self.configurations else self._neutral

    # The configuration.

    def _inside(self, q: Array) -> Array:
        """A configuration with every joint moved into its range."""
        q = np.array(q)
        if self.position_limit is not None:
            low, high = self.position_limit[:, self._columns]
            q[self._q_indices] = np.clip(q[self._q_indices], low, high)
        q.flags.writeable = False
        return q

    def _named(self, name: str) -> Array:
        if name in self._states:
            q = self._put(self.neutral, self._states[name], name)
        else:
            q = np.array(self.model.referenceConfigurations[name])
        inside = self._inside(q)
        moved = [self.joint_names[i] for i in self._columns[np.abs(inside - q)[self._q_indices] > SAME]]
        if moved:
            tell(f"{self!r}: configuration {name!r} is outside the ranges, and is moved into them: {', '.join(moved)}")
        return inside

    def configuration(self, joints: str | Mapping[str, float]) -> Array:
        """A named configuration, or the neutral one with these joints at these positions [rad], [m].

        :attr:`configurations` lists the names. Named configurations outside the position limits are moved into them.

        Raises
        ------
        InvalidInput
            If there is no such configuration or joint, or a joint has no single position or is put outside its range.
        """
        if isinstance(joints, str):
            if joints not in self.configurations:
                raise InvalidInput(
                    f"{joints!r} is no configuration of {self!r}{suggestion(joints, self.configurations)}"
                )
            return np.array(self._named(joints))
        q = np.array(self.neutral)
        for name, position in of_type(joints, Mapping, "joints").items():
            column = joint_index(self.joint_names, name, "joint")
            axis, value = self._axes[column], finite_scalar(position, f"position of {name!r}")
            if axis.q_index != NONE:
                low, high = (-np.inf, np.inf) if self.position_limit is None else self.position_limit[:, column]
                if not low - SAME <= value <= high + SAME:
                    raise InvalidInput(
                        f"position of {name!r} = {value:g} {axis.unit} is outside its range, {low:g} .. {high:g}"
                    )
                q[axis.q_index] = value
            elif axis.circle != NONE:
                q[axis.circle : axis.circle + 2] = np.cos(value), np.sin(value)
            else:
                raise InvalidInput(f"joint {name!r}: {no_position(axis)}; write its numbers into q")
        return q

    def near(self, joints: Mapping[str, float]) -> Array:
        """A configuration as of :meth:`configuration`, with positions outside the limits moved into them."""
        q = np.array(self.neutral)
        for name, position in joints.items():
            q[self._axes[self.joint_names.index(name)].q_index] = position
        return np.array(self._inside(q))

    def describe(self, q: Array) -> list[tuple[str, float, float, float]]:
        """Name, position and range of every joint with a single position; for a continuous joint, its angle.

        All in [rad] or [m]; the range is infinite if there is none.
        """
        q = finite(q, "q")
        if q.shape != (self.nq,):
            raise InvalidInput(f"q has shape {q.shape}; {self!r} takes ({self.nq},)")
        told, low, high = [], *np.array([[-np.inf], [np.inf]]).repeat(self.nv, axis=1)
        if self.position_limit is not None:
            low, high = self.position_limit
        for column, axis in enumerate(self._axes):
            if axis.q_index != NONE or axis.circle != NONE:
                cosine, sine = q[axis.circle : axis.circle + 2] if axis.circle != NONE else (1.0, 0.0)
                position = q[axis.q_index] if axis.q_index != NONE else np.arctan2(sine, cosine)
                told.append((axis.name, float(position), float(low[column]), float(high[column])))
        return told

    def random(self, rng: np.random.Generator) -> Array:
        """A random configuration in the range of every joint; within half a turn to either side if it has no range."""
        rng = of_type(rng, np.random.Generator, "rng")
        low, high = np.full(self.nq, -1.0), np.full(self.nq, 1.0)
        if self.position_limit is None:
            ends = np.array([[-np.pi], [np.pi]]).repeat(len(self._columns), axis=1)
        else:
            least, most = self.position_limit[:, self._columns]
            turn = 2.0 * np.pi  # range of a joint with one limit, from it; with none, half to either side
            ends = np.array(
                [
                    np.maximum(least, np.minimum(most - turn, -np.pi)),
                    np.minimum(most, np.maximum(least + turn, np.pi)),
                ]
            )
        low[self._q_indices], high[self._q_indices] = ends
        pin.seed(int(rng.integers(2**31)))
        return np.asarray(pin.randomConfiguration(self.model, low, high))

    def on_base(self, base: Array, joints: Array) -> Array:
        """The configuration with the base of the first one and the joints of the second."""
        return np.concatenate([base[: self._base], joints[self._base :]])

    # The state.

    def at(self, q: ArrayLike, v: ArrayLike | None = None) -> PinocchioState:
        """Everything that tasks ask for at (q, v), each quantity computed when asked for; without v: at rest.

        Raises
        ------
        InvalidInput
            If q or v has a wrong size, or a circle or quaternion of q does not have norm 1 to 1e-6. NaN is accepted:
            the solver reports it.
        """
        state = self.state(q, np.zeros(self.nv) if v is None else v)
        if self._units:
            state.q, fault = self.on_manifold(state.q)
            if fault is not None:
                raise InvalidInput(fault)
        return state

    def state(self, q: ArrayLike, v: ArrayLike) -> PinocchioState:
        """The same state as :meth:`at`, for a q whose circles and quaternions have been checked.

        Raises
        ------
        InvalidInput
            If q or v has a wrong size for this robot.
        """
        position, velocity = own_numbers(q, "q"), own_numbers(v, "v")
        if position.shape != (self.nq,) or velocity.shape != (self.nv,):
            what, given, size = ("q", position, self.nq) if position.shape != (self.nq,) else ("v", velocity, self.nv)
            raise InvalidInput(f"{what} has shape {given.shape}; {self!r} takes ({size},)")
        return PinocchioState(self, position, velocity)

    def frame_source(self, q: Array, v: Array) -> PinocchioSource:
        """Its frames for loops; q and v hold the state of the tick."""
        return PinocchioSource(self, q, v)

    def __getstate__(self) -> dict[str, Any]:
        own = dict(self.__dict__, model=Kept(self.model, self.recipe), kinematics=None, guard=None)
        return dict(own, _geometry=self._geometry if self._geometry_is_given else None, _visuals=None)

    def __setstate__(self, state: dict[str, Any]) -> None:
        own = vars(self)
        own.update(state, model=state["model"].model)
        own.update(kinematics=Kinematics(self.model, repr(self)), guard=Guard(f"the workspace of {self!r}"))
