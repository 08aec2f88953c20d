"""A Pinocchio robot as a MuJoCo model: bodies, joints, and spheres at the points of contacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from .ground import RADIUS

if TYPE_CHECKING:
    import mujoco

    from ..contacts.contact import Contact


def known(joint: Any) -> bool:
    """Whether MuJoCo has such a joint: a hinge, with or without ends, a slide, a ball, or a floating base."""
    single = joint.nq == joint.nv == 1 and _kind(joint).startswith(("R", "P"))
    return bool(single or unbounded(joint) or ball(joint) or free(joint))


def unbounded(joint: Any) -> bool:
    """Whether a joint turns without end, its position the cosine and sine of an angle."""
    return _kind(joint).startswith(("RUB", "RevoluteUnbounded"))


def ball(joint: Any) -> bool:
    """Whether a joint is a ball, its position a quaternion."""
    return _kind(joint) == "Spherical"


def _kind(joint: Any) -> str:
    return str(joint.shortname()).removeprefix("JointModel")


def free(joint: Any) -> bool:
    """Whether a joint is a free joint, with six degrees of freedom."""
    return bool(joint.shortname() == "JointModelFreeFlyer")


def joints(model: Any) -> list[tuple[Any, str]]:
    """The joints of a Pinocchio model and their names, without its first joint, the universe."""
    return list(zip(list(model.joints)[1:], list(model.names)[1:], strict=True))


def specification_of(robot: Any, mujoco: Any, contacts: Sequence[Contact] = ()) -> mujoco.MjSpec:
    """The same robot as a MuJoCo model: one body per joint, or one for successive joints without mass between them.

    MuJoCo allows no body without mass: the joint of such a link is added to the next body that has mass.

    Raises
    ------
    InvalidInput
        If a contact or a ball is on such a link, or a base or a ball has an armature or a damping that differs by
        direction.
    """
    import pinocchio as pin

    model, specification = robot.model, mujoco.MjSpec()
    specification.option.gravity = model.gravity.linear
    specification.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    # If numbers diverge, MuJoCo silently resets the robot to its start; the run must stop instead.
    specification.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    bodies, waiting = [specification.worldbody], dict[int, list[tuple[int, pin.SE3]]]()
    children = [[i for i in range(1, model.njoints) if model.parents[i] == parent] for parent in range(model.njoints)]
    for index in range(1, model.njoints):
        inertia, parent, place = model.inertias[index], int(model.parents[index]), model.jointPlacements[index]
        before = [(i, place.inverse() * at) for i, at in waiting.pop(parent, [])]
        if before:  # the body is placed where the first joint of the chain is on the body before
            first = before[0][0]
            place = model.jointPlacements[first] * before[0][1].inverse()
        own = [*before, (index, pin.SE3.Identity())]
        if not inertia.toDynamicParameters().any() and len(children[index]) == 1:
            if ball(model.joints[index]):
                raise InvalidInput(
                    f"MujocoPlant: the ball {model.names[index]!r} moves a link without mass, which MuJoCo has not"
                )
            waiting[index] = own
            bodies.append(bodies[parent])
            continue
        body = bodies[parent].add_body(
            name=body_name(model, index), pos=place.translation, quat=quaternion(place.rotation)
        )
        J = inertia.inertia
        body.explicitinertial = True
        body.mass, body.ipos = inertia.mass, inertia.lever
        body.fullinertia = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        for i, at in own:
            _add_joint(body, robot, i, at, mujoco)
        bodies.append(body)
    for contact in contacts:
        body, frame = (
            carrier(specification, robot, contact.frame, contact.full_name()),
            model.frames[robot.frame_index(contact.frame)],
        )
        for k, point in enumerate(contact.shape.points):
            body.add_geom(
                name=point_name(contact, k),
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[RADIUS + (contact.radius or 0.0), 0.0, 0.0],
                pos=frame.placement.act(point),
                mass=0.0,
                contype=1,
                conaffinity=0,
            )
    return specification


def carrier(specification: Any, robot: Any, frame: str, what: str) -> Any:
    """The body that carries a frame of the robot.

    Raises
    ------
    InvalidInput
        If it is on a link without mass that moves.
    """
    joint = int(robot.model.frames[robot.frame_index(frame)].parentJoint)
    body = specification.body(body_name(robot.model, joint)) if joint else specification.worldbody
    if body is None:
        raise InvalidInput(
            f"MujocoPlant: {what}: frame {frame!r} is on a link without mass that"
            " moves, which MuJoCo does not have; it must be on one with mass"
        )
    return body


def body_name(model: Any, index: int) -> str:
    """The name of the body that joint `index` moves, that of the joint; ``"world"`` is taken by the world."""
    name = str(model.names[index])
    while name == "world" or (name != model.names[index] and name in model.names):
        name += "_"
    return name


def point_name(contact: Contact, k: int) -> str:
    """The name of a contact point in MuJoCo."""
    return f"{contact.name} point {k}"


def _add_joint(body: Any, robot: Any, index: int, at: Any, mujoco: Any) -> None:
    """Add joint `index` of the model to a MuJoCo body, at the placement `at` on it."""
    model = robot.model
    joint, name = model.joints[index], model.names[index]
    if free(joint) or ball(joint):
        own = slice(joint.idx_v, joint.idx_v + joint.nv)
        armature, damping = (_same(numbers[own], name) for numbers in (model.armature, model.damping))
        kind = mujoco.mjtJoint.mjJNT_FREE if free(joint) else mujoco.mjtJoint.mjJNT_BALL
        place = {} if free(joint) else {"pos": at.translation}
        body.add_joint(name=name, type=kind, armature=armature, damping=[damping, 0.0, 0.0], **place)
        return
    motion = joint.createData()
    joint.calc(motion, np.zeros(model.nq))
    subspace = np.array(motion.S).reshape(6)  # linear, angular: one of them is the axis
    slides = bool(subspace[:3].any())
    stiffness, rest = robot.springs.get(name, (0.0, 0.0))
    body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE,
        pos=at.translation,
        axis=at.rotation @ (subspace[:3] if slides else subspace[3:]),
        armature=model.armature[joint.idx_v],
        damping=[model.damping[joint.idx_v], 0.0, 0.0],
        stiffness=[stiffness, 0.0, 0.0],
        springref=rest if slides else np.degrees(rest),
    )


def _same(numbers: Array, name: str) -> float:
    """The armature or damping of a floating base or a ball, for which MuJoCo has one number."""
    if np.ptp(numbers):
        raise InvalidInput(
            f"MujocoPlant: armature or damping of joint {name!r} {numbers.tolist()}; all must be the same"
        )
    return float(numbers[0])


def quaternion(rotation: Array) -> Array:
    """The quaternion (w, x, y, z) of a rotation matrix, in MuJoCo's order."""
    import pinocchio as pin

    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return np.array([w, x, y, z])
