"""The collision shapes of an MJCF: what MuJoCo compiled of the geoms, on the bodies of a model."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ..convexity import hull, shape_of
from .mujoco_numbers import pose

GEOM = mujoco.mjtGeom


def mjcf_geometry(model: pin.Model, mj: mujoco.MjModel, what: str) -> pin.GeometryModel:
    """The geoms that collide, of all bodies that the model has; meshes become their convex hulls.

    Its collision pairs are those that MuJoCo may look at: bodies that the file excludes are none.

    Raises
    ------
    InvalidInput
        If a geom of the robot is a plane or a field, which no body carries, or a mesh has no volume.
    """
    geometry, carriers = pin.GeometryModel(), list[int]()
    for i in range(mj.ngeom):
        body = int(mj.geom_bodyid[i])
        name = mj.body(body).name
        if body == 0 or not (mj.geom_contype[i] or mj.geom_conaffinity[i]) or not model.existBodyName(name):
            continue
        frame = model.frames[model.getFrameId(name, pin.FrameType.BODY)]
        label = mj.geom(i).name or f"{name} {i - int(mj.body_geomadr[body])}"
        shape = _shape(mj, i, f"{what}: geom {label!r}")
        placement = frame.placement * pose(mj.geom_pos[i], mj.geom_quat[i])
        number = model.getFrameId(name, pin.FrameType.BODY)
        geometry.addGeometryObject(pin.GeometryObject(label, frame.parentJoint, number, placement, shape))
        carriers.append(body)
    excluded = {frozenset((int(pair) >> 16, int(pair) & 0xFFFF)) for pair in mj.exclude_signature}
    for i, first in enumerate(carriers):
        for j in range(i + 1, len(carriers)):
            if frozenset((first, carriers[j])) not in excluded:
                geometry.addCollisionPair(pin.CollisionPair(i, j))
    return geometry


def _shape(mj: mujoco.MjModel, i: int, what: str) -> object:
    kind, (a, b, c) = GEOM(mj.geom_type[i]), (float(size) for size in mj.geom_size[i])
    if kind == GEOM.mjGEOM_MESH:
        mesh = int(mj.geom_dataid[i])
        first = int(mj.mesh_vertadr[mesh])
        return hull(np.array(mj.mesh_vert[first : first + int(mj.mesh_vertnum[mesh])], dtype=np.float64), what)
    simple = {
        GEOM.mjGEOM_SPHERE: ("Sphere", (a,)),
        GEOM.mjGEOM_CAPSULE: ("Capsule", (a, 2.0 * b)),
        GEOM.mjGEOM_CYLINDER: ("Cylinder", (a, 2.0 * b)),
        GEOM.mjGEOM_ELLIPSOID: ("Ellipsoid", (a, b, c)),
        GEOM.mjGEOM_BOX: ("Box", (2.0 * a, 2.0 * b, 2.0 * c)),
    }
    if kind not in simple:
        raise InvalidInput(f"{what} is a {kind.name.removeprefix('mjGEOM_').lower()}, which no body of a robot carries")
    name, sizes = simple[kind]
    return shape_of(name, *sizes)
