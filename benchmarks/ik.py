"""``python -m benchmarks ik``: inverse kinematics of random reachable poses, compared with other libraries."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress

from hqp import InvalidInput
from hqp.commands.options import integer
from hqp.commands.terminal import console
from hqp.files.whole import writable
from tasks import load_robot

from .ik_methods import METHODS, missing
from .ik_ours import TOLERANCE, Method, Outcome, Target
from .tables import Out, Row, save, show, terminal

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

#: Of the G1, one arm; all else of it is held.
_ARM = "shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_roll", "wrist_pitch", "wrist_yaw"


@dataclass(frozen=True)
class Machine:
    """An arm of the library.

    Attributes
    ----------
    robot : str
        Its name there.
    moves : tuple of str
        The joints that move, where not all do.
    tip : str, optional
        Of robots that have no tip of their own.
    home : dict of str to float
        Joints that start elsewhere than the library has them, away from singular configurations [rad].
    """

    robot: str
    moves: tuple[str, ...] = ()
    tip: str | None = None
    home: Mapping[str, float] = field(default_factory=dict)

    def load(self) -> PinocchioRobot:
        """The arm, fixed to the world."""
        robot = load_robot(self.robot, base="fixed", tip=self.tip)
        if self.moves:
            others = [name for name in robot.joint_names if name not in self.moves]
            robot = load_robot(self.robot, base="fixed", tip=self.tip, lock=others)
        home = np.array(robot.home)
        for name, position in self.home.items():
            home[robot.joint_names.index(name)] = position
        robot.home = home
        return robot


#: Seven, seven, six and seven joints.
MACHINES = {
    "panda": Machine("panda", tuple(f"panda_joint{i}" for i in range(1, 8))),
    "xarm7": Machine("xarm7", home={"joint2": -0.3, "joint4": 1.0, "joint6": 1.3}),
    "ur5": Machine("ur5"),
    "g1 arm": Machine("g1", tuple(f"left_{joint}_joint" for joint in _ARM), "left_rubber_hand"),
}
#: How often all may begin anew, and what counts as outside a limit [rad].
ATTEMPTS, OUTSIDE = (1, 10), 1e-9


def ik(
    count: Annotated[int, integer("--count", "-n", least=1, help="Poses of each robot.")] = 1000,
    robot: Annotated[
        list[str] | None, typer.Option("--robot", "-r", help="One of these; may be given several times.")
    ] = None,
    attempts: Annotated[
        list[int] | None,
        integer("--attempts", "-a", least=1, help="May be given several times (default: 1 and 10)."),
    ] = None,
    budget: Annotated[int, integer("--budget", "-b", least=1, help="Steps of an attempt.")] = 100,
    seed: Annotated[int, integer("--seed", least=0)] = 0,
    start: Annotated[Literal["home", "neutral"], typer.Option("--start", help="Where all of them start.")] = "home",
    out: Out = None,
) -> None:
    """Solve for random reachable poses by this library, Pink, mink and OInK, interleaved in one run."""
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
            machine = MACHINES[name].load()
            machine.home = getattr(machine, start)
            targets = poses(machine, count, seed)
            here: list[Row] = []
            for most in attempts or ATTEMPTS:
                methods = [kind(machine, most > 1) for kind in kinds]
                bar = progress.add_task(f"{name}, attempts: {most}", total=count)
                timed = measure(methods, targets, most * budget, lambda bar=bar: progress.advance(bar))
                here += [row(name, most, method, timed[method]) for method in methods]
            rows += here
            show(printer, terminal(f"{name}: {count} poses in reach, from {start}", here, group="attempts"))
            if out is not None:
                save(out, rows)
    printer.print(
        f"solved: within {TOLERANCE[0]:g} m and {TOLERANCE[1]:g} rad; steps: median of those solved; ms: of the"
        f" processor, a pose, all of them\nattempts: {budget} steps each; more than one: as many in all, begun anew at"
        " random configurations where the\nerror stays, by the rule of solve_ik for everyone"
        f"\noutside: poses on whose way a joint was more than {OUTSIDE:g} rad outside its range"
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
    """Outcome and CPU seconds of every method on every target, in turn, so that disturbances affect all alike."""
    timed: dict[Method, list[tuple[Outcome, float]]] = {method: [] for method in methods}
    for method in methods:
        method.solve(targets[0], budget)  # what is done once is not timed
    gc.disable()
    try:
        for number, target in enumerate(targets):
            first = number % len(methods)
            for method in methods[first:] + methods[:first]:
                start = time.thread_time()
                outcome = method.solve(target, budget)
                timed[method].append((outcome, time.thread_time() - start))
            tick()
    finally:
        gc.enable()
    return timed


def row(robot: str, attempts: int, method: Method, timed: list[tuple[Outcome, float]]) -> Row:
    """One line of the table."""
    steps = [outcome.steps for outcome, _ in timed if outcome.reached]
    ms = 1e3 * np.array([second for _, second in timed])
    return {
        "family": robot,
        "attempts": str(attempts),
        "method": method.name,
        "solved": f"{len(steps) / len(timed):.1%}",
        "steps": f"{np.median(steps):.0f}" if steps else "",
        "p50 ms": f"{np.median(ms):.2f}",
        "p95 ms": f"{np.quantile(ms, 0.95):.2f}",
        "mean ms": f"{np.mean(ms):.2f}",
        "outside": str(sum(outcome.beyond > OUTSIDE for outcome, _ in timed)),
    }
