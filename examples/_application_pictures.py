"""The pictures of the applications: ``python examples/14_welding.py docs/images`` draws the one of the weld."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from _pictures import BLUE, GREEN, GREY, ORANGE, RED, save, space, stick
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from tasks import Capsule, PlanarArm, Record, Robot
from tasks.robots.skeleton import skeleton

FIRST, LAST = BLUE, ORANGE  # the right order, and the other


def errors(figure: Figure, places: Sequence[object], records: dict[str, Record], tasks: dict[str, str]) -> list[Axes]:
    """The error of each task over time, one panel a task: {task: title}; titles tell the unit, mm or deg."""
    panels = [figure.add_subplot(place) for place in places]
    for axes, (task, title) in zip(panels, tasks.items(), strict=True):
        for (name, record), colour in zip(records.items(), (FIRST, LAST), strict=True):
            size = np.linalg.norm(record.errors[task], axis=1)
            axes.plot(record.t, size * 1e3 if "[mm]" in title else np.degrees(size), color=colour, label=name)
        axes.set_title(title)
    panels[-1].set_xlabel("t [s]")
    return panels


def pipe(axes: Axes3D, start: np.ndarray, end: np.ndarray, radius: float, colour: str = GREY) -> None:
    """A cylinder from one point to another, as a surface that what is behind shines through."""
    along = (end - start) / np.linalg.norm(end - start)
    across = np.linalg.svd(along[None])[2][1:]
    angle = np.linspace(0.0, 2.0 * np.pi, 17)
    ring = radius * (np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1])
    surface = np.stack([start + ring, end + ring])
    axes.plot_surface(*surface.transpose(2, 0, 1), color=colour, alpha=0.3, lw=0, rstride=1, cstride=1)


def welding(folder: str, robot: Robot, records: dict[str, Record], tilt: float) -> None:
    """The arm round the socket; the tracks of the tip from above, with the torch; both errors over time."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1.15, 1.1, 1])
    right = records["seam first"]
    wanted = right.pose[:, :3] + right.errors["seam"]
    centre = 0.5 * (wanted.max(axis=0) + wanted.min(axis=0))
    axes = space(figure, grid[:, 0], ((-0.2, 0.7), (-0.35, 0.35), (0.0, 1.0)))
    axes.set_title("seam first: t = 0, 10, 14 s")
    pipe(axes, centre, centre + np.array([0.0, 0.0, 0.05]), 0.07)
    axes.plot(*wanted.T, color=RED, lw=1.5)
    for t, alpha in (0.0, 0.3), (14.0, 0.5), (10.0, 1.0):
        stick(axes, skeleton(robot, right.q[int(np.argmin(np.abs(right.t - t)))]), FIRST, alpha)
    above = figure.add_subplot(grid[:, 1], aspect="equal")
    above.set(title="from above: the tip and the torch", xlabel="x [m]", ylabel="y [m]")
    for (name, record), colour in zip(records.items(), (FIRST, LAST), strict=True):
        above.plot(*record.pose[:, :2].T, color=colour, lw=1.5, label=name)
        for k in range(0, len(record), 80):
            axis = robot.at(record.q[k], record.v[k]).frame().rotation[:2, 2]
            above.plot(*(record.pose[k, :2, None] - 0.05 * axis[:, None] * [0.0, 1.0]), color=colour, lw=0.8)
    above.plot(*wanted[:, :2].T, color=RED, ls=":", lw=1.2, label="seam")
    above.legend(loc="upper center", ncols=3, fontsize=7)
    above.margins(0.12)
    titles = {"seam": "error of the tip [mm]", "torch": "error of the torch [deg]"}
    errors(figure, [grid[0, 2], grid[1, 2]], records, titles)[1].legend(loc="upper right", fontsize=7)
    save(figure, folder, "welding.png")


