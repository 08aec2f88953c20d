"""``python -m benchmarks teleop``: robots follow the hand of an operator, by this library and others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from hqp.commands.options import integer, path, real
from hqp.commands.terminal import console
from hqp.files.whole import writable

from .registry import select
from .tables import Out, Row, save, show, terminal
from .teleoperation.cost import cost, timed
from .teleoperation.loop import Run, drive
from .teleoperation.measure import THRESHOLD, measure
from .teleoperation.report import hand_share, shown, table, title
from .teleoperation.scenes import SCENES, Scene
from .teleoperation.setups import ACCELERATION, SETUPS, Own, Peer
from .teleoperation.targets import OURS, Check, checks, costs, told
from .teleoperation.tracking import inevitable, track

LEGEND = f"""\
mm, max: distance of the hand from its target less what no configuration avoids, root mean square and largest
deg: angle between them, root mean square; jerk: of the joints, root mean square [rad/s^3]
>3 Hz: share of the power of the joint velocities that is faster; p50, p99: whole ticks, targets set [us]
frozen: ticks in which no joint moves though the hand is {1e3 * THRESHOLD:g} mm too far off; longest: in a row [ms]
raised: ticks without an answer, in which the robot is held; back: when joints that start outside are inside [s]
out, over: by how much, at most, a joint that was inside leaves its range [rad], and exceeds its speed [rad/s]
moved: by how much, at most, the hand is farther off after 5 / K than if the levels below had been left out [mm], ours
pushed: the same, against joints that follow the levels below as far as these do not push the hand [mm], ours
reach: until the hand was there again when its target had come back into reach [s]; caught: how often it never was
soonest: from when on joint speeds permit a configuration that is there; told where reach is over 5 / K [s]
feet: how far frames that stand have gone [mm]; end: the last error, end ik: that of inverse kinematics [mm]
hqp: with default damping; strict: without it, as all rows of ours below it are
damped: levels damped by a number; braked: joint accelerations up to {ACCELERATION:g} rad/s^2; both: both, of ours
error: levels damped by what they lack; lm: the others, damped as their examples are
lm 100: the same, and a cost of 100 in place of 1 for the first level, a weight that is nearly a priority
levels: roboplan with priorities; hqp keeps strict ones, the others weigh their tasks in one QP"""


def teleop(
    scene: Annotated[
        list[str] | None, typer.Option("--scene", "-s", help="Only this one; may be given several times.")
    ] = None,
    method: Annotated[
        list[str] | None, typer.Option("--method", "-m", help="Only this row; may be given several times.")
    ] = None,
    gain: Annotated[
        list[float] | None, real("--gain", least=0.1, help="Of all tasks but the posture [1/s] (default: 20).")
    ] = None,
    dt: Annotated[
        list[float] | None, real("--dt", least=1e-4, most=0.1, help="Length of a tick [s] (default: 0.005).")
    ] = None,
    seconds: Annotated[
        float | None, real("--seconds", least=0.1, most=600.0, help="Length of each motion (default: its own).")
    ] = None,
    rounds: Annotated[int, integer("--rounds", least=1, help="How often it is run through, for the times.")] = 3,
    targets: Annotated[
        bool, typer.Option("--targets", help="Hold the default stack against its targets; fail where it misses one.")
    ] = False,
    out: Out = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", help="Draw a picture of each scene into this folder.", parser=path)
    ] = None,
) -> None:
    """Compare libraries that each control a robot in closed loop after the hand of an operator."""
    chosen = [
        replace(s, gain=K or s.gain, dt=tick or s.dt)
        for s, K, tick in product(select(scene, {s.name: s for s in SCENES}, "scene"), gain or [0.0], dt or [0.0])
    ]
    setups: list[Own | Peer] = select(method, {setup.name: setup for setup in SETUPS}, "method")
    if out is not None:
        writable(out.parent, [out.name])
    if plot is not None:
        writable(plot, [picture_name(s) for s in chosen])
    printer, rows, found = console(120), list[Row](), list[Check]()
    for s in chosen:
        here = [setup for setup in setups if not (setup.missing() or setup.refuses(s))]
        made, verdicts = _scene(s, here, seconds, rounds, targets, printer, plot)
        rows, found = rows + made, found + verdicts
        if out is not None:
            save(out, rows)
    printer.print(LEGEND, markup=False)
    left = [why for setup in setups if (why := setup.missing())]
    left += [why for s in chosen for setup in setups if not setup.missing() and (why := setup.refuses(s))]
    for why in dict.fromkeys(left):
        printer.print(why, markup=False)
    if targets:
        missed, unknown = (sum(check.met is verdict for check in found) for verdict in (False, None))
        printer.print(
            f"targets: {len(found) - missed - unknown} met, {missed} missed, {unknown} not told", markup=False
        )
        if missed:
            raise typer.Exit(1)


def _scene(
    scene: Scene,
    setups: Sequence[Own | Peer],
    seconds: float | None,
    rounds: int,
    targets: bool,
    printer: Console,
    plot: Path | None,
) -> tuple[list[Row], list[Check]]:
    """Run one scene, and print its results."""
    stream = scene.stream(seconds)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task(title(scene), total=rounds)
        runs = drive(stream, [setup.driver for setup in setups], rounds, lambda: progress.advance(bar))
    forced = inevitable(stream)
    tracking = track(stream, runs, forced)
    measured = measure(stream, runs, tracking, forced, {s.name: s for s in setups if isinstance(s, Own)})
    rows = table(scene, measured)
    power = f"of the hand's own power {100 * hand_share(stream):.2f} % is above 3 Hz"
    show(printer, terminal(f"{title(scene)}: {scene.about}; {power}", shown(scene, rows)))
    if plot is not None:
        from .teleoperation.pictures import draw

        draw(plot / picture_name(scene), stream, runs, tracking)
    found = checks(scene, measured)
    default: Run | None = next((run for run in runs if run.name == OURS), None)
    if default is not None:
        ticks = cost(scene.name, *timed(stream, default, rounds), forced)
        show(printer, terminal(f"{title(scene)}: a tick at the same states, default and strict in turn [us]", ticks))
        found += costs(ticks)
    if targets and found:
        show(printer, terminal(f"{title(scene)}: the targets of the default stack", told(scene, found)))
    return rows, found


def picture_name(scene: Scene) -> str:
    """The name of the file that a scene is drawn into."""
    return f"teleop-{title(scene).replace(',', '').replace(' /s', '').replace(' ', '-')}.png"
