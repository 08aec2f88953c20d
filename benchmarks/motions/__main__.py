"""``python -m benchmarks.motions``: record the motions anew that the families of real motions are made of."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from hqp.commands.command import run
from hqp.commands.options import path
from hqp.files.whole import writable

from . import standing
from .data import FOLDER
from .playback import FIGURES, SCENES
from .recording import record_all

app = typer.Typer(rich_markup_mode=None, add_completion=False, pretty_exceptions_enable=False)


@app.command()
def motions(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for the data; that of the families by default.", parser=path)
    ] = FOLDER,
) -> None:
    """Record, in closed loop with this library, the ticks of the families of "motion", "thesis" and "contacts"."""
    files = [*dict.fromkeys(scene.robot for scene in SCENES.values()), "thesis"]
    files += dict.fromkeys(map(standing.file_of, standing.SCENES.values()))
    writable(out, [*(f"{file}.npz" for file in files), "families.csv"])
    with Progress(console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task("", total=len(SCENES) + len(FIGURES) + len(standing.families()))
        record_all(out, lambda name: progress.update(bar, description=name, advance=1))
    print(
        f"recorded {len(SCENES)} motions, {len(FIGURES)} figures of the thesis"
        f" and {len(standing.SCENES)} robots that stand to {out}"
    )


if __name__ == "__main__":
    sys.exit(run(app, "python -m benchmarks.motions"))
