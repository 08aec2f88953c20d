"""Measures a simulated run against the figure that it reproduces, and writes the results as CSV."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import fields
from io import StringIO
from math import isnan, nan

import numpy as np

from ..base.checks import Array
from ..simulation.record import Record
from .run_result import AT_REST, RunResult
from .runs import Job, phi_error, tip_error
from .scenarios import MINUTE

#: From when on the tip must be on its path, and phi settled: shares of the motion. The position
#: feedback is slow (10 /min): the error of the start is below 1 mm only after 0.5 to 0.67 min.
TIP_FROM, PHI_FROM = 0.7, 0.2
#: Error of phi that counts as held [deg].
HELD = 1.0
#: Difference of a joint angle to the run at twice the tick up to which a run counts as converged [deg].
CONVERGED = 1.0


def measure(job: Job, record: Record, closed_form: Record | None = None, coarser: Record | None = None) -> RunResult:
    """The numbers of one run; beside it those of the same law by its formula, and of the same run at twice the tick."""
    scenario = job.scenario
    elapsed = record.t / scenario.duration
    share = peak = nan
    if scenario.phi is not None:
        error = np.abs(np.degrees(phi_error(scenario, record)))
        share = float(np.count_nonzero(error < HELD) / (job.ticks + 1))
        peak = _largest(error[elapsed >= PHI_FROM])
    difference = nan
    if closed_form is not None and not job.closed_form:
        both = min(len(record.q), len(closed_form.q))
        difference = _largest(np.abs(record.q[:both] - closed_form.q[:both]))
    too_fast = too_hard = limited = nan
    if job.law.inequalities and len(record):
        too_fast = max(_largest(np.abs(record.v)) - scenario.velocity_limit, 0.0)
        too_hard = max(_largest(np.abs(record.a)) - scenario.acceleration_limit, 0.0)
        limited = float(np.mean(np.any([states.any(axis=1) for states in record.active.values()], axis=0)))
    assert record.tau is not None  # a planar arm knows its torques and
    assert record.manipulability is not None  # its manipulability
    stopped = record.stopped
    return RunResult(
        figure=scenario.figure,
        law=job.law.title,
        backend=job.backend,
        tip_error_mm=1e3 * _largest(tip_error(record)[elapsed >= TIP_FROM]),
        phi_share=share,
        phi_peak_deg=peak,
        peak_speed=MINUTE * _largest(np.abs(record.v)),
        end_speed=MINUTE * _largest(np.abs(record.v[-1])),
        peak_acceleration=MINUTE**2 * _largest(np.abs(record.a[elapsed[:-1] >= PHI_FROM])),
        reversals=reversals(MINUTE * record.v),
        turned_deg=float(np.degrees(np.ptp(record.q, axis=0).max())),
        peak_torque=_largest(np.abs(record.tau)),
        least_singular=float(np.linalg.svd(scenario.arm.jacobian(record.q)[:, :2], compute_uv=False)[:, 1].min()),
        least_manipulability=float(record.manipulability.min()),
        velocity_excess=too_fast,
        acceleration_excess=too_hard,
        limited_share=limited,
        diverged_min=nan if record.diverged_at is None else record.diverged_at / MINUTE,
        certified=record.certified_share,
        difference_rad=difference,
        tick_deg=nan if coarser is None else _between_ticks(record, coarser),
        note=stopped.reason if stopped is not None and not stopped.diverged else "",
    )


def digits(value: float) -> str:
    """Two digits: 0.022, 1.5, 140."""
    return f"{float(f'{value:.2g}'):g}"


def to_csv(results: Sequence[RunResult]) -> str:
    """All numbers with full precision, one header line; empty where a number means nothing."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    names = [field.name for field in fields(RunResult)]
    writer.writerow(names)
    for found in results:
        values = [getattr(found, name) for name in names]
        writer.writerow(["" if isinstance(value, float) and isnan(value) else value for value in values])
    return out.getvalue()


def reversals(v: Array) -> int:
    """Changes of direction of the joint that has most, v [rad/min], shape (N + 1, n); at rest it has none."""
    turning = [np.sign(joint[np.abs(joint) > AT_REST]) for joint in v.T]
    return max(int(np.count_nonzero(np.diff(direction))) for direction in turning)


def _between_ticks(record: Record, coarser: Record) -> float:
    """Largest difference of a joint angle [deg] at the times of both, if both went to their end."""
    if record.stopped or coarser.stopped:
        return nan
    both = min(len(record.q[::2]), len(coarser.q))
    return float(np.degrees(np.abs(record.q[::2][:both] - coarser.q[:both]).max()))


def _largest(values: Array) -> float:
    return float(values.max()) if values.size else nan
