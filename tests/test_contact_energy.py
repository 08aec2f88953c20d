"""The power balance of robots that stand: the energy changes by what motors and contacts do, and by nothing else."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from contact_scenes import DT, Scene, advanced, humanoid, moved, quadruped, talos

from tasks import CenterOfMassTask, Controller, Step

#: Half of the time over which energies are compared [s].
H = 1e-5


def power(scene: Scene, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> float:
    """The rate of kinetic and potential energy, from those shortly before and after (q, v) [W]."""
    model, data = scene.robot.model, scene.robot.model.createData()
    states = [advanced(scene.robot, q, v, a, h) for h in (-H, H)]
    before, after = (pin.computeMechanicalEnergy(model, data, *state) for state in states)
    return float(after - before) / (2.0 * H)


def of_contacts(scene: Scene, q: np.ndarray, v: np.ndarray, step: Step) -> float:
    """What the contact forces do at the points on which they act [W]."""
    state, total = scene.robot.at(q, v), 0.0
    assert step.forces is not None
    for contact in scene.feet:
        frame, f = state.frame(contact.frame), step.forces[contact.name]
        velocity, turning = frame.linear @ v, frame.angular @ v
        if contact.wrench:
            arm = frame.rotation @ contact.shape.centre
            total += f[:3] @ (velocity + np.cross(turning, arm)) + f[3:] @ turning
        else:
            arms = contact.shape.points @ frame.rotation.T
            total += float(np.sum(f * (velocity + np.cross(turning, arms))))
    return float(total)


SCENES = {
    "points": humanoid,
    "wrenches": lambda: humanoid(rectangle=True, wrench=True),
    "quadruped": quadruped,
    "talos": talos,
}


def check_balance(scene: Scene, q: np.ndarray, v: np.ndarray, step: Step) -> tuple[float, float]:
    """Returns the power of all, and of the contacts alone."""
    whole, motors, contacts = power(scene, q, v, step.a), step.tau @ v[6:], of_contacts(scene, q, v, step)
    assert abs(whole - motors - contacts) < 1e-6 * (1.0 + abs(whole) + abs(motors) + abs(contacts))
    return abs(whole), abs(contacts)


@pytest.mark.parametrize("name", SCENES)
def test_the_energy_changes_by_the_power_of_motors_and_contacts(name: str) -> None:
    scene = SCENES[name]()
    pelvis = {"quadruped": "base", "talos": "base_link"}.get(name, "pelvis")
    stack = scene.limits >> CenterOfMassTask(scene.com, gain=5.0) >> scene.rest(pelvis)
    controller = Controller(scene.robot, stack, order="torque", dt=DT)
    for seed in range(6):
        q, v = moved(scene, seed)
        controller.settle()
        check_balance(scene, q, v, controller(q, v))


@pytest.mark.parametrize("name", SCENES)
def test_contacts_that_hold_do_no_work(name: str) -> None:
    scene = SCENES[name]()
    pelvis = {"quadruped": "base", "talos": "base_link"}.get(name, "pelvis")
    w, way = 2.0 * np.pi, np.array([0.01, 0.02, 0.01])

    def sway(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return scene.com + way * np.sin(w * t), way * w * np.cos(w * t), -way * w * w * np.sin(w * t)

    stack = scene.limits >> CenterOfMassTask(sway, gain=8.0) >> scene.rest(pelvis)
    controller = Controller(scene.robot, stack, order="torque", dt=DT)
    q, v = scene.q, scene.v
    powers = []
    for k in range(150):
        step = controller(q, v, DT * k)
        if k % 10 == 0:
            powers.append(check_balance(scene, q, v, step))
        q, v = advanced(scene.robot, q, v, step.a)
    assert max(whole for whole, _ in powers) > 1.0
    assert max(contacts for _, contacts in powers) < 1e-3 * max(whole for whole, _ in powers)
