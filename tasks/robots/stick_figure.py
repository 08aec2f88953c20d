"""A robot as a stick figure in space: a line from the origin of each joint to that of its parent."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hqp.files.names import PICTURE, check_name

from ..base.checks import Array
from .skeleton import skeleton

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d.axes3d import Axes3D

    from .pinocchio import PinocchioRobot

LINK, JOINT, SHADOW, TARGET = "#33475b", "#e8743b", "#c9d1d9", "#7a3fb0"
AXES = ("#d62728", "#2ca02c", "#1f77b4")
#: Length of the axes of a frame, and margin around the robot, relative to the size of the picture.
TRIAD, MARGIN = 0.12, 0.08


def stick_figure(
    path: Path,
    robot: PinocchioRobot,
    q: Array,
    *,
    frame: str | None = None,
    position: Array | None = None,
    rotation: Array | None = None,
) -> None:
    """Draw a robot, one of its frames and the target of that frame into a picture.

    Parameters
    ----------
    path : Path
        The picture, called .png.
    robot : PinocchioRobot
    q : array, shape (nq,)
    frame : str, optional
        The frame whose axes are drawn (default: the tip).
    position : array, shape (3,), optional
        The target [m].
    rotation : array, shape (3, 3), optional
        Its axes.

    Raises
    ------
    InvalidInput
        If the file is called otherwise.
    """
    check_name(path, *PICTURE)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    own = robot.at(q, np.zeros(robot.nv)).frame(frame)
    lines = skeleton(robot, q, frames=() if frame is None else (frame,))
    joints = np.unique(lines.reshape(-1, 3), axis=0)
    points = np.concatenate(
        [joints, own.position[None], np.zeros((1, 3)), *([] if position is None else [position[None]])]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    low[2] = min(low[2], 0.0)
    size = float((high - low).max())

    figure = Figure(figsize=(7.0, 7.0), dpi=130)
    FigureCanvasAgg(figure)
    axes: Axes3D = figure.add_subplot(projection="3d")
    for line in lines:
        axes.plot(line[:, 0], line[:, 1], np.full(2, low[2]), color=SHADOW, linewidth=3.0, zorder=1)
    for line in lines:
        axes.plot(*line.T, color=LINK, linewidth=4.0, solid_capstyle="round")
    axes.scatter(*joints.T, color=JOINT, s=36.0, depthshade=False, edgecolors="white", linewidths=0.8, zorder=5)
    _triad(axes, own.position, own.rotation, TRIAD * size)
    if position is not None:
        axes.scatter(*position, color=TARGET, s=90.0, marker="x", linewidths=2.0, depthshade=False, label="target")
        if rotation is not None:
            _triad(axes, position, rotation, 1.6 * TRIAD * size, linestyle=":")
        off = float(np.linalg.norm(position - own.position))
        if off > 0.01 * size:
            axes.plot(*np.array([own.position, position]).T, color=TARGET, linewidth=1.2, linestyle="--")
        axes.legend(loc="upper right", frameon=False)
    _frame_view(axes, low, high, size)
    name = robot.tip if frame is None else frame
    axes.set_title(f"{robot.name}: {name}", fontsize=11)
    figure.savefig(path, format="png", bbox_inches="tight")


def _triad(axes: Axes3D, origin: Array, rotation: Array, length: float, linestyle: str = "-") -> None:
    for axis, color in zip(rotation.T, AXES, strict=True):
        end = origin + length * axis
        axes.plot(*np.array([origin, end]).T, color=color, linewidth=2.0, linestyle=linestyle, zorder=6)


def _frame_view(axes: Axes3D, low: Array, high: Array, size: float) -> None:
    """A cube around the robot, the same scale along all axes, with a floor."""
    centre = 0.5 * (low + high)
    half = (0.5 + MARGIN) * size
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.set_xlim(centre[0] - half, centre[0] + half)
    axes.set_ylim(centre[1] - half, centre[1] + half)
    axes.set_zlim(low[2], low[2] + 2.0 * half)
    axes.set_box_aspect((1.0, 1.0, 1.0))
    axes.view_init(elev=20.0, azim=-55.0)
    for axis in axes.xaxis, axes.yaxis, axes.zaxis:
        axis.set_pane_color((0.97, 0.98, 0.99, 1.0))
    axes.grid(alpha=0.3)
