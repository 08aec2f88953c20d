"""The base class of drivers: one library on a recorded motion, timed tick by tick."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from hqp.arrays import Array

from .stream import Stream

#: The parts of a tick that are timed alone.
STAGES = ("kinematics", "rows", "solve")


class Driver(ABC):
    """One library, its tasks declared, its targets and configurations there in its own types.

    Attributes
    ----------
    name : str
    q : list
        Where the robot is at each tick, in the types of the library.
    raised : Counter
        Ticks without an answer, by the name of the exception.
    clock : callable
        What tells nanoseconds.
    """

    name: str
    q: list[Any]
    clock: Callable[[], int]

    def __init__(self, name: str, stream: Stream) -> None:
        self.name, self.stream, self.raised = name, stream, Counter[str]()
        self.clock = time.perf_counter_ns

    @property
    def unknowns(self) -> int:
        """How many numbers an answer has."""
        return self.stream.robot.nv

    def stand(self, k: int, q: Array, v: Array) -> None:
        """Let the robot be elsewhere at tick k than the stream has it: where the library itself has led it."""
        self.q[k] = self.configured(q)

    def configured(self, q: Array) -> Any:
        """A configuration of the stream as the library has it."""
        return q

    @abstractmethod
    def tick(self, k: int) -> Any:
        """Tick k, from targets and configuration to joint velocities: what is timed."""

    @abstractmethod
    def stages(self, k: int) -> Iterator[None]:
        """The same in parts; yields at the end of each of `STAGES`."""

    @abstractmethod
    def velocity(self, answer: Any) -> Array:
        """The joint velocities of an answer of :meth:`tick`, in the order of the stream; of who decides forces, all."""

    def proved(self, k: int, v: Array) -> bool | None:
        """Whether joint velocities are certified as the optimum of tick k; None where nothing can be."""
        return None

    def run(self, first: int, last: int) -> tuple[Array, Array]:
        """Nanoseconds of each tick from first to last, shape (ticks,), and joint velocities, NaN where it failed."""
        clock, times, answers, nothing = self.clock, [], [], np.full(self.unknowns, np.nan)
        for k in range(first, last):
            start = clock()
            try:
                answer = self.tick(k)
            except Exception as error:  # each library has exceptions of its own for having no answer
                answer = None
                self.raised[type(error).__name__] += 1
            times.append(clock() - start)
            answers.append(nothing if answer is None else np.array(self.velocity(answer)))
            answer = None  # as in a control loop, whose memory the next tick takes: fresh memory costs page faults
        return np.array(times), np.array(answers)

    def split(self, first: int, last: int) -> Array:
        """Nanoseconds of each stage of each tick, shape (ticks, 3); NaN where it failed."""
        clock, rows = self.clock, []
        for k in range(first, last):
            laps = [clock()]
            try:
                for _ in self.stages(k):
                    laps.append(clock())  # noqa: PERF401
            except Exception:
                laps = []
            rows.append(np.diff(laps) if len(laps) == 1 + len(STAGES) else np.full(len(STAGES), np.nan))
        return np.array(rows)

    def close(self) -> None:  # noqa: B027
        """Let go of what it holds."""
