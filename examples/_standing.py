"""What the examples on feet share: motions from stop to stop, and what is measured of a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tasks import Chain, Contact, Line, MujocoPlant, Record, Robot, quintic


def stops(start: ArrayLike, *ways: tuple[float, ArrayLike | None]) -> Chain:
    """From place to place, at rest at each: seconds, and where it then is, or None where it is to stay."""
    lines, here = [], np.asarray(start, dtype=float)
    for seconds, place in ways:
        there = here if place is None else np.asarray(place, dtype=float)
        lines.append(Line(here, there, duration=seconds, timing=quintic))
        here = there
    return Chain(lines)


def moved(record: Record, contact: Contact) -> np.ndarray:
    """How far a contact is along the ground from where it began to bear [m], shape (N, 2); 0 where it does not."""
    assert record.robot is not None
    bears = record.forces[contact.name][..., 2].sum(axis=1) > 1e-6
    out, start = np.zeros((len(record), 2)), np.zeros(2)
    for k in np.flatnonzero(bears):
        frame = record.robot.at(record.q[k], record.v[k]).frame(contact.frame)
        here = (frame.position + frame.rotation @ contact.shape.centre)[:2]
        start = start if k and bears[k - 1] else here
        out[k] = here - start
    return out


def passed(record: Record, contacts: Iterable[Contact]) -> float:
    """By how much a commanded torque is beyond its limit, or a force outside its cone [N m], [N]."""
    assert record.tau is not None
    assert record.robot is not None
    torque = np.abs(record.tau) - record.robot.torque_limit[-record.tau.shape[1] :]
    forces = [(record.forces[contact.name], contact.friction or 0.0) for contact in contacts]
    cones = [(np.hypot(f[..., 0], f[..., 1]) - mu * f[..., 2]).max() for f, mu in forces]
    return float(max(torque.max(), *cones, 0.0))


def tell(record: Record, contacts: Sequence[Contact], plant: MujocoPlant, still: float) -> None:
    """Print what a run is judged by: statuses; slip, and creep from `still` [s] on; torques and cones."""
    ways = {contact.name: 1e3 * moved(record, contact) for contact in contacts}
    slip = max(np.linalg.norm(way, axis=1).max() for way in ways.values())
    begin = int(np.searchsorted(record.t, still))
    creep = max(np.linalg.norm(way[-1] - way[begin]) for way in ways.values())
    held = 1e3 * plant.creep(record.q[0], record.t[-1] - still)
    optimal = sum(status.value == "optimal" for status in record.status)
    print(f"{record}; {optimal} optimal")
    print(f"feet slip by at most {slip:.2f} mm, and creep by {creep:.3f} mm in the last {record.t[-1] - still:g} s")
    print(f"(with all joints held they creep by {held:.3f} mm in as long)")
    print(f"no torque or cone is passed by more than {passed(record, contacts):.0e} N m, N")
    if "center of mass" in record.errors:
        off = 1e3 * np.linalg.norm(record.errors["center of mass"], axis=1)
        print(f"center of mass off by at most {off.max():.2f} mm, {off[-1]:.2f} mm at the end")


class Scales(MujocoPlant):
    """A plant that writes down what its ground bears, tick by tick, by the names of the contacts [N]."""

    def __init__(self, robot: Robot, **options: Any) -> None:
        super().__init__(robot, **options)
        self.read: list[dict[str, np.ndarray]] = []

    def advance(self, q: np.ndarray, v: np.ndarray, tau: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """As the plant does."""
        after = super().advance(q, v, tau, dt)
        self.read.append(self.forces)
        return after
