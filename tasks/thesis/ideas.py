"""Three pictures: the argument for a QP, two priorities exchanged, and the workspace of the position alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

import hqp

from ..base.checks import Array
from ..robots.planar import PlanarArm
from ..simulation.record import Record
from .arms import desired_path, draw_arm, legend, proportion, show, view
from .figures import ended, summary
from .laws import DAMPED, LIMITS, STRICT, SWAPPED, THESIS, Law
from .measuring import digits, measure
from .panels import draw_joints, draw_phi, draw_time, name_joints, speed_range
from .runs import Job, tip_error
from .scenarios import MINUTE, scenario
from .sheet import COLUMN, Head, Row, rule, same_range, sheet
from .style import ACTUAL, ARM, DESIRED, GRID, JOINTS, LAST, MUTED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The figure of the text that all three start from: links 0.5 0.5 0.5, the straight line, phi = 0.
FIGURE = "4.3"
#: The rows below the arm.
PANELS = {
    "tip": Row("tip error [mm]", 1.15, above=0.56),
    "phi": Row("φ error [deg]", 1.15),
    "speed": Row("speed [rad/min]", 1.15),
    "acceleration": Row("acc. [rad/min²]", 1.15, above=0.32),
}


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
    title = "Position before orientation: links 0.5 0.5 0.5 m, tip along the red line, φ = 0°"
    return _columns(title, runs, {job: titles[job.law.key] for job in runs})


def draw_priorities(runs: Mapping[Job, Record]) -> Figure:
    """Position before orientation, and the other way round: one ``>>`` exchanged (section 1.2)."""
    orders = {SWAPPED.key: "orientation >> position", DAMPED.key: "position >> orientation"}
    title = "One >> exchanged: what is lost where both cannot be met"
    return _columns(title, runs, {job: orders[job.law.key] for job in runs})


def draw_workspace(runs: Mapping[Job, Record]) -> Figure:
    """The reachable workspace of position alone against those with phi fixed (section 3.6)."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.patches import Annulus

    item = scenario(FIGURE)
    arm = item.arm
    figure = Figure(figsize=(7.4, 8.25), layout=ConstrainedLayoutEngine(h_pad=0.12))
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
        axis.plot(*points[:-1].T, color=ARM, lw=2.2, solid_capstyle="round", zorder=4)
        axis.plot(*points[-2:].T, color=LAST, lw=2.2, solid_capstyle="round", zorder=5)
        axis.plot(*points[1:-1].T, "o", color=ARM, ms=4.5, mec="white", mew=0.6, zorder=6)
    axis.plot(0, 0, "s", color=ARM, ms=8, zorder=6)
    axis.set_aspect("equal")
    axis.set_xlim(-outer - 0.1, outer + 0.1)
    axis.set_ylim(-outer - 0.1, outer + 0.1)
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    axis.grid(alpha=GRID)
    figure.legend(loc="outside lower center", ncols=2, fontsize=9.5, frameon=False)
    figure.suptitle("What position alone can reach, links 0.5 0.5 0.5 m", fontsize=14, fontweight="bold")
    return figure


def _stretched(arm: PlanarArm, tip: Array, phi: float) -> Sequence[float]:
    """Joint angles [rad] of three links whose wrist is stretched out to the tip's place at phi."""
    x, y = tip - arm.lengths[-1] * np.array([np.cos(phi), np.sin(phi)])
    return float(np.arctan2(y, x)), 0.0, phi - float(np.arctan2(y, x))


def _columns(title: str, runs: Mapping[Job, Record], names: Mapping[Job, str]) -> Figure:
    """A column a run: the arm, the errors, the joint speeds and accelerations."""
    item = scenario(FIGURE)
    piece = view(item, runs.values())
    rows = {"arm": Row("y [m]", COLUMN * proportion(piece), above=0.0)} | PANELS
    heads = []
    for job, record in runs.items():
        found = measure(job, record)
        speeds = f"joints turn at up to {found.peak_speed:.0f} rad/min"
        if found.turning:
            speeds += f", at the end at {digits(found.end_speed)}"
        lines = [speeds, summary(found)]
        heads.append(Head(names[job], lines, ended(record)))
    figure, panels = sheet(title, rows, heads, legend(held=True))
    top = item.acceleration_limit * MINUTE**2
    for k, (job, record) in enumerate(runs.items()):
        column = {name: row[k] for name, row in panels.items()}
        draw_arm(column["arm"], item, record)
        show(column["arm"], piece)
        column["arm"].set_xlabel("x [m]")
        column["tip"].semilogy(record.t / MINUTE, np.maximum(1e3 * tip_error(record), 1e-3), color=ACTUAL)
        draw_phi(column["phi"], item, record)
        limited = job.law.inequalities
        draw_joints(column["speed"], record.t, record.v * MINUTE, item.velocity_limit * MINUTE if limited else 0.0)
        draw_joints(column["acceleration"], record.t[:-1], record.a * MINUTE**2, top if limited else 0.0)
        for name in PANELS:
            draw_time(column[name], item, record, last=name == "acceleration")
    same_range(panels["tip"])
    same_range(panels["speed"], *speed_range(item, runs.values()))
    same_range(panels["acceleration"], -1.15 * top, 1.15 * top)
    limited = any(job.law.inequalities for job in runs)
    name_joints(panels["acceleration"][0], top if limited else 0.0)
    rule(figure)
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
