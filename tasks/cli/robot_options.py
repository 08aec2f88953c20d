"""Options of commands that load a robot, passed on to :func:`tasks.load_robot`."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

Lock = Annotated[
    list[str] | None,
    typer.Option(
        "--lock", help="Hold this joint at its neutral position; may be given several times.", metavar="JOINT"
    ),
]
Base = Annotated[
    Literal["fixed", "planar", "floating"] | None,
    typer.Option("--base", help="Base of the robot (default: as the library knows it, or as its file says)."),
]
Body = Annotated[
    list[str] | None,
    typer.Option(
        "--body",
        help="Root body, if an MJCF has several; may be given several times, for one robot of all.",
        metavar="NAME",
    ),
]
