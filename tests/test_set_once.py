"""What is computed from an attribute beforehand would not follow it: such an attribute is refused, and all goes on."""

from __future__ import annotations

from inspect import signature

import numpy as np
import pytest

from hqp import Batch, BatchSolver, Hierarchy, InvalidInput, Level, Settings, Solver, available_backends
from tasks import (
    Chain,
    Circle,
    Controller,
    Fixed,
    FixedRotation,
    JointVelocityLimit,
    Line,
    PlanarArm,
    Polygon,
    Polynomial,
    PoseSetpoint,
    PositionTask,
    RotationSetpoint,
    Setpoint,
    Surface,
    Turn,
    from_rpy,
    loop,
)
from tasks.targets.paths import Path
from tasks.targets.trajectories import Target

HALF = from_rpy(0.0, 0.0, 0.5)


def hierarchy() -> Hierarchy:
    return Hierarchy([Level.bounds([-1.0, -1.0], [1.0, 1.0]), Level.equality([[2.0, 1.0]], [1.5])])


#: What sets it, and the name and a value of every public attribute that it is told by.
MADE = {
    "hierarchy": (
        hierarchy,
        {
            "n": 3,
            "m": 1,
            "levels": (),
            "A": np.ones((1, 2)),
            "lower": np.zeros(3),
            "upper": np.zeros(3),
            "weights": np.ones(3),
            "columns": np.zeros(3, dtype=int),
            "numbers": np.zeros(11),
            "pointers": (0, 2),
            "structure": (),
            "address": 0,
        },
    ),
    "solver": (Solver, {"backend": "daqp", "settings": Settings(tolerance=1e-6), "damping": {1: 0.1}}),
    "batch solver": (BatchSolver, {"settings": Settings(tolerance=1e-6), "threads": 1}),
    "batch": (lambda: Batch(hierarchy(), 2), {"numbers": np.zeros((2, 11)), "levels": ()}),
    "fixed": (lambda: Fixed([0.3, 0.4]), {"target": np.ones(2)}),
    "fixed of numbers": (lambda: PositionTask([0.3, 0.4], gain=1.0).target, {"target": np.ones(2)}),
    "line": (
        lambda: Line([0.0, 0.0], [1.0, 0.0], 2.0),
        {"start": np.ones(2), "end": np.ones(2), "duration": 3.0, "timing": None},
    ),
    "circle": (
        lambda: Circle([0.5, 0.0], 0.2, 2.0),
        {"center": np.ones(2), "radius": 1.0, "start": 1.0, "turn": 1.0, "duration": 3.0, "timing": None},
    ),
    "chain": (lambda: Chain([Line([0.0], [1.0], 2.0)]), {"pieces": (), "duration": 3.0}),
    "polygon": (
        lambda: Polygon([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 3.0),
        {"corners": np.ones((3, 2)), "closed": False, "pieces": (), "duration": 1.0},
    ),
    "polynomial": (
        lambda: Polynomial([1.0, 0.0], [3.0, 0.0], 2.0),
        {"start": np.ones((2, 1)), "end": np.ones((2, 1)), "duration": 1.0, "via": {}, "coefficients": np.ones((4, 1))},
    ),
    "turn": (lambda: Turn(np.eye(3), HALF, 2.0), {"start": HALF, "end": np.eye(3), "duration": 1.0, "law": None}),
    "fixed rotation": (lambda: FixedRotation(HALF), {"R": np.eye(3)}),
    "pose setpoint": (
        lambda: PoseSetpoint(np.eye(4)),
        {"position": Setpoint(np.zeros(3)), "rotation": RotationSetpoint(HALF)},
    ),
    "surface": (lambda: Surface([0.0, 0.0, 0.0]), {"position": Fixed(np.ones(3)), "rotation": FixedRotation(HALF)}),
    "loop": (lambda: loop(100.0, 1.0), {"rate": 200.0, "duration": 2.0}),
}


@pytest.mark.parametrize(("what", "name"), [(what, name) for what, (_, names) in MADE.items() for name in names])
def test_what_would_not_follow_is_refused_and_stays(what: str, name: str) -> None:
    make, names = MADE[what]
    made = make()
    before = getattr(made, name)
    with pytest.raises(InvalidInput, match=name):
        setattr(made, name, names[name])
    assert getattr(made, name) is before


@pytest.mark.parametrize("what", MADE)
def test_every_public_attribute_is_in_the_table(what: str) -> None:
    make, names = MADE[what]
    known = vars(make()).keys() - {"ticks", "overruns", "worst", "left_out"}  # which a loop counts by itself
    assert {name for name in known if not name.startswith("_")} <= names.keys()


@pytest.mark.parametrize(
    "target", [Setpoint([0.3, 0.4]), RotationSetpoint(HALF), PoseSetpoint(np.eye(4)), Line([0.0], [1.0], 2.0)]
)
def test_a_name_that_a_target_does_not_have_is_refused(target: Target) -> None:
    with pytest.raises(InvalidInput, match="there is no attribute 'value'"):
        target.value = 1.0


@pytest.mark.parametrize("name", signature(Controller).parameters)
def test_what_a_controller_was_given_is_set_or_said_to_stay(name: str) -> None:
    made = Controller(PlanarArm([1.0, 1.0]), JointVelocityLimit(1.0) >> PositionTask([1.0, 1.0], gain=1.0), dt=0.01)
    before = dict(vars(made))
    with pytest.raises(InvalidInput, match=f"Controller: {name} is .*, and stays"):
        setattr(made, name, None)
    assert vars(made) == before


def test_a_path_of_ones_own_sets_what_is_its_own() -> None:
    class Wave(Path):
        def __init__(self, height: float) -> None:
            super().__init__(2.0)
            self.height = height

        def curve(self, s: float):
            return np.array([s, self.height * s]), np.array([1.0, self.height]), 0.0

    wave = Wave(1.0)
    wave.height = 3.0
    assert wave(5.0)[0].tolist() == [1.0, 3.0]


@pytest.mark.parametrize("backend", [name for name in available_backends() if not name.startswith("pseudoinverse")])
def test_numbers_written_in_place_are_solved(backend: str) -> None:
    """As the message says; all backends see the same numbers."""
    h = hierarchy()
    with pytest.raises(InvalidInput, match=r"written in place, as in hierarchy\.levels\[1\]\.lower\[:\] = "):
        h.upper = np.full(3, 0.25)
    h.upper[:2] = 0.125
    h.upper *= [2.0, 2.0, 1.0]
    assert np.allclose(Solver(backend).solve(h).x, 0.25, atol=1e-6)


def test_a_task_goes_on_to_the_target_that_it_had() -> None:
    arm, way = PlanarArm([0.5, 0.5, 0.5], velocity_limit=2.0), Line([0.9, 0.6], [1.0, 0.2], 2.0)
    controller = Controller(arm, PositionTask(way, gain=2.0), dt=0.01)
    before = controller([1.1, -1.3, -0.7], t=1.0).v
    with pytest.raises(InvalidInput, match="make a new one, and set the target of the task to it"):
        way.end = [0.0, 0.0]
    assert np.array_equal(controller([1.1, -1.3, -0.7], t=1.0).v, before)
