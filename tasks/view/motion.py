"""A controller in closed loop with its model, tick by tick: what is shown, plotted, explained and recorded of it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type, whole_number

from ..base.checks import Array, finite
from ..control.controller import Controller
from ..control.step import Step
from ..robots.robot import check_joints, home, integration
from ..rows.part import Part, Stack
from ..simulation.account import NEGLIGIBLE, ROUND_OFF, met
from ..simulation.log import Log
from ..simulation.motion import follow
from ..simulation.record import Record
from .priorities import level_name

#: Time that is plotted [s], and the number of points.
PLOTTED, POINTS = 10.0, 200
#: The most ticks of a recording.
MOST_RECORDED = 60_000


@dataclass(frozen=True, eq=False)
class Sample:
    """One point of the plots.

    Attributes
    ----------
    t : float
        Time [s].
    residuals : dict of str to float
        Name of a level -> its residual norm, in the unit of x.
    v : array, shape (nv,)
        Joint velocities [rad/s], [m/s].
    """

    t: float
    residuals: dict[str, float]
    v: Array


@dataclass(frozen=True, eq=False)
class Verdict:
    """The certificate and explanation of the last tick that was checked.

    Attributes
    ----------
    t : float
        Time of the tick [s].
    certified : bool
        Whether the certificate accepts it.
    levels : tuple of (str, bool, str)
        For each level: its parts, whether it is met, and what it lacks and why.
    """

    t: float
    certified: bool
    levels: tuple[tuple[str, bool, str], ...]


class Motion:
    """The closed loop, without a clock: one call of :meth:`tick` per tick.

    Parameters
    ----------
    controller : Controller
        It must have a dt.
    q0 : array, shape (nq,), optional
        Configuration at the start (default: the robot's home).
    certify : int
        Every how many ticks one is put to the certificate and explained; 0 for none.
    parts : list of Part
        All parts that may be in its stack, for recordings.

    Attributes
    ----------
    t : float
        Time of the next tick [s].
    q, v : array
        Configuration and velocities of the robot.
    step : Step or None
        The result of the last tick.
    verdict : Verdict or None
    fault : str or None
        Why the motion has stopped; :meth:`reset` restarts it.
    samples : deque of Sample
        Points of the plots, for the last 10 s.
    """

    def __init__(self, controller: Controller, q0: ArrayLike | None, certify: int, parts: list[Part]) -> None:
        if of_type(controller, Controller, "controller").dt is None:
            raise InvalidInput("a live controller needs its tick; give it dt in s")
        self.controller, self._parts = controller, parts
        self.dt = float(controller.dt or 0.0)
        robot = controller.robot
        self._start = np.array(home(robot) if q0 is None else finite(q0, "q0"))
        self._start.flags.writeable = False
        check_joints(robot, self._start, np.zeros(robot.nv))
        self._certify = whole_number(certify, "certify")
        self._integrate = integration(robot)
        self._log: Log | None = None
        self.record: Record | None = None
        self.samples: deque[Sample] = deque(maxlen=POINTS)
        self._every = max(1, round(PLOTTED / POINTS / self.dt))
        self.reset()

    def reset(self) -> None:
        """Go back to the start and to t = 0, at rest; this ends a recording."""
        self.stop_recording()
        self.t, self.ticks = 0.0, 0
        self.q, self.v = self._start, np.zeros(self.controller.robot.nv)
        self.step: Step[Any, Any, Any] | None = None
        self.verdict: Verdict | None = None
        self.fault: str | None = None
        self.samples.clear()
        self.change(self.controller.stack, 0.0)
        self.controller.settle()

    def change(self, stack: Stack, duration: float) -> None:
        """Change to another stack within `duration` [s].

        Raises
        ------
        InvalidInput
            If the stack does not fit; then nothing has changed.
        """
        self.controller.change(stack, duration=duration)

    def tick(self) -> bool:
        """Run one tick; returns whether the robot has moved."""
        if self.fault is not None:
            return False
        step = self.controller.unchecked(self.q, self.v, self.t)
        self.step = step
        if not step.ok:
            self.fault = f"{step.solution.status} at t = {self.t:g} s {step.solution.message}".rstrip()
            self.stop_recording()
            return False
        if self._certify and self.ticks % self._certify == 0:
            self.verdict = self._judge(step)
        q, v, a = follow(self._integrate, step, self.q, self.v, self.dt)
        if self.ticks % self._every == 0:
            names = map(level_name, self.controller.stack.levels)
            norms = (_plain(level.residual_norm) for level in step.solution.levels)
            self.samples.append(
                Sample(self.t, dict(zip(names, norms, strict=False)), np.where(np.abs(v) > ROUND_OFF, v, 0.0))
            )
        self._write(step, a)
        q.flags.writeable = v.flags.writeable = False
        self.q, self.v, self.ticks = q, v, self.ticks + 1
        self.t = self.ticks * self.dt
        return True

    def _judge(self, step: Step[Any, Any, Any]) -> Verdict:
        told = []
        for level in step.solution.explain().levels:
            name = " + ".join(part.part for part in level.parts)
            told.append(
                (name, met(level), f"{name} met, within {NEGLIGIBLE:g}" if met(level) != level.met else str(level))
            )
        return Verdict(self.t, bool(step.solution.certify().ok), tuple(told))

    # Recording.

    @property
    def recording(self) -> bool:
        """Whether ticks are recorded."""
        return self._log is not None

    @property
    def recorded(self) -> int:
        """How many ticks the current recording has."""
        return 0 if self._log is None else self._log.states

    def start_recording(self) -> None:
        """Record every tick from the next one on, up to `MOST_RECORDED`."""
        state = self.controller.robot.at(self.q, self.v)
        self._log = Log(self.controller, MOST_RECORDED, state, self.t, self._parts)

    def stop_recording(self) -> Record | None:
        """End the recording; returns its record, also kept as `record`, or None if no tick was recorded."""
        log, self._log = getattr(self, "_log", None), None
        if log is None or not log.states:
            return None
        log.state(log.states, self.t, self.controller.robot.at(self.q, self.v))
        self.record = log.record(None)
        return self.record

    def _write(self, step: Step[Any, Any, Any], a: Array) -> None:
        log = self._log
        if log is None:
            return
        k = log.states
        if self._certify and k % self._certify == 0:
            log.check(self.t, step.solution, step.solution.certify().ok)
        log.state(k, self.t, step.state)
        log.tick(k, a, step)
        if log.states >= MOST_RECORDED:
            self.stop_recording()


def _plain(norm: float) -> float:
    """The norm, or 0 if it is round-off: the axis of a plot would otherwise be scaled to round-off."""
    return float(norm) if norm > ROUND_OFF else 0.0
