r"""A plant that is moved by the physics of MuJoCo instead of the model of the controller.

The robot is converted joint by joint: placements, axes, masses, inertias, armatures and viscous damping of its
Pinocchio model. Joints that the model holds, such as locked fingers, become part of the links that carry them. Links do
not collide; only the points of contacts touch the ground. Joints have no ranges and no dry friction. Closed chains of
the robot's file are closed. In free space, without them, the motion is

.. math:: M(q)\,\dot v + b(q, v) + D\,v = \tau.

The model of the controller is the same without the damping D: feedback has to compensate it, as on a real robot. An
armature A of a floating base, which only an MJCF can have, MuJoCo adds along the axes of the world, and Pinocchio along
those of the base: there they differ by :math:`A\,\omega \times v`, too.

States are handed over as :mod:`.places` says.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple
from warnings import warn

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, MissingPackage
from hqp.checks import listed, of_type
from hqp.errors import brief

from ..base.checks import Array, finite, finite_scalar, positive_scalar
from ..base.live import Live, number, structure
from ..contacts.contact import Contact
from ..contacts.loop import Loop
from ..robots.robot import Robot, base, check_frame, check_joints, on_pinocchio
from .closing import close, loop_forces, loops_of
from .ground import Ground
from .motion import check_names, check_still, told
from .mujoco_model import body_name, free, joints, known, point_name, specification_of
from .places import StatePlaces

if TYPE_CHECKING:
    import mujoco


#: How far a surface may be turned from level, as 1 less the cosine.
LEVEL = 1e-6
#: A push that covers no more than this share of a step does so by round-off of the clock.
NEGLIGIBLE = 1e-6


class Push(NamedTuple):
    """A force in the axes of the world [N], at a point of a body, from one time to another [s]."""

    body: int
    point: Array
    force: Array
    start: float
    end: float


class MujocoPlant(Live):
    """A robot in MuJoCo, moved by joint torques: ``simulate(controller, q0, duration=1.0, plant=MujocoPlant(robot))``.

    Parameters
    ----------
    robot : PinocchioRobot
        With a fixed or floating base, and joints that turn about one axis, slide along one, or are balls.
    contacts : list of Contact
        Contacts whose points touch the ground; their surfaces must be level.
    ground : Ground, optional
        Its height, its friction, and how contacts are modelled.
    loops : list of Loop, optional
        Closed chains (default: those in the file of the robot, :meth:`tasks.Loop.of`).
    step : float
        The longest step of the physics [s]; a tick of the controller is divided into equal steps.

    Attributes
    ----------
    model, data : mujoco.MjModel, mujoco.MjData
    dofs : array of int
        Places of the joints with a motor among MuJoCo's velocities.

    Raises
    ------
    InvalidInput
        If the robot is not of that kind, a contact or loop does not belong to it, a surface moves or is not level, a
        loop does not say which orientation it holds, or MuJoCo refuses the robot, as for impossible inertias.
    MissingPackage
        If MuJoCo is not installed.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    contacts: tuple[Contact, ...] = structure()
    loops: tuple[Loop, ...] = structure()
    ground: Ground = structure()

    @number
    def step(self, value: float) -> float:
        """The longest step of the physics [s]."""
        return positive_scalar(value, "step", unit="s")

    def __init__(
        self,
        robot: Robot,
        *,
        contacts: Iterable[Contact] = (),
        ground: Ground | None = None,
        loops: Iterable[Loop] | None = None,
        step: float = 5e-4,
    ) -> None:
        try:
            import mujoco
        except ImportError:
            raise MissingPackage("physics need MuJoCo: pip install 'hqp[mujoco]'") from None
        self._mujoco: Any = mujoco
        self.step = step
        self.ground = Ground() if ground is None else of_type(ground, Ground, "ground")
        self.contacts = tuple(
            of_type(contact, Contact, "a contact") for contact in listed(contacts, "contacts", "Contact")
        )
        self._robot = _checked(robot, self.contacts)
        self.loops = loops_of(robot, loops, "MujocoPlant")
        check_names(self.contacts, self.loops)
        specification = specification_of(self._robot, mujoco, self.contacts)
        close(specification, self.loops, self._robot, self.step, mujoco)
        if self.contacts:
            self.ground.check_step(self.step)
            self.ground.lay(specification, mujoco)
        try:
            self.model = specification.compile()
        except ValueError as error:
            raise InvalidInput(f"MujocoPlant: MuJoCo refuses {robot!r}: {error}") from None
        self.data = mujoco.MjData(self.model)
        self._base = base(robot)
        self._places = StatePlaces(self._robot, self.model)
        self.dofs = self._places.dofs
        names = [[point_name(contact, k) for k in range(len(contact.shape.points))] for contact in self.contacts]
        self._points = [np.array([self.model.geom(name).id for name in each], dtype=np.intp) for each in names]
        self._laid = not self.contacts or self.ground.height is not None
        self._pushes: list[Push] = []

    def _renew(self) -> None:
        if self.contacts:
            self.ground.check_step(self.step)

    def __getstate__(self) -> dict[str, Any]:
        """All but the module of MuJoCo: a copy goes on from the same state, by itself."""
        return {name: value for name, value in vars(self).items() if name != "_mujoco"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        import mujoco

        vars(self).update(state, _mujoco=mujoco)

    @property
    def time(self) -> float:
        """The clock of the plant: for how long it has moved [s]."""
        return float(self.data.time)

    def advance(self, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Positions [rad] and velocities [rad/s] dt [s] after (q, v), while the torques tau [N m] hold."""
        q, v, tau, dt = told(self._robot, q, v, tau, dt, "MujocoPlant")
        steps = ceil(dt / self.step * (1.0 - 1e-9))
        self.model.opt.timestep = dt / steps
        self._put(q, v)
        if not self._laid:
            self._lay_ground()
        data = self.data
        data.qfrc_applied[:] = 0.0
        data.qfrc_applied[self.dofs] = tau
        self._step(steps)
        if not np.isfinite(data.qacc).all():  # else MuJoCo would start the next step from them
            data.qacc[:] = data.qacc_warmstart[:] = 0.0
        return self.state()

    def place(self, q: ArrayLike, v: ArrayLike) -> None:
        """The former name of :meth:`set_state`."""
        warn("MujocoPlant.place is MujocoPlant.set_state now", DeprecationWarning, stacklevel=2)
        self.set_state(q, v)

    def set_state(self, q: ArrayLike, v: ArrayLike) -> None:
        """Set the state of the robot: q and v of its Pinocchio model.

        Raises
        ------
        InvalidInput
            If a number is not finite, or there are more or fewer than the robot has.
        """
        q, v = finite(q, "MujocoPlant: q"), finite(v, "MujocoPlant: v")
        check_joints(self._robot, q, v)
        self._put(q, v)

    def _put(self, q: Array, v: Array) -> None:
        self._places.put(self.data, q, v)

    def state(self) -> tuple[Array, Array]:
        """The state of the robot: q and v of its Pinocchio model."""
        return self._places.take(self.data)

    def push(self, frame: str, force: ArrayLike, duration: float, *, start: float | None = None) -> None:
        """Push a frame at its origin for a time, which need not begin or end with a tick of the controller.

        A physics step that the push covers in part gets the mean force, so that the momentum is always force times
        duration.

        Parameters
        ----------
        frame : str
        force : array, shape (3,)
            Along the axes of the world [N].
        duration : float
            How long the push lasts [s].
        start : float, optional
            When it begins, by the clock of the plant, :attr:`time` [s] (default: now).

        Raises
        ------
        InvalidInput
            If there is no such frame, a number is out of range, or the push would be over already.
        """
        check_frame(self._robot, frame, "push: frame")
        pull, seconds = finite(force, "push: force"), positive_scalar(duration, "push: duration", unit="s")
        if pull.shape != (3,):
            raise InvalidInput(f"push: force has shape {pull.shape}; it must be (3,), in N")
        begin = self.time if start is None else finite_scalar(start, "push: start")
        if begin + seconds <= self.time:
            raise InvalidInput(
                f"push: it would end at {begin + seconds:g} s, and the clock of the plant stands at {self.time:g} s"
            )
        found = self._robot.model.frames[self._robot.frame_index(frame)]
        name = body_name(self._robot.model, found.parentJoint)
        body = self._mujoco.mj_name2id(self.model, self._mujoco.mjtObj.mjOBJ_BODY, name)
        if body < 0:
            raise InvalidInput(f"push: frame {frame!r} is on nothing that has mass, and moves")
        self._pushes.append(Push(body, found.placement.translation.copy(), pull, begin, begin + seconds))

    @property
    def forces(self) -> dict[str, Array]:
        """Name of a contact -> forces of the ground on its k points in the last physics step, shape (k, 3) [N].

        And name of a loop -> force on its first frame, shape (3,) [N], or force and moment (6,), [N] and [N m]. All are
        along the axes of the world.
        """
        every, wrench = np.zeros((self.model.ngeom, 3)), np.zeros(6)
        for i in range(self.data.ncon):
            contact = self.data.contact[i]
            self._mujoco.mj_contactForce(self.model, self.data, i, wrench)
            every[contact.geom2] += wrench[:3] @ contact.frame.reshape(3, 3)  # geom1 is the ground
        ground = {contact.name: every[points] for contact, points in zip(self.contacts, self._points, strict=True)}
        return ground | loop_forces(self.model, self.data, self.loops, self._mujoco)

    @property
    def points(self) -> dict[str, Array]:
        """Name of a contact -> positions of its k points in the world, shape (k, 3) [m]."""
        self._mujoco.mj_kinematics(self.model, self.data)
        found = zip(self.contacts, self._points, strict=True)
        return {each.name: self.data.geom_xpos[points] - [0.0, 0.0, each.radius or 0.0] for each, points in found}

    def creep(self, q: Array, duration: float = 10.0) -> float:
        """How far the points of the contacts creep along the ground, at most, while all joints are locked at q [m].

        After a second to come to rest, within `duration` [s]. This creep comes from the contact model of the physics,
        not from the controller.
        """
        from ..robots.files.reduction import without
        from ..robots.pinocchio import PinocchioRobot

        model: Any = self._robot.model
        held = without(model, list(range(2 if self._base else 1, model.njoints)), np.asarray(q))
        plant = MujocoPlant(PinocchioRobot(held), contacts=self.contacts, ground=self.ground, step=self.step)
        q, v, none = np.array(q[: held.nq]), np.zeros(held.nv), np.zeros(0)
        q, v = plant.advance(q, v, none, 1.0)  # it comes to rest
        before = plant.points
        plant.advance(q, v, none, duration)
        return max(
            float(np.linalg.norm((there - before[name])[:, :2], axis=1).max()) for name, there in plant.points.items()
        )

    def _lay_ground(self) -> None:
        """Move the ground to the height of the lowest contact point."""
        lowest = min(float(points[:, 2].min()) for points in self.points.values())
        self.model.geom("ground").pos[2] += lowest
        self._laid = True

    def _step(self, steps: int) -> None:
        """Run `steps` physics steps, one by one during a push; a step covered in part gets the mean force."""
        data, mujoco, step = self.data, self._mujoco, self.model.opt.timestep
        self._pushes = [push for push in self._pushes if push.end > self.time]
        if not any(push.start < self.time + steps * step for push in self._pushes):
            mujoco.mj_step(self.model, data, steps)
            return
        unpushed = data.qfrc_applied.copy()
        for _ in range(steps):
            data.qfrc_applied[:] = unpushed
            now = self.time
            shares = [(push, (min(push.end, now + step) - max(push.start, now)) / step) for push in self._pushes]
            acting = [(push, share) for push, share in shares if share > NEGLIGIBLE]
            if acting:
                mujoco.mj_kinematics(self.model, data)
                mujoco.mj_comPos(self.model, data)
            for push, share in acting:
                at = data.xpos[push.body] + data.xmat[push.body].reshape(3, 3) @ push.point
                pull = share * push.force
                mujoco.mj_applyFT(self.model, data, pull, np.zeros(3), at, push.body, data.qfrc_applied)
            mujoco.mj_step(self.model, data)

    def __repr__(self) -> str:
        return f"MujocoPlant({self.model.nv} degrees of freedom, step={self.step:g})"


def _checked(robot: Robot, contacts: tuple[Contact, ...]) -> Any:
    """The robot, if MuJoCo can move it and it has the frames of these contacts; InvalidInput otherwise."""
    if not on_pinocchio(robot):
        raise InvalidInput(f"robot = {brief(robot)}; the physics need the model of a PinocchioRobot")
    other = [name for joint, name in joints(robot.model) if not known(joint)]
    if other:
        raise InvalidInput(
            f"MujocoPlant: joint {other[0]!r} of {robot!r} must turn about one axis, or slide along it, or be a ball"
        )
    if any(free(joint) for joint, _ in joints(robot.model)[1:]) or (
        base(robot) and not robot.model.jointPlacements[1].isIdentity()
    ):
        raise InvalidInput(f"MujocoPlant: the base of {robot!r} must be its first joint, and float about the origin")
    for contact in contacts:
        check_frame(robot, contact.frame, f"{contact.full_name()}: frame")
        check_still(contact, "MujocoPlant")
        up = contact.normal if contact.surface is None else contact.surface.rotation(0.0)[0] @ contact.normal
        if not up[2] >= 1.0 - LEVEL:
            raise InvalidInput(
                f"MujocoPlant: {contact.full_name()}: the normal of its surface is {np.round(up, 4).tolist()} in the"
                " world; the ground is level, and it must be [0, 0, 1]"
            )
    return robot
