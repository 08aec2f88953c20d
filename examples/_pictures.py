"""The pictures of the examples: ``python examples/06_panda_elbow_up.py docs/images`` draws the one of the Panda."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.animation import PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle as Disk
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection

from tasks import PlanarArm, Record, Robot, Sphere
from tasks.robots.skeleton import skeleton

BLUE, ORANGE, GREEN, GREY, RED = "#0072b2", "#d55e00", "#009e73", "#8c8c8c", "#b2182b"
mpl.rcParams.update(
    {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e6e6e6"}
)
mpl.rcParams.update(
    {"axes.titlesize": 9, "axes.titlelocation": "left", "axes.axisbelow": True, "legend.frameon": False}
)


def planar(folder: str, name: str, record: Record, times: Sequence[float]) -> None:
    """A planar arm at some times, and over time its joints, their speeds and both errors; limits are dashed."""
    figure = Figure(figsize=(9.0, 3.9), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1.6, 1, 1])
    side = figure.add_subplot(grid[:, 0], aspect="equal")
    side.plot(*record.pose[:, :2].T, color=ORANGE, lw=1.2)
    for t, alpha in zip(times, np.linspace(0.25, 1.0, len(times)), strict=True):
        points = record.robot.points(record.q[int(np.argmin(np.abs(record.t - t)))])
        side.plot(*points.T, "-o", color=BLUE, alpha=alpha, lw=2.4, ms=4)
    side.set(title=f"t = {', '.join(f'{t:g}' for t in times)} s", xlabel="x [m]", ylabel="y [m]")
    angle, speed, position, orientation = (figure.add_subplot(grid[i, j]) for i in (0, 1) for j in (1, 2))
    for joint, colour in zip(range(record.robot.nv), (BLUE, ORANGE, GREEN), strict=True):
        angle.plot(record.t, np.degrees(record.q[:, joint]), color=colour)
        angle.annotate(
            f"{joint + 1}",
            (record.t[-1], np.degrees(record.q[-1, joint])),
            (4, 0),
            color=colour,
            textcoords="offset points",
            va="center",
        )
        speed.plot(record.t, record.v[:, joint], color=colour)
        for end in () if record.robot.position_limit is None else np.degrees(record.robot.position_limit)[:, joint]:
            angle.axhline(end, color=colour, ls="--", lw=0.8)
    angle.set(title="joints [deg]")
    speed.set(title="their speeds [rad/s]")
    position.plot(record.t, 1e3 * np.linalg.norm(record.errors["position"], axis=1), color=GREY)
    position.set(title="tip is off by [mm]", xlabel="t [s]")
    orientation.plot(record.t, np.degrees(np.abs(record.errors["orientation"][:, 0])), color=GREY)
    orientation.set(title="last link is off by [deg]", xlabel="t [s]")
    save(figure, folder, name)


def panda_elbow(folder: str, robot: Robot, records: dict[str, Record], elbow: str, lowest: float) -> None:
    """Both runs as stick figures from the side, the height of the elbow and the error of the orientation."""
    figure = Figure(figsize=(9.0, 3.9), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1, 1, 1.1])
    height, turn = (figure.add_subplot(grid[row, 2]) for row in range(2))
    path = next(iter(records.values())).pose[:, :3]
    ahead = path[-1, :2] / np.linalg.norm(path[-1, :2])  # the view is across the vertical plane of the goal
    for column, (name, record), colour in zip((0, 1), records.items(), (ORANGE, BLUE), strict=True):
        side = figure.add_subplot(grid[:, column], aspect="equal", xlim=(-0.28, 0.88), ylim=(-0.03, 0.8))
        side.set(title=f"{name}: t = 0, 1, 1.5, 3 s", xlabel="towards the goal [m]")
        side.set_ylabel("z [m]" if column == 0 else "")
        side.axhline(lowest, color=GREY, ls="--", lw=1.0)
        side.plot(path[:, :2] @ ahead, path[:, 2], color=GREY, lw=1.0)
        heights = np.array([robot.at(q, record.v[0]).frame(elbow).position for q in record.q])
        for t, alpha in (0.0, 0.2), (1.0, 0.35), (1.5, 0.5), (3.0, 1.0):
            k = int(np.argmin(np.abs(record.t - t)))
            segments = skeleton(robot, record.q[k])
            flat = np.stack([segments[..., :2] @ ahead, segments[..., 2]], axis=-1)
            side.add_collection(LineCollection(flat, colors=colour, linewidths=2.5, alpha=alpha, capstyle="round"))
            side.plot(heights[k, :2] @ ahead, heights[k, 2], "o", color=colour, alpha=alpha, ms=7)
        height.plot(record.t, heights[:, 2], color=colour, label=name)
        turn.plot(record.t, np.degrees(np.linalg.norm(record.errors["orientation"], axis=1)), color=colour)
    height.axhline(lowest, color=GREY, ls="--", lw=1.0)
    height.set(title="height of the elbow [m]", xticklabels=[])
    height.legend()
    turn.set(title="error of the orientation [deg]", xlabel="t [s]")
    save(figure, folder, "panda_elbow.png")


def ur5_singularity(folder: str, records: dict[str, Record], fastest: float) -> None:
    """Joint speeds and errors of each run, one above the other."""
    chosen = {"strict": BLUE, "default": GREEN, "one level, strict": ORANGE, "one level": GREY}
    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    left, right = figure.add_gridspec(1, 2)
    speeds = left.subgridspec(len(chosen), 1).subplots(sharex=True, sharey=True)
    for axes, (name, colour) in zip(speeds, chosen.items(), strict=True):
        axes.plot(records[name].t, records[name].v, color=colour, lw=0.9)
        for side in (-fastest, fastest):
            axes.axhline(side, color=RED, ls="--", lw=0.8)
        axes.set_ylim(-1.25 * fastest, 1.25 * fastest)
        axes.annotate(name, (0.01, 0.84), xycoords="axes fraction", va="top", color=colour)
    speeds[0].set_title("joint speeds [rad/s], and the limit")
    speeds[-1].set_xlabel("t [s]")
    position, orientation = right.subgridspec(2, 1).subplots(sharex=True)
    for name, colour in chosen.items():
        away, turn = (np.linalg.norm(records[name].errors[task], axis=1) for task in ("position", "orientation"))
        position.plot(records[name].t, 1e3 * away, color=colour, label=name)
        orientation.plot(records[name].t, np.degrees(turn), color=colour)
    position.set(title="error of the position [mm]", yscale="log", ylim=(1e-2, 1e2))
    orientation.set_title("error of the orientation [deg]")
    orientation.legend(*position.get_legend_handles_labels(), loc="upper left")
    orientation.set_xlabel("t [s]")
    save(figure, folder, "ur5_singularity.png")


def humanoid_reach(folder: str, robot: Robot, record: Record, margin: float) -> None:
    """The robot at the start and where it reaches farthest; the centre of mass, the hands and the feet over time."""
    figure = Figure(figsize=(9.0, 4.4), layout="constrained")
    grid = figure.add_gridspec(3, 3, width_ratios=[1, 1, 1.25])
    ends = [f"{side}_{frame}" for side in ("left", "right") for frame in ("rubber_hand", "ankle_roll_link")]
    half = len(record) // 2
    mass = np.array([robot.at(q, v).center_of_mass.position for q, v in zip(record.q, record.v, strict=True)])
    for column, k in enumerate((0, half)):
        axes = space(figure, grid[:, column], ((-0.3, 0.8), (-0.4, 0.4), (0.0, 1.2)))
        axes.set_title(f"t = {record.t[k]:g} s")
        stick(axes, skeleton(robot, record.q[k], frames=ends), BLUE)
        square = mass[0, :2] + margin * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
        axes.plot(*square.T, np.zeros(5), color=GREY, lw=1.0)
        axes.plot(*np.array([mass[k], mass[k] * [1, 1, 0]]).T, color=RED, ls=":", lw=1.0)
        axes.scatter(*mass[k], color=RED, s=24)
        goals = [robot.at(record.q[k], record.v[k]).frame(f"{side}_rubber_hand").position for side in ("left", "right")]
        errors = [record.errors[f"{side} hand"][k] for side in ("left", "right")]
        axes.scatter(*(np.array(goals) + errors).T, color=ORANGE, marker="x", s=30, depthshade=False)
    forward, hands, feet = (figure.add_subplot(grid[row, 2]) for row in range(3))
    forward.plot(record.t, 1e3 * (mass[:, 0] - mass[0, 0]), color=RED)
    for side in (-margin, margin):
        forward.axhline(1e3 * side, color=GREY, ls="--", lw=1.0)
    forward.set(title="centre of mass, forward [mm], and its bounds", xticklabels=[])
    hands.plot(record.t, 1e3 * np.linalg.norm(record.errors["left hand"], axis=1), color=ORANGE)
    hands.set(title="error of the left hand [mm]", xticklabels=[])
    feet.plot(record.t, 1e3 * np.linalg.norm(record.errors["left foot"][:, :3], axis=1), color=BLUE)
    feet.set(title="error of the left foot [mm]", xlabel="t [s]")
    save(figure, folder, "humanoid_reach.png")


def torque_minimisation(folder: str, records: dict[tuple[str, str], Record]) -> None:
    """Torque and joint speed of each law, of the short move and of the long one."""
    colours = {"least acceleration": GREY, "least torque": ORANGE, "balanced": BLUE}
    figure = Figure(figsize=(9.0, 4.4), layout="constrained")
    panels = figure.subplots(2, 2, sharex="col")
    for (length, name), record in records.items():
        torque, speed = panels[:, 0 if length == "short" else 1]
        torque.plot(record.t[: len(record.tau)], np.linalg.norm(record.tau, axis=1), color=colours[name], label=name)
        speed.plot(record.t, np.abs(record.v).max(axis=1), color=colours[name])
        torque.set_title(f"{length} move: norm of the torques [N m]")
        speed.set(title="fastest joint [rad/s]", xlabel="t [s]")
        if record.stopped:
            torque.plot(record.t[-2], np.linalg.norm(record.tau[-1]), "x", color=colours[name])
            speed.plot(record.t[-1], np.abs(record.v[-1]).max(), "x", color=colours[name])
    panels[0, 1].set(yscale="log", ylim=(5.0, 1e6))
    panels[1, 1].set(yscale="log", ylim=(1e-2, 1e3))
    panels[0, 0].set_ylim(0.0, 200.0)
    panels[0, 0].legend(ncols=2)
    save(figure, folder, "torque_minimisation.png")


def liegeois(folder: str, robot: Robot, records: dict[str, Record]) -> None:
    """Every joint in its range, the mean square of that, and the error of the hand."""
    low, high = robot.position_limit
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    left, right = figure.add_gridspec(1, 2, width_ratios=[1.3, 1])
    ranges = left.subgridspec(2, 1).subplots(sharex=True, sharey=True)
    square, error = right.subgridspec(2, 1).subplots(sharex=True)
    for axes, (name, record), colour in zip(ranges, records.items(), (ORANGE, BLUE), strict=True):
        relative = (2.0 * record.q - high - low) / (high - low)
        axes.plot(record.t, relative, lw=1.0, label=[f"joint {i + 1}" for i in range(robot.nv)])
        for side in (-1.0, 1.0):
            axes.axhline(side, color=RED, ls="--", lw=0.8)
        axes.set(title=f"{name}: position of each joint in its range", ylim=(-1.15, 1.15))
        square.plot(record.t, np.mean(relative**2, axis=1), color=colour, label=name)
        error.plot(record.t, 1e3 * np.linalg.norm(record.errors["position"], axis=1), color=colour)
    ranges[1].set_xlabel("t [s]")
    ranges[1].legend(ncols=4, fontsize=7, loc="upper center", bbox_to_anchor=(0.5, 0.93))
    square.set(title="mean square: what is descended")
    square.legend()
    error.set(title="error of the hand [mm]", xlabel="t [s]")
    save(figure, folder, "liegeois.png")


def torque_panda(folder: str, robot: Robot, record: Record) -> None:
    """Error, torques and active limits over time, and the change from slow to fast as a GIF."""
    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    position, orientation, torque, active = figure.subplots(4, sharex=True, height_ratios=[1, 1, 1.4, 1])
    position.plot(record.t, 1e3 * np.linalg.norm(record.errors["position"], axis=1), color=BLUE, lw=0.8)
    position.set(title="error of the position [mm]", ylim=(0, None))
    orientation.plot(record.t, np.degrees(np.linalg.norm(record.errors["orientation"], axis=1)), color=ORANGE, lw=0.8)
    orientation.set_title("error of the orientation [deg]")
    torque.plot(record.t[:-1], np.abs(record.tau / robot.torque_limit).max(axis=1), color=GREEN, lw=0.6)
    torque.axhline(1.0, color=RED, ls="--", lw=0.8)
    torque.set(title="largest torque over its limit", ylim=(0, 1.1))
    ticks, joints = np.nonzero(record.active["torque"])
    active.plot(record.t[ticks], joints + 1, "|", color=RED, ms=5)
    active.set(title="motors at their limit", xlabel="t [s]", ylim=(0.4, robot.nv + 0.6), yticks=range(1, robot.nv + 1))
    active.set_ylabel("joint")
    for axes in figure.axes:
        axes.axvline(record.t[-1] / 2, color=GREY, lw=1.0)
    save(figure, folder, "torque_panda.png")
    torque_film(Path(folder) / "torque_panda.gif", robot, record)


def torque_film(path: Path, robot: Robot, record: Record, seconds: float = 4.0, per_second: int = 15) -> None:
    """The middle of the run as a stick figure, as fast as it was: joints at their torque limit are red."""
    figure = Figure(figsize=(4.2, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    start = max(record.t[-1] / 2 - seconds / 4, 0.0)
    frames = np.arange(start, min(start + seconds, record.t[-1]), 1.0 / per_second)
    writer = PillowWriter(fps=per_second)
    with writer.saving(figure, str(path), dpi=70):
        for k in np.minimum(np.searchsorted(record.t, frames), len(record) - 1):
            figure.clear()
            axes = space(figure, 111, ((-0.2, 0.6), (-0.4, 0.4), (0.0, 0.8)))
            axes.plot(*record.pose[max(k - 1000, 0) : k + 1, :3].T, color=GREY, lw=1.0)
            stick(axes, skeleton(robot, record.q[k]), BLUE)
            placements = robot.at(record.q[k], record.v[k])
            for joint in np.flatnonzero(record.active["torque"][max(k - 15, 0) : k + 15].any(axis=0)):
                axes.scatter(*placements.frame(robot.joint_names[joint]).position, color=RED, s=40, depthshade=False)
            axes.set_title(f"t = {record.t[k]:5.2f} s")
            writer.grab_frame()


def obstacle(
    folder: str, arm: PlanarArm, records: dict[str, Record], apart: dict[str, np.ndarray], circle: Sphere, margin: float
) -> None:
    """Each run as stick figures about the obstacle; the least distance and the error of the tip over time."""
    figure = Figure(figsize=(9.0, 5.4), layout="constrained")
    grid = figure.add_gridspec(2, len(records))
    distance, error = figure.add_subplot(grid[1, :2]), figure.add_subplot(grid[1, 2:])
    centre = circle.centre(0.0)[0]
    for column, (name, record) in enumerate(records.items()):
        colour = (GREY, ORANGE, GREEN, BLUE)[column]
        side = figure.add_subplot(grid[0, column], aspect="equal", xlim=(-0.5, 0.95), ylim=(-0.25, 1.2))
        side.set(title=name, xlabel="x [m]")
        side.set_ylabel("y [m]" if column == 0 else "")
        side.add_patch(Disk(centre, circle.radius, color=RED, alpha=0.5, lw=0))
        side.add_patch(Disk(centre, circle.radius + margin, fill=False, ec=RED, ls="--", lw=0.8))
        side.plot(record.pose[:, 0], record.pose[:, 1], color="black", lw=0.8)
        for t, alpha in (0.0, 0.2), (1.2, 0.35), (1.8, 0.5), (4.0, 1.0):
            points = arm.points(record.q[int(np.argmin(np.abs(record.t - t)))])
            side.plot(*points.T, "-o", color=colour, alpha=alpha, lw=2.2, ms=3)
        distance.plot(record.t, 1e3 * apart[name], color=colour, label=name)
        error.plot(record.t, 1e3 * np.linalg.norm(record.errors["position"], axis=1), color=colour)
    distance.axhline(1e3 * margin, color=RED, ls="--", lw=0.8)
    distance.set(title="least distance of a link [mm], and the margin", xlabel="t [s]", ylim=(-130.0, 200.0))
    distance.legend(loc="lower left", fontsize=8)
    error.set(title="error of the tip [mm]", xlabel="t [s]")
    save(figure, folder, "obstacle.png")


def stick(axes: Axes3D, segments: np.ndarray, colour: str, alpha: float = 1.0) -> None:
    """A stick figure: its links, and dots between them."""
    axes.add_collection3d(Line3DCollection(segments, colors=colour, linewidths=2.2, alpha=alpha, capstyle="round"))
    axes.scatter(*segments.reshape(-1, 3).T, color=colour, s=5, alpha=alpha, depthshade=False)


def space(figure: Figure, place: object, box: tuple[tuple[float, float], ...]) -> Axes3D:
    """Axes of equal scale for a stick figure in a box [m]."""
    axes = figure.add_subplot(place, projection="3d", elev=12.0, azim=-60.0)
    axes.set(xlim=box[0], ylim=box[1], zlim=box[2])
    axes.set_box_aspect([high - low for low, high in box], zoom=1.25)
    axes.locator_params(nbins=4)
    axes.tick_params(labelsize=7, pad=-2)
    axes.set_xlabel("x [m]", labelpad=-4, fontsize=8)
    axes.set_ylabel("y [m]", labelpad=-2, fontsize=8)
    axes.text(box[0][1], box[1][1], 1.05 * box[2][1], "z [m]", fontsize=8)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
    return axes


def save(figure: Figure, folder: str, name: str) -> None:
    """Write it, without a date or a version: the same run gives the same file."""
    figure.savefig(Path(folder) / name, dpi=110, metadata={"Software": None})


def priority_swap(folder: str, records: dict[str, Record], at: float, over: float) -> None:
    """Joint speeds of each run, and the errors of both tasks."""
    figure = Figure(figsize=(9.0, 3.9), layout="constrained")
    left, right = figure.add_gridspec(1, 2)
    colours = dict(zip(records, (GREY, ORANGE, BLUE), strict=True))
    speeds = left.subgridspec(len(records), 1).subplots(sharex=True, sharey=True)
    for axes, (name, record) in zip(speeds, records.items(), strict=True):
        axes.plot(record.t, record.v, color=colours[name], lw=0.9)
        axes.annotate(name, (0.99, 0.9), xycoords="axes fraction", va="top", ha="right", color=colours[name])
    speeds[0].set_title("joint speeds [rad/s]")
    speeds[-1].set_xlabel("t [s]")
    errors = right.subgridspec(2, 1).subplots(sharex=True)
    for axes, (task, unit, scale) in zip(errors, (("hand", "mm", 1e3), ("rest", "deg", 180 / np.pi)), strict=True):
        for name, record in records.items():
            axes.plot(record.t, scale * np.linalg.norm(record.errors[task], axis=1), color=colours[name], label=name)
        axes.set_title(f"error of the {task} [{unit}]")
    for axes in (*speeds, *errors):
        axes.axvspan(at, at + over, color=GREY, alpha=0.15, lw=0)
    errors[0].legend()
    errors[-1].set_xlabel("t [s]")
    save(figure, folder, "priority_swap.png")
