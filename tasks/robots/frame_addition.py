"""Frames that a file does not name: a tool, the point of a foot."""

from __future__ import annotations

from copy import copy
from typing import Self

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.checks import finite
from ..base.rotations import rotation_matrix
from .keeping import Recipe
from .pinocchio_model import PinocchioModel
from .verification import verify


class Framed(PinocchioModel):
    """A base of :class:`tasks.PinocchioRobot`."""

    recipe: Recipe | None

    def with_frame(
        self, name: str, *, on: str, at: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None
    ) -> Self:
        """The same robot with one frame more, such as a tool, or the point of a foot that is only a shape in its file.

        Parameters
        ----------
        name : str
            Of the new frame.
        on : str
            The frame with which it moves.
        at : array, shape (3,)
            Where it is, in the coordinates of that frame [m].
        rotation : array, shape (3, 3), optional
            Its axes in the coordinates of that frame (default: the same).

        Raises
        ------
        InvalidInput
            If the robot has a frame of that name, or has no frame `on`, or a number is invalid.

        Examples
        --------
        >>> from tasks import load_robot
        >>> robot = load_robot("go2").with_frame("toe", on="FL_calf", at=(0.0, 0.0, -0.213))
        >>> robot.at(robot.home).frame("toe").position.round(3)
        array([0.193, 0.142, 0.022])
        """
        what = f"{self!r}: with_frame"
        place = finite(at, f"{what}: at")
        if place.shape != (3,):
            raise InvalidInput(f"{what}: at has shape {place.shape}; it must be (3,), in m")
        axes = np.eye(3) if rotation is None else rotation_matrix(rotation, f"{what}: rotation")
        if self.has_frame(of_type(name, str, f"{what}: name")):
            raise InvalidInput(f"{what}: {name!r} is a frame of the robot already")
        carrier = self.model.frames[self.frame_index(of_type(on, str, f"{what}: on"))]

        def extended(model: pin.Model) -> pin.Model:
            own = pin.Model(model)
            index = own.getFrameId(carrier.name, carrier.type)
            frame = own.frames[index]
            placed = frame.placement * pin.SE3(axes, place)
            own.addFrame(pin.Frame(name, frame.parentJoint, index, placed, pin.FrameType.OP_FRAME))
            return own

        model, other = extended(self.model), copy(self)
        verify(model, what)
        other.change_model(model)
        if self.recipe is not None:
            other.recipe = Recipe(extended(self.recipe.untied), self.recipe.ties)
        return other
