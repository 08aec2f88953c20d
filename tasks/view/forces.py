"""Draws the forces of contacts as arrows, and the support polygon."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import Array
from ..contacts.contact import Contact
from ..control.contacts import GRAVITY, has_dynamics
from ..control.step import Step
from ..drawing.figure import Figure, MeshFigure
from ..rows.part import Stack
from .session import Session

if TYPE_CHECKING:
    import viser

#: Length of the arrow of a force equal to the robot's weight, relative to the robot's size; and the smallest force that
#: has an arrow, relative to the weight.
LENGTH, LEAST = 1.5, 1e-3
#: Thickness of arrows and of the polygon, relative to the size of the robot.
SHAFT, EDGE = 0.003, 0.003
#: Colours (r, g, b).
FORCE, SUPPORT = (230, 120, 30), (60, 160, 90)
NO_LINES = np.zeros((1, 2, 3))


def has_forces(stack: Stack, figure: Figure) -> bool:
    """Whether contacts of this stack have forces, and the figure has the frames at which they act."""
    return has_dynamics(stack) and any(isinstance(part, Contact) for part in stack) and isinstance(figure, MeshFigure)


class ContactForces:
    """Arrows for the commanded force of the last tick at each point of the contacts, and the support polygon.

    The polygon encloses the points of all contacts with forces, seen from above. A contact with one wrench has one
    arrow, at its centre of pressure.
    """

    def put(self, server: viser.ViserServer, session: Session, figure: Figure) -> None:
        """Add arrows and polygon to the scene, once; the arrows are scaled by the size and the weight of the robot."""
        robot: Any = session.motion.controller.robot
        size = float(np.linalg.norm(figure.bounds[1] - figure.bounds[0]))
        self._figure, self._weight = figure, GRAVITY * sum(inertia.mass for inertia in robot.model.inertias)
        self._scale = LENGTH * size / self._weight
        self._contacts = [part for part in session.motion.controller.stack if isinstance(part, Contact)]
        self._arrows = server.scene.add_arrows(
            "/contacts/forces", NO_LINES, FORCE, shaft_radius=SHAFT * size, head_radius=2.5 * SHAFT * size,
            head_length=6.0 * SHAFT * size, visible=False,
        )  # fmt: skip
        self._polygon = server.scene.add_line_segments(
            "/contacts/support", NO_LINES, SUPPORT, thickness=EDGE * size, visible=False
        )

    def show(self, session: Session) -> None:
        """Draw the forces of the last tick."""
        step = session.motion.step
        acting, points = [], []
        if step is not None and step.ok:
            for contact in self._contacts:
                at, forces = self._of(contact, step)
                bear = np.linalg.norm(forces, axis=1) > LEAST * self._weight
                acting += [np.stack([p, p + self._scale * f]) for p, f in zip(at[bear], forces[bear], strict=True)]
                if bear.any():
                    points.append(self._touching(contact))
        _draw(self._arrows, np.array(acting))
        _draw(self._polygon, around(np.concatenate(points)) if points else np.zeros(0))

    def _of(self, contact: Contact, step: Step[Any, Any, Any]) -> tuple[Array, Array]:
        """The points at which the forces of a contact act, and the forces, (k, 3) each, along the axes of the world."""
        if step.forces is None or step.cop is None or contact.name not in step.forces:
            return np.zeros((0, 3)), np.zeros((0, 3))
        forces = step.forces[contact.name]
        if forces.ndim == 2:
            return self._touching(contact), forces
        where = step.cop[contact.name]
        pressed = bool(np.isfinite(where).all())
        return self._in_world(contact, where[None]), forces[None, :3] if pressed else np.zeros((1, 3))

    def _touching(self, contact: Contact) -> Array:
        return self._in_world(contact, contact.shape.points) - (contact.radius or 0.0) * contact.normal

    def _in_world(self, contact: Contact, points: Array) -> Array:
        from viser.transforms import SO3

        position, wxyz = self._figure.pose(contact.frame)
        return np.asarray(position + points @ SO3(np.array(wxyz)).as_matrix().T)


def around(points: Array) -> Array:
    """The edges of the convex polygon around points (k, 3), seen from above, shape (edges, 2, 3); none without area."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        corners = points[ConvexHull(points[:, :2]).vertices]
    except (QhullError, ValueError):
        return np.zeros((0, 2, 3))
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def _draw(lines: Any, ends: Array) -> None:
    """Show lines with these ends, shape (k, 2, 3); hide them if there are none."""
    if len(ends):
        lines.points = ends
    lines.visible = len(ends) > 0
