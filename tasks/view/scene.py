"""The picture in the browser: the robot, and the targets of its tasks as gizmos that can be dragged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np

from ..base.checks import Array
from ..drawing.figure import Figure, Pose, figure
from ..drawing.stage import look
from .forces import ContactForces, has_forces
from .session import Session
from .targets import Target

if TYPE_CHECKING:
    import viser

#: Size of a gizmo, and of the axes of a target that moves by itself, relative to the size of the robot.
GIZMO, AXES = 0.14, 0.08
#: The corner of a label that is at its target, of one target after the other: those of neighbours lie apart.
CORNERS: tuple[Literal["top-left", "bottom-left", "top-right"], ...] = ("top-left", "bottom-left", "top-right")


class Overlay(Protocol):
    """Something else that is drawn with every picture, such as the forces of :mod:`tasks.view.forces`."""

    def put(self, server: viser.ViserServer, session: Session, figure: Figure) -> None:
        """Add it to the scene, once; ``figure.pose(frame)`` is where a frame of the robot is shown."""
        ...

    def show(self, session: Session) -> None:
        """Update it; called from the thread of the picture, which must not ask the robot for a state."""
        ...


class Scene:
    """The robot and its targets.

    Parameters
    ----------
    server : viser.ViserServer
    session : Session
    overlays : sequence of Overlay
        What else is drawn, in addition to the forces of contacts.
    """

    def __init__(self, server: viser.ViserServer, session: Session, overlays: Sequence[Overlay] = ()) -> None:
        self._server, self._session = server, session
        self.figure = figure(server, session.controller.robot)
        standing = has_forces(session.controller.stack, self.figure)
        self._overlays = (*overlays, ContactForces()) if standing else tuple(overlays)
        self.figure.move(session.q)
        look(server, self.figure.bounds, [self._place(target) for target in session.targets])
        size = float(np.linalg.norm(self.figure.bounds[1] - self.figure.bounds[0]))
        self._parents = {
            name: server.scene.add_frame(f"/relative/{i}", show_axes=False)
            for i, name in enumerate(dict.fromkeys(t.relative_to for t in session.targets))
            if name is not None
        }
        self.gizmos = [self._gizmo(target, i, size) for i, target in enumerate(session.targets)]
        #: Position and rotation of each target when it was last shown, or dragged.
        self._seen = [(target.p, target.R) for target in session.targets]
        #: Called whenever a target has moved, here or by another program.
        self.moved: Callable[[Target], None] = lambda target: None
        for overlay in self._overlays:
            overlay.put(server, session, self.figure)

    def _place(self, target: Target) -> Array:
        """Where a target is in the world [m], shape (3,)."""
        if target.relative_to is None:
            return target.p
        position, wxyz = self.figure.pose(target.relative_to)
        return np.asarray(position + _matrix(wxyz) @ target.p)

    def _gizmo(self, target: Target, number: int, size: float) -> Any:
        parent = self._parents.get(target.relative_to or "")
        name = f"/targets/{number}" if parent is None else f"{parent.name}/target{number}"
        position, wxyz = pose_of(target)
        if not target.draggable:
            gizmo: Any = self._server.scene.add_frame(
                name, axes_length=AXES * size, axes_radius=0.03 * AXES * size, position=position, wxyz=wxyz
            )
        else:
            gizmo = self._server.scene.add_transform_controls(
                name,
                scale=GIZMO * size,
                active_axes=target.free,
                disable_axes=target.point is None,
                disable_sliders=target.point is None,
                disable_rotations=target.turn is None,
                depth_test=False,
                position=position,
                wxyz=wxyz,
            )
            gizmo.on_update(self._dragging(target, number, gizmo))
        self._server.scene.add_label(f"{name}/label", target.name, anchor=CORNERS[number % len(CORNERS)])
        return gizmo

    def _dragging(self, target: Target, number: int, gizmo: Any) -> Callable[[Any], Any]:
        async def dragged(event: Any) -> None:  # the server has a single thread, so drags stay in order
            p, R = np.array(gizmo.position), _matrix(gizmo.wxyz)

            def move() -> None:
                target.move(p if target.point is not None else None, R if target.turn is not None else None)
                self._seen[number] = target.p, target.R
                self.moved(target)

            self._session.do(move)

        return dragged

    def put(self, target: Target) -> None:
        """Move the gizmo of a target to where the target is, as after it was typed."""
        number = self._session.targets.index(target)
        gizmo, self._seen[number] = self.gizmos[number], (target.p, target.R)
        gizmo.position, gizmo.wxyz = pose_of(target)

    def show(self) -> None:
        """Draw the robot at its present configuration, and the targets that have moved."""
        self.figure.move(self._session.q)
        for name, parent in self._parents.items():
            parent.position, parent.wxyz = self.figure.pose(name)
        for target, (p, R) in zip(self._session.targets, list(self._seen), strict=True):
            target.follow(self._session.motion.t)
            if not (np.array_equal(target.p, p) and np.array_equal(target.R, R)):  # moved, but not by a hand here
                self.put(target)
                self.moved(target)
        for overlay in self._overlays:
            overlay.show(self._session)


def pose_of(target: Target) -> Pose:
    """The pose of a target's gizmo: position, and quaternion (w, x, y, z)."""
    from viser.transforms import SO3

    w, x, y, z = SO3.from_matrix(target.R).wxyz
    return target.p, (float(w), float(x), float(y), float(z))


def _matrix(wxyz: Any) -> Any:
    from viser.transforms import SO3

    return SO3(np.array(wxyz) / np.linalg.norm(wxyz)).as_matrix()
