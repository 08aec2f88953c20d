"""Numbers of contacts, and of what speaks of forces, are live: as if a fresh controller had been made with them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contact_scenes import DT, FEET, SOLE, humanoid, moved

import tasks
from tasks import (
    CapturePointTask,
    CenterOfPressureTask,
    Change,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    Loop,
    MomentumTask,
    Part,
    PostureTask,
    Stack,
    SupportLimit,
    TorqueTask,
    load_robot,
    simulate,
)

#: A quarter of a turn about z.
TURNED = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
#: Another value for every number of every part.
CHANGES: dict[str, dict[str, Any]] = {
    "contact": {
        "friction": 0.1,
        "torsion": 0.002,
        "normal": (0.2, 0.0, 1.0),
        "least": 200.0,
        "largest": 100.0,
        "gain": 5.0,
        "damping_ratio": 2.0,
        "weight": 3.0,
    },
    "dynamics": {
        "wrenches": {"torso_link": [30.0, 0.0, 0.0, 0.0, 0.0, 0.0]},
        "joint_damping": 0.7,
        "springs": {"left_knee_joint": (20.0, 0.3)},
        "weight": 2.0,
    },
    "loop": {
        "at": (0.02, 0.0, 0.0),
        "at_b": (0.0, 0.03, 0.0),
        "rotation": TURNED,
        "gain": 5.0,
        "damping_ratio": 2.0,
        "weight": 2.0,
    },
    "force": {"target": [50.0], "weight": 3.0},
    "pressure": {"target": [0.05, 0.01], "weight": 3.0},
    "momentum": {"target": [1.0, 2.0, 0.5], "gain": 2.0, "damping_ratio": 0.5, "weight": 3.0},
    "capture": {"target": [0.05, 0.02], "gain": 5.0, "weight": 2.0},
    "support": {"margin": 0.02, "gain": 3.0, "weight": 2.0},
    "torque": {"target": 1.0, "weight": 0.3},
}
#: What a momentum, whose error is brought down at first order, has of all tasks, and does not go by.
NO_KEYWORD = {("momentum", "damping_ratio")}


def parts(changes: dict[str, dict[str, Any]]) -> tuple[dict[str, Part], Stack]:
    """One of each, with these numbers in place of its own, and a stack of all of them."""

    def made(key: str, kind: type, /, *given: Any, **named: Any) -> Any:
        other = {name: value for name, value in changes.get(key, {}).items() if (key, name) not in NO_KEYWORD}
        return kind(*given, **{**named, **other})

    rectangle = {"plane": (0.17, 0.06), "centre": (0.035, 0.0, -0.03), "wrench": True}
    contact = made("contact", Contact, FEET[0], name="left", **{"friction": 0.6, **rectangle})
    other = Contact(FEET[1], points=SOLE, friction=0.6)
    own = {
        "contact": contact,
        "dynamics": made("dynamics", Dynamics),
        "loop": made("loop", Loop, "left_rubber_hand", "right_rubber_hand", turns=False),
        "support": made("support", SupportLimit),
        "force": made("force", ForceTask, contact=contact, **{"target": [120.0]}),
        "pressure": made("pressure", CenterOfPressureTask, contact=other, **{"target": [0.03, 0.0]}),
        "capture": made("capture", CapturePointTask, **{"target": [0.0, 0.0], "gain": 2.0}),
        "momentum": made("momentum", MomentumTask, kind="angular", gain=4.0),
        "torque": made("torque", TorqueTask),
    }
    limits = own["dynamics"] + contact + other + own["loop"] >> JointTorqueLimit() + JointLimits()
    tasks_ = own["force"] + own["pressure"] + own["capture"] + own["momentum"]
    rest = PostureTask(humanoid().q, gain=4.0) + own["torque"]
    return own, limits >> own["support"] >> tasks_ >> rest


CASES = [(part, name) for part, numbers in CHANGES.items() for name in numbers]


@pytest.mark.parametrize(("part", "name"), CASES)
def test_a_change_gives_what_a_fresh_controller_gives(part: str, name: str) -> None:
    scene, value = humanoid(), CHANGES[part][name]
    q, v = moved(scene, 1, 0.02)
    own, stack = parts({})
    at_work = Controller(scene.robot, stack, order="torque", dt=DT)
    before = at_work(q, v)
    _, other = parts({part: {name: value}})
    fresh = Controller(scene.robot, other, order="torque", dt=DT)
    setattr(own[part], name, value)
    at_work(q, v)
    fresh(q, v)
    rows = [controller.hierarchy for controller in (at_work, fresh)]
    for what in "A", "lower", "upper", "weights":
        for mine, theirs in zip(*(h.levels for h in rows), strict=True):
            first, second = getattr(mine, what), getattr(theirs, what)
            assert (first is None and second is None) or np.allclose(first, second, rtol=1e-12, atol=1e-9)
    assert before.ok


def test_every_number_of_every_part_is_in_the_table() -> None:
    own, _ = parts({})
    kinds = {type(part) for part in own.values()}
    for name in tasks.__all__:
        kind = getattr(tasks, name)
        if isinstance(kind, type) and issubclass(kind, Part) and kind.__module__.startswith("tasks.contacts."):
            assert kind in kinds, name
    for name, part in own.items():
        assert set(type(part)._numbers) - set(CHANGES[name]) == set()


def test_structure_stays() -> None:
    own, stack = parts({})
    Controller(humanoid().robot, stack, order="torque", dt=DT)
    for part, name in (
        ("contact", "frame"),
        ("contact", "faces"),
        ("contact", "wrench"),
        ("loop", "a"),
        ("force", "contact"),
        ("momentum", "kind"),
    ):
        with pytest.raises(ValueError, match=r"is part of its structure, and stays; make a new one"):
            setattr(own[part], name, None)
    with pytest.raises(ValueError, match="did you mean 'friction'"):
        own["contact"].fricton = 0.3


def test_contacts_that_come_back_with_a_stack_hold_where_it_finds_them() -> None:
    """As in a new controller; those that the stack before has, too, go on as they are."""
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    hand, aside = Contact("panda_hand_tcp", name="hand"), robot.home + 0.1
    held, free = Stack(hand) >> PostureTask(robot.home, gain=1.0), Stack(PostureTask(robot.home + 0.3, gain=1.0))
    controller = Controller(robot, held, dt=0.01)
    controller(robot.home)
    controller.change(Stack(hand) >> PostureTask(aside, gain=1.0), duration=0.0)
    assert np.abs(controller(aside).v).max() > 1.0  # it goes back to where the hand has been all the time
    controller.change(free, duration=0.0)
    controller(aside)
    controller.change(held, duration=0.0)
    np.testing.assert_allclose(controller(aside).v, Controller(robot, held, dt=0.01)(aside).v, atol=1e-9)


def test_contacts_of_a_stack_that_is_left_slowly_hold_when_it_comes_back() -> None:
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    hand, aside = Contact("panda_hand_tcp", name="hand"), robot.home + 0.1
    held, free = Stack(hand) >> PostureTask(robot.home, gain=1.0), Stack(PostureTask(robot.home, gain=1.0))
    controller = Controller(robot, held, dt=0.01)
    controller(robot.home)
    before = controller(aside).v
    controller.change(free, duration=1.0)
    controller(aside, t=0.0)
    controller.change(held, duration=1.0)
    controller(aside, t=0.1)
    np.testing.assert_allclose(controller(aside, t=1.2).v, before, atol=1e-9)


def test_a_second_run_holds_contacts_of_later_stacks_where_it_comes_to_them() -> None:
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    held = Stack(Contact("panda_hand_tcp", name="hand")) >> PostureTask(robot.home, gain=1.0)
    free = Stack(PostureTask(robot.home + 0.3, gain=1.0))

    def run(controller: Controller, start: np.ndarray) -> np.ndarray:
        return simulate(controller, start, duration=0.2, changes=[Change(0.1, held, 0.0)]).q

    controller = Controller(robot, free, dt=0.01)
    run(controller, robot.home)
    controller.change(free, duration=0.0)
    fresh = Controller(robot, free, dt=0.01)
    np.testing.assert_allclose(run(controller, robot.home + 0.2), run(fresh, robot.home + 0.2), atol=1e-9)
