"""``hqp live``: a robot in the browser, with a stack to be dragged, reordered and asked why."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hqp.commands.options import integer, path, real

from .robot_options import Base, Body, Lock

#: Time between two ticks [s].
TICK = 0.01


def live(
    robot: Annotated[str, typer.Argument(help="A name, as panda or g1, or a URDF or MJCF file.", metavar="ROBOT")],
    lock: Lock = None,
    base: Base = None,
    body: Body = None,
    tick: Annotated[float, real("--dt", help="Time between two ticks [s].", metavar="DT")] = TICK,
    certify: Annotated[
        int, integer("--certify", least=0, help="Certify and explain every N-th tick; 0: none.", metavar="N")
    ] = 25,
    host: Annotated[
        str,
        typer.Option(
            "--host",
            help="Address to listen on. With 0.0.0.0 other machines can connect, without a password.",
            metavar="ADDRESS",
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int,
        integer("--port", least=1, most=65535, help="Port to listen on, or the next that is free.", metavar="PORT"),
    ] = 8080,
    folder: Annotated[
        Path, typer.Option("--out", "-o", help="Where recordings are saved.", metavar="DIR", parser=path)
    ] = Path("."),
) -> None:
    """Move a robot in the browser, simulated.

    Drag its targets, reorder its levels, and read what each lacks and why. The levels are joint limits, position,
    orientation, posture; of a robot on feet: joint limits, feet, centre of mass, hands, posture. No real robot is
    connected. In Python, tasks.live(controller) shows a stack of your own. Ctrl-C ends it.
    """
    from ..drawing.stage import viser_module
    from ..robots.loading import load_robot
    from ..view.live import live as show
    from ..view.stacks import ready_controller

    viser_module()  # fails before a robot is loaded, if viser is missing
    machine = load_robot(robot, base=base, body=body or None, lock=lock or ())
    show(ready_controller(machine, tick), host=host, port=port, certify=certify, folder=folder)
