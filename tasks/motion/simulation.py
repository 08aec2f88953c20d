r"""The loop closed: controller and robot, tick after tick, and the record of it.

The command holds over the tick and the robot follows it exactly:

.. math::

    \text{acceleration order:}\quad & q \leftarrow q + v\,dt + \tfrac12 a\,dt^2, \quad v \leftarrow v + a\,dt \\
    \text{velocity order:}\quad & q \leftarrow q + v\,dt

which is the exact motion under such a command: what a run shows is the controller, not the integrator. Where a
configuration is more than a number a joint, the sum is the robot's own ``integrate``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, RegularisedSolution, Solution
from hqp.checks import of_type, whole_number

from .._checks import finite, finite_scalar, function, positive_scalar
from ..robots.robot import check_joints, integrate
from .controller import Controller
from .log import Log
from .record import Record, Stop

#: Joint speed [rad/s] beyond which a run counts as diverged: 16 turns a second.
SPEED_CAP = 100.0
#: The longest run: a record of so many ticks fills a gigabyte or two.
MOST_TICKS = 10_000_000


def simulate(
    controller: Controller,
    q0: ArrayLike,
    v0: ArrayLike | None = None,
    *,
    duration: float,
    start: float = 0.0,
    speed_cap: float = SPEED_CAP,
    certify: int = 50,
    proof: Callable[[Any], bool] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Record:
    """Run a controller on the robot it was made for.

    Parameters
    ----------
    controller : Controller
        With its dt [s]: one solve a tick.
    q0 : array, shape (nq,)
        Joint positions at the start [rad].
    v0 : array, shape (nv,), optional
        Joint velocities at the start [rad/s] (default: at rest).
    duration : float
        [s], rounded to whole ticks.
    start : float
        Time of the first tick [s].
    speed_cap : float
        A run in which a joint turns faster than this [rad/s] has diverged and stops.
    certify : int
        Put every so many-th tick to the certificate; 0 for none.
    proof : callable, optional
        The judge of the solutions of those ticks (default: ``solution.certify().ok``).
    progress : callable, optional
        Told the share of the run that is done, about a hundred times.

    Returns
    -------
    Record
        Up to the tick before, if the run diverges or the solver has no answer: see ``stopped``.

    Raises
    ------
    InvalidInput
        If the controller has no dt, the start is not finite or has the wrong shape, a number is
        out of range, or the run would take more than `MOST_TICKS`.
    """
    dt = of_type(controller, Controller, "controller").dt
    if dt is None:
        raise InvalidInput("simulate needs the tick; give the controller dt in s")
    share = positive_scalar(duration, "duration", unit="s") / dt
    if share > MOST_TICKS:
        raise InvalidInput(f"duration = {duration:g} s is more than {MOST_TICKS} ticks of dt = {dt:g} s")
    ticks = round(share)
    if ticks < 1:
        raise InvalidInput(f"duration = {duration} s is shorter than one tick, dt = {dt} s")
    start = finite_scalar(start, "start")
    cap = positive_scalar(speed_cap, "speed cap", unit="rad/s")
    certify = whole_number(certify, "certify")
    robot = controller.robot
    q = finite(q0, "q0")
    v = np.zeros(robot.nv) if v0 is None else finite(v0, "v0")
    check_joints(robot, q, v)
    judge = _certified if proof is None else function(proof, "proof")
    progress = None if progress is None else function(progress, "progress")
    report_every = max(ticks // 100, 1)

    log = Log(controller, ticks, robot.at(q, v))
    stopped = None
    for k in range(ticks):
        t = start + k * dt
        step = controller.unchecked(q, v, t)
        log.state(k, t, step.state)
        if not step.ok:
            where = f" ({step.solution.message})" if step.solution.message else ""
            stopped = Stop(t, f"{step.solution.status} at t = {t:g} s{where}", diverged=False)
            break
        if certify and k % certify == 0:
            log.check(t, step.solution, judge(step.solution))

        if step.a is not None:
            a = step.a
            q = integrate(robot, q, dt * v + (0.5 * dt * dt) * a)
            v = v + dt * a
        else:
            assert step.v is not None
            a = (step.v - v) / dt
            v = step.v.copy()
            q = integrate(robot, q, dt * v)
        q.flags.writeable = v.flags.writeable = False  # ours, and kept as they are: a robot need not copy them
        speed = float(np.abs(v).max(initial=0.0))
        if not speed <= cap:  # NaN too
            stopped = Stop(t + dt, f"diverged at t = {t + dt:g} s: a joint turns at {speed:.3g} rad/s", diverged=True)
            break
        log.tick(k, a, step.solution.status)
        if progress is not None and (k + 1) % report_every == 0:
            progress((k + 1) / ticks)
    else:
        log.state(ticks, start + ticks * dt, robot.at(q, v))
    return log.record(stopped)


def _certified(solution: Solution | RegularisedSolution) -> bool:
    return solution.certify().ok
