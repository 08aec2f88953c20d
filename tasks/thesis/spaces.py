"""Spaces of joint motions and of task motions, and the maps between them (Fig. 3.1 to 3.5).

A space is an oval around its zero, and a subspace a blade through that zero: two subspaces meet there
and nowhere else, and complements stand at right angles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Array
from .style import ACTUAL, ARM, COLUMN, ELLIPSE, LAST, MUTED, PAGE, SIZE, caption, paper, write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: What moves the task, what it leaves, what of the task cannot be moved, and what two tasks leave.
MOVES, LEAVES, LOST, REST = ACTUAL, LAST, MUTED, ELLIPSE
EMPTY = "#f4f5f7"
#: Half axes of an oval, and half length and half width of a blade [inch].
OVAL, BLADE, THIN = np.array([0.74, 0.76]), 0.66, 0.075
#: Of the two complements in a space [deg].
UP, DOWN = 72.0, -18.0
#: Where names stand beside the zero, which no map crosses: on the left of joints, on the right of tasks [inch].
LEFT_UP, LEFT_DOWN, RIGHT_UP, RIGHT_DOWN = (-0.18, 0.44), (-0.44, -0.1), (0.41, 0.38), (0.4, -0.34)


def draw_manipulable() -> Figure:
    """Fig. 3.1: all joint motions together make the manipulable space, and nothing else."""
    figure, axis = _canvas(2.4)
    joints, task = _two_spaces(axis, "#dfe7f5")
    reached = _blade(axis, task, UP, MOVES, "$R(J)$", RIGHT_UP)
    _blade(axis, task, DOWN, LOST, r"$R(J)^\perp$", RIGHT_DOWN)
    rim = np.array([_by(joints, 0.0, -OVAL[1]), _by(joints, 0.0, OVAL[1])])
    _band(axis, rim, reached, MOVES)
    _arrow(axis, _by(joints, 0.4, 0.4), _by(task, 0.05, 0.4), "$J$", MOVES)
    _words(axis, ("manipulable space $R(J)$, of dimension rank $J$", MOVES), (r"$R(J)^\perp$: cannot be moved", LOST))
    caption(figure, r"Figure 3.1: what $\delta r = J\,\delta\theta$ can be")
    return figure


def draw_redundant() -> Figure:
    """Fig. 3.2: joint motions that differ by a member of the redundant space make the same task motion."""
    figure, axis = _canvas(2.4)
    joints, task = _two_spaces(axis)
    left = _blade(axis, joints, DOWN, LEAVES, "$N(J)$", (-0.4, 0.34))
    _blade(axis, task, UP, MOVES, "$R(J)$", RIGHT_UP)
    _band(axis, left, np.array([task, task]), LEAVES)
    _arrow(axis, _by(joints, 0.7, -0.08), _by(task, -0.03, 0.01), "$J$", LEAVES, share=0.2)
    beside, made = _by(joints, -0.06, -0.42), task - 0.44 * _direction(UP)
    ends = beside + np.array([[-0.4], [0.46]]) * _direction(DOWN)
    axis.plot(*ends.T, color=LEAVES, lw=0.9, ls=(0, (4, 2)), zorder=3)
    for share, name, up in (-0.28, r"$\delta\theta^1$", 0.11), (0.28, r"$\delta\theta^2$", -0.11):
        place = beside + share * _direction(DOWN)
        _arrow(axis, place, made, "", MOVES)
        axis.plot(*place, "o", color=MOVES, ms=3.5, zorder=6)
        write(axis, _by(place, 0.0, up), name, MOVES)
    axis.plot(*made, "o", color=MOVES, ms=3.5, zorder=6)
    write(axis, _by(made, 0.15, -0.02), r"$\delta r$", MOVES)
    _words(
        axis,
        (r"redundant space $N(J)$, of dimension $n$ − rank $J$", LEAVES),
        (r"$J(\delta\theta^1 - \delta\theta^2) = 0$: both make the same $\delta r$", MOVES),
    )
    caption(figure, r"Figure 3.2: what $J$ takes to zero")
    return figure


def draw_mapping() -> Figure:
    """Fig. 3.3: J takes the complement of its null space onto its range, one to one, and the null space to zero."""
    figure, axis = _canvas(2.4)
    joints, task = _two_spaces(axis)
    moving = _blade(axis, joints, UP, MOVES, r"$N(J)^\perp$", LEFT_UP)
    left = _blade(axis, joints, DOWN, LEAVES, "$N(J)$", LEFT_DOWN)
    reached = _blade(axis, task, UP, MOVES, "$R(J)$", RIGHT_UP)
    _blade(axis, task, DOWN, LOST, r"$R(J)^\perp$", RIGHT_DOWN)
    _band(axis, moving, reached, MOVES)
    _band(axis, left, np.array([task, task]), LEAVES)
    _arrow(axis, _by(joints, 0.36, 0.42), _by(task, 0.06, 0.42), "$J$", MOVES)
    _arrow(axis, _by(joints, 0.7, -0.08), _by(task, -0.03, 0.01), "$J$", LEAVES, share=0.2)
    _words(axis, ("one to one onto the manipulable space", MOVES), ("the redundant space to zero", LEAVES))
    caption(figure, r"Figure 3.3: $\dim R(J) + \dim N(J) = n$")
    return figure


def draw_pseudoinverse() -> Figure:
    """Fig. 3.4: the pseudoinverse maps the range back, and its orthogonal complement to zero."""
    figure, axis = _canvas(2.4)
    joints, task = _two_spaces(axis)
    moving = _blade(axis, joints, UP, MOVES, r"$R(J^{\#})$", LEFT_UP)
    _blade(axis, joints, DOWN, LEAVES, r"$R(J^{\#})^\perp$", LEFT_DOWN)
    reached = _blade(axis, task, UP, MOVES, r"$N(J^{\#})^\perp$", _by(np.array(RIGHT_UP), 0.03, -0.04))
    lost = _blade(axis, task, DOWN, LOST, r"$N(J^{\#})$", RIGHT_DOWN)
    _band(axis, moving, reached, MOVES)
    _band(axis, np.array([joints, joints]), lost, LOST)
    _arrow(axis, _by(task, 0.06, 0.42), _by(joints, 0.3, 0.42), r"$J^{\#}$", MOVES)
    _arrow(axis, _by(task, -0.7, 0.08), _by(joints, 0.03, 0.01), r"$J^{\#}$", LOST)
    _words(
        axis,
        (r"$R(J^{\#}) = N(J)^\perp$ and $N(J^{\#})^\perp = R(J)$, one to one", MOVES),
        (r"$N(J^{\#}) = R(J)^\perp$ to zero", LOST),
    )
    caption(figure, r"Figure 3.4: the way back by the pseudoinverse $J^{\#}$")
    return figure


def draw_priority() -> Figure:
    """Fig. 3.5: the joint motions that the first task uses, those that the second can use, and those that remain."""
    from matplotlib.patches import Ellipse

    figure, axis = _canvas(2.7, PAGE)
    first, joints, second = (np.array([x, 1.66]) for x in (1.0, PAGE / 2, PAGE - 1.0))
    for zero, name in (first, r"$\dot r_1$"), (joints, r"$\dot\theta$"), (second, r"$\dot r_2$"):
        _space(axis, zero, name)
    moved = _blade(axis, first, 90.0, MOVES, "$R(J_1)$", (-0.38, 0.3))
    a = _blade(axis, joints, 90.0, MOVES, "$A$", (0.15, 0.58))
    b = _blade(axis, joints, 30.0, LEAVES, "$B$", (0.45, 0.42))
    c = _blade(axis, joints, -30.0, REST, "$C$", (0.45, -0.42))
    axis.add_patch(
        Ellipse((second[0], second[1]), 1.3, 1.16, facecolor=MOVES, edgecolor=MOVES, alpha=0.12, lw=1.0, zorder=1.5)
    )
    write(axis, _by(second, 0.24, -0.4), "$R(J_2)$", MOVES)
    freed = _blade(axis, second, 30.0, LEAVES, r"$R(\hat{J}_2)$", (-0.03, 0.22), 0.6)
    _band(axis, moved, a, MOVES)
    _band(axis, b, freed, LEAVES)
    _arrow(axis, _by(joints, -0.1, 0.5), _by(first, 0.12, 0.5), "$J_1$", MOVES)
    _arrow(axis, _by(joints, 0.72, 0.1), _by(second, -0.3, 0.1), "$J_2$", LEAVES)
    _arrow(axis, _by(joints, 0.05, -0.56), _by(second, -0.3, -0.46), "$J_2$", MOVES, dashed=True)
    _arrow(axis, b[0], first, "$J_1$", LEAVES, dashed=True)
    _arrow(axis, c[1], first, "$J_1$", REST, dashed=True)
    _arrow(axis, c[0], second, "$J_2$", REST, dashed=True)
    _words(
        axis,
        (r"$A = N(J_1)^\perp$: what moves the first task, and the second with it", MOVES),
        (r"$B = N(\hat{J}_2)^\perp$: what moves the second alone, onto $R(\hat{J}_2) = J_2 N(J_1)$", LEAVES),
        (r"$C = N(J_1) \cap N(J_2)$: what moves neither, free for a third", REST),
    )
    caption(figure, r"Figure 3.5: the first task takes $A$, the second $B$, and $C$ is left")
    return figure


def _canvas(height: float, width: float = COLUMN) -> tuple[Figure, Axes]:
    """A figure of a paper, and in it a plane in inches without a frame."""
    figure = paper(height, width)
    axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axis.set_xlim(0.0, width)
    axis.set_ylim(0.0, height)
    axis.axis("off")
    return figure, axis


def _two_spaces(axis: Axes, motions: str = EMPTY) -> tuple[Array, Array]:
    """Joint motions on the left, in a colour if all of them are meant, task motions on the right: their zeros."""
    joints, task = np.array([0.82, 1.46]), np.array([2.58, 1.46])
    _space(axis, joints, r"$\delta\theta \in \mathbb{R}^n$", motions)
    _space(axis, task, r"$\delta r \in \mathbb{R}^m$")
    return joints, task


def _space(axis: Axes, zero: Array, name: str, color: str = EMPTY) -> None:
    """An oval around a zero, with a name above; in a colour it covers what leads away from it."""
    from matplotlib.patches import Ellipse

    wide, high = OVAL
    above = 1.0 if color == EMPTY else 2.5
    oval = Ellipse((zero[0], zero[1]), 2 * wide, 2 * high, facecolor=color, edgecolor=MUTED, lw=0.9, zorder=above)
    axis.add_patch(oval)
    write(axis, _by(zero, 0.0, high + 0.04), name, va="bottom")
    axis.plot(*zero, "o", color=ARM, ms=3.5, zorder=7)


def _blade(axis: Axes, zero: Array, turn: float, color: str, name: str, at: ArrayLike, half: float = BLADE) -> Array:
    """A subspace: a blade through the zero, turned by so many degrees, named beside; its lower and upper end."""
    from matplotlib.patches import Ellipse

    for look in {"facecolor": color, "alpha": 0.3, "lw": 0.0}, {"facecolor": "none", "edgecolor": color, "lw": 1.0}:
        axis.add_patch(Ellipse((zero[0], zero[1]), 2 * half, 2 * THIN, angle=turn, zorder=4, **look))
    write(axis, zero + np.asarray(at), name, color)
    end = half * _direction(turn)
    ends = np.array([zero - end, zero + end])
    return ends[np.argsort(ends[:, 1])]


def _by(zero: Array, right: float, up: float) -> Array:
    return np.asarray(zero + np.array([right, up]))


def _direction(turn: float) -> Array:
    return np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])


def _band(axis: Axes, left: Array, right: Array, color: str) -> None:
    """From a subspace to its image: the lower ends joined, and the upper ones."""
    from matplotlib.patches import Polygon

    axis.add_patch(
        Polygon(np.array([left[0], left[1], right[1], right[0]]), closed=True, color=color, alpha=0.12, lw=0, zorder=2)
    )
    for a, b in zip(left, right, strict=True):
        axis.plot(*np.array([a, b]).T, color=color, lw=0.7, alpha=0.7, zorder=2)


def _arrow(
    axis: Axes, start: Array, end: Array, name: str, color: str, *, share: float = 0.5, dashed: bool = False
) -> None:
    """A map, named above this share of its way."""
    from matplotlib.patches import FancyArrowPatch

    look: dict[str, Any] = {"lw": 0.8, "ls": (0, (4, 2))} if dashed else {"lw": 1.1}
    ends: dict[str, Any] = {"posA": start, "posB": end, "shrinkA": 0, "shrinkB": 3}
    axis.add_patch(FancyArrowPatch(**ends, arrowstyle="-|>", mutation_scale=8.0, color=color, zorder=5, **look))
    write(axis, _by(start + share * (end - start), 0.0, 0.03), name, color, va="bottom", fontsize=SIZE + 1)


def _words(axis: Axes, *lines: tuple[str, str]) -> None:
    """What the colours mean, line by line above the caption."""
    middle = float(np.mean(axis.get_xlim()))
    for k, (line, color) in enumerate(reversed(lines)):
        write(axis, (middle, 0.27 + 0.16 * k), line, color, va="bottom")
