"""Three pictures of ideas: the argument for a QP, priorities exchanged, and what position alone can reach."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

import hqp

from .._checks import Array
from ..motion.record import Record
from ..robots.planar import PlanarArm
from .figures import (
    ACTUAL,
    ARM,
    DESIRED,
    JOINTS,
    MUTED,
    common_view,
    desired_path,
    draw_arm,
    draw_joints,
    draw_phi,
    draw_time,
    grid,
    speed_range,
    summary,
)
from .findings import measure
from .laws import DAMPED, LIMITS, STRICT, SWAPPED, THESIS, Law
from .runs import Job, tip_error
from .scenarios import MINUTE, scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The figure of the text that all three start from: links 0.5 0.5 0.5, the straight line, phi = 0.
FIGURE = "4.3"


@dataclass(frozen=True)
class Idea:
    """A picture beside those of the text.

    Attributes
    ----------
    name : str
        Of its file, and for ``hqp thesis --figure``.
    laws : tuple of Law
        The runs of :data:`FIGURE` that it shows.
    draw : callable
        Jobs and their records -> figure.
    """

    name: str
    laws: tuple[Law, ...]
    draw: Callable[[Mapping[Job, Record]], Figure]

    def jobs(self, backend: str) -> list[Job]:
        """What to simulate for it; none if the backend cannot show one of them."""
        info = hqp.backend_info(backend)
        if any(law.refusal(info) for law in self.laws):
            return []
        return [Job(scenario(FIGURE), law, backend) for law in self.laws]


def reach(lengths: ArrayLike) -> tuple[float, float]:
    """Inner and outer radius of what the tip of such a chain can reach [m], in any orientation.

    The outer one is the stretched chain; the chain can fold back onto its base unless one link is
    longer than all others together.
    """
    given = np.asarray(lengths, dtype=float)
    total = float(given.sum())
    return max(0.0, 2.0 * float(given.max(initial=0.0)) - total), total


def reach_at(arm: PlanarArm, phi: float) -> tuple[Array, float, float]:
    """What the tip can reach while the last link stands at phi: centre [m], inner and outer radius [m] of a ring.

    The wrist, where the last link begins, reaches a ring about the base; the last link shifts it.
    """
    return arm.lengths[-1] * np.array([np.cos(phi), np.sin(phi)]), *reach(arm.lengths[:-1])


def draw_argument(runs: Mapping[Job, Record]) -> Figure:
    """Eq. 4.8, Eq. 3.17, and the QP with limits, undamped and damped, on the same motion."""
    titles = {
        THESIS.key: "Eq. 4.8: projected motion",
        STRICT.key: "Eq. 3.17: strict priority",
        LIMITS.key: "QP stack: limits on top",
        DAMPED.key: "QP stack: limits, damped",
    }
    heads = {job: titles[job.law.key] for job in runs}
    figure = _columns(runs, heads)
    figure.text(
        0.5, 0.985, "Position before orientation: links 0.5 0.5 0.5 m, tip along the red line, φ = 0°",
        ha="center", va="top", fontsize=14, fontweight="bold",
    )  # fmt: skip
    return figure


def draw_priorities(runs: Mapping[Job, Record]) -> Figure:
    """Position before orientation, and the other way round: one ``>>`` exchanged (section 1.2)."""
    orders = {SWAPPED.key: "orientation >> position", DAMPED.key: "position >> orientation"}
    heads = {job: orders[job.law.key] for job in runs}
    figure = _columns(runs, heads)
    figure.text(
        0.5, 0.985, "One >> exchanged: what is lost where both cannot be met", ha="center", va="top",
        fontsize=14, fontweight="bold",
    )  # fmt: skip
    return figure


def draw_workspace(runs: Mapping[Job, Record]) -> Figure:
    """The reachable workspace of position alone against those with phi fixed (section 3.6)."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Annulus

    item = scenario(FIGURE)
    arm = item.arm
    figure = Figure(figsize=(8.2, 8.6), layout="constrained")
    axis = figure.subplots()
    inner, outer = reach(arm.lengths)
    regions = [(np.zeros(2), inner, outer, MUTED, "position alone, φ free")]
    for phi, color in ((0.0, JOINTS[2]), (np.pi / 2, JOINTS[1])):
        centre, low, high = reach_at(arm, phi)
        regions.append((centre, low, high, color, f"with φ = {np.degrees(phi):.0f}°"))
    for centre, low, high, color, name in regions:
        label = f"{name}: {np.pi * (high**2 - low**2):.1f} m²"
        place = (float(centre[0]), float(centre[1]))
        axis.add_patch(Annulus(place, high, high - low, color=color, alpha=0.22, lw=0))
        axis.add_patch(Annulus(place, high, high - low, fill=False, color=color, lw=1.8, label=label))
    path = desired_path(item)
    axis.plot(*path.T, color=DESIRED, lw=4.0, alpha=0.7, solid_capstyle="round", label="line of figures 4.2 to 4.5")
    centre, _, high = reach_at(arm, 0.0)
    lost = path[np.linalg.norm(path - centre, axis=1) > high][0]
    axis.annotate(
        f"from here on φ = 0° is\nout of reach: y = {lost[1]:.2f} m", lost, (0.72, 1.36), color=DESIRED, fontsize=9,
        arrowprops={"arrowstyle": "->", "color": DESIRED},
    )  # fmt: skip
    for q in item.q0, _stretched(arm, lost, 0.0):
        points = arm.points(q)
        axis.plot(*points.T, "o-", color=ARM, lw=2.0, ms=4.0, mec="white")
    axis.plot(0, 0, "s", color=ARM, ms=8)
    axis.set_aspect("equal")
    axis.set_xlim(-outer - 0.1, outer + 0.1)
    axis.set_ylim(-outer - 0.1, outer + 0.1)
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    axis.grid(alpha=0.15)
    axis.legend(loc="lower left", fontsize=9, framealpha=0.95)
    axis.set_title("What position alone can reach, links 0.5 0.5 0.5 m", fontsize=13, fontweight="bold")
    return figure


