"""``python -m benchmarks teleop``: a hand leads a robot, which this library, pink and mink control in closed loop."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from hqp.commands.command import path
from hqp.commands.terminal import console
from hqp.files.whole import writable

from .registry import select
from .tables import Row, save, show, terminal
from .teleoperation.loop import drive
from .teleoperation.report import THRESHOLD, hand_share, shown, table, track
from .teleoperation.scenes import SCENES, Scene
from .teleoperation.setups import ACCELERATION, SETUPS

LEGEND = f"""\
mm, max: distance of the hand from its target less what no configuration avoids, root mean square and largest
deg: angle between them, root mean square; jerk: of the joints, root mean square [rad/s^3]
>3 Hz: share of the power of the joint velocities that is faster; p50, p99: whole ticks, targets set [us]
frozen: ticks in which no joint moves though the hand is {1e3 * THRESHOLD:g} mm too far off; longest: in a row [ms]
raised: ticks without an answer, in which the robot is held; back: when joints that start outside are inside [s]
out, over: by how much, at most, a joint that was inside leaves its range [rad], and exceeds its speed [rad/s]
damped: levels damped by a number; braked: joint accelerations up to {ACCELERATION:g} rad/s^2; both: both, of ours
error: levels damped by what they lack; lm: the others, damped as their examples are
lm 100: the same, and a cost of 100 in place of 1 for the position, a weight that is nearly a priority
hqp keeps strict priorities, the others weigh their tasks in one QP"""


def teleop(
    scene: Annotated[
        list[str] | None, typer.Option("--scene", "-s", help="Only this one; may be given several times.")
    ] = None,
    seconds: Annotated[
        float | None, typer.Option("--seconds", min=0.1, max=600.0, help="Length of each motion (default: its own).")
    ] = None,
    rounds: Annotated[int, typer.Option("--rounds", min=1, help="How often it is run through, for the times.")] = 3,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Also write the rows to this CSV file.", parser=path)
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", help="Draw a picture of each scene into this folder.", parser=path)
    ] = None,
) -> None:
    """Let a hand lead a robot that each library controls by itself, and compare how it moves."""
    chosen = select(scene, {s.name: s for s in SCENES}, "scene")
    if out is not None:
        writable(out.parent, [out.name])
    if plot is not None:
        writable(plot, [picture_name(s) for s in chosen])
    here = [setup for setup in SETUPS if not setup.missing()]
    printer = console(120)
    rows: list[Row] = []
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for s in chosen:
            bar = progress.add_task(s.name, total=rounds)
            stream = s.stream(seconds)
            runs = drive(stream, [setup.driver for setup in here], rounds, lambda bar=bar: progress.advance(bar))
            tracking = track(stream, runs)
            found = table(stream, runs, tracking)
            rows += found
            title = f"{s.name}: {s.about}; of the hand's own power {100 * hand_share(stream):.2f} % is above 3 Hz"
            show(printer, terminal(title, shown(stream, found)))
            if out is not None:
                save(out, rows)
            if plot is not None:
                from .teleoperation.pictures import draw

                draw(plot / picture_name(s), stream, runs, tracking)
    printer.print(LEGEND, markup=False)
    for setup in SETUPS:
        if why := setup.missing():
            printer.print(why, markup=False)


def picture_name(scene: Scene) -> str:
    """Of the file that a scene is drawn into."""
    return f"teleop-{scene.name.replace(' ', '-')}.png"
