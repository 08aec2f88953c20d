"""Libraries in an interpreter of their own: they do not get on with other Pinocchios, or are large."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from hqp import InvalidInput
from hqp.arrays import Array
from tasks.base.rotations import exp, log

from .driver import Driver
from .scenes import COM
from .stream import Stream
from .urdf import bare, root_link

#: Runs there, and imports nothing from here.
SCRIPTS = Path(__file__).parent / "there"
#: What is imported of each library.
MODULES = {"placo": "placo", "tsid": "tsid", "drake": "pydrake.multibody.inverse_kinematics"}


def check_apart(library: str, python: str) -> None:
    """Refuse an interpreter that cannot be started, or does not have the library.

    Raises
    ------
    InvalidInput
        With its last words.
    """
    try:
        done = subprocess.run(
            [python, "-I", "-c", f"import {MODULES[library]}"], capture_output=True, text=True, check=False
        )
    except OSError as error:
        raise InvalidInput(f"--{library} {python}: {error.strerror}") from error
    if done.returncode:
        raise InvalidInput(f"--{library} {python}: {_last(done.stderr)}")


class Apart(Driver):
    """One of `MODULES` with limits of joint positions and velocities, times taken where it runs.

    placo asks for the whole error to be gone after a step, and has no gain. Targets are therefore moved towards the
    frame beforehand, by the share that the others leave to the next ticks, and all libraries here are asked for the
    whole of what is left: one step.

    Parameters
    ----------
    library, python : str
        Its name, and an interpreter that has it.
    stream : Stream
    name : str
    **options
        Of its ``Library`` in `SCRIPTS`.

    Raises
    ------
    InvalidInput
        If it ends before its time; with its last words.
    """

    def __init__(self, library: str, python: str, stream: Stream, *, name: str = "", **options: Any) -> None:
        super().__init__(name or library, stream)
        self.folder = TemporaryDirectory()
        folder = Path(self.folder.name)
        urdf = bare(stream.scene.robot, stream.scene.held)
        ET.ElementTree(urdf).write(folder / "robot.urdf")
        scene = _about(stream) | {"urdf": str(folder / "robot.urdf"), "root": root_link(urdf), "options": options}
        np.savez(folder / "motion.npz", scene=json.dumps(scene), **_motion(stream))
        self.said = (folder / "said.txt").open("w+")
        self.process = subprocess.Popen(
            [python, "-I", str(SCRIPTS), library, str(folder / "motion.npz")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.said,
            text=True,
        )
        try:
            self._reply()
        except InvalidInput:
            self.close()
            raise

    def tick(self, k: int) -> Any:
        raise NotImplementedError("it runs in blocks")

    def stages(self, k: int) -> Iterator[None]:
        raise NotImplementedError("it runs in blocks")

    def run(self, first: int, last: int) -> tuple[Array, Array]:
        said = self._ask("run", first, last)
        nothing = [np.nan] * self.stream.robot.nv
        return np.array(said["ns"]), np.array(
            [nothing if step is None else self.velocity(step) for step in said["step"]]
        )

    def split(self, first: int, last: int) -> Array:
        return np.array(self._ask("split", first, last)["ns"], dtype=float)

    def velocity(self, answer: list[float]) -> Array:
        return np.array(answer) / self.stream.scene.dt

    def close(self) -> None:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()
        self.said.close()
        self.folder.cleanup()

    def _ask(self, command: str, first: int, last: int) -> dict[str, Any]:
        assert self.process.stdin is not None
        print(command, first, last, file=self.process.stdin, flush=True)
        return self._reply()

    def _reply(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            self.said.seek(0)
            raise InvalidInput(f"{self.name}: {_last(self.said.read())}")
        reply: dict[str, Any] = json.loads(line)
        return reply


def _last(words: str) -> str:
    """The last line of what a process said."""
    lines = words.strip().splitlines()
    return lines[-1] if lines else "it ended without a word"


def _about(stream: Stream) -> dict[str, Any]:
    """What the script is told of the robot and its tasks, beside its motion."""
    scene, robot = stream.scene, stream.robot
    goals = [
        asdict(goal) | {"frame": COM if goal.what == "com" else goal.frame, "level": level}
        for level, goals in enumerate(scene.levels)
        for goal in goals
    ]
    return {"dt": scene.dt, "base": robot.base, "joints": robot.joint_names[robot.base :], "goals": goals}


def _motion(stream: Stream) -> dict[str, Any]:
    """What the script is given tick by tick, targets moved: where the robot is and is to be after the tick."""
    scene, robot = stream.scene, stream.robot
    states = [robot.at(q, v) for q, v in zip(stream.q, stream.v, strict=True)]
    given: dict[str, Any] = {"q": stream.q}
    for frame in scene.frames:
        own = [state.frame(frame) for state in states]
        p, R = (np.array([getattr(place, what) for place in own]) for what in ("position", "rotation"))
        given[f"position {frame}"] = p + scene.step * (stream.positions[frame] - p)
        turns = [log(target @ now.T) for target, now in zip(stream.rotations[frame], R, strict=True)]
        given[f"rotation {frame}"] = [exp(scene.step * turn) @ now for turn, now in zip(turns, R, strict=True)]
        given[f"turned {frame}"] = R
    com = np.array([state.center_of_mass.position for state in states])
    given[f"position {COM}"] = com + scene.step * (stream.positions[COM] - com)
    q = stream.q[:, robot.nq - (robot.nv - robot.base) :]
    given["posture"] = q + scene.posture_step * (robot.home[-q.shape[1] :] - q)
    assert robot.velocity_limit is not None
    assert robot.position_limit is not None
    low, high = (bound[robot.base :] for bound in robot.position_limit)
    return given | {"low": low, "high": high, "speed": robot.velocity_limit[robot.base :]}
