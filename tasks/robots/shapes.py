"""Collision and visual shapes of a robot: those of its file, or given ones."""

from __future__ import annotations

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
        """The collision shapes, of its file unless some were given; meshes become their convex hulls.

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
        """The same robot with other collision shapes: any Pinocchio has, on joints of its model or of the world.

        Raises
        ------
        InvalidInput
            If it is no GeometryModel, has no shapes, or one is on no joint of the model or a mesh without volume.
        """
        from .geometry import checked_geometry

        other = copy(self)
        other._geometry = checked_geometry(self.model, geometry, repr(self))
        other._geometry_is_given = True
        return other

    def visuals(self) -> pin.GeometryModel:
        """The visual shapes of its file, read at the first use.

        Raises
        ------
        InvalidInput
            If there is no URDF file, or a mesh of it cannot be read.
        """
        if self._visuals is None:
            from .geometry import read_geometry

            self._visuals = read_geometry(self, "visual")
        return self._visuals
