"""Arms with their lengths and angles named (Fig. 2.1, 4.1)."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..base.checks import Array
from ..robots.manipulability import velocity_ellipse
from ..robots.planar import PlanarArm
from .style import ACTUAL, ARM, ELLIPSE, JOINTS, LAST, MUTED, SIZE, caption, paper, write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

THETA, PHI = JOINTS[0], LAST
#: Radii of the arcs [m]: of a joint angle, and of phi around it.
INNER, OUTER = 0.3, 0.56


def draw_three_links() -> Figure:
    """Fig. 4.1: three links, their joint angles, and the orientation phi of the last one."""
    arm = PlanarArm([1.0, 0.95, 0.85])
    q = np.radians([50.0, -62.0, 76.0])
    figure = paper(2.2)
    axis = _plane(figure, 0.0, 1.0, (-0.35, 2.55))
    points = arm.points(q)
    phi = float(np.sum(q))
    _arm(axis, points, q, LAST)
    wrist = points[-2]
    axis.plot(*np.array([wrist, wrist + np.array([OUTER + 0.16, 0.0])]).T, color=MUTED, lw=0.8, ls=(0, (4, 3)))
    _angle(axis, wrist, 0.0, phi, OUTER, r"$\varphi$", PHI)
    axis.annotate(
        r"$r_1 = (x, y)$", points[-1], (-6, 0), textcoords="offset points", ha="right", va="center", fontsize=SIZE
    )
    caption(figure, r"Figure 4.1: the last link stands at $r_2 = \varphi = \theta_1 + \theta_2 + \theta_3$")
    return figure


def draw_two_links() -> Figure:
    """Fig. 2.1: two links, the velocity-ratio ellipse of the hand, and Eq. 2.2 for every elbow angle."""
    arm = PlanarArm([1.0, 0.85])
    q = np.radians([33.0, 58.0])
    figure = paper(2.1)
    axis = _plane(figure, 0.0, 0.58, (-0.32, 1.8))
    points = arm.points(q)
    ellipse = velocity_ellipse(arm.jacobian(q)[:2])
    turn = np.linspace(0.0, 2.0 * np.pi, 97)
    outline = ellipse.directions @ (0.22 * ellipse.half_axes[:, None] * np.array([np.cos(turn), np.sin(turn)]))
    axis.plot(*(points[-1][:, None] + outline), color=ELLIPSE, lw=1.1)
    _arm(axis, points, q, ARM)
    axis.annotate("$(x, y)$", points[-1], (9, 9), textcoords="offset points", va="center", fontsize=SIZE)

    height = figure.get_figheight()
    measure = figure.add_axes((0.69, 0.62 / height, 0.28, (height - 0.9) / height))
    bends = np.linspace(-180.0, 180.0, 181)
    measure.plot(bends, np.abs(np.sin(np.radians(bends))), color=ACTUAL, lw=1.3)
    bend = float(np.degrees(q[1]))
    measure.plot(bend, np.sin(q[1]), "o", color=ELLIPSE, ms=4.5)
    measure.set_xlim(-180, 180)
    measure.set_ylim(0, 1.08)
    measure.set_xticks([-90, 0, 90], ["−90°", "0", "90°"])
    measure.set_yticks([0, 1])
    measure.tick_params(labelsize=SIZE, length=2.5, pad=2.0)
    measure.grid(alpha=0.2)
    measure.set_xlabel(r"$\theta_2$", fontsize=SIZE, labelpad=1.0)
    measure.set_title(r"$W / (l_1 l_2)$", fontsize=SIZE, pad=4.0)
    caption(figure, r"Figure 2.1: two links; $W = l_1 l_2 |\sin\theta_2|$ is largest at $\theta_2 = \pm 90°$")
    return figure


def _plane(figure: Figure, left: float, width: float, across: tuple[float, float]) -> Axes:
    """The plane without a frame, from a little below the base upwards, above the caption."""
    wide, high = figure.get_size_inches()
    bottom = 0.25
    axis = figure.add_axes((left, bottom / high, width, 1.0 - bottom / high))
    axis.set_xlim(*across)
    up = (across[1] - across[0]) * (high - bottom) / (wide * width)
    axis.set_ylim(-0.2, up - 0.2)
    axis.set_aspect("equal")
    axis.axis("off")
    return axis


def _arm(axis: Axes, points: Array, q: Array, last: str) -> None:
    """The frame of the plane, the links with their lengths, the last one in its colour, and the joint angles."""
    arrow = {"arrowstyle": "-|>", "color": MUTED, "lw": 0.9, "shrinkA": 0.0, "shrinkB": 0.0}
    for tip, name, side in ((0.72, 0.0), "$x$", (0.0, -0.1)), ((0.0, 0.72), "$y$", (-0.1, 0.0)):
        axis.annotate("", tip, (0.0, 0.0), arrowprops=arrow)
        write(axis, np.add(tip, side), name, MUTED)
    heading = np.cumsum(q)
    for k, (start, end) in enumerate(pairwise(points)):
        color = last if k == len(q) - 1 else ARM
        axis.plot(*np.array([start, end]).T, color=color, lw=3.6, solid_capstyle="round", zorder=4)
        along = (end - start) / np.linalg.norm(end - start)
        beside = (start + end) / 2.0 + np.sign(q[k]) * 0.13 * np.array([-along[1], along[0]])  # where the arc is not
        write(axis, beside, f"$l_{k + 1}$")
        before = heading[k] - q[k]
        if k:
            onward = start + (INNER + 0.16) * np.array([np.cos(before), np.sin(before)])
            axis.plot(*np.array([start, onward]).T, color=MUTED, lw=0.8, ls=(0, (4, 3)))
        _angle(axis, start, before, heading[k], INNER, rf"$\theta_{k + 1}$", THETA)
    axis.plot(*points[1:-1].T, "o", color=ARM, ms=6.5, mec="white", mew=1.0, zorder=5)
    axis.plot(*points[-1], "o", color=last, ms=5.0, zorder=5)
    axis.plot(0, 0, "s", color=ARM, ms=8.5, zorder=5)


def _angle(axis: Axes, centre: Array, start: float, end: float, radius: float, name: str, color: str) -> None:
    """An arc from one direction [rad] to another, with a head at its end and its name beside it."""
    from matplotlib.patches import FancyArrowPatch
    from matplotlib.path import Path

    turn = np.linspace(start, end, 41)
    arc = centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    axis.add_patch(FancyArrowPatch(path=Path(arc), arrowstyle="-|>", mutation_scale=7.0, color=color, lw=1.1, zorder=6))
    middle = (start + end) / 2.0
    place = centre + (radius + 0.11) * np.array([np.cos(middle), np.sin(middle)])
    write(axis, place, name, color, fontsize=SIZE + 1)
