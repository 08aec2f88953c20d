"""The pictures of robots that stand: ``python examples/18_biped_lifts_a_foot.py docs/images`` draws the biped."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from _pictures import BLUE, GREEN, GREY, ORANGE, RED, save, space, stick
from _standing import moved
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from tasks import Contact, Record
from tasks.robots.skeleton import skeleton

COLOURS = BLUE, ORANGE, GREEN, GREY


def feet(
    folder: str,
    name: str,
    record: Record,
    contacts: Sequence[Contact],
    times: Sequence[float],
    *,
    mark: tuple[float, float] | None = None,
    ends: Sequence[str] = (),
) -> None:
    """The robot at some times, with its forces; error of the centre of mass, forces and slip of the feet over time."""
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    grid = figure.add_gridspec(4, len(times) + 1, width_ratios=[*(1.0 for _ in times), 1.7])
    for column, t in enumerate(times):
        robots(figure, grid[:, column], record, contacts, t, ends)
    mass, force, slip, torque = (figure.add_subplot(grid[row, -1]) for row in range(4))
    t = record.t[:-1]
    mass.plot(record.t, 1e3 * np.linalg.norm(record.errors["center of mass"], axis=1), color=RED, lw=0.9)
    mass.set(title="error of the centre of mass [mm]")
    for contact, colour in zip(contacts, COLOURS, strict=False):
        force.plot(t, record.forces[contact.name][..., 2].sum(axis=1), color=colour, lw=0.9, label=contact.name)
        slip.plot(t, 1e3 * np.linalg.norm(moved(record, contact), axis=1), color=colour, lw=0.9)
    force.set(title="normal force of each foot [N]")
    force.set_ylim(0.0, 1.4 * force.get_ylim()[1])
    force.legend(ncols=4, fontsize=7, loc="upper right")
    slip.set(title="how far each has slipped [mm]")
    limit = record.robot.torque_limit[-record.tau.shape[1] :]
    torque.plot(t, np.abs(record.tau / limit).max(axis=1), color=GREY, lw=0.7)
    torque.set(title="largest torque / its limit", xlabel="t [s]", ylim=(0.0, 1.05))
    for axes in (mass, force, slip, torque):
        if mark is not None:
            axes.axvspan(*mark, color=RED, alpha=0.3, lw=0)
        if axes is not torque:
            axes.set_xticklabels([])
    save(figure, folder, name)


def robots(
    figure: Figure, place: object, record: Record, contacts: Sequence[Contact], t: float, ends: Sequence[str]
) -> Axes3D:
    """The robot at one time: links, centre of mass above the ground, and what the ground does to it, 1 m for 500 N."""
    k = min(int(np.searchsorted(record.t, t)), len(record) - 1)
    state = record.robot.at(record.q[k], record.v[k])
    segments = skeleton(record.robot, record.q[k], frames=[*(contact.frame for contact in contacts), *ends])
    low, high = segments.reshape(-1, 3).min(axis=0), segments.reshape(-1, 3).max(axis=0)
    middle, half = 0.5 * (low + high), max(0.5 * (high - low)[:2].max(), 0.25) + 0.05
    box = [(m - half, m + half) for m in middle[:2]] + [(low[2] - 0.05, high[2] + 0.05)]
    axes = space(figure, place, tuple(box))
    axes.set_title(f"t = {record.t[k]:.1f} s")
    stick(axes, segments, BLUE)
    c = state.center_of_mass.position
    axes.plot(*np.array([c, [c[0], c[1], box[2][0] + 0.02]]).T, color=RED, ls=":", lw=1.0)
    axes.scatter(*c, color=RED, s=24)
    for contact in contacts:
        frame = state.frame(contact.frame)
        for point, f in zip(contact.shape.points, record.forces[contact.name][k], strict=True):
            at = frame.position + frame.rotation @ point
            axes.plot(*np.array([at, at + f / 500.0]).T, color=ORANGE, lw=1.6)
    return axes


def leaning(
    folder: str, record: Record, contacts: Sequence[Contact], hand: str, thing: np.ndarray, margin: float
) -> None:
    """The robot at the start and where it leans; the centre of mass in the support polygon; error of the hand."""
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1, 1, 1.3])
    ends = [hand, hand.replace("right", "left")]
    for column, t in enumerate((0.0, record.t[-2])):
        axes = robots(figure, grid[:, column], record, contacts, float(t), ends)
    axes.scatter(*thing, color=GREEN, marker="x", s=40)
    above, short = figure.add_subplot(grid[0, 2], aspect="equal"), figure.add_subplot(grid[1, 2])
    states = [record.robot.at(q, v) for q, v in zip(record.q, record.v, strict=True)]
    points = [
        (frame := states[0].frame(contact.frame)).position + frame.rotation @ point
        for contact in contacts
        for point in contact.shape.points
    ]
    corners = np.array(points)[:, :2]
    low, high = corners.min(axis=0), corners.max(axis=0)
    for inside, style in (0.0, "-"), (margin, "--"):
        (x, y), (right, top) = low + inside, high - inside
        above.plot([x, right, right, x, x], [y, y, top, top, y], color=GREY, ls=style, lw=1.0)
    mass = np.array([state.center_of_mass.position for state in states])
    above.plot(mass[:, 0], mass[:, 1], color=RED, lw=1.5)
    above.plot(*corners.T, ".", color=GREY)
    above.plot(*thing[:2], "x", color=GREEN)
    above.set(title="from above: feet, centre of mass, target", xlabel="x [m]", ylabel="y [m]")
    short.plot(record.t, 1e3 * np.linalg.norm(record.errors["hand"], axis=1), color=ORANGE)
    short.set(title="the hand is short of its path by [mm]", xlabel="t [s]", ylim=(0.0, None))
    save(figure, folder, "leaning.png")


def pressing(
    folder: str, record: Record, pressed: np.ndarray, height: np.ndarray, table: np.ndarray, lowest: float
) -> None:
    """The arm above the table and on it; what was asked and what the table bears; the height of the elbow."""
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.3])
    axes = space(figure, grid[:, 0], ((-0.2, 0.7), (-0.45, 0.45), (0.0, 0.9)))
    for k, alpha in (0, 0.3), (len(record), 1.0):
        stick(axes, skeleton(record.robot, record.q[k]), BLUE, alpha)
    x, y = np.meshgrid(table[0] + np.array([-0.2, 0.2]), table[1] + np.array([-0.3, 0.3]))
    axes.plot_surface(x, y, np.full_like(x, table[2]), color=GREY, alpha=0.3, lw=0)
    axes.set_title("at the start, and at the end")
    force, elbow = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    force.plot(record.t[:-1], pressed, color=ORANGE, lw=1.2, label="the table bears")
    force.plot(record.t[:-1], record.forces["hand"][:, 0, 2], color=BLUE, lw=0.9, ls="--", label="asked for")
    force.set(title="normal force [N]", xticklabels=[])
    force.legend(loc="lower right")
    elbow.plot(record.t, height, color=GREEN)
    elbow.axhline(lowest, color=GREY, ls="--", lw=1.0)
    elbow.set(title="height of the elbow [m], and its bound", xlabel="t [s]")
    save(figure, folder, "pressing.png")
