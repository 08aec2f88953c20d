"""Blocks of ticks of every kind of part, timed in this process, or by another checkout in a process of its own.

What counts is the time of the processor. A tick of milliseconds is longer than what a busy machine leaves a process at
a time, and on the clock of the wall it would be slower by what others do meanwhile, a short one not.

``python -m benchmarks.ticks.blocks`` is that other process: a line of JSON in, a line of JSON out.
"""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from time import thread_time_ns
from typing import Any

import numpy as np

import tasks
from hqp import InvalidInput
from hqp.arrays import Array
from tasks import Controller, PoseTask, load_robot, solve_ik

from ..checkout import front
from ..timing import undisturbed
from .parts import DT, KINDS, PLAIN, Order, Scene

#: Of the random poses and starts of inverse kinematics.
SEED = 0
#: Without the damping that is the default, in checkouts that have one.
STRICT: dict[str, Any] = {"damping": None} if "damping" in inspect.signature(Controller).parameters else {}


class Blocks(ABC):
    """Nanoseconds of the processor for single calls, a block of them at a time."""

    @abstractmethod
    def ticks(self, name: str, order: Order, first: int, last: int) -> list[int]:
        """Of the ticks from first to last of the controller with this kind of part.

        Raises
        ------
        InvalidInput
            If the library refuses the stack.
        """

    @abstractmethod
    def rows(self, name: str, order: Order, first: int, last: int) -> list[int]:
        """Of kinematics and rows alone, without solving; see :meth:`ticks`."""

    @abstractmethod
    def poses(self, first: int, last: int) -> list[int]:
        """Of inverse kinematics, of the poses from first to last, each from a random start."""

    def close(self) -> None:  # noqa: B027
        """Let go of what it holds."""


class Here(Blocks):
    """The library of this process.

    All controllers are called with the states of one motion, which the plain stack at velocity order makes in closed
    loop, so that what they differ by is their stack alone.

    Parameters
    ----------
    ticks : int
        Length of the motion.
    """

    def __init__(self, ticks: int) -> None:
        self._motion = _motion(ticks)
        self._made: dict[tuple[str, Order], tuple[Controller, Any]] = {}

    def ticks(self, name: str, order: Order, first: int, last: int) -> list[int]:
        return self._timed(self._at_work(name, order)[0], first, last)

    def rows(self, name: str, order: Order, first: int, last: int) -> list[int]:
        controller, rows = self._at_work(name, order)
        at, fill = controller.robot.at, rows.fill
        return self._timed(lambda q, v, t: fill(at(q, v), t), first, last)

    def _timed(self, call: Callable[[Array, Array, float], object], first: int, last: int) -> list[int]:
        clock, times, motion = thread_time_ns, [], self._motion[first:last]
        call(*motion[0])  # warm, as all but the first of a block
        with undisturbed():
            for q, v, t in motion:
                start = clock()
                call(q, v, t)
                times.append(clock() - start)
        return times

    def _at_work(self, name: str, order: Order) -> tuple[Controller, Any]:
        """A controller, and rows of its stack; made when asked for, and called once, for what is compiled then."""
        found = self._made.get((name, order))
        if found is None:
            scene, kind = Scene(order), next(kind for kind in KINDS if kind.name == name)
            controller = Controller(scene.robot, kind.declare(scene), order=order, dt=DT, **STRICT)
            controller(*self._motion[0])
            rows = controller.stack.build(scene.robot, "velocity" if order == "velocity" else "acceleration", DT)
            found = self._made[name, order] = controller, rows
        return found

    def poses(self, first: int, last: int) -> list[int]:
        clock, times = thread_time_ns, []
        robot = _ranged()
        for number in range(first, last):
            pose, start_at = _pose(number)
            with undisturbed():
                start = clock()
                solve_ik(robot, pose, start_at)
                times.append(clock() - start)
        return times


class There(Blocks):
    """The library of another checkout, with the stacks of this one.

    Raises
    ------
    InvalidInput
        If there is no checkout, or the process ends before its time; with its last words.
    """

    def __init__(self, tree: Path, ticks: int) -> None:
        if not all((tree / package).is_dir() for package in ("hqp", "tasks")):
            raise InvalidInput(f"{str(tree)!r} is no checkout of this library: it must have the folders hqp and tasks")
        self._folder, self._tree = TemporaryDirectory(), tree
        folder = Path(self._folder.name)
        self._said = (folder / "said.txt").open("w+")
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__, str(ticks)],
            cwd=folder,
            env=front(folder / "front", tree),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            text=True,
        )
        try:
            found = Path(self._asked()["tasks"])
            if not found.is_relative_to(tree.resolve()):
                raise InvalidInput(f"{str(tree)!r}: {found} was imported in its place")
        except BaseException:
            self.close()
            raise

    def ticks(self, name: str, order: Order, first: int, last: int) -> list[int]:
        return self._times("ticks", name, order, first, last)

    def rows(self, name: str, order: Order, first: int, last: int) -> list[int]:
        return self._times("rows", name, order, first, last)

    def poses(self, first: int, last: int) -> list[int]:
        return self._times("poses", first, last)

    def close(self) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()
        self._said.close()
        self._folder.cleanup()

    def _times(self, *command: str | int) -> list[int]:
        assert self._process.stdin is not None
        print(json.dumps(command), file=self._process.stdin, flush=True)
        reply = self._asked()
        if "refused" in reply:
            raise InvalidInput(reply["refused"])
        times: list[int] = reply["ns"]
        return times

    def _asked(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            self._said.seek(0)
            words = self._said.read().strip().splitlines()
            raise InvalidInput(f"{str(self._tree)!r}: {words[-1] if words else 'it ended without a word'}")
        reply: dict[str, Any] = json.loads(line)
        return reply


def _motion(ticks: int) -> list[tuple[Array, Array, float]]:
    """Positions, velocities and times of the plain stack in closed loop."""
    scene = Scene("velocity")
    controller, robot = Controller(scene.robot, PLAIN.declare(scene), dt=DT, **STRICT), scene.robot
    q, v, found = robot.home, np.zeros(robot.nv), []
    for k in range(ticks):
        found.append((q, v, k * DT))
        step = controller(q, v, k * DT)
        assert step.v is not None
        v = step.v
        q = robot.integrate(q, DT * v)
    return found


@cache
def _ranged() -> Any:
    """The robot of inverse kinematics."""
    return load_robot("panda", lock=["panda_finger_joint1"])


@cache
def _pose(number: int) -> tuple[PoseTask, Array]:
    """A pose in reach, and where to start."""
    robot, rng = _ranged(), np.random.default_rng([SEED, number])
    target, start = (rng.uniform(*robot.position_limit) for _ in range(2))
    tip = robot.at(target, np.zeros(robot.nv)).frame()
    return PoseTask(tip.position.copy(), tip.rotation.copy(), gain=1.0), start


def serve(ticks: int) -> None:
    """Answer until nobody asks any more."""
    blocks = Here(ticks)
    print(json.dumps({"tasks": str(Path(tasks.__file__).resolve())}), flush=True)
    for line in sys.stdin:
        what, *rest = json.loads(line)
        try:
            reply: dict[str, Any] = {"ns": getattr(blocks, what)(*rest)}
        except InvalidInput as error:
            reply = {"refused": str(error)}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    serve(int(sys.argv[1]))
