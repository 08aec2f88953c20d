"""``python -m benchmarks ik``: reachable random poses, from home, against the differential solvers of others."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress

from hqp import InvalidInput
from hqp.commands.command import path
from hqp.commands.terminal import console
from hqp.files.whole import writable
from tasks import load_robot

from .ik_methods import METHODS, TOLERANCE, Method, Outcome, Target, missing
from .tables import Row, save, show, terminal

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

#: The robots, and the joints of theirs that are held.
MACHINES: dict[str, tuple[str, ...]] = {"panda": ("panda_finger_joint1",), "ur5": ()}
#: The budgets [steps], and what counts as outside a limit [rad].
BUDGETS, OUTSIDE = (100, 300), 1e-9


def ik(
    count: Annotated[int, typer.Option("--count", "-n", min=1, help="Poses of each robot.")] = 1000,
    robot: Annotated[
        list[str] | None, typer.Option("--robot", "-r", help="panda or ur5; may be given several times.")
    ] = None,
    budget: Annotated[
        list[int] | None,
        typer.Option("--budget", "-b", min=1, help="Steps; may be given several times (default: 100 and 300)."),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0)] = 0,
    start: Annotated[Literal["home", "neutral"], typer.Option("--start", help="Where all of them start.")] = "home",
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Also write the rows to this CSV file.", parser=path)
    ] = None,
) -> None:
    """Solve for random poses that are in reach, by ours and by Pink and Mink, interleaved in one run."""
    for name in robot or ():
        if name not in MACHINES:
            raise InvalidInput(f"unknown robot {name!r}; there are {', '.join(MACHINES)}")
    if out is not None:
        writable(out.parent, [out.name])
    printer = console(120)
    kinds = [kind for kind in METHODS if not missing(kind)]
    for kind in METHODS:
        if why := missing(kind):
            printer.print(why, markup=False)
    rows: list[Row] = []
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for name in MACHINES if not robot else dict.fromkeys(robot):
            machine = load_robot(name, lock=MACHINES[name])
            machine.home = getattr(machine, start)
            targets = poses(machine, count, seed)
            here: list[Row] = []
            for most in budget or BUDGETS:
                methods = [kind(machine, again) for kind in kinds for again in (True, False)]
                bar = progress.add_task(f"{name}, {most} steps", total=count)
                timed = measure(methods, targets, most, lambda bar=bar: progress.advance(bar))
                here += [row(name, most, method, timed[method]) for method in methods]
            rows += here
            show(printer, terminal(f"{name}: {count} poses in reach, from {start}", here, group="budget"))
            if out is not None:
                save(out, rows)
    printer.print(
        f"solved: within {TOLERANCE[0]:g} m and {TOLERANCE[1]:g} rad in so many steps; steps, p90: of those solved;"
        " ms: a pose, all of them\nrestarts: from random configurations where the error stays; those of the peers are"
        f" ours around their steps\noutside: poses on whose way a joint was more than {OUTSIDE:g} rad outside its range"
    )


def poses(robot: PinocchioRobot, count: int, seed: int) -> list[Target]:
    """Poses of the tip at random configurations inside the ranges of the joints."""
    assert robot.position_limit is not None
    rng, still = np.random.default_rng(seed), np.zeros(robot.nv)
    tips = [robot.at(rng.uniform(*robot.position_limit), still).frame() for _ in range(count)]
    return [Target(tip.position, tip.rotation, number) for number, tip in enumerate(tips)]


def measure(
    methods: list[Method], targets: list[Target], budget: int, tick: Callable[[], None] = lambda: None
) -> dict[Method, list[tuple[Outcome, float]]]:
    """Outcome and seconds of every method on every target, in turn, so that the machine's moods hit all alike."""
    timed: dict[Method, list[tuple[Outcome, float]]] = {method: [] for method in methods}
    for method in methods:
        method.solve(targets[0], budget)  # what is done once is not timed
    gc.disable()
    try:
        for number, target in enumerate(targets):
            first = number % len(methods)
            for method in methods[first:] + methods[:first]:
                start = time.perf_counter()
                outcome = method.solve(target, budget)
                timed[method].append((outcome, time.perf_counter() - start))
            tick()
    finally:
        gc.enable()
    return timed


def row(robot: str, budget: int, method: Method, timed: list[tuple[Outcome, float]]) -> Row:
    """One line of the table."""
    steps = [outcome.steps for outcome, _ in timed if outcome.reached]
    seconds = [second for _, second in timed]
    return {
        "family": robot,
        "budget": str(budget),
        "method": method.name,
        "restarts": "on" if method.restarts else "off",
        "solved": f"{len(steps) / len(timed):.1%}",
        "steps": f"{np.median(steps):.0f}" if steps else "",
        "p90": f"{np.quantile(steps, 0.9):.0f}" if steps else "",
        "median ms": f"{1e3 * np.median(seconds):.2f}",
        "mean ms": f"{1e3 * np.mean(seconds):.2f}",
        "outside": str(sum(outcome.beyond > OUTSIDE for outcome, _ in timed)),
    }
