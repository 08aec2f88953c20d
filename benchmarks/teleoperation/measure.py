"""The metrics of one motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hqp.arrays import Array

from ..ticks.stream import Stream
from .loop import Run
from .metrics import fast_share, frozen, jerk, longest, overspeed, ranges, rms
from .returns import Returns, allowed, returns
from .setups import Own
from .shadow import moved, pushed
from .soonest import soonest
from .tracking import Tracking

#: By how much the hand has to be too far off for a robot that stands still to count as frozen [m].
THRESHOLD = 5e-3
#: A target that is slower stands [m/s].
STANDS = 1e-6
#: How many time constants 1 / K coming back may take.
CONSTANTS = 5.0


@dataclass(frozen=True)
class Measure:
    """What a table tells of a run, in SI units; None where the scene does not ask for it.

    Attributes
    ----------
    far, far_max, excess, excess_max : float
        Distance from the target, root mean square and largest, and the same without what is forced [m].
    turned, turned_max : float or None
        Angles [rad].
    jerk : float
        [rad/s^3].
    fast : float
        The share of the power that is above 3 Hz.
    frozen, longest : int
        Ticks that are, and the most in a row.
    raised : int
        Ticks without an answer; `by` names the exceptions.
    out_ticks, out, further : int, float, float
        Ticks outside the ranges, by how much at most, and how much further out what started there went [rad].
    back : float or None
        When joints that start outside were inside [s]; None for never.
    over_ticks, over : int, float
        Ticks that are too fast, and by how much at most [rad/s].
    reach : float or None
        How long the hand needed at most when its target came back into reach [s].
    soonest : float or None
        From when on any motion within the joint speeds could have been there that time [s]; told where the hand needed
        more than 5 / K.
    caught : int
        How often it was not there at all.
    moved : float or None
        By how much, at most, the hand is farther off for what the levels below asked [m]; None of other libraries.
    pushed : float or None
        The same, against joints that follow the levels below as far as these do not push the hand [m].
    strayed : float or None
        How far frames that are to stand have gone [m].
    end, forced : float or None
        Distance from the target at the last tick, and what of it inverse kinematics of the same stack leaves [m]; None
        where the target still moves.
    p50, p99 : float
        Whole ticks [us].
    """

    far: float
    far_max: float
    excess: float
    excess_max: float
    turned: float | None
    turned_max: float | None
    jerk: float
    fast: float
    frozen: int
    longest: int
    raised: int
    by: str
    out_ticks: int
    out: float
    further: float
    back: float | None
    over_ticks: int
    over: float
    reach: float | None
    soonest: float | None
    caught: int
    moved: float | None
    pushed: float | None
    strayed: float | None
    end: float | None
    forced: float | None
    p50: float
    p99: float


def measure(
    stream: Stream, runs: Sequence[Run], tracking: Mapping[str, Tracking], forced: Array, own: Mapping[str, Own]
) -> dict[str, Measure]:
    """All runs of a stream, by name; `own` has the setups of this library."""
    return {run.name: _measure(stream, run, tracking[run.name], forced, own.get(run.name)) for run in runs}


def target_speed(stream: Stream) -> Array:
    """How fast the targets move, the fastest of them, shape (ticks,) [m/s]."""
    dt = stream.scene.dt
    moves = [np.gradient(stream.positions[frame], dt, axis=0) for frame in stream.scene.led]
    return np.max([np.linalg.norm(move, axis=1) for move in moves], axis=0)


def _measure(stream: Stream, run: Run, tracked: Tracking, forced: Array, setup: Own | None) -> Measure:
    scene, robot = stream.scene, stream.robot
    dt, gain = scene.dt, scene.gain
    still = frozen(run.v, tracked.excess, THRESHOLD)
    joints = np.array([robot.at(q, run.v[0]).joints for q in run.q])
    kept = ranges(joints, *robot.position_limit)
    over_ticks, over = overspeed(run.v, robot.velocity_limit)
    speed = target_speed(stream)
    stands = bool(speed[-1] < STANDS)
    came = returns(forced, tracked.excess, speed, gain, dt, CONSTANTS / gain)
    us = 1e-3 * run.ns.min(axis=0)  # the same work in every round: what the machine adds is never negative
    return Measure(
        far=rms(tracked.far),
        far_max=float(tracked.far.max()),
        excess=rms(tracked.excess),
        excess_max=float(tracked.excess.max()),
        turned=rms(tracked.turned) if len(tracked.turned) else None,
        turned_max=float(tracked.turned.max()) if len(tracked.turned) else None,
        jerk=jerk(run.v, dt),
        fast=fast_share(run.v, dt),
        frozen=int(still.sum()),
        longest=longest(still),
        raised=int(run.held.sum()),
        by=", ".join(sorted(run.raised)),
        out_ticks=kept.ticks,
        out=kept.worst,
        further=kept.further,
        back=None if kept.back is None else dt * kept.back,
        over_ticks=over_ticks,
        over=over,
        reach=came.slowest,
        soonest=_soonest(stream, run, forced, came, speed),
        caught=came.caught,
        moved=None if setup is None else moved(stream, run, setup),
        pushed=None if setup is None else pushed(stream, run, setup),
        strayed=float(tracked.strayed.max()) if len(tracked.strayed) else None,
        end=float(tracked.far[-1]) if stands else None,
        forced=float(forced[-1]) if stands else None,
        p50=float(np.nanmedian(us)),
        p99=float(np.nanquantile(us, 0.99)),
    )


def _soonest(stream: Stream, run: Run, forced: Array, came: Returns, speed: Array) -> float | None:
    """How soon the hand could have been back when it needed longest, where that is longer than its gain is slow."""
    scene = stream.scene
    if came.slowest is None or came.slowest <= CONSTANTS / scene.gain or len(scene.led) > 1:
        return None
    (frame,), since = scene.led, came.since
    way = slice(since, since + round(came.slowest / scene.dt) + 1)
    within = forced[way] + allowed(speed[way], scene.gain)
    return soonest(stream.robot, frame, run.q[since], stream.positions[frame][way], within, scene.dt)
