r"""A plant moved by the physics of MuJoCo instead of the model of the controller.

The robot is handed over as it is, joint by joint: placements, axes, masses, inertias, armatures and viscous damping
of its Pinocchio model. Joints that the model holds, such as locked fingers, are part of the links that carry them.
There are no collisions, no ranges of the joints and no dry friction. In free space both agree on

.. math:: M(q)\,\dot v + b(q, v) + D\,v = \tau,

but for the damping D, which the controller does not know: it has to be overcome by feedback, as in life.
"""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from hqp import InvalidInput, MissingPackage
from hqp.errors import brief

from ..base.checks import Array, positive_scalar
from ..robots.robot import Robot, check_fixed_base, on_pinocchio

if TYPE_CHECKING:
    import mujoco


class MujocoPlant:
    """A robot in MuJoCo, moved by joint torques: ``simulate(controller, q0, duration=1.0, plant=MujocoPlant(robot))``.

    Parameters
    ----------
    robot : PinocchioRobot
        With a fixed base, and one position a joint.
    step : float
        The longest step of the physics [s]; a tick of the controller is cut into as many as it takes.

    Attributes
    ----------
    model, data : mujoco.MjModel, mujoco.MjData
    dofs : array of int, shape (nv,)
        Where MuJoCo keeps the joints of the robot.

    Raises
    ------
    InvalidInput
        If the robot is not of that kind, or MuJoCo refuses it, as it does inertias that no body has.
    MissingPackage
        If MuJoCo is not installed.
    """

    model: mujoco.MjModel
    data: mujoco.MjData

    def __init__(self, robot: Robot, *, step: float = 5e-4) -> None:
        try:
            import mujoco
        except ImportError:
            raise MissingPackage("physics need MuJoCo: pip install 'hqp[mujoco]'") from None
        self._mujoco: Any = mujoco
        self.step = positive_scalar(step, "step", unit="s")
        if not on_pinocchio(robot):
            raise InvalidInput(f"robot = {brief(robot)}; the physics need the model of a PinocchioRobot")
        model: Any = robot.model
        check_fixed_base(robot, "MujocoPlant")
        other = [name for joint, name in _joints(model) if not _known(joint)]
        if other:
            raise InvalidInput(
                f"MujocoPlant: joint {other[0]!r} of {robot!r} must turn about one axis, or slide along it"
            )
        try:
            self.model = _specification(model, mujoco).compile()
        except ValueError as error:
            raise InvalidInput(f"MujocoPlant: MuJoCo refuses {robot!r}: {error}") from None
        self.data = mujoco.MjData(self.model)
        self.dofs = np.array([self.model.joint(name).dofadr[0] for _, name in _joints(model)], dtype=np.intp)

    def advance(self, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Positions [rad] and velocities [rad/s] dt [s] after (q, v), while the torques tau [N m] hold."""
        steps = ceil(dt / self.step * (1.0 - 1e-9))
        self.model.opt.timestep = dt / steps
        data, dofs = self.data, self.dofs
        data.qpos[dofs], data.qvel[dofs], data.qfrc_applied[dofs] = q, v, tau
        self._mujoco.mj_step(self.model, data, steps)
        return data.qpos[dofs].copy(), data.qvel[dofs].copy()

    def __repr__(self) -> str:
        return f"MujocoPlant({self.model.nv} degrees of freedom, step={self.step:g})"


def _known(joint: Any) -> bool:
    """Whether MuJoCo has such a joint: one position, one velocity, and no screw."""
    kind = joint.shortname().removeprefix("JointModel")
    return bool(joint.nq == joint.nv == 1 and kind.startswith(("R", "P")))


def _joints(model: Any) -> list[tuple[Any, str]]:
    """The joints of a Pinocchio model and their names, without the universe."""
    return list(zip(list(model.joints)[1:], list(model.names)[1:], strict=True))


def _specification(model: Any, mujoco: Any) -> mujoco.MjSpec:
    """The same robot in the words of MuJoCo: a body a joint, or one for all joints in a row that carry nothing between.

    What carries nothing is no body to MuJoCo. Its joint goes to the next one that does, as the first of several.
    """
    import pinocchio as pin

    specification = mujoco.MjSpec()
    specification.option.gravity = model.gravity.linear
    specification.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    bodies, waiting = [specification.worldbody], dict[int, list[tuple[int, pin.SE3]]]()
    children = [[i for i in range(1, model.njoints) if model.parents[i] == parent] for parent in range(model.njoints)]
    for index in range(1, model.njoints):
        inertia, parent, place = model.inertias[index], int(model.parents[index]), model.jointPlacements[index]
        before = [(i, place.inverse() * at) for i, at in waiting.pop(parent, [])]
        if before:  # where the first of them is placed on the last body that there is
            first = before[0][0]
            place = model.jointPlacements[first] * before[0][1].inverse()
        own = [*before, (index, pin.SE3.Identity())]
        if inertia.mass == 0.0 and len(children[index]) == 1:
            waiting[index] = own
            bodies.append(bodies[parent])
            continue
        name = model.names[index]
        body = bodies[parent].add_body(name=name, pos=place.translation, quat=_quaternion(place.rotation))
        J = inertia.inertia
        body.explicitinertial = True
        body.mass, body.ipos = inertia.mass, inertia.lever
        body.fullinertia = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        for i, at in own:
            _add_joint(body, model, i, at, mujoco)
        bodies.append(body)
    return specification


def _add_joint(body: Any, model: Any, index: int, at: Any, mujoco: Any) -> None:
    """Put a joint of the model into a body, on which it is at a place."""
    joint = model.joints[index]
    motion = joint.createData()
    joint.calc(motion, np.zeros(model.nq))
    subspace = np.array(motion.S).reshape(6)  # linear, angular: one of them is the axis
    slides = bool(subspace[:3].any())
    body.add_joint(
        name=model.names[index],
        type=mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE,
        pos=at.translation,
        axis=at.rotation @ (subspace[:3] if slides else subspace[3:]),
        armature=model.armature[joint.idx_v],
        damping=[model.damping[joint.idx_v], 0.0, 0.0],
    )


def _quaternion(rotation: Array) -> Array:
    """(w, x, y, z) of a rotation matrix, as MuJoCo writes it."""
    import pinocchio as pin

    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return np.array([w, x, y, z])
