r"""An arm of any number of revolute links in the plane (Fig. 4.1 of the thesis).

With the angle of link i against the x axis :math:`\alpha_i = q_1 + \dots + q_i`,

.. math::

    x = \sum_i l_i \cos\alpha_i, \qquad y = \sum_i l_i \sin\alpha_i, \qquad \varphi = \alpha_n,

where :math:`\varphi` is the plain, *unwrapped* sum of the joint angles (Eq. 4.3): a full turn is 2 pi,
not 0. Positive angles turn counter-clockwise; the base frame has its origin in the first joint.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.checks import Array, numbers, own_numbers, per_joint, per_row, position_range, positive
from ..base.live import Live, number, structure
from . import planar_dynamics as dynamics
from .block import told_by
from .chain import APART
from .configurations import Configurations
from .frame import FixedFrame
from .kernels import block as at
from .manipulability import manipulability
from .planar_source import PlanarSource, block_of
from .transforms import Transforms

#: Default mass per length of a link [kg/m].
DENSITY = 1.0
#: The frame at the end of the last link.
TIP = "tip"
#: x, y and the turn about z among three linear and three angular coordinates.
PLANE = [0, 1, 5]
#: Where x, y and the angle are in a block.
POSE = np.array([at.POSITION, at.POSITION + 1, at.ANGLE])


class PlanarState(Transforms):
    """A planar arm at one instant, each quantity computed when first asked for; see :class:`tasks.RobotState`.

    Attributes
    ----------
    robot : PlanarArm
    q, v : array, shape (n,)
        Joint angles [rad] and velocities [rad/s].
    points : array, shape (n + 1, 2)
        Base, joints and tip [m].
    pose : array, shape (3,)
        (x [m], y [m], phi [rad]).
    jacobian : array, shape (3, n)
        Rows x, y [m/rad] and phi [1].
    twist, drift : array, shape (3,)
        ``J v`` [m/s, m/s, rad/s] and ``Jdot v`` [m/s^2, m/s^2, rad/s^2].
    """

    def __init__(self, robot: PlanarArm, q: Array, v: Array) -> None:
        self.robot, self.q, self.v = robot, q, v
        self._block: Array | None = None

    @cached_property
    def points(self) -> Array:
        return self.robot.points(self.q)

    @property
    def _tip(self) -> Array:
        if self._block is None:
            self._block = block_of(self.robot, self.q, self.v, None)
        return self._block

    @property
    def pose(self) -> Array:
        pose: Array = self._tip[POSE]
        return pose

    @property
    def jacobian(self) -> Array:
        return self._tip[at.JACOBIAN :].reshape(6, -1)[PLANE]

    @property
    def twist(self) -> Array:
        return self._tip[at.LINEAR_VELOCITY : at.LINEAR_VELOCITY + 6][PLANE]

    @property
    def drift(self) -> Array:
        return self._tip[at.LINEAR_DRIFT : at.LINEAR_DRIFT + 6][PLANE]

    def frame(self, name: str | None = None) -> FixedFrame:
        """The tip, or ``"link1"``, ``"link2"``, ...: the end of that link, counted from the base.

        Raises
        ------
        InvalidInput
            If there is no such frame.
        """
        return told_by(self._tip if name is None else block_of(self.robot, self.q, self.v, name))


class PlanarArm(Configurations, Live):
    """A chain of links in the plane, each turning about the end of the one before.

    Methods of q, v and a take leading axes: a whole record at once, of shape (..., n).

    Parameters
    ----------
    lengths : array, shape (n,)
        Link lengths [m], at least one.
    masses : array, shape (n,), optional
        Link masses [kg], each spread evenly along its link (default: 1 kg per metre).
    position_limit : pair of float or array, shape (n,), optional
        Lowest and highest joint angles [rad], used by limits without numbers; infinite if a joint
        turns freely.
    velocity_limit : float or array, shape (n,), optional
        Largest joint speed [rad/s]; 0 holds a joint.
    acceleration_limit : float or array, shape (n,), optional
        Largest joint acceleration [rad/s^2].
    torque_limit : float or array, shape (n,), optional
        Largest joint torque [N m]; 0 of a joint without a motor.
    name : str

    Raises
    ------
    InvalidInput
        If there is no link, a length, mass or limit is not positive or larger than 1e15, or a lowest
        joint angle is not below the highest.

    Examples
    --------
    >>> from tasks import PlanarArm
    >>> arm = PlanarArm([0.5, 0.5, 0.5], masses=[1.0, 1.0, 1.0], velocity_limit=2.0)
    >>> arm.pose([0.0, 0.0, 0.0])  # x, y [m] and angle [rad] of the tip
    array([1.5, 0. , 0. ])
    >>> arm.nq, arm.nv
    (3, 3)
    """

    lengths: Array = structure()
    masses: Array = structure()
    nq: int = structure()
    nv: int = structure()
    name: str = structure()
    _instead = "make another arm"

    def __init__(
        self,
        lengths: ArrayLike,
        *,
        masses: ArrayLike | None = None,
        position_limit: tuple[ArrayLike, ArrayLike] | None = None,
        velocity_limit: ArrayLike | None = None,
        acceleration_limit: ArrayLike | None = None,
        torque_limit: ArrayLike | None = None,
        name: str = "",
    ) -> None:
        given = numbers(lengths, "link lengths")
        if given.ndim != 1 or not given.size:
            raise InvalidInput(
                f"link lengths have shape {given.shape}; give one positive length [m] a link, at least one"
            )
        for link, length in enumerate(given):
            positive(length, f"link {link}: length", unit="m")
        self.lengths = given
        self.nq = self.nv = len(given)
        self.name = of_type(name, str, "name of an arm")
        self.masses = DENSITY * given if masses is None else self._per_link(masses, "mass", "kg")
        self._H = dynamics.inertia_constants(self.lengths, self.masses)
        self.position_limit, self.velocity_limit = position_limit, velocity_limit
        self.acceleration_limit, self.torque_limit = acceleration_limit, torque_limit

    @number
    def position_limit(self, value: tuple[ArrayLike, ArrayLike] | None) -> Array | None:
        """Lowest and highest joint angles [rad], shape (2, n), or None."""
        return None if value is None else position_range(value, self.nv, f"{self!r}: position limit")

    @number
    def velocity_limit(self, value: ArrayLike | None) -> Array | None:
        """Largest joint speeds [rad/s], shape (n,), or None; 0 holds a joint."""
        label = f"{self!r}: velocity limit"
        return None if value is None else per_joint(value, self.nv, label, unit="rad/s", zero_holds=True)

    @number
    def acceleration_limit(self, value: ArrayLike | None) -> Array | None:
        """Largest joint accelerations [rad/s^2], shape (n,), or None."""
        return None if value is None else per_joint(value, self.nv, f"{self!r}: acceleration limit", unit="rad/s^2")

    @number
    def torque_limit(self, value: ArrayLike | None) -> Array | None:
        """Largest joint torques [N m], shape (n,), 0 of a joint without a motor; or None."""
        return (
            None if value is None else per_joint(value, self.nv, f"{self!r}: torque limit", unit="N m", zero_holds=True)
        )

    @property
    def frame_names(self) -> tuple[str, ...]:
        """``"tip"``, and ``"link1"``, ...: the ends of the links."""
        return (TIP, *_link_names(self.nv))

    def _per_link(self, value: ArrayLike, what: str, unit: str) -> Array:
        return per_row(positive(value, f"{self!r}: {what}", unit=unit), self.nv, f"{self!r}: {what}", "link")

    def points(self, q: ArrayLike) -> Array:
        """Base, joints and tip [m], shape (..., n + 1, 2)."""
        return self._points(*self._joints(q=q))[1]

    def pose(self, q: ArrayLike) -> Array:
        """Tip position and orientation (x [m], y [m], phi [rad]), shape (..., 3); phi is unwrapped."""
        angles, points = self._points(*self._joints(q=q))
        return np.concatenate([points[..., -1, :], angles[..., -1:]], axis=-1)

    def jacobian(self, q: ArrayLike) -> Array:
        """Rows x, y, phi of ``d pose / dq``, shape (..., 3, n)."""
        return _jacobian(self._points(*self._joints(q=q))[1])

    def jacobian_dot(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Time derivative of the Jacobian while the joints turn at v [rad/s], shape (..., 3, n)."""
        q, v = self._joints(q=q, v=v)
        angles, _ = self._points(q)
        rates = self.lengths * np.cumsum(v, axis=-1)
        Jdot = _jacobian(_chain(-rates * np.sin(angles), rates * np.cos(angles)))
        Jdot[..., 2, :] = 0.0
        return Jdot

    def manipulability(self, q: ArrayLike) -> Array:
        """How well the tip can be moved in the plane: ``sqrt(det(J J^T))`` of the rows x and y [m^2], shape (...).

        It is ``l1 l2 |sin q2|`` for two links (Eq. 2.2), and 0 for one: its tip cannot leave a circle.
        """
        return manipulability(self.jacobian(q)[..., :2, :])

    def mass_matrix(self, q: ArrayLike) -> Array:
        """M(q) of Eq. 4.1 [kg m^2], shape (..., n, n)."""
        return dynamics.mass_matrix(self._H, *self._joints(q=q))

    def coriolis(self, q: ArrayLike, v: ArrayLike) -> Array:
        """C(q, v) of Eq. 4.1 [kg m^2/s], shape (..., n, n): ``C v`` is the Coriolis and centripetal torque."""
        return dynamics.coriolis(self._H, *self._joints(q=q, v=v))

    def bias(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Joint torques ``C(q, v) v`` [N m] at zero acceleration, without gravity, shape (..., n)."""
        q, v = self._joints(q=q, v=v)
        return dynamics.inverse_dynamics(self._H, q, v, np.zeros_like(v))

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Joint torques ``M(q) a + C(q, v) v`` [N m] (Eq. 4.1) for accelerations a [rad/s^2], shape (..., n)."""
        return dynamics.inverse_dynamics(self._H, *self._joints(q=q, v=v, a=a))

    def kinetic_energy(self, q: ArrayLike, v: ArrayLike) -> Array:
        """The kinetic energy of all links [J], shape (...)."""
        return dynamics.kinetic_energy(self._H, *self._joints(q=q, v=v))

    def at(self, q: ArrayLike, v: ArrayLike | None = None) -> PlanarState:
        """Everything that tasks ask for at (q, v), each quantity computed once; v left out is a state of rest.

        Raises
        ------
        InvalidInput
            If q [rad] or v [rad/s] does not have one number per joint. NaN is accepted: the solver reports it.
        """
        return PlanarState(self, *self._joints(single=True, q=q, v=np.zeros(self.nv) if v is None else v))

    def links_to(self, frame: str | None) -> int:
        """The number of links from the base to a frame, by default the tip.

        Raises
        ------
        InvalidInput
            If there is no such frame.
        """
        if frame is None or frame == TIP:
            return self.nv
        links = _link_names(self.nv)
        if frame not in links:
            raise InvalidInput(f"{frame!r} is no frame of this arm; there are {TIP}, {', '.join(links)}")
        return links.index(frame) + 1

    def frame_source(self, q: Array, v: Array) -> PlanarSource:
        """Its frames for loops; q and v hold the state of the tick."""
        return PlanarSource(self, q, v)

    def position_indices(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """Where in q the positions of these velocities are."""
        return np.asarray(columns, dtype=np.int64)

    def circles(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """Where in q the cosines of these joints are: none has one."""
        return np.full(len(columns), -1)

    def chain_order(self, frame: str | None, relative_to: str | None = None) -> NDArray[np.int64] | None:
        """The place of every joint in the chain to a frame; see :func:`tasks.robots.chain.chain_order`."""
        places = np.arange(self.nv)
        if frame is not None and frame != TIP:
            places[self.links_to(frame) :] = APART
        return places if relative_to is None else None

    def _points(self, q: Array) -> tuple[Array, Array]:
        """Angles of the links against the x axis, shape (..., n), and the points between them."""
        with np.errstate(all="ignore"):  # infinities become NaN, which the solver reports
            angles = q.cumsum(axis=-1)
            return angles, _chain(self.lengths * np.cos(angles), self.lengths * np.sin(angles))

    def _joints(self, *, single: bool = False, **values: ArrayLike) -> list[Array]:
        """Arrays of one number a joint, all of the shape of the first."""
        joints: list[Array] = []
        for what, value in values.items():
            array = own_numbers(value, what)
            if array.shape[-1:] != (self.nv,) or (single and array.ndim > 1):
                allowed = f"({'' if single else '..., '}{self.nv}{',' if single else ''})"
                raise InvalidInput(f"{what} has shape {array.shape}; {self!r} takes {allowed}, one number a joint")
            if joints and array.shape != joints[0].shape:
                first = next(iter(values))
                raise InvalidInput(f"{what} has shape {array.shape}; it must be that of {first}, {joints[0].shape}")
            joints.append(array)
        return joints

    def __repr__(self) -> str:
        label = f", name={self.name!r}" if self.name else ""
        return f"PlanarArm({self.lengths.tolist()}{label})"


def _link_names(count: int) -> list[str]:
    return [f"link{i + 1}" for i in range(count)]


def _chain(dx: Array, dy: Array) -> Array:
    """Sums of the links from the base on, shape (..., n + 1, 2)."""
    points = np.zeros((*dx.shape[:-1], dx.shape[-1] + 1, 2))
    dx.cumsum(axis=-1, out=points[..., 1:, 0])
    dy.cumsum(axis=-1, out=points[..., 1:, 1])
    return points


def _jacobian(points: Array) -> Array:
    """Columns ``(z x (tip - joint), 1)``: how the pose of the tip moves when one joint turns, shape (..., 3, n)."""
    arms = points[..., -1:, :] - points[..., :-1, :]
    J = np.ones((*arms.shape[:-2], 3, arms.shape[-2]))
    J[..., 0, :] = -arms[..., 1]
    J[..., 1, :] = arms[..., 0]
    return J
