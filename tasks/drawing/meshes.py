"""Meshes of a robot: triangles on its joints, from the shapes of its file, or capsules along its links."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.skeleton import SHORT

if TYPE_CHECKING:
    from ..robots.pinocchio import PinocchioRobot

#: Colour of shapes without one in the file, and of capsules that represent links (red, green, blue, 0 .. 1).
PLAIN, LINK = (0.85, 0.85, 0.88), (0.30, 0.42, 0.55)
#: A mesh with more triangles than this is simplified, to this number of cells along its longest side.
MOST_TRIANGLES, CELLS = 3000, 48
#: Radius of a capsule relative to the size of the robot.
THICKNESS = 0.018


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one colour, attached to one joint.

    Attributes
    ----------
    joint : int
        Pinocchio's number of the joint; 0 is the world.
    vertices : array, shape (k, 3)
        In the frame of the joint [m].
    faces : array of int, shape (m, 3)
    color : tuple of float
        Red, green and blue, 0 .. 1.
    opacity : float
        0 .. 1.
    """

    joint: int
    vertices: Array
    faces: NDArray[np.int64]
    color: tuple[float, float, float]
    opacity: float = 1.0


def meshes_of(robot: PinocchioRobot) -> tuple[list[Mesh], str]:
    """The meshes of a robot, and their source in words.

    They are those of its file; if there are none, or they cannot be read, capsules from joint to joint.
    """
    try:
        shapes = robot.visuals()
    except InvalidInput as reason:
        return list(_capsules(robot)), f"links are drawn as capsules from joint to joint: {reason}"
    meshes = [mesh for shape in shapes.geometryObjects for mesh in _of_shape(shape)]
    if meshes:
        return meshes, "drawn by the visual shapes of the file"
    capsules = list(_capsules(robot))
    if not capsules:
        return [], "nothing is drawn: the file has no visual shapes, and all joints are at one point"
    return capsules, "links are drawn as capsules from joint to joint: the file has no visual shapes"


def _of_shape(shape: Any) -> Iterator[Mesh]:
    joint, T = int(shape.parentJoint), np.array(shape.placement.homogeneous)
    color = np.array(shape.meshColor, dtype=np.float64)
    path = Path(shape.meshPath)
    parts = [] if shape.overrideMaterial or path.suffix.lower() != ".dae" else _coloured(path)
    scale = np.array(shape.meshScale, dtype=np.float64).ravel()
    if not parts:
        parts = [(*_triangles(shape.geometry), tuple(color[:3].tolist()))]
        scale = np.ones(3)  # Pinocchio has applied the scale already
    for vertices, faces, own in parts:
        vertices, faces = _thinned(vertices * scale, faces)
        yield Mesh(joint, vertices @ T[:3, :3].T + T[:3, 3], faces, own, float(color[3]))


def _coloured(path: Path) -> list[tuple[Array, NDArray[np.int64], tuple[float, float, float]]]:
    """The parts of a COLLADA file, each with its colour; none if its reader is missing or cannot read the file."""
    try:
        import trimesh

        scene: Any = trimesh.load(path, force="scene")
        found: dict[tuple[float, ...], list[Any]] = {}
        for mesh in scene.dump():
            material = getattr(mesh.visual, "material", None)
            color = np.array(mesh.visual.main_color if material is None else material.main_color)[:3] / 255.0
            found.setdefault(tuple(color.tolist()), []).append(mesh)
    except Exception:  # any error in a file: Pinocchio then reads its triangles, in one colour
        return []
    joined: list[tuple[Any, Any]] = [(color, trimesh.util.concatenate(own)) for color, own in found.items()]
    return [(np.array(m.vertices), np.array(m.faces, dtype=np.int64), (c[0], c[1], c[2])) for c, m in joined]


def _triangles(shape: Any) -> tuple[Array, NDArray[np.int64]]:
    """Vertices and faces of a shape of Coal."""
    import coal
    from trimesh import creation

    if isinstance(shape, coal.BVHModelBase):
        faces = [[triangle[0], triangle[1], triangle[2]] for triangle in map(shape.tri_indices, range(shape.num_tris))]
        return np.array(shape.vertices(), dtype=np.float64), np.array(faces, dtype=np.int64)
    if isinstance(shape, coal.Box):
        mesh = creation.box(2.0 * np.array(shape.halfSide))
    elif isinstance(shape, coal.Sphere):
        mesh = creation.icosphere(subdivisions=2, radius=shape.radius)
    elif isinstance(shape, coal.Cylinder):
        mesh = creation.cylinder(shape.radius, 2.0 * shape.halfLength, sections=24)
    elif isinstance(shape, coal.Capsule):
        mesh = _capsule(shape.radius, 2.0 * shape.halfLength)
    elif isinstance(shape, coal.Ellipsoid):
        mesh = creation.icosphere(subdivisions=2)
        mesh.apply_scale(np.array(shape.radii))
    else:  # cones and other shapes: their bounding box
        shape.computeLocalAABB()
        box = shape.aabb_local
        mesh = creation.box(bounds=np.array([box.min_, box.max_]))
    return np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)


def _thinned(vertices: Array, faces: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """The mesh; if it is large, with all vertices in one cell of a grid merged into one."""
    if len(faces) <= MOST_TRIANGLES:
        return vertices, faces
    low = vertices.min(axis=0)
    cell = float((vertices.max(axis=0) - low).max()) / CELLS
    _, index, counts = np.unique(
        np.floor((vertices - low) / cell).astype(np.int64), axis=0, return_inverse=True, return_counts=True
    )
    index = index.ravel()
    centre = np.stack([np.bincount(index, vertices[:, i]) for i in range(3)], axis=1) / counts[:, None]
    kept = index[faces]
    distinct = (kept[:, 0] != kept[:, 1]) & (kept[:, 1] != kept[:, 2]) & (kept[:, 2] != kept[:, 0])
    return centre, np.unique(kept[distinct], axis=0)


def _capsule(radius: float, length: float) -> Any:
    """A capsule of Coal along z, its centre at the origin."""
    from trimesh import creation

    mesh = creation.capsule(length, radius, count=(12, 12))
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    return mesh


def _capsules(robot: PinocchioRobot) -> Iterator[Mesh]:
    """Capsules from each joint to its children, and to the tip."""
    model = robot.model
    ends = [
        (int(model.parents[i]), np.array(model.jointPlacements[i].translation))
        for i in range(2 if robot.base else 1, model.njoints)
    ]
    if robot.tip is not None:
        frame = model.frames[robot.frame_index(robot.tip)]
        ends.append((int(frame.parentJoint), np.array(frame.placement.translation)))
    radius = THICKNESS * max(1e-3, sum(float(np.linalg.norm(end)) for _, end in ends) / max(1, len(ends)) * 6.0)
    for joint, end in ends:
        length = float(np.linalg.norm(end))
        if length > SHORT:
            mesh = _capsule(radius, length)
            yield Mesh(joint, _along(np.array(mesh.vertices), end), np.array(mesh.faces, dtype=np.int64), LINK)


def _along(vertices: Array, end: Array) -> Array:
    """Vertices along z about the origin, moved to lie along the segment from the origin to `end`."""
    from ..base.rotations import perpendicular

    axis = end / np.linalg.norm(end)
    first, second = perpendicular(axis)
    return np.asarray(vertices @ np.stack([first, second, axis]) + 0.5 * end)
