"""A controller that runs in real time and can be changed while it runs: all that the page can do, without the page."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from queue import Empty, SimpleQueue
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hqp import HqpError, InvalidInput
from hqp.files.names import PAGE, misnamed, name_of

from ..base.checks import Array, positive_scalar
from ..control.controller import Controller
from ..rows.inequality import Inequality
from ..rows.part import Part
from ..rows.task import Task
from ..simulation.record import Record
from .motion import Motion
from .priorities import Priorities
from .targets import Target, targets_of

#: How long a change of priorities takes [s].
CHANGE = 0.5
#: The longest delay that the loop catches up [s]; the rest is left out.
LATE = 0.1
#: The longest sleep of the loop [s].
NAP = 0.02


class Session:
    """A motion in real time that can be paused, reset, reordered and recorded.

    One thread runs the loop, :meth:`run`; other threads act on it through :meth:`do`.

    Parameters
    ----------
    controller : Controller
        It must have a dt.
    q0 : array, shape (nq,), optional
        Configuration at the start (default: the robot's home).
    certify : int
        Every how many ticks one is put to the certificate and explained; 0 for none.

    Attributes
    ----------
    motion : Motion
    priorities : Priorities
    targets : list of Target
    running : bool
    speed : float
        Seconds of motion per second of real time.
    rate : float
        Ticks per second, measured over the last second.
    message : str
        The last error, or the last action.
    """

    def __init__(self, controller: Controller, q0: ArrayLike | None = None, *, certify: int = 25) -> None:
        self.priorities = Priorities(controller.stack)
        self.motion = Motion(controller, q0, certify, self.priorities.parts)
        self.controller = controller
        start = controller.robot.at(self.motion.q, self.motion.v)
        self.targets: list[Target] = targets_of(self.priorities.parts, start)
        self.running, self._speed = True, 1.0
        self.rate, self.message = 0.0, ""
        self._wishes: SimpleQueue[Callable[[], Any]] = SimpleQueue()
        self._due, self._counted, self._since = 0.0, 0, perf_counter()
        self._end = threading.Event()

    # Inputs.

    def do(self, wish: Callable[[], Any]) -> None:
        """Run an action between two ticks; its error, if any, becomes the message."""
        self._wishes.put(wish)

    def pause(self, paused: bool = True) -> None:
        """Pause the motion, or let it go on."""
        self.running = not paused

    def step(self) -> None:
        """Run one tick, and pause."""
        self.running = False
        self.motion.tick()

    def reset(self) -> None:
        """Go back to the start; targets, gains and priorities stay."""
        self.motion.reset()
        self.message, self._due = "", 0.0

    @property
    def speed(self) -> float:
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        self._speed = positive_scalar(value, "speed of time")

    def move_level(self, place: int, by: int) -> None:
        """Move the level at a place up (by = -1) or down (by = 1), within `CHANGE` seconds.

        Raises
        ------
        InvalidInput
            If there is no such place, or the controller refuses the order.
        """
        self._change(lambda: self.priorities.move(place, by))

    def switch_level(self, place: int, on: bool) -> None:
        """Switch the level at a place off or on, within `CHANGE` seconds.

        Raises
        ------
        InvalidInput
            If there is no such place, or no other level.
        """
        self._change(lambda: self.priorities.switch(place, on))

    def _change(self, make: Callable[[], Any]) -> None:
        kept = self.priorities.keep()
        try:
            self.motion.change(make(), CHANGE)
        except HqpError:
            self.priorities.restore(kept)
            raise

    @property
    def tasks(self) -> list[Task]:
        """All tasks, which have gains, including those inside inequalities."""
        return [task for task in map(_task, self.priorities.parts) if task is not None]

    def set_gain(self, task: Task, gain: float) -> None:
        """Set the gain of a task [1/s], live; gains of several rows keep their ratios, and the largest becomes this.

        Raises
        ------
        InvalidInput
            If the controller refuses it, for example as too large for its tick; then nothing has changed.
        """
        own = np.asarray(task.gain)
        task.gain = positive_scalar(gain, "gain", unit="1/s") * (own / own.max())

    def record(self, on: bool = True) -> None:
        """Begin a recording, or end it; its record is then `motion.record`."""
        if on:
            self.motion.start_recording()
            self.message = "recording"
        else:
            record = self.motion.stop_recording()
            self.message = "nothing was recorded" if record is None else f"recorded: {record!r}"

    def save(self, path: str | os.PathLike[str]) -> Record:
        """End a recording, and write its record: as a page if the name ends in .html or .htm, otherwise as .npz.

        Raises
        ------
        InvalidInput
            If nothing was recorded, or the file has another suffix than these, or cannot be written.
        """
        if self.motion.recording:
            self.record(False)
        record = self.motion.record
        if record is None:
            raise InvalidInput("nothing was recorded that could be saved; record first")
        if misnamed(name_of(path), *PAGE) is None:
            record.save_html(path)
        else:
            record.save(path)
        self.message = f"saved: {os.fspath(path)}"
        return record

    # The loop.

    def serve(self, wait: float = 0.0) -> None:
        """Run the requested actions, after waiting up to `wait` [s] for the first."""
        while True:
            try:
                wish = self._wishes.get(timeout=wait) if wait > 0.0 else self._wishes.get_nowait()
            except Empty:
                return
            wait = 0.0
            try:
                wish()
            except HqpError as refused:
                self.message = str(refused)

    def advance(self, seconds: float) -> int:
        """Run the ticks that are due after `seconds` of real time; returns how many were run.

        If the machine is too slow, the motion falls behind the clock; missed ticks do not accumulate.
        """
        if not self.running:
            self._due = 0.0
            return 0
        self._due = min(self._due + seconds * self._speed, LATE * max(1.0, self._speed))
        made, begin = 0, perf_counter()
        while self._due >= self.motion.dt and self.motion.tick():
            self._due -= self.motion.dt
            made += 1
            if perf_counter() - begin > LATE:
                break
        if self.motion.fault is not None:
            self.running, self.message = False, self.motion.fault
        return made

    def run(self) -> None:
        """Run in real time until :meth:`end`."""
        last = perf_counter()
        while not self._end.is_set():
            now = perf_counter()
            self._count(self.advance(now - last), now)
            last = now
            left = (self.motion.dt - self._due) / self._speed if self.running else NAP
            self.serve(min(NAP, max(1e-4, left - (perf_counter() - now))))

    def end(self) -> None:
        """Let :meth:`run` return."""
        self._end.set()

    def _count(self, made: int, now: float) -> None:
        self._counted += made
        if now - self._since > 1.0:
            self.rate = self._counted / (now - self._since)
            self._counted, self._since = 0, now

    # Outputs.

    @property
    def q(self) -> Array:
        """The configuration of the robot, a read-only array."""
        return self.motion.q


def _task(part: Part) -> Task | None:
    own = part.task if isinstance(part, Inequality) else part
    return own if isinstance(own, Task) else None
