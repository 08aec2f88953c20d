"""Collision and visual shapes of a robot: those of its file, or given ones."""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy
from typing import Self

import pinocchio as pin


class Shaped:
    """A base of :class:`tasks.PinocchioRobot`."""

    model: pin.Model
    _geometry: pin.GeometryModel | None = None
    _geometry_is_given = False
    _visuals: pin.GeometryModel | None = None

    def geometry(self) -> pin.GeometryModel:
        """The collision shapes: those given, else those of its file; meshes become their convex hulls.

        Raises
        ------
        InvalidInput
            If there is no file, or a shape of it cannot be read.
        """
        if self._geometry is None:
            from .geometry import read_geometry

            self._geometry = read_geometry(self, "collision")
        return self._geometry

    def with_geometry(self, geometry: pin.GeometryModel) -> Self:
        """The same robot with other collision shapes: any shape of Pinocchio, on joints of its model or on the world.

        Raises
        ------
        InvalidInput
            If it is not a GeometryModel, has no shapes, or a shape is on no joint of the model or is a flat mesh.
        """
        from .geometry import checked_geometry

        other = copy(self)
        other._geometry = checked_geometry(self.model, geometry, repr(self))
        other._geometry_is_given = True
        return other

    def with_capsules(self, bodies: Iterable[str] | None = None) -> Self:
        """The same robot with one capsule per body, the smallest that contains all its collision shapes.

        Capsules are round, so that nearest points do not jump, and fast; they are larger than the shapes they contain.

        Parameters
        ----------
        bodies : iterable of str, optional
            Frames of the bodies that become capsules; others keep their shapes (default: all bodies that have shapes).

        Raises
        ------
        InvalidInput
            If there are no shapes, a frame carries none, or a shape is unbounded, such as a plane.
        """
        from .capsules import capsule_geometry
        from .geometry import bodies_with_shapes

        asked = bodies_with_shapes(self, bodies, f"{self!r}: with_capsules")
        return self.with_geometry(capsule_geometry(self.model, self.geometry(), asked))

    def visuals(self) -> pin.GeometryModel:
        """The visual shapes of its file, read at the first use.

        Raises
        ------
        InvalidInput
            If there is no file, or a mesh of it cannot be read.
        """
        if self._visuals is None:
            from .geometry import read_geometry

            self._visuals = read_geometry(self, "visual")
        return self._visuals
