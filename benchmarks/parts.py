"""``python -m benchmarks parts``: time of a tick with every kind of part, as a ratio to one with plain tasks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress

from hqp import InvalidInput
from hqp.commands.options import integer, path
from hqp.commands.terminal import console
from hqp.files.whole import writable

from .registry import select
from .tables import Out, Row, save, show, terminal
from .ticks.blocks import Blocks, Here, There
from .ticks.parts import ACCELERATION, KINDS, ORDERS, PLAIN, Kind, Order

#: Name of the line of inverse kinematics, which has no order.
POSES = "solve_ik"
#: What is timed, block by block: a kind of part, an order, and of its tick all or the rows.
Key = tuple[str, str, str]
WHOLE, ROWS = "tick", "rows"
LEGEND = f"""\
stands: in place of which part of the plain stack, or added to it
us: of the processor, for whole ticks, and for their kinematics and rows alone
to plain: to the plain stack at the same order; to velocity: to the tick of the same stack at velocity order
damping: none by default, as in checkouts that have none
limits: those of the robot, at acceleration and torque order also {ACCELERATION:g} rad/s^2
solve_ik: poses in reach, each from a random start
ratios: medians over rounds, in each of which all stacks take turns on the same ticks of one motion"""
#: Nanoseconds of single calls, block by block.
Times = dict[Key, list[list[int]]]


def parts(
    part: Annotated[
        list[str] | None,
        typer.Option("--part", "-p", help="Only this one, beside the plain stack; may be given several times."),
    ] = None,
    order: Annotated[
        list[str] | None,
        typer.Option("--order", help="velocity, acceleration or torque; may be given several times."),
    ] = None,
    ticks: Annotated[int, integer("--ticks", "-n", least=1, help="Length of a block.")] = 50,
    rounds: Annotated[int, integer("--rounds", least=1, help="Blocks of each stack.")] = 8,
    poses: Annotated[int, integer("--poses", least=0, help="Poses of solve_ik in a block; 0 for none.")] = 10,
    against: Annotated[
        Path | None,
        typer.Option("--against", help="Another checkout, whose library takes turns with this one.", parser=path),
    ] = None,
    out: Out = None,
) -> None:
    """Time a tick of a Panda with every kind of part, compared with plain tasks, or with another checkout."""
    kinds = [PLAIN, *(kind for kind in select(part, {k.name: k for k in KINDS}, "part") if kind is not PLAIN)]
    orders = select(order, {own: own for own in ORDERS}, "order")
    if out is not None:
        writable(out.parent, [out.name])
    there = None if against is None else There(against, ticks * rounds)
    try:
        ours, theirs, refused = _measured(kinds, orders, Here(ticks * rounds), there, ticks, rounds, poses)
    finally:
        if there is not None:
            there.close()
    rows = [_row(key, kinds, ours, theirs if there is not None else None) for key in ours if key[2] == WHOLE]
    printer = console(120)
    show(printer, terminal("a tick of a Panda: limits > position > orientation > posture", rows, group="order"))
    for key, why in refused.items():
        printer.print(f"{' '.join(key)}: refused by {against}: {why}", markup=False, soft_wrap=True)
    printer.print(LEGEND + f"; {rounds} x {ticks}")
    if against is not None:
        printer.print(
            f"ours/theirs, rows: our time to that of {against}, whole ticks and rows alone, block by block in turn",
            markup=False,
            soft_wrap=True,
        )
    if out is not None:
        save(out, rows)


def _measured(
    kinds: list[Kind], orders: list[Order], here: Blocks, there: Blocks | None, ticks: int, rounds: int, poses: int
) -> tuple[Times, Times, dict[Key, str]]:
    """Times of both checkouts, block by block, and what the other one refuses."""
    calls = list(_calls(kinds, orders, ticks, poses))
    ours, theirs = defaultdict[Key, list[list[int]]](list), defaultdict[Key, list[list[int]]](list)
    refused: dict[Key, str] = {}
    for key, call in calls:  # compilers, memory
        call(here, 0)
        if there is not None:
            try:
                call(there, 0)
            except InvalidInput as error:
                refused[key] = str(error)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task("parts", total=rounds * len(calls))
        for number in range(rounds):
            for key, call in calls:
                pair = [(here, ours), *([(there, theirs)] if there is not None and key not in refused else [])]
                for blocks, times in pair if number % 2 else reversed(pair):
                    times[key].append(call(blocks, number))
                progress.advance(bar)
    return ours, theirs, refused


def _calls(
    kinds: list[Kind], orders: list[Order], ticks: int, poses: int
) -> Iterator[tuple[Key, Callable[[Blocks, int], list[int]]]]:
    """What is timed in a round, in its order: the plain stack first, so that what is compared lies close by."""

    def block(blocks: Blocks, k: int, name: str, order: Order, what: str) -> list[int]:
        timed = blocks.ticks if what == WHOLE else blocks.rows
        return timed(name, order, k * ticks, (k + 1) * ticks)

    for order in orders:
        for kind in kinds:
            if order in kind.orders:
                for what in (WHOLE,) if order == "torque" else (WHOLE, ROWS):  # its rows are those of accelerations
                    yield (kind.name, order, what), partial(block, name=kind.name, order=order, what=what)
    if poses:
        yield (POSES, "", WHOLE), lambda blocks, k: blocks.poses(k * poses, (k + 1) * poses)


def _row(key: Key, kinds: list[Kind], ours: Times, theirs: Times | None) -> Row:
    """One line of the table."""
    name, order, _ = key
    us, written = 1e-3 * np.concatenate(ours[key]), (name, order, ROWS)
    stands = next((kind.stands for kind in kinds if kind.name == name), "")
    row = {"order": order, "name": name, "stands": stands, "median us": f"{np.median(us):.1f}"}
    row |= {
        "p90 us": f"{np.quantile(us, 0.9):.1f}",
        "to plain": _ratio(ours, key, ours, (PLAIN.name, order, WHOLE)),
        "to velocity": _ratio(ours, key, ours, (name, "velocity", WHOLE)) if order else "",
        "rows us": f"{1e-3 * np.median(np.concatenate(ours[written])):.1f}" if written in ours else "",
        "rows to plain": _ratio(ours, written, ours, (PLAIN.name, order, ROWS)),
    }
    if theirs is not None:
        there = theirs.get(key)
        row["theirs us"] = "" if there is None else f"{1e-3 * np.median(np.concatenate(there)):.1f}"
        row["ours/theirs"] = _ratio(ours, key, theirs, key)
        row["rows"] = _ratio(ours, written, theirs, written)
    return row


def _ratio(of: Times, mine: Key, to: Times, other: Key) -> str:
    """Of the medians of blocks, round by round: their median; nothing where one was not timed."""
    if mine not in of or other not in to:
        return ""
    rounds = [np.median(a) / np.median(b) for a, b in zip(of[mine], to[other], strict=True)]
    return f"{np.median(rounds):.2f}"
