r"""A plant with the constrained dynamics of Pinocchio: its contacts and loops hold with any force that is needed.

With the torques tau, and the Jacobian :math:`J_c` and error e of what holds,

.. math:: M a + b = S^T \tau + J_c^T f, \quad J_c a + \dot J_c v = -2 K J_c v + K^2 e.

It serves as a reference: a controller with the same contacts gets exactly the accelerations that it computes. The
feedback terms, with gain K, only correct the drift of integration.

A line is held at its two ends. What rolls is held where it touches: that point stays at r from the middle of the wheel,
below it, and is not carried around. The point of the wheel that is there now is; so it is allowed the acceleration

.. math:: \omega \times (\omega \times r), \quad \text{told as an error of its place,} \quad
   e = K^{-2}\, \omega \times (\omega \times r),

and its error is that of its height alone.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from math import ceil
from typing import Any

import numpy as np

from hqp import InvalidInput
from hqp.checks import listed, of_type
from hqp.errors import brief

from ..base.checks import Array, function, positive_scalar, suggestion
from ..base.live import Live, number, structure
from ..contacts.contact import Contact
from ..contacts.loop import Loop
from ..robots.robot import Robot, base, check_frame, on_pinocchio
from .closing import ends, loops_of
from .motion import check_names, check_still, told

#: Proximal parameter [1/kg], which makes forces unique if contacts are redundant.
PROXIMAL = 1e-10
#: Pinocchio's types of contacts, by the number of motions that a contact forbids: a line is two points.
POINT, PLANE = "CONTACT_3D", "CONTACT_6D"
KINDS = {3: POINT, 5: POINT, 6: PLANE}


class RigidContactPlant(Live):
    """A robot whose contacts hold, moved by joint torques: ``simulate(..., plant=RigidContactPlant(robot, feet))``.

    Parameters
    ----------
    robot : PinocchioRobot
    contacts : list of Contact
        They can pull as well as push.
    holding : callable, optional
        Returns the names of the contacts that hold, called every tick, such as ``lambda: controller.loaded``. A contact
        is held where it is when it begins to hold (default: all contacts, always).
    loops : list of Loop, optional
        Closed chains (default: those in the file of the robot, :meth:`tasks.Loop.of`).
    step : float
        The longest step of integration [s].
    gain : float
        K [1/s], the rate at which errors of the contacts and loops decay.

    Raises
    ------
    InvalidInput
        If the robot is not of that kind, has joints that follow others, or a contact does not belong to it, or has a
        surface that moves; or a loop does not belong to it, or does not say which orientation it holds.
    """

    contacts: tuple[Contact, ...] = structure()
    loops: tuple[Loop, ...] = structure()
    gain: float = structure()

    @number
    def step(self, value: float) -> float:
        """The longest step of integration [s]."""
        return positive_scalar(value, "step", unit="s")

    def __init__(
        self,
        robot: Robot,
        contacts: Iterable[Contact],
        *,
        holding: Callable[[], Collection[str]] | None = None,
        loops: Iterable[Loop] | None = None,
        step: float = 5e-4,
        gain: float = 20.0,
    ) -> None:
        import pinocchio as pin

        if not on_pinocchio(robot):
            raise InvalidInput(f"robot = {brief(robot)}; its plant needs the model of a PinocchioRobot")
        if len(robot.model.mimicking_joints):
            raise InvalidInput(f"RigidContactPlant: joints of {robot!r} follow others; load it with mimic='lock'")
        self._pin: Any = pin
        self._robot: Any = robot
        self.contacts = tuple(of_type(each, Contact, "a contact") for each in listed(contacts, "contacts", "Contact"))
        for contact in self.contacts:
            check_frame(robot, contact.frame, f"{contact.full_name()}: frame")
            check_still(contact, "RigidContactPlant")
        self.loops = loops_of(robot, loops, "RigidContactPlant")
        check_names(self.contacts, self.loops)
        self._holding = None if holding is None else function(holding, "holding")
        self.step = step
        self.gain = positive_scalar(gain, "gain", unit="1/s")
        self._data = self._robot.model.createData()
        self._free = np.zeros(base(robot))
        self._held: dict[str, list[Any]] = {}
        self._rolling: list[tuple[Contact, int]] = []
        self._models: Any = None
        self._datas: Any = None
        self._proximal = pin.ProximalSettings(1e-12, PROXIMAL, 20)
        self._own = {contact.name: contact for contact in self.contacts}
        self._constrain({})

    def __getstate__(self) -> dict[str, Any]:
        """What defines it, and the contacts that hold; the work memory of Pinocchio is made anew."""
        return {
            "robot": self._robot,
            "contacts": self.contacts,
            "options": {"holding": self._holding, "loops": self.loops, "step": self.step, "gain": self.gain},
            "held": self._held,
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        RigidContactPlant.__init__(self, state["robot"], state["contacts"], **state["options"])
        self._constrain(state["held"])

    def advance(self, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Positions [rad] and velocities [rad/s] dt [s] after (q, v), while the torques tau [N m] hold."""
        q, v, tau, dt = told(self._robot, q, v, tau, dt, "RigidContactPlant")
        steps = ceil(dt / self.step * (1.0 - 1e-9))
        h, full = dt / steps, np.concatenate([self._free, tau])
        self._hold(q)
        for _ in range(steps):
            a = self.acceleration(q, v, full)
            q, v = self._pin.integrate(self._robot.model, q, h * v + 0.5 * h * h * a), v + h * a
        return q, v

    def acceleration(self, q: Array, v: Array, tau: Array) -> Array:
        """Joint accelerations (nv,) [rad/s^2] under generalised forces `tau` (nv,), with the contacts that hold."""
        self._roll(q, v)
        told = self._robot.model, self._data, q, v, tau, self._models, self._datas, self._proximal
        return np.array(self._pin.constraintDynamics(*told))

    @property
    def forces(self) -> dict[str, Array]:
        """Name of a contact that holds -> force [N] and moment [N m] of the world on the robot in the last step, (6,).

        They act at the centre of the contact, of what rolls where it touches, along the axes of its frame; the moment
        of a point contact is 0. And name of a loop -> force and moment on its first frame, at its point, along the axes
        of that frame.
        """
        every, found = iter(np.array(data.contact_force.vector) for data in self._datas), {}
        for name in self._held:
            contact = self._own[name]
            spots = spots_of(contact)
            own = [next(every) for _ in spots]
            arms = [spot - contact.shape.centre for spot in spots]
            found[name] = np.sum(own, axis=0)
            if contact.radius is None:
                found[name][3:] += np.sum([np.cross(r, f[:3]) for r, f in zip(arms, own, strict=True)], axis=0)
        return found | {loop.name: next(every) for loop in self.loops}

    def _hold(self, q: Array) -> None:
        """Update the constraints to the contacts that must hold now; a new one is held where it is at q."""
        holding = self._wanted()
        wanted = {contact.name: contact for contact in self.contacts if contact.name in holding}
        if list(wanted) == list(self._held):
            return
        self._pin.framesForwardKinematics(self._robot.model, self._data, q)
        self._constrain({name: self._held.get(name) or self._places(contact) for name, contact in wanted.items()})

    def _constrain(self, held: dict[str, list[Any]]) -> None:
        """Hold the contacts of these names at these places, and close the loops."""
        pin, model, self._held = self._pin, self._robot.model, held
        self._models, self._datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        pairs = [
            (KINDS[self._own[name].shape.motions], [here, (0, there)])
            for name, places in held.items()
            for here, there in zip(self._mounted(self._own[name]), places, strict=True)
        ]
        pairs += [(POINT if loop.turns else PLANE, ends(self._robot, loop)) for loop in self.loops]
        for kind, places in pairs:
            constraint = self._constraint(kind, places)
            self._models.append(constraint)
            self._datas.append(constraint.createData())
        pin.initConstraintDynamics(model, self._data, self._models, self._datas)
        spots = [self._own[name] for name, places in held.items() for _ in places]
        self._rolling = [(contact, k) for k, contact in enumerate(spots) if contact.radius is not None]

    def _roll(self, q: Array, v: Array) -> None:
        """Move the constraints of what rolls to where it touches at q, with the error that its velocities v ask for."""
        if not self._rolling:
            return
        self._pin.forwardKinematics(self._robot.model, self._data, q, v)
        for contact, k in self._rolling:
            ((joint, touching),) = self._mounted(contact)
            spin = self._data.oMi[joint].rotation @ self._data.v[joint].angular
            there, n = self._data.oMi[joint] * touching, contact.normal
            lowest, arm = there.translation, -(contact.radius or 0.0) * n
            high = n @ (self._held[contact.name][0].translation - lowest)
            there.translation = lowest + high * n + np.cross(spin, np.cross(spin, arm)) / self.gain**2
            self._models[k].joint1_placement, self._models[k].joint2_placement = touching, there

    def _wanted(self) -> Collection[str]:
        """The checked names of the contacts that must hold now."""
        names = [contact.name for contact in self.contacts]
        if self._holding is None:
            return names
        holding = self._holding()
        if isinstance(holding, str) or not isinstance(holding, Collection):
            raise InvalidInput(f"holding gave {brief(holding)}; it must give a list of names of contacts")
        for name in holding:
            if name not in names:
                raise InvalidInput(
                    f"holding gave {brief(name)}, which is no contact of the plant{suggestion(str(name), names)}"
                )
        return holding

    def _mounted(self, contact: Contact) -> list[tuple[int, Any]]:
        """The joint that moves a contact, and poses on it where it is held, at the last kinematics."""
        frame, pin = self._robot.model.frames[self._robot.frame_index(contact.frame)], self._pin
        joint, down = int(frame.parentJoint), np.zeros(3)
        if contact.radius is not None:
            turned = self._data.oMi[joint].rotation @ frame.placement.rotation
            down = contact.radius * turned.T @ contact.normal
        return [(joint, frame.placement * pin.SE3(np.eye(3), spot - down)) for spot in spots_of(contact)]

    def _places(self, contact: Contact) -> list[Any]:
        """The poses in the world of the points where a contact is held, at the last kinematics."""
        return [self._data.oMi[joint] * here for joint, here in self._mounted(contact)]

    def _constraint(self, what: str, places: list[tuple[int, Any]]) -> Any:
        """That two places coincide, each told by a joint, 0 for the world, and a pose on it."""
        pin, model, (first, second) = self._pin, self._robot.model, places
        kind = getattr(pin.ContactType, what)
        constraint = pin.RigidConstraintModel(kind, model, *first, *second, pin.ReferenceFrame.LOCAL)
        constraint.m_baumgarte_parameters.Kp = self.gain**2
        constraint.m_baumgarte_parameters.Kd = 2.0 * self.gain
        return constraint

    def __repr__(self) -> str:
        return f"RigidContactPlant({len(self.contacts)} contacts, step={self.step:g})"


def spots_of(contact: Contact) -> list[Array]:
    """The points of its frame at which a contact is held: the ends of a line, else its centre."""
    points, centre = contact.shape.points, contact.shape.centre
    if contact.shape.motions != 5:
        return [centre]
    along = (points - centre) @ contact.shape.along
    return [points[along.argmin()], points[along.argmax()]]
