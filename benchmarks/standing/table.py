"""A robot that stands, decided by everyone in turn: times, and what the answers are worth, as a table."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.util import find_spec

import numpy as np

from hqp import certify
from hqp.arrays import Array
from hqp.certificate import excess

from ..tables import Row
from ..ticks.driver import Driver
from ..ticks.interleaved import Measured, measure
from ..ticks.ours import Ours
from ..ticks.scenes import SCENES as ARMS
from ..ticks.stream import record as record_arm
from .ours import OursStanding, Standing
from .peers import DaqpStanding, Weighted
from .scenes import StandingScene
from .solvers import SOLVERS
from .stream import StandingStream, record

#: Every so many-th answer is put to the certificate, and held against the strict one.
EVERY = 20
#: The scene whose tick is the unit of all others, and what it is called here.
UNIT, UNIT_NAME = "panda slow", "hqp, panda"
LEGEND = f"""\
robots that stand: us of the processor, whole ticks with torques, each the shortest of its rounds
changes: of the ticks at which a contact is being made or let go; rows, solve: medians of the parts, timed alone; of
others, to lay the QP out counts as rows; to panda, to weighted: ratio of medians, to the tick of a Panda in the same
run, to the fastest weighted QP; solve to: the same of the solves alone; failed: ticks without an answer; lost: by how
much more than in the strict answer the centre of mass misses its acceleration, worst [m/s^2]; beyond: largest excess
over a row of physics or limits that the strict answer keeps; proved: certificates of every {EVERY}th answer
all are given the rows that hqp writes"""


#: A row that is passed by no more counts as kept.
KEPT = 1e-6
#: What is told of the answers of a driver that is not judged.
NOTHING: Row = {"lost": "", "beyond": "", "proved": ""}


def drivers(stream: StandingStream) -> list[Driver]:
    """This library, the others that are here, and this library on the arm that is the unit."""
    found: list[Driver] = [OursStanding(stream)]
    found += [Weighted(solver(), stream) for package, solver in SOLVERS.items() if find_spec(package) is not None]
    if find_spec("daqp") is not None:
        found.append(DaqpStanding(stream))
    arm = next(scene for scene in ARMS if scene.name == UNIT)
    found.append(Ours(record_arm(arm, len(stream)), name=UNIT_NAME))
    for driver in found:
        driver.clock = time.thread_time_ns
    return found


def measured(
    scene: StandingScene, ticks: int, rounds: int, progress: Callable[[], None] = lambda: None
) -> tuple[str, list[Row]]:
    """How many torques are at a limit in one scene, and the rows of its table.

    Columns
    -------
    median, p99, worst
        Of all ticks, each the shortest of its rounds; time of the processor, so that a long tick does not suffer more
        than a short one from what else the machine does.
    changes, worst change
        Median and worst of the ticks at which a contact is being made or let go.
    rows, solve
        Medians of the parts: of others, to lay the QP out counts as rows.
    to panda, to weighted
        Ratio of the medians: to the tick of a Panda in the same run, and to the fastest weighted QP; `solve to` is the
        same of the solves alone.
    lost
        By how much more than in the strict answer the centre of mass misses its acceleration [m/s^2], worst.
    failed
        Ticks without an answer.
    beyond
        The largest excess over a row of physics or limits that the strict answer keeps, in its unit.
    proved
        Certified answers, of every so many-th.
    """
    stream = record(scene, ticks)
    here = drivers(stream)
    found = measure(here, rounds, progress)
    found = [replace(m, ns=m.ns.min(axis=0)) for m in found]
    return stream.at_limit, _table(stream, here, found)


def _table(stream: StandingStream, here: Sequence[Driver], found: Sequence[Measured]) -> list[Row]:
    unit = found[-1].median
    weighted = [m for m in found if m.name.startswith("weighted")]
    whole = min((m.median for m in weighted), default=np.nan)
    alone = min((_part(m, 2) for m in weighted), default=np.nan)
    judged = _judged(here[0], found[:-1])
    rows = []
    for driver, m in zip(here, found, strict=True):
        us, standing = 1e-3 * m.ns, isinstance(driver, Standing)
        row = {"scene": stream.scene.name, "method": m.name}
        row |= {"median us": _us(np.median(us)), "p99 us": _us(np.quantile(us, 0.99)), "worst us": _us(us.max())}
        changing = us[stream.changing]
        told = standing and len(changing) > 0
        row |= {"changes us": _us(np.median(changing)) if told else ""}
        row |= {"worst change us": _us(changing.max()) if told else ""}
        row |= {"rows us": _us(1e-3 * _part(m, 1)), "solve us": _us(1e-3 * _part(m, 2))}
        row |= {"to panda": f"{m.median / unit:.3g}"}
        row |= {"to weighted": f"{m.median / whole:.2f}" if standing and np.isfinite(whole) else ""}
        row |= {"solve to": f"{_part(m, 2) / alone:.2f}" if standing and np.isfinite(alone) else ""}
        row |= {"failed": str(int(np.isnan(m.v).any(axis=1).sum()))} | judged.get(m.name, NOTHING)
        rows.append(row)
    return rows


def _us(value: float) -> str:
    return f"{value:.0f}" if value >= 100.0 else f"{value:.1f}"


def _part(m: Measured, stage: int) -> float:
    """The median of one part of the ticks [ns]; none where it failed always."""
    known = m.stages[:, stage][np.isfinite(m.stages[:, stage])]
    return float(np.median(known)) if len(known) else np.nan


def _judged(strict: Driver, found: Sequence[Measured]) -> dict[str, Row]:
    """What the answers of all are worth, held against the first one's."""
    assert isinstance(strict, Standing)
    lost: dict[str, list[float]] = {m.name: [] for m in found}
    beyond: dict[str, list[float]] = {m.name: [] for m in found}
    proofs = dict.fromkeys(lost, 0)
    sample = range(0, len(strict.stream), EVERY)
    for k in sample:
        h = strict.fill(k, strict.state(k))
        above = slice(0, h.pointers[strict.hard])
        A, wanted = h.dense()[above], h.levels[strict.hard]
        assert wanted.A is not None
        kept = np.abs(excess(A @ found[0].v[k], h.lower[above], h.upper[above])) <= KEPT
        own = slice(0, strict.declared.center_of_mass.size(strict.robot))

        def missed(x: Array, A: Array = wanted.A[own], b: Array = wanted.lower[own]) -> float:
            return float(np.linalg.norm(A @ x - b))

        for m in found:
            x = m.v[k]
            if not np.isfinite(x).all():
                continue
            lost[m.name].append(missed(x) - missed(found[0].v[k]))
            beyond[m.name].append(float(np.abs(excess(A @ x, h.lower[above], h.upper[above]))[kept].max()))
            proofs[m.name] += certify(h, x).ok
    return {
        m.name: {
            "lost": f"{max(lost[m.name]):.0e}" if lost[m.name] else "",
            "beyond": f"{max(beyond[m.name]):.0e}" if beyond[m.name] else "",
            "proved": f"{proofs[m.name]}/{len(sample)}",
        }
        for m in found
    }
