"""Converts frames to blocks of numbers for loops, and back; the layout is in :mod:`tasks.robots.kernels.block`."""

from __future__ import annotations

import numpy as np

from ..base.checks import Array
from .frame import FixedFrame, Frame
from .kernels import block as at


def fill(block: Array, frame: Frame, v: Array, drifts: bool) -> None:
    """Write the numbers of a frame into its block.

    Parameters
    ----------
    block : array
    frame : Frame
    v : array, shape (nv,)
        Joint velocities.
    drifts : bool
        Whether drifts and velocities are written too.
    """
    n = len(v)
    J = block[at.JACOBIAN :].reshape(6, n)
    block[:3], J[:3], J[3:] = frame.position, frame.linear, frame.angular
    rotation = frame.rotation
    if rotation.ndim == 1:
        angle = float(rotation[0])
        c, s = np.cos(angle), np.sin(angle)
        block[at.ANGLE], block[at.PLANAR] = angle, 1.0
        block[at.ROTATION : at.ROTATION + 9] = c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0
    else:
        block[at.ROTATION : at.ROTATION + 9] = rotation.ravel()
    if drifts:
        block[at.LINEAR_DRIFT : at.LINEAR_DRIFT + 3] = frame.linear_drift
        block[at.ANGULAR_DRIFT : at.ANGULAR_DRIFT + 3] = frame.angular_drift
        block[at.LINEAR_VELOCITY : at.LINEAR_VELOCITY + 6] = J @ v


def told_by(block: Array) -> FixedFrame:
    """The frame in a block that loops have written, drifts included; its arrays are views of the block."""
    J = block[at.JACOBIAN :].reshape(6, -1)
    drift = block[at.LINEAR_DRIFT : at.LINEAR_DRIFT + 6]
    planar = block[at.PLANAR] != 0.0
    rotation = block[at.ANGLE : at.ANGLE + 1] if planar else block[at.ROTATION : at.ROTATION + 9].reshape(3, 3)
    return FixedFrame(block[:3], rotation, J[:3], J[3:], drift[:3], drift[3:])


def relative(root: Frame, frame: Frame, v: Array) -> FixedFrame:
    """`frame` relative to a moving `root`, in its axes; see :func:`tasks.robots.kernels.frames.relative_frame`."""
    from ..base.loops import Call
    from .kernels.frames import relative_frame

    n = len(v)
    first, second, seen = np.zeros((3, at.size(n)))
    fill(first, root, v, True)
    fill(second, frame, v, True)
    Call(relative_frame, n, seen, np.ones(1, dtype=np.int64), first, second).run()
    return told_by(seen)