def _stretched(arm: PlanarArm, tip: Array, phi: float) -> Sequence[float]:
    """Joint angles [rad] of three links whose wrist is stretched out to the tip's place at phi."""
    x, y = tip - arm.lengths[-1] * np.array([np.cos(phi), np.sin(phi)])
    return float(np.arctan2(y, x)), 0.0, phi - float(np.arctan2(y, x))


def _columns(runs: Mapping[Job, Record], heads: Mapping[Job, str]) -> Figure:
    """A column a run: the arm, the errors, the joint speeds and accelerations."""
    item = scenario(FIGURE)
    figure, axes = grid([2.5, 0.9, 0.9, 0.9, 0.9], len(runs), column=3.6, height=10.4, top=0.88, bottom=0.055)
    for column, (job, record) in zip(axes.T, runs.items(), strict=True):
        arm, tip, phi, speed, acceleration = column
        arm.set_title(f"{heads[job]}\n\n", fontsize=12, fontweight="bold")
        found = measure(job, record)
        lines = f"joints turn at up to {found.peak_speed:.0f} rad/min\n{summary(found)}"
        arm.text(0.5, 1.015, lines, transform=arm.transAxes, ha="center", color=MUTED, fontsize=9)
        draw_arm(arm, item, record)
        tip.semilogy(record.t / MINUTE, np.maximum(1e3 * tip_error(record), 1e-3), color=ACTUAL)
        draw_phi(phi, item, record)
        draw_joints(speed, record.t, record.v * MINUTE)
        draw_joints(acceleration, record.t[:-1], record.a * MINUTE**2)
        if job.law.inequalities:
            for side in -1, 1:
                speed.axhline(side * item.velocity_limit * MINUTE, color=MUTED, ls="--", lw=1.0)
                acceleration.axhline(side * item.acceleration_limit * MINUTE**2, color=MUTED, ls="--", lw=1.0)
        for panel in column[1:]:
            draw_time(panel, item, record, last=panel is acceleration)
    common_view(axes[0], item, runs.values())
    axes[3, 0].set_ylim(*speed_range(item, runs.values()))
    top = 1.15 * item.acceleration_limit * MINUTE**2
    axes[4, 0].set_ylim(-top, top)
    labels = "y [m]", "tip error [mm]", "φ error [deg]", "speed [rad/min]", "acc. [rad/min²]"
    for axis, label in zip(axes[:, 0], labels, strict=True):
        axis.set_ylabel(label)
    figure.align_ylabels(axes[:, 0])
    axes[0, 0].legend(loc="upper left", fontsize=8, framealpha=0.9)
    axes[3, 0].legend(loc="lower right", fontsize=7, ncols=3, framealpha=0.9)
    return figure


#: Name -> idea.
IDEAS = {
    idea.name: idea
    for idea in (
        Idea("argument", (THESIS, STRICT, LIMITS, DAMPED), draw_argument),
        Idea("priorities", (DAMPED, SWAPPED), draw_priorities),
        Idea("workspace", (), draw_workspace),
    )
}
