"""A robot on a stage: placed there once, then moved by its configuration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.robot import Robot, neutral, on_pinocchio
from ..robots.skeleton import skeleton
from .meshes import LINK, meshes_of

if TYPE_CHECKING:
    import viser

    from ..robots.pinocchio import PinocchioRobot

#: Path of the robot in the scene.
ROOT = "/robot"
#: Half a side of the box about a robot of which nothing can be drawn [m].
UNKNOWN = 0.5

#: Position [m], shape (3,), and unit quaternion (w, x, y, z): the form in which viser takes a pose.
Pose = tuple[Array, tuple[float, float, float, float]]


class Figure(Protocol):
    """A robot on a stage; `note` says how it is drawn, `bounds` are two corners of its box [m], shape (2, 3)."""

    note: str
    bounds: Array

    def move(self, q: Array) -> None:
        """Show it at a configuration, shape (nq,)."""
        ...

    def pose(self, frame: str) -> Pose:
        """The pose at which one of its frames is shown."""
        ...


def figure(server: viser.ViserServer, robot: Robot) -> Figure:
    """Put a robot on the stage: a Pinocchio robot by its meshes, any other as lines."""
    return MeshFigure(server, robot) if on_pinocchio(robot) else LineFigure(server, robot)


class MeshFigure:
    """The meshes of a Pinocchio robot: one viser frame per joint is moved, and the meshes are attached to it."""

    def __init__(self, server: viser.ViserServer, robot: PinocchioRobot) -> None:
        import pinocchio as pin

        self._server, self._robot, self._model = server, robot, robot.model
        self._data = robot.model.createData()  # separate: the robot's own data is in use by the controller
        meshes, self.note = meshes_of(robot)
        scene = server.scene
        self._frames: dict[int, Any] = {
            joint: scene.add_frame(f"{ROOT}/{joint}", show_axes=False) for joint in sorted({m.joint for m in meshes})
        }
        pin.forwardKinematics(self._model, self._data, robot.home)
        corners = []
        for number, mesh in enumerate(meshes):
            scene.add_mesh_simple(
                f"{ROOT}/{mesh.joint}/{number}",
                mesh.vertices.astype(np.float32),
                mesh.faces.astype(np.uint32),
                color=np.array([round(255 * part) for part in mesh.color]),
                opacity=None if mesh.opacity >= 1.0 else mesh.opacity,
                flat_shading=True,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )
            place = self._data.oMi[mesh.joint]
            points = mesh.vertices @ np.array(place.rotation).T + np.array(place.translation)
            corners += [points.min(axis=0), points.max(axis=0)]
        corners = corners or [np.full(3, -UNKNOWN), np.full(3, UNKNOWN)]
        self.bounds = np.array([np.min(corners, axis=0), np.max(corners, axis=0)])
        self.move(robot.home)

    def move(self, q: Array) -> None:
        import pinocchio as pin

        pin.forwardKinematics(self._model, self._data, q)
        with self._server.atomic():  # all joints move in one update
            for joint, frame in self._frames.items():
                frame.position, frame.wxyz = _pose(self._data.oMi[joint])

    def pose(self, frame: str) -> Pose:
        own = self._model.frames[self._robot.frame_index(frame)]
        return _pose(self._data.oMi[own.parentJoint] * own.placement)


class LineFigure:
    """The lines through the points of a robot; empty if the robot has no points."""

    def __init__(self, server: viser.ViserServer, robot: Robot) -> None:
        self._robot, self.note = robot, "drawn as lines: it has no shapes"
        lines = skeleton(robot, neutral(robot))
        reach = float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum())
        self.bounds = np.array([[-0.6, -0.6, 0.0], [0.6, 0.6, 0.1]]) * reach
        self._lines = server.scene.add_line_segments(
            f"{ROOT}/lines",
            lines.astype(np.float32),
            np.array([round(255 * part) for part in LINK]),
            thickness=8.0,
        )

    def move(self, q: Array) -> None:
        self._lines.points = skeleton(self._robot, q).astype(np.float32)

    def pose(self, frame: str) -> Pose:
        raise InvalidInput(f"{self._robot!r} is drawn as lines, which have no frame {frame!r}")


def _pose(T: Any) -> Pose:
    """Position and quaternion of an SE3."""
    import pinocchio as pin

    x, y, z, w = pin.SE3ToXYZQUAT(T)[3:]
    return np.array(T.translation), (w, x, y, z)
