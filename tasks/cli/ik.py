"""``hqp ik``: inverse kinematics from the command line, with what stopped it where a pose cannot be reached."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from typer.core import TyperCommand

from hqp.commands.options import file, integer, real
from hqp.commands.terminal import console
from hqp.files.names import PICTURE

from .robot_options import Base, Body, Lock

if TYPE_CHECKING:
    from rich.table import Table

    from ..base.checks import Array
    from ..ik.inverse_kinematics import IkResult
    from ..robots.pinocchio import PinocchioRobot

NOT_REACHED = 1
#: The options that take several numbers, separated by blanks or commas.
SEVERAL = ("--position", "--orientation")
#: A joint rests on its limit if it is as near as this [rad], [m].
RESTS = 1e-6


class Numbers(TyperCommand):
    """A command that reads ``--position 0.5 0 0.4`` as ``--position=0.5,0,0.4``, for any number of values."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        return super().parse_args(ctx, joined(args))


def joined(words: Sequence[str]) -> list[str]:
    """The words of a command line, with the numbers after each option in `SEVERAL` joined to that option."""
    from hqp.checks import spelled_number

    found, rest = list[str](), list(words)
    while rest:
        word = rest.pop(0)
        if word in SEVERAL and rest and not rest[0].startswith("--"):
            numbers = [rest.pop(0)]
            while rest and spelled_number(rest[0]) is not None:
                numbers.append(rest.pop(0))
            word += f"={','.join(numbers)}"
        found.append(word)
    return found


def ik(
    robot: Annotated[str, typer.Argument(help="A name, as panda or ur5, or a URDF or MJCF file.", metavar="ROBOT")],
    position: Annotated[str, typer.Option("--position", help="Where the frame is to be [m].", metavar="X Y Z")],
    frame: Annotated[
        str | None, typer.Option("--frame", help="Frame to bring there (default: the robot's tip).", metavar="NAME")
    ] = None,
    orientation: Annotated[
        str | None,
        typer.Option(
            "--orientation",
            help="Three numbers are roll, pitch and yaw [rad], four a quaternion x y z w (default: free).",
            metavar="R P Y | X Y Z W",
        ),
    ] = None,
    start: Annotated[
        Literal["home", "neutral", "random"],
        typer.Option("--start", help="Configuration to start from, and the posture to keep."),
    ] = "home",
    seed: Annotated[int, integer("--seed", least=0, help="Seed of all that is random.")] = 0,
    iterations: Annotated[int, integer("--iterations", least=1, help="Most iterations, restarts included.")] = 300,
    tolerance: Annotated[
        float | None,
        real(
            "--tolerance",
            help="Error that counts as none [m], [rad] (default: 1e-4, 1e-3).",
            metavar="T",
        ),
    ] = None,
    lock: Lock = None,
    base: Base = None,
    body: Body = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            "--plot", help="Draw the robot at the answer, to this PNG.", parser=file(*PICTURE), metavar="FILE"
        ),
    ] = None,
) -> None:
    """Solve inverse kinematics for a pose of a frame.

    The joints stay inside their ranges; position has priority over orientation, and orientation over posture. Exit
    code 1 if the pose is out of reach: the nearest is printed, and what stops it.
    """
    from hqp.files.whole import writable

    from ..base.checks import finite
    from ..frames.orientation import OrientationTask
    from ..frames.position import PositionTask
    from ..ik.inverse_kinematics import TOLERANCE, solve_ik
    from ..joints.posture import PostureTask
    from ..robots.loading import load_robot

    place = finite(_numbers("--position", position, (3,)), "--position")
    rotation = None if orientation is None else _rotation(orientation)
    if plot is not None:
        writable(plot.parent, [plot.name])
    machine = load_robot(robot, base=base, body=body or None, lock=lock or ())
    begin = _begin(machine, start, seed)
    stack = PositionTask(place, frame=frame, gain=1.0) >> PostureTask(begin, gain=1.0)
    if rotation is not None:
        above, below = stack.levels
        stack = above[0] >> OrientationTask(rotation, frame=frame, gain=1.0) >> below[0]
    result = solve_ik(
        machine,
        stack,
        begin,
        tolerance=TOLERANCE if tolerance is None else tolerance,
        iterations=iterations,
        seed=seed,
    )
    _show(machine, result)
    if plot is not None:
        from ..robots.stick_figure import stick_figure

        stick_figure(plot, machine, result.q, frame=frame, position=place, rotation=rotation)
        print(f"drawn: {plot}")
    if not result.reached:
        raise typer.Exit(NOT_REACHED)


def _begin(robot: PinocchioRobot, start: str, seed: int) -> Array:
    """The configuration to start from; a random one keeps the base at its place in `home`."""
    import numpy as np

    if start == "random":
        return robot.on_base(robot.home, robot.random(np.random.default_rng(seed)))
    return robot.neutral if start == "neutral" else robot.home


def _numbers(option: str, text: str, counts: tuple[int, ...]) -> list[float]:
    """The numbers of an option, separated by commas or blanks; `counts` are the allowed numbers of them."""
    from hqp import InvalidInput
    from hqp.checks import spelled_number

    words = text.replace(",", " ").split()
    found = {word: spelled_number(word) for word in words}
    wrong = next((word for word, value in found.items() if value is None), None)
    if wrong is not None or len(words) not in counts:
        said = f"{wrong!r} is no number" if wrong is not None else f"{len(words)} numbers"
        allowed = " or ".join(map(str, counts))
        raise InvalidInput(f"{option} {text}: {said}; give {allowed} numbers, as in {option} 0.5 0 0.4")
    return [value for word in words if (value := found[word]) is not None]


def _rotation(text: str) -> Array:
    from ..base.checks import finite
    from ..base.rotations import from_quaternion, from_rpy

    numbers = finite(_numbers("--orientation", text, (3, 4)), "--orientation").tolist()
    return from_rpy(*numbers) if len(numbers) == 3 else from_quaternion(*numbers)


def _show(robot: PinocchioRobot, result: IkResult) -> None:
    """Print the joints, the errors, what stopped each task, and whether the pose was reached."""
    out = console(100)
    out.print(_joints(robot, result.q))
    for task, errors in result.errors.items():
        out.print(f"{task}: {', '.join(_error(norm, unit) for unit, norm in errors.items())} away", soft_wrap=True)
    out.print(f"\n{result.solution.explain()}\n", markup=False, soft_wrap=True)
    print(f"q = {result.q.tolist()}")  # all digits, for use elsewhere
    out.print(result.status, style="green" if result.reached else "bold red", soft_wrap=True)


def _joints(robot: PinocchioRobot, q: Array) -> Table:
    """One line per joint: its position, its range, and whether it rests on a limit."""
    from rich.box import SIMPLE_HEAD
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("joint")
    for title in "position", "lower", "upper":
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("")
    for name, position, low, high in robot.describe(q):
        ends = [side for side, room in (("lower", position - low), ("upper", high - position)) if room <= RESTS]
        at = f"at its {ends[0]} limit" if ends else ""
        table.add_row(escape(name), *(f"{value:.4f}" for value in (position, low, high)), at, style="red" if at else "")
    return table


def _error(norm: float, unit: str) -> str:
    """An error in a readable unit."""
    from math import degrees

    return f"{1e3 * norm:.4g} mm" if unit == "m" else f"{degrees(norm):.4g} deg" if unit == "rad" else f"{norm:.4g}"
