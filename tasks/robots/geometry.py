"""The shapes of a robot, read from its file or given: collision shapes and visual shapes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal
from xml.etree.ElementTree import Element

import coal
import numpy as np
import pinocchio as pin

from hqp import InvalidInput
from hqp.checks import listed, of_type
from hqp.errors import brief

from ..base.checks import suggestion
from ..base.quiet import caught, reason
from .convexity import check_sizes, check_volume
from .files.urdf import rename, rename_shared
from .files.xml import parsed, root_of, written
from .frame import WORLD


def read_geometry(robot: Any, kind: Literal["collision", "visual"]) -> pin.GeometryModel:
    """The shapes of the file that a robot was loaded from, URDF or MJCF.

    Raises
    ------
    InvalidInput
        If there is no such file, or a shape cannot be read.
    """
    if robot.scene is not None:
        from .files.mjcf_shapes import mjcf_geometry, mjcf_visuals

        if kind == "visual":
            return mjcf_visuals(robot.model, robot.scene)
        return mjcf_geometry(robot.model, robot.scene, f"the collision shapes of {robot!r}")
    if robot.source is None or root_of(robot.source, repr(robot)) != "robot":
        beside = ", or give it some by robot.with_geometry" if kind == "collision" else ""
        raise InvalidInput(f"{robot!r} has no URDF file to read shapes from; use load_robot, or set its source{beside}")
    return (collision_geometry if kind == "collision" else visual_geometry)(robot.model, robot.source)


def checked_geometry(model: pin.Model, geometry: Any, what: str) -> pin.GeometryModel:
    """A checked copy of given shapes, meshes as their convex hulls, each on a frame of the model.

    Raises
    ------
    InvalidInput
        If it is no GeometryModel, there are no shapes, one is on no joint of the model, or a mesh has no volume.
    """
    own = pin.GeometryModel(of_type(geometry, pin.GeometryModel, f"{what}: geometry"))
    if not own.ngeoms:
        raise InvalidInput(f"{what}: geometry has no shapes")
    for shape in own.geometryObjects:
        if not 0 <= shape.parentJoint < model.njoints:
            number = shape.parentJoint
            raise InvalidInput(f"{what}: shape {shape.name!r} is on joint {number}; it must be one of the model")
        if not (shape.parentFrame < model.nframes and model.frames[shape.parentFrame].parentJoint == shape.parentJoint):
            kinds = pin.FrameType.JOINT if shape.parentJoint else pin.FrameType.FIXED_JOINT
            shape.parentFrame = model.getFrameId(model.names[shape.parentJoint], kinds)
        shape.geometry = convex(shape.geometry, f"{what}: {shape.name!r}")
    return own


def collision_geometry(model: pin.Model, source: Path) -> pin.GeometryModel:
    """The collision shapes of a URDF on the joints of a model, which may hold some of the file's joints.

    A mesh is replaced by its convex hull, which contains it, has one nearest point where a mesh may have many, and
    takes microseconds. The shapes of a body whose joint is locked in the model are attached to the joint before it.

    Parameters
    ----------
    model : pinocchio.Model
    source : path
        The URDF. Meshes are sought beside it and in all folders above, as ``package://`` names them.

    Raises
    ------
    InvalidInput
        If a shape cannot be read, or a mesh has no volume.
    """
    what = f"the collision shapes of {str(source)!r}"
    geometry = pin.GeometryModel()
    for shape in _carried(model, source, "collision", what):
        shape.geometry = convex(shape.geometry, f"{what}: {shape.name!r}")
        geometry.addGeometryObject(shape)
    return geometry


def visual_geometry(model: pin.Model, source: Path) -> pin.GeometryModel:
    """The visual shapes of a URDF on the joints of a model: meshes as they are, with their colours.

    Raises
    ------
    InvalidInput
        If a shape cannot be read.
    """
    geometry = pin.GeometryModel()
    for shape in _carried(model, source, "visual", f"the visual shapes of {str(source)!r}"):
        geometry.addGeometryObject(shape)
    return geometry


def _carried(
    model: pin.Model, source: Path, kind: Literal["collision", "visual"], what: str
) -> list[pin.GeometryObject]:
    """All shapes of a kind, each on the joint of the model that carries it."""
    root = parsed(source, what)
    shared = rename_shared(root)
    text, folders = written(root, what), [str(folder) for folder in source.parents]
    asked = pin.GeometryType.COLLISION if kind == "collision" else pin.GeometryType.VISUAL
    try:
        with caught() as lines:
            whole = pin.buildModelFromXML(text)
            shapes = pin.buildGeomFromUrdfString(whole, text, asked, package_dirs=folders)
    except (ValueError, RuntimeError) as error:
        raise InvalidInput(
            f"{what} cannot be read: {reason(lines, error)}; package://NAME/... is sought as a folder NAME beside the"
            " file and in all folders above it"
        ) from None
    rename(whole, shared)
    _check_all(root, whole, shapes, kind, what)
    found = []
    for shape in shapes.geometryObjects:
        body = whole.frames[shape.parentFrame]
        frame = model.getFrameId(body.name, pin.FrameType.BODY)
        if frame >= model.nframes:
            raise InvalidInput(f"{str(source)!r}: the model has no frame {body.name!r}, which carries {shape.name!r}")
        own = model.frames[frame]
        carried = pin.GeometryObject(shape)
        carried.parentJoint, carried.parentFrame = own.parentJoint, frame
        carried.placement = own.placement * body.placement.inverse() * shape.placement
        found.append(carried)
    return found


def _check_all(root: Element, model: pin.Model, shapes: pin.GeometryModel, kind: str, what: str) -> None:
    """Refuse a file if urdfdom has left out some of its shapes because it could not read them."""
    read = Counter(model.frames[shape.parentFrame].name for shape in shapes.geometryObjects)
    for link in root.findall("link"):
        name, written = str(link.get("name")), len(link.findall(kind))
        if read[name] < written:
            raise InvalidInput(f"{what} cannot be read: of link {name!r} {read[name]} of {written} mean something")


def convex(shape: coal.CollisionGeometry, what: str) -> coal.CollisionGeometry:
    """The convex hull of a mesh, anything else as it is.

    Raises
    ------
    InvalidInput
        If the mesh has no volume, and so no hull, or a size of a simple shape is not positive.
    """
    if not isinstance(shape, coal.BVHModelBase):
        check_sizes(shape, what)
        return shape
    check_volume(np.array(shape.vertices()).reshape(-1, 3), what)
    shape.buildConvexHull(True, "Qt")
    return shape.convex


def bodies_of(model: pin.Model, geometry: pin.GeometryModel) -> list[str]:
    """The frame that carries each shape."""
    return [str(model.frames[shape.parentFrame].name) for shape in geometry.geometryObjects]


def bodies_with_shapes(robot: Any, asked: Iterable[str] | None, what: str) -> list[str]:
    """The frames that carry shapes, each once, without the world: all of them, or those asked for.

    Raises
    ------
    InvalidInput
        If a frame that is asked for carries no shape (the message lists the nearest), or none is asked for.
    """
    carriers = [body for body in dict.fromkeys(bodies_of(robot.model, robot.geometry())) if body != WORLD]
    if asked is None:
        return carriers
    named = [of_type(body, str, f"{what}: a body") for body in listed(asked, f"{what}: bodies", "frames of bodies")]
    for body in named:
        if body not in carriers:
            raise InvalidInput(f"{what}: {brief(body)} is no body with a shape{suggestion(body, carriers)}")
    if not named:
        raise InvalidInput(f"{what}: bodies is empty; leave it out for all bodies with shapes")
    return list(dict.fromkeys(named))


def neighbours(model: pin.Model, first: int, second: int) -> bool:
    """Whether two joints are the same, or one is the parent of the other."""
    return first == second or model.parents[first] == second or model.parents[second] == first


def cold_request() -> coal.DistanceRequest:
    """A request for a distance that is a function of the two shapes and their places alone."""
    return coal.DistanceRequest()


def witnesses(distance: coal.DistanceResult) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Distance [m], nearest points (3,) of both, and the unit normal from the second to the first.

    If the shapes overlap, the distance is negative and the points are the deepest ones.
    """
    d = float(distance.min_distance)
    first, second = np.array(distance.getNearestPoint1()), np.array(distance.getNearestPoint2())
    gap = first - second
    size = float(np.linalg.norm(gap))
    normal = gap / size * (1.0 if d >= 0.0 else -1.0) if size > 1e-9 else -np.array(distance.normal)
    return d, first, second, normal
