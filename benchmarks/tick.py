"""``python -m benchmarks tick``: one tick of a controller from Python, in this library and in others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from hqp.commands.options import integer
from hqp.commands.terminal import console
from hqp.files.whole import writable

from .registry import select
from .standing.scenes import SCENES as STANDING
from .standing.scenes import StandingScene
from .standing.table import LEGEND
from .standing.table import measured as standing
from .strictness import STATES, lost_by
from .tables import Out, Row, save, show, terminal
from .teleoperation.setups import Peer
from .ticks.apart import Apart, check_apart
from .ticks.driver import Driver
from .ticks.interleaved import EVERY, SLACK, measure, table
from .ticks.ours import Ours
from .ticks.scenes import SCENES, Scene
from .ticks.stream import Stream, record

PEERS = (
    Peer("pink", "daqp"),
    Peer("pink", "proxqp"),
    Peer("mink", "daqp"),
    Peer("roboplan", ""),
    Peer("roboplan", "", "levels", options={"priorities": True}),
)


def tick(
    scene: Annotated[
        list[str] | None, typer.Option("--scene", "-s", help="Only this one; may be given several times.")
    ] = None,
    ticks: Annotated[int, integer("--ticks", "-n", least=1, help="Length of each motion.")] = 2000,
    rounds: Annotated[int, integer("--rounds", least=1, help="How often it is run through.")] = 5,
    placo: Annotated[
        str | None, typer.Option("--placo", help="A Python that has placo, which needs an environment of its own.")
    ] = None,
    tsid: Annotated[
        str | None, typer.Option("--tsid", help="A Python that has TSID, for the table of strictness.")
    ] = None,
    drake: Annotated[
        str | None, typer.Option("--drake", help="A Python that has Drake, for the table of strictness.")
    ] = None,
    out: Out = None,
) -> None:
    """Time one tick of a controller, whole and from Python, against other libraries on the same motion."""
    chosen = select(scene, {s.name: s for s in (*SCENES, *STANDING)}, "scene")
    if out is not None:
        writable(out.parent, [out.name])
    pythons = {name: own for name, own in (("placo", placo), ("tsid", tsid), ("drake", drake)) if own is not None}
    for library, python in pythons.items():
        check_apart(library, python)
    printer = console(120)
    rows: list[Row] = []
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for s in chosen:
            bar = progress.add_task(s.name, total=rounds + 1)
            done = partial(progress.advance, bar)
            if isinstance(s, StandingScene):
                at_limit, here = standing(s, ticks, rounds, done)
            else:
                at_limit, here = _measured(s, ticks, rounds, placo, done)
            rows += here
            show(printer, terminal(f"{s.name}: {s.about}; at a limit: {at_limit}", here))
            if out is not None:
                save(out, rows)
    if not scene:
        _alone(printer, ticks, pythons)
    if any(isinstance(s, StandingScene) for s in chosen):
        printer.print(LEGEND, markup=False)
    if not any(isinstance(s, Scene) for s in chosen):
        return
    printer.print(
        f"us: whole ticks, targets set, {rounds} x {ticks}; to: ratio of medians, to the fastest of that library\n"
        "kinematics, rows, solve: medians of the parts in us, timed alone; off: distance of the answer from the first\n"
        f"one's; kept: answers within the limits, to {SLACK:g} rad; proved: certificates of every {EVERY}th answer\n"
        f"lost: how much further off the position is than the limits force it to be, the most of {STATES} ticks [m/s];"
        " -: not\nmeasured where the first level is not one position; hqp keeps strict priorities, roboplan levels has"
        " priorities by\nprojection, the others weigh their tasks in one QP",
        markup=False,
    )
    for why in _left_out(s for s in chosen if isinstance(s, Scene)):
        printer.print(why, markup=False)


def _left_out(scenes: Iterable[Scene]) -> list[str]:
    """Why peers have no row in some scenes."""
    missing = [why for peer in PEERS if (why := peer.missing())]
    here = [peer for peer in PEERS if not peer.missing()]
    return missing + [why for s in scenes for peer in here if (why := peer.refuses(s))]


def _alone(printer: Console, ticks: int, pythons: Mapping[str, str]) -> None:
    """Tables of this library alone, and of how well each library keeps the first level."""
    from .strictness import LOSS, STATES, strictness
    from .ticks.damping import ratios
    from .ticks.paced import RATE, paced
    from .ticks.redundancy import costs

    show(printer, terminal("what else the joints are used for: a Panda, this library alone", costs(ticks)))
    show(printer, terminal("damped levels of that Panda, native, one warm solve from Python", ratios(ticks)))
    show(printer, terminal(f"asked {RATE:g} times a second, asleep between ticks, this library alone", paced(ticks)))
    held, rows, left_out = strictness(min(STATES, ticks), pythons)
    title = "strictness: how much further off the position is than limits force it to be, in m/s; limits are active in"
    show(printer, terminal(f"{title} {held} states", rows))
    printer.print(
        f"the largest of each stack; lost: states where it is more than {LOSS:g}; alone: asked for nothing below\n"
        "second: the largest of the orientation [rad/s], of states that are not lost; inf: no answer\n"
        "levels: priorities by projection, 1e-10: with that tolerance in place of 1e-6, cold; scaled: slowed down by\n"
        "one factor, of placo the position, of drake the pose; hard: the position is a row; no margins: a joint slows\n"
        "down only a tick away from the end of its range",
        markup=False,
    )
    for why in left_out:
        printer.print(why, markup=False)


def _measured(
    scene: Scene, ticks: int, rounds: int, placo: str | None, progress: Callable[[], None]
) -> tuple[str, list[Row]]:
    """The number of joints at a limit in one scene, and the rows of its table."""
    stream = record(scene, ticks)
    drivers = _drivers(stream, placo)
    try:
        measured = measure(drivers, rounds, progress)
        lost = lost_by(stream, [own.v for own in measured])
        rows = [row | {"lost": most} for row, most in zip(table(stream, measured), lost, strict=True)]
        return stream.at_limit, rows
    finally:
        for driver in drivers:
            driver.close()


def _drivers(stream: Stream, placo: str | None) -> list[Driver]:
    """The drivers of this library, and of the others that are installed."""
    drivers: list[Driver] = [Ours(stream)]
    drivers += [peer.driver(stream) for peer in PEERS if not peer.missing() and not peer.refuses(stream.scene)]
    if placo is not None:
        drivers.append(Apart("placo", placo, stream))
    return drivers
