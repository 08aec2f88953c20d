"""Collision and visual shapes of an MJCF: its compiled geoms on the bodies of a model, and those that stand beside."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ..convexity import hull, shape_of, triangles
from .mujoco_numbers import pose
from .scene import body_name

GEOM = mujoco.mjtGeom
#: The geoms that can be drawn, and the last group of those that MuJoCo's viewer shows at first.
SEEN = (
    *(GEOM.mjGEOM_SPHERE, GEOM.mjGEOM_CAPSULE, GEOM.mjGEOM_CYLINDER),
    *(GEOM.mjGEOM_ELLIPSOID, GEOM.mjGEOM_BOX, GEOM.mjGEOM_MESH),
)
LAST_SHOWN = 2


def mjcf_geometry(model: pin.Model, mj: mujoco.MjModel, what: str) -> pin.GeometryModel:
    """The geoms that collide, of all bodies that the model has; meshes become their convex hulls.

    Its collision pairs are those that MuJoCo may check, without those that the file excludes.

    Raises
    ------
    InvalidInput
        If a geom of the robot is a plane or a field, which no body carries, or a mesh has no volume.
    """
    geometry, carriers = pin.GeometryModel(), list[int]()
    for i in _carried(model, mj):
        if mj.geom_contype[i] or mj.geom_conaffinity[i]:
            geometry.addGeometryObject(_placed(model, mj, i, _shape(mj, i, f"{what}: geom {_label(mj, i)!r}")))
            carriers.append(int(mj.geom_bodyid[i]))
    excluded = {frozenset((int(pair) >> 16, int(pair) & 0xFFFF)) for pair in mj.exclude_signature}
    for i, first in enumerate(carriers):
        for j in range(i + 1, len(carriers)):
            if frozenset((first, carriers[j])) not in excluded:
                geometry.addCollisionPair(pin.CollisionPair(i, j))
    return geometry


class Standing(NamedTuple):
    """A geom that nothing moves: its name and that of its body, its shape as :func:`_form` tells it, and its pose."""

    name: str
    body: str
    kind: str
    sizes: Any
    at: Any


def standing(model: pin.Model, mj: mujoco.MjModel) -> list[Standing]:
    """The geoms that collide, of the world and of the bodies beside the model that no joint and no hand moves."""
    data = mujoco.MjData(mj)
    mujoco.mj_kinematics(mj, data)
    found = []
    for i in range(mj.ngeom):
        body = int(mj.geom_bodyid[i])
        beside = not body or not model.existBodyName(body_name(mj, body))
        if beside and mj.body_weldid[body] == 0 and (mj.geom_contype[i] or mj.geom_conaffinity[i]):
            at = np.eye(4)
            at[:3, :3], at[:3, 3] = data.geom_xmat[i].reshape(3, 3), data.geom_xpos[i]
            found.append(Standing(_label(mj, i), body_name(mj, body), *_form(mj, i), at))
    return found


def mjcf_visuals(model: pin.Model, mj: mujoco.MjModel) -> pin.GeometryModel:
    """The geoms that MuJoCo's own viewer shows at first, those of the groups 0 to 2, with their colours.

    Meshes are as they are. If a file has none in these groups, all are shown.
    """
    geometry, seen = pin.GeometryModel(), [i for i in _carried(model, mj) if GEOM(mj.geom_type[i]) in SEEN]
    for i in [i for i in seen if mj.geom_group[i] <= LAST_SHOWN] or seen:
        material = int(mj.geom_matid[i])
        color = mj.geom_rgba[i] if material < 0 else mj.mat_rgba[material]
        if color[3] > 0.0:
            shape = _mesh(mj, i) if GEOM(mj.geom_type[i]) == GEOM.mjGEOM_MESH else _shape(mj, i, "")
            shown = _placed(model, mj, i, shape)
            shown.meshColor, shown.overrideMaterial = np.array(color, dtype=np.float64), True
            geometry.addGeometryObject(shown)
    return geometry


def _carried(model: pin.Model, mj: mujoco.MjModel) -> Iterator[int]:
    """MuJoCo's numbers of the geoms on bodies of the model."""
    for i in range(mj.ngeom):
        body = int(mj.geom_bodyid[i])
        if body and model.existBodyName(body_name(mj, body)):
            yield i


def _label(mj: mujoco.MjModel, i: int) -> str:
    body = int(mj.geom_bodyid[i])
    return str(mj.geom(i).name or f"{body_name(mj, body)} {i - int(mj.body_geomadr[body])}")


def _placed(model: pin.Model, mj: mujoco.MjModel, i: int, shape: Any) -> pin.GeometryObject:
    """A shape where its geom is, on the joint that carries its body."""
    number = model.getFrameId(body_name(mj, int(mj.geom_bodyid[i])), pin.FrameType.BODY)
    frame = model.frames[number]
    placement = frame.placement * pose(mj.geom_pos[i], mj.geom_quat[i])
    return pin.GeometryObject(_label(mj, i), frame.parentJoint, number, placement, shape)


def _mesh(mj: mujoco.MjModel, i: int) -> Any:
    """The triangles of a mesh."""
    mesh = int(mj.geom_dataid[i])
    corners, faces = int(mj.mesh_vertadr[mesh]), int(mj.mesh_faceadr[mesh])
    vertices = mj.mesh_vert[corners : corners + int(mj.mesh_vertnum[mesh])]
    return triangles(vertices, mj.mesh_face[faces : faces + int(mj.mesh_facenum[mesh])])


def _shape(mj: mujoco.MjModel, i: int, what: str) -> Any:
    kind, sizes = _form(mj, i)
    if kind == "hull":
        return hull(sizes, what)
    if kind in ("", "Halfspace"):
        kind = GEOM(mj.geom_type[i]).name.removeprefix("mjGEOM_").lower()
        raise InvalidInput(f"{what} is a {kind}, which no body of a robot carries")
    return shape_of(kind, *sizes)


def _form(mj: mujoco.MjModel, i: int) -> tuple[str, Any]:
    """The name of Coal for the shape of a geom, and its sizes; "hull" and its points; "" if it is not convex."""
    kind, (a, b, c) = GEOM(mj.geom_type[i]), (float(size) for size in mj.geom_size[i])
    if kind == GEOM.mjGEOM_MESH:
        mesh = int(mj.geom_dataid[i])
        first = int(mj.mesh_vertadr[mesh])
        return "hull", np.array(mj.mesh_vert[first : first + int(mj.mesh_vertnum[mesh])], dtype=np.float64)
    simple: dict[Any, tuple[str, Any]] = {
        GEOM.mjGEOM_SPHERE: ("Sphere", (a,)),
        GEOM.mjGEOM_CAPSULE: ("Capsule", (a, 2.0 * b)),
        GEOM.mjGEOM_CYLINDER: ("Cylinder", (a, 2.0 * b)),
        GEOM.mjGEOM_ELLIPSOID: ("Ellipsoid", (a, b, c)),
        GEOM.mjGEOM_BOX: ("Box", (2.0 * a, 2.0 * b, 2.0 * c)),
        GEOM.mjGEOM_PLANE: ("Halfspace", (np.array([0.0, 0.0, 1.0]), 0.0)),
    }
    return simple.get(kind, ("", ()))
