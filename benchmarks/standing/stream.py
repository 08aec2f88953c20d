"""The motion of a robot that stands, tick by tick, recorded in closed loop: its states, and how its contacts are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hqp.arrays import Array
from tasks import Contact, Controller
from tasks.contacts.kernels.layout import SHARE
from tasks.rows.site import Workspace

from .scenes import DT, FALLEN, PERIOD, RAMP, Lift, StandingScene, declare

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot


@dataclass(frozen=True, eq=False)
class StandingStream:
    """What every controller is given, tick by tick.

    Attributes
    ----------
    scene : StandingScene
    robot : PinocchioRobot
    q, v : array, shape (ticks, nq), (ticks, nv)
        Where the robot is.
    contacts : dict of str to array, shape (ticks, numbers)
        By the frame of each foot: whether it holds, where, and how large its forces may be.
    saturated : float
        How many torques are at their limits at once, mean.
    """

    scene: StandingScene
    robot: PinocchioRobot
    q: Array
    v: Array
    contacts: dict[str, Array]
    saturated: float

    @property
    def at_limit(self) -> str:
        """How many torques are at their limits, in words."""
        return f"{self.saturated:.1f} of {self.robot.nv - self.robot.base} torques"

    def __len__(self) -> int:
        return len(self.q)

    @property
    def changing(self) -> NDArray[np.bool_]:
        """The ticks at which a contact is being made or let go: its numbers are others than at the tick before."""
        after = [(row[1:] != row[:-1]).any(axis=1) for row in self.contacts.values()]
        return np.concatenate([[False], np.any(after, axis=0)])


def record(scene: StandingScene, ticks: int) -> StandingStream:
    """Run this library on the scene; each acceleration holds over its tick. Who has fallen begins anew."""
    robot = scene.load()
    declared = declare(scene, robot)
    controller = Controller(robot, declared.stack, order="torque", dt=DT)
    assert robot.torque_limit is not None
    most = robot.torque_limit[robot.base :] * (1.0 - 1e-9)
    q, v = np.zeros((ticks + 1, robot.nq)), np.zeros((ticks + 1, robot.nv))
    kept: dict[str, list[Array]] = {foot: [] for foot in scene.body.feet}
    q[0], saturated = robot.home, 0
    low = FALLEN * robot.at(robot.home, v[0]).frame(scene.body.base).position[2]
    for k in range(ticks):
        _change(controller, scene.lifts, k)
        step = controller(q[k], v[k], k * DT)
        for foot, contact in declared.contacts.items():
            kept[foot].append(numbers_of(contact, workspace(controller)))
        saturated += int(np.count_nonzero(np.abs(step.tau) >= most))
        q[k + 1] = robot.integrate(q[k], DT * v[k] + 0.5 * DT * DT * step.a)
        v[k + 1] = v[k] + DT * step.a
        if robot.at(q[k + 1], v[k + 1]).frame(scene.body.base).position[2] < low:
            q[k + 1], v[k + 1] = robot.home, 0.0
    contacts = {foot: np.array(rows) for foot, rows in kept.items()}
    return StandingStream(scene, robot, q[:-1], v[:-1], contacts, saturated / ticks)


def _change(controller: Controller[None, Array, Array], lifts: tuple[Lift, ...], k: int) -> None:
    """Let go and put down the feet whose time has come."""
    period = round(PERIOD / DT)
    for lift in lifts:
        if k % period == round(lift.at / DT):
            controller.release(lift.foot, RAMP)
        if k % period == round(lift.down / DT):
            controller.make(lift.foot, RAMP)


def workspace(controller: Controller[None, Array, Array]) -> Workspace:
    """Where the contacts of a controller are at work: nobody but who records and plays has to know."""
    return controller._rows.shared


def numbers_of(contact: Contact, shared: Workspace) -> Array:
    """How a contact is at present, in one array; without the share of its ramp, which only damped levels ask for."""
    slot = contact.slot(shared)
    return np.concatenate([slot.numbers[:SHARE], slot.caps])


def restore(contacts: Mapping[str, Contact], shared: Workspace, numbers: Mapping[str, Array]) -> None:
    """Let contacts be as they were, whatever has been since."""
    for frame, contact in contacts.items():
        slot, own = contact.slot(shared), numbers[frame]
        slot.numbers[:SHARE], slot.caps[:] = own[:SHARE], own[SHARE:]
