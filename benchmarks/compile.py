"""``python -m benchmarks compile``: what compiling costs, and a start with all compiled, compared with a checkout."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from hqp import InvalidInput
from hqp.commands.options import integer, path
from hqp.commands.terminal import console
from hqp.files.whole import writable

from .checkout import HERE
from .registry import select
from .tables import Out, Row, save, show, terminal

SOLVE = """
from hqp import Hierarchy, Level, solve

limits = Level.bounds([-1, -1, -1], [1, 1, 1], name="limits")
reach = Level.equality([[2, 1, 0]], [4], name="reach")
posture = Level.equality([[0, 1, 0], [0, 0, 1]], [0.5, 0.5], name="posture")
assert solve(Hierarchy([limits, reach, posture])).ok
"""
TICK = """
import numpy as np
from tasks import AtLeast, Controller, JointLimits, OrientationTask, PositionTask, load_robot

panda = load_robot("panda", lock=["panda_finger_joint1"])
hand = panda.at(panda.home, np.zeros(7)).frame()
elbow = AtLeast(PositionTask([0.61], frame="panda_link4", mask="z", gain=5.0, name="elbow"))
reach = PositionTask([0.3, 0.4, 0.2], gain=3.0) >> OrientationTask(hand.rotation, gain=3.0)
controller = Controller(panda, JointLimits() >> elbow >> reach, dt=0.01)
assert controller(panda.home, np.zeros(7)).solution.ok
"""
WARMUP = """
from tasks.cli.warmup import warmup

warmup()
"""
#: What is started, each in processes of its own: the first two examples of the README, and ``hqp warmup``.
PROGRAMS = {"solve": SOLVE, "tick": TICK, "warmup": WARMUP}
#: Printed last: the processor time of the process since its start, not that of the kernel of the system.
CLOCK = "\nimport os\nprint(os.times().user)\n"
#: How many times a program is started with all compiled; the shortest counts.
STARTS = 5
LEGEND = """\
seconds of the processor, in the program itself, from the start of Python to its end
solve: hqp.solve of three levels; tick: the first tick of the Panda of the README; warmup: hqp warmup, all kernels
first: nothing compiled yet; cached: all found on disk, Python's bytecode too, the shortest of {starts}"""


def compile_(
    program: Annotated[
        list[str] | None,
        typer.Option("--program", "-p", help="solve, tick or warmup; may be given several times."),
    ] = None,
    rounds: Annotated[int, integer("--rounds", least=1, help="How many times everything is compiled.")] = 1,
    against: Annotated[
        Path | None, typer.Option("--against", help="Another checkout, which takes turns with this one.", parser=path)
    ] = None,
    out: Out = None,
) -> None:
    """Measure what compiling costs, and a start with all compiled; compare with another checkout."""
    programs = select(program, {name: name for name in PROGRAMS}, "program")
    trees = [HERE] if against is None else [HERE, against]
    if out is not None:
        writable(out.parent, [out.name])
    rows: list[Row] = []
    with Progress(console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task("compile", total=len(programs) * rounds * len(trees))
        for name in programs:
            spent: list[list[tuple[float, float]]] = [[] for _ in trees]
            for turn in range(rounds):
                for tree, times in list(zip(trees, spent, strict=True))[:: 1 if turn % 2 == 0 else -1]:
                    times.append(_spent(PROGRAMS[name], tree))
                    progress.advance(bar)
            rows.append(_row(name, *([median(column) for column in zip(*times, strict=True)] for times in spent)))
    printer = console(110)
    show(printer, terminal("what compiling costs", rows))
    printer.print(LEGEND.format(starts=STARTS))
    if against is not None:
        printer.print(f"theirs, ratio: of {against}, and our time to that", markup=False, soft_wrap=True)
    if out is not None:
        save(out, rows)


def _spent(program: str, tree: Path) -> tuple[float, float]:
    """Seconds of a program of a checkout in an empty folder of kernels, and then with all found there."""
    with TemporaryDirectory() as folder:
        first = _started(program, tree, folder)
        return first, min(_started(program, tree, folder) for _ in range(STARTS))


def _started(program: str, tree: Path, folder: str) -> float:
    """Seconds of a process that runs a program with the library of a checkout and the kernels in a folder."""
    usual = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}  # see LEGEND
    done = subprocess.run(
        [sys.executable, "-c", program + CLOCK],
        env=usual | {"PYTHONPATH": str(tree.absolute()), "NUMBA_CACHE_DIR": folder},
        cwd=tree,
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        raise InvalidInput(f"{tree}: the program failed: {done.stderr.strip().splitlines()[-1]}")
    return float(done.stdout.splitlines()[-1])


def _row(name: str, ours: list[float], theirs: list[float] | None = None) -> Row:
    """One line of the table."""
    row = {"name": name}
    for start, k in (("first", 0), ("cached", 1)):
        row |= {start: f"{ours[k]:.2f}"}
        if theirs is not None:
            row |= {f"{start}, theirs": f"{theirs[k]:.2f}", f"{start}, ratio": f"{ours[k] / theirs[k]:.2f}"}
    return row
