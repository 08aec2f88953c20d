"""Functions of time of a user's own: what they give at a tick is what they gave at first, or the tick tells of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    AvoidanceTask,
    Chain,
    Contact,
    Controller,
    DistanceLimit,
    Dynamics,
    ForceTask,
    JointVelocityLimit,
    JointVelocityTask,
    Line,
    OrientationTask,
    PlanarArm,
    Polygon,
    PositionTask,
    PostureTask,
    Sphere,
    Stack,
    Surface,
    Turn,
    VelocityRatioTask,
    Within,
    cubic,
    from_rpy,
    load_robot,
    planar_links,
)

#: What a function gives later on, in place of three arrays x, 0, 0 of the same shape.
LATER: dict[str, Callable[[np.ndarray], Any]] = {
    "an array": lambda x: x,
    "a number": lambda x: 0.4,
    "nothing": lambda x: None,
    "two arrays": lambda x: (x, 0.0 * x),
    "numbers": lambda x: (0.4, 0.0, 0.0),
    "arrays of one more": lambda x: (np.append(x, 0.0),) * 3,
    "imaginary parts": lambda x: (x * 1j, 0.0 * x, 0.0 * x),
    "words": lambda x: (["0.4"] * len(x),) * 3,
    "what is masked": lambda x: (np.ma.array(x, mask=True), 0.0 * x, 0.0 * x),
}


class Piece:
    """A piece of a chain, of a user's own."""

    duration = 1.0

    def __init__(self, function: Callable[[float], Any]) -> None:
        self.function = function

    def __call__(self, t: float) -> Any:
        return self.function(t)


ARM = PlanarArm([0.5, 0.5, 0.5])
LINKS, LIMIT = planar_links(ARM, 0.01), JointVelocityLimit(1.0)
#: Where a function stands in a stack: of how many numbers, and the stack.
PLACES: dict[str, tuple[int, Callable[[Any], Any]]] = {
    "position": (2, lambda f: PositionTask(f, gain=1.0)),
    "chain": (2, lambda f: PositionTask(Chain([Piece(f)]), gain=1.0)),
    "angle": (1, lambda f: OrientationTask(f, gain=1.0)),
    "posture": (3, lambda f: PostureTask(f, gain=1.0)),
    "speed": (3, lambda f: JointVelocityTask(f)),
    "inequality": (2, lambda f: Within(PositionTask(f, gain=1.0), 0.1)),
    "ratio": (2, lambda f: VelocityRatioTask(PositionTask(f, gain=1.0), gain=0.1)),
    "limit": (2, lambda f: LIMIT >> DistanceLimit(LINKS, [Sphere(f, 0.1)], margin=0.01, gain=5.0)),
    "avoided": (2, lambda f: LIMIT >> AvoidanceTask(LINKS, [Sphere(f, 0.1)], influence=0.5, speed=0.1)),
}


@pytest.mark.parametrize("later", LATER)
@pytest.mark.parametrize("place", PLACES)
def test_another_answer_is_refused_at_that_tick(place: str, later: str) -> None:
    """NumPy would spread a number, read words, and drop imaginary parts; the rest ended in errors of Python."""
    size, stack = PLACES[place]
    x, changed = np.full(size, 0.6), False

    def function(t: float) -> Any:
        return LATER[later](x) if changed else (x, 0.0 * x, 0.0 * x)

    controller = Controller(ARM, Stack(stack(function)), dt=0.01)
    q = [0.3, 0.4, 0.5]
    first = controller(q, t=0.06)
    assert first.ok
    changed = True
    with pytest.raises(InvalidInput, match=r"target\(0.0\d?\)"):
        controller(q, t=0.06)
    changed = False
    assert np.array_equal(controller(q, t=0.06).v, first.v)


#: What a timing law gives later on, in place of three numbers.
LAWS: dict[str, Any] = {
    "two": (0.5, 1.0),
    "nothing": None,
    "one": 0.5,
    "words": ("0.5", "1", "0"),
    "imaginary": (0.5j, 1.0, 0.0),
    "arrays": (np.ones(2), np.ones(2), np.ones(2)),
    "NaN": (np.nan, 1.0, 0.0),
    "infinity": (0.5, np.inf, 0.0),
}


