"""Simulates one scenario under one law with one backend; equal jobs are simulated once."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

import hqp

from ..base.checks import Array
from ..control.controller import Controller
from ..simulation.record import Record
from ..simulation.simulation import simulate
from .laws import NAMES, Law, laws_of
from .scenarios import MINUTE, Scenario

#: Joint speed [rad/s] beyond which a run has diverged (300 rad/min). Runs that do not diverge stay below
#: 80 rad/min; those that do pass from 200 to 1000 rad/min within 4e-4 min, so the time hardly depends on it.
SPEED_CAP = 300 / MINUTE
#: Every so many-th tick is put to the certificate.
CERTIFY = 50


@dataclass(frozen=True)
class Job:
    """One simulation: scenario, law, backend and tick. Equal jobs give equal records.

    Attributes
    ----------
    scenario : Scenario
    law : Law
    backend : str
    closed_form : bool
        Whether the law is evaluated as its formula.
    """

    scenario: Scenario
    law: Law
    backend: str
    closed_form: bool = False

    @property
    def tick(self) -> float:
        """Between two solves [s]."""
        return self.scenario.tick if self.law.inequalities else self.scenario.free_tick

    @property
    def ticks(self) -> int:
        """Number of solves, if the run goes to its end."""
        return round(self.scenario.duration / self.tick)

    @property
    def coarser(self) -> Job:
        """The same job at twice the tick, by which this one is checked."""
        item = self.scenario
        return replace(self, scenario=replace(item, tick=2 * item.tick, free_tick=2 * item.free_tick))


def jobs_of(scenario: Scenario, backend: str, laws: Collection[str] = NAMES) -> list[Job]:
    """All runs that one figure shows: each law by its formula, if it has one, and by the backend, if it can."""
    info = hqp.backend_info(backend)
    jobs = []
    for law in laws_of(scenario, laws):
        if law.closed_form:
            jobs.append(Job(scenario, law, law.closed_form, closed_form=True))
        if law.refusal(info) is None and law.closed_form != backend:
            jobs.append(Job(scenario, law, backend))
    return jobs


def controller(job: Job) -> Controller:
    """The controller of one job; whatever it needs is compiled by then.

    Raises
    ------
    UnknownBackend
        If the backend cannot run here.
    """
    law = job.law
    stack = law.closed_stack if job.closed_form and law.closed_stack is not None else law.stack
    arm, declared = job.scenario.arm, stack(job.scenario)
    return Controller(arm, declared, order="acceleration", dt=job.tick, backend=job.backend, damping=None)


def run(job: Job) -> Record:
    """Simulate one job, with its :func:`controller`."""
    scenario, law = job.scenario, job.law
    return simulate(
        controller(job),
        scenario.q0,
        duration=scenario.duration,
        speed_cap=SPEED_CAP,
        certify=CERTIFY,
        proof=law.closed_proof if job.closed_form else None,
    )


def tip_error(record: Record) -> Array:
    """Distance of the tip from where it should be [m], shape (N + 1,)."""
    return np.asarray(np.linalg.norm(record.errors["position"], axis=1))


def phi_error(scenario: Scenario, record: Record) -> Array:
    """Desired - actual orientation [rad], shape (N + 1,), in a scenario that has a desired one."""
    if scenario.phi is None:
        raise hqp.InvalidInput(f"figure {scenario.figure} has no desired orientation")
    return np.asarray(scenario.phi - record.pose[:, 2])
