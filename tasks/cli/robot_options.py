"""Options of commands that load a robot, passed on to :func:`tasks.load_robot`."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

Lock = Annotated[
    list[str] | None,
    typer.Option("--lock", help="Hold this joint where neutral; may be given several times.", metavar="JOINT"),
]
Base = Annotated[
    Literal["fixed", "planar", "floating"] | None,
    typer.Option("--base", help="How the robot stands (default: as the library knows it, or as its file says)."),
]
Body = Annotated[
    list[str] | None,
    typer.Option("--body", help="Where the robot begins, if an MJCF has several.", metavar="NAME"),
]