@pytest.mark.parametrize("later", LAWS)
@pytest.mark.parametrize("place", ["line", "polygon", "change"])
def test_so_is_another_answer_of_a_timing_law(place: str, later: str) -> None:
    """One of NaN gave NaN as joint speeds, in a step that was ok, while a stack was changed to another one."""
    changed, still = False, PositionTask([0.6, 0.6], gain=1.0)

    def law(u: float) -> Any:
        return LAWS[later] if changed else cubic(u)

    goals: dict[str, Callable[[], Any]] = {
        "line": lambda: PositionTask(Line([0.6, 0.6], [0.8, 0.6], 1.0, law), gain=1.0),
        "polygon": lambda: PositionTask(Polygon([[0.6, 0.6], [0.8, 0.6], [0.6, 0.8]], 1.0, law), gain=1.0),
        "change": lambda: PositionTask([0.8, 0.6], gain=1.0),
    }
    controller = Controller(ARM, still if place == "change" else goals[place](), dt=0.01)
    q = [0.3, 0.4, 0.5]
    if place == "change":
        assert controller(q, t=0.0).ok
        controller.change(goals[place]() >> PostureTask(q, gain=1.0), duration=1.0, law=law)
    assert controller(q, t=0.1).ok
    turn = Turn(np.eye(3), from_rpy(0.0, 0.0, 1.0), 1.0, law)
    changed = True
    with pytest.raises(InvalidInput, match=r"(timing|law of a change)\(0\.\d+\)"):
        controller(q, t=0.2)
    with pytest.raises(InvalidInput, match=r"law\(0\.2\)"):
        turn(0.2)


@pytest.mark.parametrize("answer", [[0.6, 0.6], np.full(2, 0.6, dtype=np.float32), np.full(2, 0.6, dtype=object)])
def test_other_forms_of_the_same_numbers_are_taken(answer: Any) -> None:
    def function(t: float) -> Any:
        return (np.full(2, 0.6), np.zeros(2), np.zeros(2)) if t < 0.05 else iter((answer, [0, 0], (False, False)))

    controller = Controller(ARM, PositionTask(function, gain=1.0), dt=0.01)
    first = controller([0.3, 0.4, 0.5], t=0.04).v
    assert np.abs(controller([0.3, 0.4, 0.5], t=0.06).v - first).max() < 1e-6


@pytest.fixture(scope="module")
def panda() -> Any:
    pytest.importorskip("pinocchio")
    return load_robot("panda", lock=["panda_finger_joint1"])


def on_a_table(panda: Any, at: str, later: Callable[[np.ndarray], Any]) -> Controller:
    """A controller of forces with functions at four places, of which one changes at t = 0.05 s."""
    force, place, eye = np.full(6, 0.1), np.zeros(3), np.eye(3)

    def wrench(t: float) -> Any:
        return force if t < 0.05 or at != "wrench" else later(force)

    def pressed(t: float) -> Any:
        return (force[:1], 0.0 * force[:1], 0.0 * force[:1]) if t < 0.05 or at != "force" else later(force[:1])

    def position(t: float) -> Any:
        return (place, place, place) if t < 0.05 or at != "position" else later(place)

    def rotation(t: float) -> Any:
        return (eye, place, place) if t < 0.05 or at != "rotation" else later(eye)

    hand = Contact("panda_hand", friction=0.5, surface=Surface(position, rotation), name="hand")
    stack = (
        Dynamics({"panda_hand": wrench}) + hand >> ForceTask(pressed, contact=hand) >> PostureTask(panda.home, gain=2.0)
    )
    return Controller(panda, stack, order="torque", dt=0.01)


@pytest.mark.parametrize("later", [name for name in LATER if name != "an array"])
@pytest.mark.parametrize("at", ["wrench", "force", "position", "rotation"])
def test_so_are_other_wrenches_forces_and_surfaces(panda: Any, at: str, later: str) -> None:
    controller = on_a_table(panda, at, LATER[later])
    q, v = panda.home, np.zeros(panda.nv)
    assert controller(q, v, 0.04).ok
    with pytest.raises(InvalidInput, match=r"target\(0.06\)|wrench at"):
        controller(q, v, 0.06)
    assert controller(q, v, 0.04).ok


def test_torques_are_zero_for_want_of_a_number_only_where_the_step_is_not_ok(panda: Any) -> None:
    """No row of an arm that is mounted holds a measured wrench: its torques alone were zero, and the step was ok."""
    controller = on_a_table(panda, "wrench", lambda force: np.full(6, np.nan))
    q, v = panda.home, np.zeros(panda.nv)
    assert controller(q, v, 0.04).ok
    step = controller(q, v, 0.06)
    assert not step.ok
    assert "torques are not finite" in step.solution.message
    assert not step.tau.any()
    assert not step.a.any()
    assert controller(q, v, 0.04).ok