def spraying(folder: str, robot: Robot, records: dict[str, Record], corners: np.ndarray) -> None:
    """The arm before the panel, where it is short; the tracks of both orders on the panel; both errors over time."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1.15, 1.1, 1])
    axes = space(figure, grid[:, 0], ((-0.1, 0.6), (-0.5, 0.5), (0.0, 0.6)))
    axes.set_title("both orders, where the gun is short")
    axes.plot(*corners.T, color=RED, lw=1.0)
    sheet = corners.reshape(-1, 2, 3).copy()
    sheet[1::2] = sheet[1::2, ::-1]  # all lanes the same way round
    axes.plot_surface(*sheet.transpose(2, 0, 1), color=GREY, alpha=0.25, lw=0)
    right = records["square first"]
    worst = int(np.argmax(np.linalg.norm(right.errors["gun"], axis=1)))
    for record, colour in zip(records.values(), (FIRST, LAST), strict=True):
        stick(axes, skeleton(robot, record.q[worst], frames=["tool0"]), colour)
        frame = robot.at(record.q[worst], record.v[worst]).frame()
        axes.quiver(*frame.position, *(0.12 * frame.rotation[:, 2]), color=colour, lw=1.5)
    front = figure.add_subplot(grid[:, 1], aspect="equal")
    front.set(title="the gun, from the front", xlabel="y [m]", ylabel="z [m]")
    for (name, record), colour in zip(records.items(), (FIRST, LAST), strict=True):
        front.plot(*record.pose[:, 1:3].T, color=colour, lw=1.5, label=name)
    front.plot(*corners[:, 1:].T, color=RED, ls=":", lw=1.2, label="wanted")
    front.legend(loc="upper center", ncols=3, fontsize=7, bbox_to_anchor=(0.5, -0.35))
    titles = {"gun": "error of the gun [mm]", "square": "tilt of the gun [deg]"}
    errors(figure, [grid[0, 2], grid[1, 2]], records, titles)[0].legend()
    save(figure, folder, "spraying.png")


def snake_arm(
    folder: str,
    arm: PlanarArm,
    records: dict[str, Record],
    apart: dict[str, np.ndarray],
    walls: Sequence[Capsule],
    margin: float,
) -> None:
    """Each run as stick figures at the wall; the least distance over time."""
    figure = Figure(figsize=(9.0, 3.9), layout="constrained")
    grid = figure.add_gridspec(1, 3, width_ratios=[1, 1, 1.05])
    distance = figure.add_subplot(grid[2])
    for column, ((name, record), colour) in enumerate(zip(records.items(), (LAST, FIRST), strict=True)):
        side = figure.add_subplot(grid[column], aspect="equal", xlim=(-0.25, 1.0), ylim=(-0.5, 0.72))
        side.set(title=f"{name}: t = 0, 4, 8, 12 s", xlabel="x [m]")
        side.set_ylabel("y [m]" if column == 0 else "")
        for wall in walls:
            (x, inner), (_, outer) = wall.core(0.0)[:, :2]
            top, bottom = np.sign(outer) * 2.0, inner - np.sign(outer) * wall.radius
            side.fill_between([x - wall.radius, x + wall.radius], bottom, top, color=RED, alpha=0.35, lw=0)
        side.plot(*record.pose[:, :2].T, color="black", lw=0.8)
        for t, alpha in (0.0, 0.25), (4.0, 0.4), (8.0, 0.6), (12.0, 1.0):
            points = arm.points(record.q[int(np.argmin(np.abs(record.t - t)))])
            side.plot(*points.T, "-o", color=colour, alpha=alpha, lw=2.4, ms=3)
        distance.plot(record.t, 1e3 * apart[name], color=colour, label=name)
    distance.axhline(1e3 * margin, color=RED, ls="--", lw=0.8)
    distance.set(title="distance to the wall, margin [mm]", xlabel="t [s]")
    distance.legend()
    save(figure, folder, "snake_arm.png")


def inspection(
    folder: str,
    robot: Robot,
    records: dict[str, Record],
    apart: dict[str, np.ndarray],
    pipes: Sequence[Capsule],
    valve: Sequence[float],
    margin: float,
) -> None:
    """Each run as stick figures among the pipes; the least distance and what it costs over time."""
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    grid = figure.add_gridspec(3, 3, width_ratios=[1.1, 1.1, 1])
    distance = figure.add_subplot(grid[0, 2])
    for column, ((name, record), colour) in enumerate(zip(records.items(), (LAST, FIRST), strict=True)):
        axes = space(figure, grid[:, column], ((-0.2, 0.7), (-0.5, 0.5), (0.0, 1.0)))
        axes.view_init(elev=28.0, azim=-120.0)
        axes.set_title(name)
        for capsule in pipes:
            pipe(axes, *capsule.core(0.0), capsule.radius, RED)
        axes.scatter(*valve, color=GREEN, s=40, depthshade=False)
        axes.plot(*record.pose[:, :3].T, color="black", lw=1.0)
        for t, alpha in (0.0, 0.25), (5.0, 0.5), (10.0, 1.0):
            k = int(np.argmin(np.abs(record.t - t)))
            stick(axes, skeleton(robot, record.q[k]), colour, alpha)
            axes.plot(*np.array([record.pose[k, :3], valve]).T, color=GREEN, ls=":", lw=1.0)
        distance.plot(record.t, 1e3 * apart[name], color=colour)
    distance.axhline(1e3 * margin, color=RED, ls="--", lw=0.8)
    distance.set_title("distance to the pipes, margin [mm]")
    reverse = dict(reversed(records.items()))
    titles = {"sight": "error of the sight [deg]", "camera": "error of the camera [mm]"}
    errors(figure, [grid[1, 2], grid[2, 2]], reverse, titles)[1].legend()
    save(figure, folder, "inspection.png")
