r"""Robots from MJCF: MuJoCo compiles the file, and the robot is built from what it compiled, joint by joint.

So all features of the format, such as defaults, frames and units, have the meaning MuJoCo gives them. A body is at
:math:`T = T_{parent} B`, with B its pose there, and each of its joints in turn moves it about its anchor p,

.. math::

    T \leftarrow T\, \mathrm{Tr}(p)\, M(q - q_0)\, \mathrm{Tr}(-p),

where M turns about the axis, slides along it, or turns as a ball does, and :math:`q_0` is the ``ref`` of the joint. The
shift by :math:`q_0` goes into the placement of the joint: q is what MuJoCo calls qpos, but for quaternions, which are
x, y, z, w here. Before a robot is given, the places of its bodies and sites, and its mass matrix, are compared with
MuJoCo's at random configurations.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ...base.checks import LARGEST, Array
from ...base.quiet import caught, reason
from ...base.telling import tell
from ..choices import Base
from ..joint_axes import kind
from .closures import closed_chains
from .couplings import couplings
from .description import BASE_JOINT, BASES, Description
from .flags import disabled, has_range
from .motors import motor_range, other_rotors, rotors
from .mujoco_numbers import BALL, FREE, HINGE, SLIDE, dofs, pose, randomise, single_joint, xyzw, yaw_of
from .scene import Scene, body_name, body_names, scene
from .springs import springs
from .unmodelled import unmodelled

#: Tolerance for positions against MuJoCo's, relative to the size of the robot, and number of comparisons.
EXACT, TRIES = 1e-9, 3


def read_mjcf(source: Path | mujoco.MjModel, base: Base | None, bodies: Iterable[str] | None, what: str) -> Description:
    """The robot of an MJCF file, or of a model that MuJoCo has compiled.

    Raises
    ------
    InvalidInput
        If MuJoCo cannot read it, it has no robot or several, or something in it cannot be read exactly.
    """
    bodies = None if bodies is None else list(bodies)
    mj = source if isinstance(source, mujoco.MjModel) else _compiled(source, what)
    described = _Reader(mj, scene(mj, bodies, what), base, what).description()
    if described.model.nv == 0 and bodies is not None:
        raise InvalidInput(f"{what}: body = {bodies} moves nothing: 0 degrees of freedom; base='floating' gives six")
    return described


def _compiled(path: Path, what: str) -> mujoco.MjModel:
    load = mujoco.MjModel.from_binary_path if path.suffix.lower() == ".mjb" else mujoco.MjModel.from_xml_path
    try:
        with caught() as lines:
            return load(str(path))
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        why = " ".join(str(error).split()).removeprefix("Error: ")
        hint = "; meshes and textures are sought where the file says" if "opening file" in why else ""
        raise InvalidInput(f"{what}: MuJoCo cannot read it: {why or reason(lines, error)}{hint}") from None


class _Reader:
    """One robot of one compiled model."""

    def __init__(self, mj: mujoco.MjModel, chosen: Scene, base: Base | None, what: str) -> None:
        self.mj, self.scene, self.what = mj, chosen, what
        self.names = body_names(mj)
        self.model = pin.Model()
        self.model.name = self.names[chosen.roots[0]]
        self.joints: dict[int, int] = {}  # MuJoCo's number -> that of the model
        self.placed: dict[int, tuple[int, pin.SE3]] = {0: (0, pin.SE3.Identity())}  # body -> joint, and where on it
        self.rotors = rotors(mj)
        self.start: list[Array] = []  # the neutral configuration, joint by joint
        self.base = base
        self.flown: int | None = None  # the free joint that a planar one replaces in the robot
        if base is not None and len(chosen.roots) > 1:
            raise InvalidInput(f"{what}: base = {base!r}, but there are several robots; each stands as the file says")
        self.world = self._world()

    def description(self) -> Description:
        self._put_gravity()
        for body in self.scene.bodies:
            self._add_body(body)
        self._add_sites()
        ties = couplings(self.mj, self.scene, self.joint_names(), self.what)
        closures, open_ends = closed_chains(self.mj, self.world, self.scene, self.placed, self.names, self.what)
        neutral = np.concatenate([np.zeros(0), *self.start])
        for i in range(self.mj.nkey):
            name = self.mj.key(i).name or f"key{i}"
            if not np.isfinite(self.mj.key_qpos[i]).all():
                raise InvalidInput(f"{self.what}: keyframe {name!r} has numbers that are not finite")
            self.model.referenceConfigurations[name] = self.configuration(self.mj.key_qpos[i], neutral)
        self._verify(neutral)
        left_out = (
            *self.scene.left_out,
            *open_ends,
            *unmodelled(self.mj, self.scene, self.joint_names(), bool(closures)),
            *self._displaced(neutral),
        )
        own = springs(self.mj, self.joint_names())
        return Description(self.model, neutral, ties, (), left_out, tuple(closures), self.mj, own)

    def joint_names(self) -> dict[int, str]:
        """MuJoCo's number of each joint of the robot -> its name."""
        return {j: self.model.names[index] for j, index in self.joints.items()}

    # Bodies and joints.

    def _world(self) -> Any:
        """MuJoCo's data at qpos0, its reference configuration."""
        data = mujoco.MjData(self.mj)
        data.qpos[:] = self.mj.qpos0
        mujoco.mj_kinematics(self.mj, data)
        return data

    def _put_gravity(self) -> None:
        off = disabled(self.mj, "GRAVITY")
        self.model.gravity.linear = np.zeros(3) if off else np.array(self.mj.opt.gravity)

    def _add_body(self, body: int) -> None:
        mj, first = self.mj, int(self.mj.body_jntadr[body])
        own = list(range(first, first + int(mj.body_jntnum[body])))
        if body in self.scene.roots:
            carrier, placement = self._add_base(body, own)
            own = [j for j in own if mj.jnt_type[j] != FREE]
        else:
            carrier, on_parent = self.placed[int(mj.body_parentid[body])]
            placement = on_parent * pose(mj.body_pos[body], mj.body_quat[body])
        for j in own:
            anchor = pin.SE3(np.eye(3), np.array(mj.jnt_pos[j]))
            carrier = self._add_joint(body, j, carrier, placement * anchor)
            placement = anchor.inverse()
        self.placed[body] = carrier, placement
        try:
            inertia = pin.Inertia(float(mj.body_mass[body]), np.zeros(3), np.diag(mj.body_inertia[body]))
        except (RuntimeError, ValueError):
            J = mj.body_inertia[body].tolist()
            raise InvalidInput(
                f"{self.what}: body {self.names[body]!r} has the inertia {J}, which no body has"
            ) from None
        self.model.appendBodyToJoint(carrier, inertia, placement * pose(mj.body_ipos[body], mj.body_iquat[body]))
        self._add_frame(body_name(mj, body), carrier, placement, pin.FrameType.BODY)

    def _add_base(self, body: int, joints: list[int]) -> tuple[int, pin.SE3]:
        """The joint that carries a root body, and the pose on it: the world, or a free joint."""
        mj, start = self.mj, pose(self.world.xpos[body], self.world.xquat[body])
        free = next((j for j in joints if mj.jnt_type[j] == FREE), None)
        asked = self.base if self.base is not None else "fixed" if free is None else "floating"
        if asked == "fixed":
            return 0, start
        model = BASES[asked]()
        name = (mj.joint(free).name if free is not None else "") or self._unused(BASE_JOINT)
        height = pin.SE3.Identity()
        if asked == "planar":
            height.translation = np.array([0.0, 0.0, start.translation[2]])
        index = int(self.model.addJoint(0, model, height, name))
        self.model.addJointFrame(index)
        if asked == "floating":
            if free is not None:
                self._take(free, index)
            self.start.append(pin.SE3ToXYZQUAT(start))
            return index, pin.SE3.Identity()
        self.flown = free
        yaw = yaw_of(start.rotation)
        self.start.append(np.array([start.translation[0], start.translation[1], np.cos(yaw), np.sin(yaw)]))
        return index, pin.SE3(pin.utils.rotate("z", -yaw) @ start.rotation, np.zeros(3))

    def _add_joint(self, body: int, j: int, parent: int, placement: pin.SE3) -> int:
        mj, address, what = self.mj, int(self.mj.jnt_qposadr[j]), int(self.mj.jnt_type[j])
        name = self._joint_name(body, j)
        if what == BALL:
            if has_range(mj, j):
                raise InvalidInput(f"{self.what}: ball joint {name!r} has a range; only hinges and slides may")
            index = int(self.model.addJoint(parent, pin.JointModelSpherical(), placement, name))
            start = xyzw(mj.qpos0[address : address + 4])
        else:
            axis, ref = np.array(mj.jnt_axis[j]), float(mj.qpos0[address])
            back = pin.SE3.Identity()
            if what == HINGE:
                back.rotation = pin.exp3(-ref * axis)
            else:
                back.translation = -ref * axis
            low, high = self._range(j, name)
            force = self._largest_force(j, name)
            ends = (np.array([end]) for end in (force, np.inf, low, high))
            index = int(self.model.addJoint(parent, single_joint(what == SLIDE, axis), placement * back, name, *ends))
            start = np.array([ref])
        self.model.addJointFrame(index)
        self._take(j, index)
        self.start.append(start)
        return index

    def _take(self, j: int, index: int) -> None:
        """Note which joint of the model is MuJoCo's number j, with its friction, damping and armature."""
        mj, first, dof = self.mj, self.model.joints[index].idx_v, int(self.mj.jnt_dofadr[j])
        armature, damping = self.rotors
        damped, rubs = not disabled(mj, "DAMPER"), not disabled(mj, "FRICTIONLOSS")
        for i in range(self.model.joints[index].nv):
            self.model.armature[first + i] = mj.dof_armature[dof + i] + armature[dof + i]
            self.model.damping[first + i] = mj.dof_damping[dof + i] + damping[dof + i] if damped else 0.0
            self.model.friction[first + i] = mj.dof_frictionloss[dof + i] if rubs else 0.0
        self.joints[j] = index

    def _joint_name(self, body: int, j: int) -> str:
        """The name of a joint; if it has none, one made from that of its body."""
        name = self.mj.joint(j).name
        if name:
            return str(name)
        count = int(self.mj.body_jntnum[body])
        number = f"{j - int(self.mj.body_jntadr[body])}" if count > 1 else ""
        return self._unused(f"{self.names[body].replace(' ', '')}_joint{number}")

    def _unused(self, name: str) -> str:
        """An unused name for a joint that has none, similar to this one."""
        taken = {*self.model.names, *(self.mj.joint(i).name for i in range(self.mj.njnt))}
        while name in taken:
            name += "_"
        return name

    def _range(self, j: int, name: str) -> tuple[float, float]:
        """Lowest and highest position of a joint."""
        low, high = (float(end) for end in self.mj.jnt_range[j])
        if not low <= high:  # without limited="true" MuJoCo takes such a range for none
            raise InvalidInput(f"{self.what}: joint {name!r} has the range {low:g} to {high:g}; it must be in order")
        if not has_range(self.mj, j):
            return -np.inf, np.inf
        return low if low > -LARGEST else -np.inf, high if high < LARGEST else np.inf

    def _largest_force(self, j: int, name: str) -> float:
        """The largest force that the motors of a joint have in both directions [N m], [N]."""
        low, high = motor_range(self.mj, j)
        if self.mj.jnt_actfrclimited[j]:
            least, most = (float(end) for end in self.mj.jnt_actfrcrange[j])
            if not least < 0.0 < most:
                raise InvalidInput(
                    f"{self.what}: actuatorfrcrange of joint {name!r} from {least:g} to {most:g}; it must have 0 inside"
                )
            low, high = max(low, least), min(high, most)
        if -low != high:
            tell(f"{self.what}: the smaller end of the range of its motor counts for both directions: {name}")
        return min(-low, high)

    def _add_frame(self, name: str, carrier: int, placement: pin.SE3, what: pin.FrameType) -> None:
        self.model.addFrame(pin.Frame(name, carrier, 0, placement, what))

    def _add_sites(self) -> None:
        for i in range(self.mj.nsite):
            body, name = int(self.mj.site_bodyid[i]), self.mj.site(i).name
            if name and body in self.placed:
                carrier, placement = self.placed[body]
                own = placement * pose(self.mj.site_pos[i], self.mj.site_quat[i])
                self._add_frame(name, carrier, own, pin.FrameType.OP_FRAME)

    # Configurations.

    def _displaced(self, neutral: Array) -> list[str]:
        """Keyframes with a base that floats in the file elsewhere than the base of the robot can be, or is held."""
        root, names = self.scene.roots[0], list[str]()
        data, world = self.model.createData(), mujoco.MjData(self.mj)
        carrier, placement = self.placed[root]
        for i in range(self.mj.nkey):
            world.qpos[:] = self.mj.key_qpos[i]
            mujoco.mj_kinematics(self.mj, world)
            pin.forwardKinematics(self.model, data, self.configuration(world.qpos, neutral))
            off = pose(world.xpos[root], world.xquat[root]).actInv(data.oMi[carrier] * placement)
            if not off.isIdentity(EXACT * (1.0 + float(np.abs(world.xpos[root]).max()))):
                names.append(self.mj.key(i).name or f"key{i}")
        return [f"places of the base in the keyframes {', '.join(names)} (base= holds it)"] if names else []

    def configuration(self, qpos: Array, neutral: Array) -> Array:
        """The robot's configuration from qpos; a base that MuJoCo does not have stays neutral."""
        q = np.array(neutral)
        if self.flown is not None:
            address = int(self.mj.jnt_qposadr[self.flown])
            place = pose(qpos[address : address + 3], qpos[address + 3 : address + 7])
            yaw = yaw_of(place.rotation)
            q[:4] = place.translation[0], place.translation[1], np.cos(yaw), np.sin(yaw)
        for j, index in self.joints.items():
            joint, address = self.model.joints[index], int(self.mj.jnt_qposadr[j])
            own = np.array(qpos[address : address + joint.nq])
            if kind(joint) == "FreeFlyer":
                own[3:] = xyzw(own[3:])
            elif kind(joint) == "Spherical":
                own = xyzw(own)
            q[joint.idx_q : joint.idx_q + joint.nq] = own
        return q

    def _verify(self, neutral: Array) -> None:
        """Compare places of bodies and sites, and the inertia, with those of MuJoCo at random configurations."""
        mj, data, rng = self.mj, self.world, np.random.default_rng(0)
        mass = float(sum(mj.body_mass[body] for body in self.scene.bodies))
        own = sum(inertia.mass for inertia in self.model.inertias)
        self._same(own, mass, "its mass [kg]")
        numbers = self.model.createData()
        for _ in range(TRIES):
            data.qpos[:] = mj.qpos0
            for j in self.joints:
                randomise(mj, j, data.qpos, rng)
            mujoco.mj_normalizeQuat(mj, data.qpos)
            mujoco.mj_kinematics(mj, data)
            q = self.configuration(data.qpos, neutral)
            self._verify_inertia(numbers, q)
            pin.forwardKinematics(self.model, numbers, q)
            for body in self.scene.bodies:
                carrier, placement = self.placed[body]
                here = numbers.oMi[carrier] * placement
                self._same(here.translation, data.xpos[body], f"the place of body {self.names[body]!r}")
                self._same(here.rotation, data.xmat[body].reshape(3, 3), f"the axes of body {self.names[body]!r}")
            if mass > 0.0:
                centres = [numbers.oMi[i].act(own.lever) * own.mass for i, own in enumerate(self.model.inertias)]
                expected = sum(mj.body_mass[body] * data.xipos[body] for body in self.scene.bodies)
                self._same(np.sum(centres, axis=0) / mass, expected / mass, "its centre of mass [m]")
            pin.updateFramePlacements(self.model, numbers)
            for i in range(mj.nsite):
                name = mj.site(i).name
                if name and int(mj.site_bodyid[i]) in self.placed:
                    here = numbers.oMf[self.model.getFrameId(name, pin.FrameType.OP_FRAME)]
                    self._same(here.translation, data.site_xpos[i], f"the place of site {name!r}")
                    self._same(here.rotation, data.site_xmat[i].reshape(3, 3), f"the axes of site {name!r}")

    def _verify_inertia(self, numbers: pin.Data, q: Array) -> None:
        """Compare the mass matrix of the joints with MuJoCo's, at the configuration that MuJoCo is in."""
        mj, joints = self.mj, {j: index for j, index in self.joints.items() if self.mj.jnt_type[j] != FREE}
        if not joints or np.any(mj.tendon_armature) or other_rotors(mj):  # these couple joints, and are told
            return
        places = [dof for j in joints for dof in dofs(mj, j)]
        columns = [self.model.joints[index].idx_v + i for j, index in joints.items() for i in range(len(dofs(mj, j)))]
        mujoco.mj_fwdPosition(mj, self.world)
        M, unit = np.zeros((len(places), mj.nv)), np.eye(mj.nv)
        for row, place in zip(M, places, strict=True):
            mujoco.mj_mulM(mj, self.world, row, unit[place])
        own = pin.crba(self.model, numbers, q)
        own = np.triu(own) + np.triu(own, 1).T
        self._same(own[np.ix_(columns, columns)], M[:, places], "its mass matrix")

    def _same(self, own: Any, expected: Any, element: str) -> None:
        off = float(np.abs(np.asarray(own) - expected).max())
        if not off <= EXACT * (1.0 + float(np.abs(expected).max())):
            raise InvalidInput(f"{self.what}: {element} is off from MuJoCo's by {off:.3g}; it cannot be read exactly")
