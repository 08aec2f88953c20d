"""``python -m benchmarks singularities``: task errors and joint speeds with each remedy for singularities."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from hqp.commands.options import file
from hqp.commands.terminal import console
from hqp.files.names import PICTURE
from hqp.files.whole import writable
from tasks import Controller, simulate

from .singular_scenes import DEFAULTS, METHODS, Run, Scene, scenes
from .tables import Row, show, terminal

#: Tick [s], every how many the certificate and the report are asked for, and the speed [rad/s] of a diverged run.
TICK, EVERY, CAP = 5e-3, 10, 1000.0
TASKS = "position", "orientation"


def run(scene: Scene, method: str) -> Run:
    """Drive the robot of a scene by a method."""
    stack = METHODS[method](scene)
    reported: dict[str, float] = {}

    def proof(solution: Any) -> bool:
        for level in getattr(solution, "relaxed", ()):
            reported[level.name] = max(reported.get(level.name, 0.0), level.residual_norm)
        return bool(solution.certify().ok)

    controller = Controller(scene.robot, stack, dt=TICK, damping=DEFAULTS.get(method))
    record = simulate(
        controller, scene.start, duration=scene.duration, speed_cap=CAP, certify=EVERY, proof=proof
    )  # fmt: skip
    return Run(method, record, reported)


def singularities(
    picture: Annotated[
        Path | None, typer.Option("--picture", help="Draw the runs into this PNG.", parser=file(*PICTURE))
    ] = None,
) -> None:
    """Drive a planar arm, a UR5 and a Panda through singularities by every remedy, and compare."""
    if picture is not None:
        writable(picture.parent, [picture.name])
    done = {scene.name: [run(scene, method) for method in METHODS] for scene in scenes()}
    printer = console(130)
    for name, runs in done.items():
        show(printer, terminal(name, [_row(each) for each in runs]))
    printer.print(
        "rad/s, jump: the largest speed of a joint, inf where the run diverged and was stopped, and its largest change"
        " from tick to tick\nmm, deg: the largest error of the position and of the orientation, and the last one\ntold:"
        f" the largest residual norm in step.relaxed, asked every {EVERY}th tick, when the certificate is"
    )
    if picture is not None:
        from .singular_pictures import draw

        draw(picture, done)


def _row(run: Run) -> Row:
    row = {"method": run.method, "rad/s": f"{run.speed:.3g}", "jump": f"{run.jump:.3g}"}
    for task, unit, scale in zip(TASKS, ("mm", "deg"), (1e3, np.degrees(1.0)), strict=True):
        errors = scale * run.errors(task)
        row |= {unit: f"{errors.max():.1f}", f"last {unit}": f"{errors[-1]:.2f}"}
        row[f"told {'m/s' if unit == 'mm' else 'rad/s'}"] = f"{run.reported[task]:.3f}" if task in run.reported else ""
    return row | {"certified": f"{run.record.certified}/{run.record.checked}"}
