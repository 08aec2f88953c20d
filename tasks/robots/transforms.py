"""Transforms between frames: the pose of one frame of a robot relative to another one or to the world."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from hqp.checks import of_type

from ..base.checks import Array
from ..base.rotations import about
from .frame import Frame


class Framed(Protocol):
    """An object with frames: a state."""

    def frame(self, name: str | None = None) -> Frame: ...


class Transforms:
    """A base of states: the transforms between their frames."""

    def transform(self: Framed, frame: str | None = None, relative_to: str | None = None) -> Array:
        """The pose of a frame: the matrix that takes its coordinates to those of the world, or of another frame.

        ``robot.at(q).transform("gripper", "base_link")``; the result can be a target of :class:`tasks.PoseTask`.

        Parameters
        ----------
        frame : str, optional
            Default: the tip.
        relative_to : str, optional
            The frame in whose coordinates the pose is given (default: the world).

        Returns
        -------
        array, shape (4, 4)
            Lengths in [m]; a planar arm turns about z.

        Raises
        ------
        InvalidInput
            If there is no such frame; the message lists the nearest names.
        """
        for what, name in ("frame", frame), ("relative_to", relative_to):
            if name is not None:
                of_type(name, str, f"transform: {what}")
        own = _matrix(self.frame(frame))
        if relative_to is None:
            return own
        root = _matrix(self.frame(relative_to))
        seen = np.eye(4)
        seen[:3, :3] = root[:3, :3].T @ own[:3, :3]
        seen[:3, 3] = root[:3, :3].T @ (own[:3, 3] - root[:3, 3])
        return seen


def _matrix(frame: Frame) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3] = about(2, float(frame.rotation[0])) if frame.rotation.ndim == 1 else frame.rotation
    matrix[:3, 3] = frame.position
    return matrix
