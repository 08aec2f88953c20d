"""The motions of one scene as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hqp.arrays import Array

from ..tables import Row
from ..ticks.stream import Stream
from .loop import Run
from .metrics import Ranges, fast_share, frozen, jerk, longest, overspeed, ranges, rms
from .tracking import errors, inevitable

#: By how much the hand has to be too far off for a robot that stands still to count as frozen [m].
THRESHOLD = 5e-3
#: Columns that are told where no joint starts outside its range; and, beside them, where one does.
SHOWN = (
    "scene", "method", "mm", "max", "deg", "jerk", ">3 Hz", "frozen", "longest", "raised", "out", "over", "p50", "p99",
)  # fmt: skip
COMING_BACK = "back"


@dataclass(frozen=True, eq=False)
class Tracking:
    """How a run kept to its targets, tick by tick.

    Attributes
    ----------
    far, excess : array, shape (ticks,)
        Distance of the hand from its target, and what of it no configuration forces [m].
    turned : array, shape (ticks,)
        Angle between the hand and its target [rad].
    """

    far: Array
    excess: Array
    turned: Array


def track(stream: Stream, runs: Sequence[Run]) -> dict[str, Tracking]:
    """The same for all runs of a stream.

    What is forced is what inverse kinematics finds, or less where one of the runs came nearer.
    """
    (frame,) = stream.scene.frames
    measured = {run.name: errors(stream, frame, run.q) for run in runs}
    forced = np.min([inevitable(stream, frame), *(far for far, _ in measured.values())], axis=0)
    return {name: Tracking(far, far - forced, turned) for name, (far, turned) in measured.items()}


def hand_share(stream: Stream) -> float:
    """The share of the power of the target's own velocity that is fast."""
    (frame,) = stream.scene.frames
    return fast_share(np.gradient(stream.positions[frame], stream.scene.dt, axis=0), stream.scene.dt)


def table(stream: Stream, runs: Sequence[Run], tracking: Mapping[str, Tracking]) -> list[Row]:
    """One row a run; the columns are explained in the documentation of teleoperation."""
    return [_row(stream, run, tracking[run.name]) for run in runs]


def shown(stream: Stream, rows: Sequence[Row]) -> list[Row]:
    """What of it fits a terminal."""
    columns = [*SHOWN, COMING_BACK] if stream.scene.beyond else SHOWN
    return [{column: row[column] for column in row if column in columns} for row in rows]


def _row(stream: Stream, run: Run, tracked: Tracking) -> Row:
    dt, robot = stream.scene.dt, stream.robot
    still = frozen(run.v, tracked.excess, THRESHOLD)
    joints = np.array([robot.at(q, run.v[0]).joints for q in run.q])
    kept = ranges(joints, *robot.position_limit)
    us = 1e-3 * run.ns.min(axis=0)  # the same work in every round: what the machine adds is never negative
    fast, over = overspeed(run.v, robot.velocity_limit)
    return {
        "scene": stream.scene.name,
        "method": run.name,
        "mm": f"{1e3 * rms(tracked.excess):.1f}",
        "max": f"{1e3 * tracked.excess.max():.1f}",
        "whole mm": f"{1e3 * rms(tracked.far):.1f}",
        "whole max": f"{1e3 * tracked.far.max():.1f}",
        "deg": f"{np.degrees(rms(tracked.turned)):.2f}",
        "deg max": f"{np.degrees(tracked.turned.max()):.2f}",
        "jerk": _jerk(jerk(run.v, dt)),
        ">3 Hz": f"{100 * fast_share(run.v, dt):.2f}%",
        "frozen": str(int(still.sum())),
        "longest": f"{1e3 * dt * longest(still):.0f}",
        "raised": str(int(run.held.sum())),
        "raised by": ", ".join(sorted(run.raised)),
        "out ticks": str(kept.ticks),
        "out": _small(kept.worst, kept.ticks),
        "back": _back(kept, dt),
        "further": _small(kept.further, int(kept.further > 0.0)),
        "over ticks": str(fast),
        "over": _small(over, fast),
        "p50": f"{np.nanmedian(us):.0f}",
        "p99": f"{np.nanquantile(us, 0.99):.0f}",
    }


def _jerk(value: float) -> str:
    return f"{value:.0f}" if value >= 10.0 else f"{value:.1f}"


def _small(worst: float, ticks: int) -> str:
    """By how much a limit was passed, at worst; nothing where it is round-off."""
    return f"{worst:.0e}" if ticks else "0"


def _back(kept: Ranges, dt: float) -> str:
    return "never" if kept.back is None else f"{dt * kept.back:.2f}"
