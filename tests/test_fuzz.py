"""Every public name with whatever anybody may give it: what is refused is refused in our words, and no more happens.

A call begins as a good one; then one of its arguments, or some, are replaced by junk. Out may come an HqpError, a
TypeError of Python's own about the signature, or an answer, with which the fuzz goes on: no other exception, and no
warning.
"""

from __future__ import annotations

import inspect
import random
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import is_dataclass
from functools import cache
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import urdf_files
from junk import JUNK

import hqp
import tasks
from hqp import Batch, BatchSolver, Hierarchy, HqpError, Label, Level, Settings, Solver
from tasks import (
    Chain,
    Change,
    Circle,
    Controller,
    Fixed,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    Line,
    OrientationTask,
    PlanarArm,
    Polynomial,
    PoseSetpoint,
    PositionTask,
    PostureTask,
    Record,
    Setpoint,
    Sphere,
    Stack,
    Turn,
    load_robot,
    planar_links,
    simulate,
)
from tasks.simulation.record import Stop

pytest.importorskip("pinocchio")

#: Calls of the default run, over all its parts, and of the sweep; damaged files of a kind, and lines of the command.
PARTS, CALLS, SWEEP, FILES, COMMANDS = 4, 8_000, 400_000, 400, 120
#: Functions that are called back: whatever they raise is their own.
CALLBACKS = {"proof", "progress"}
#: What is not called: types that only come out, protocols, exceptions, constants.
PASSIVE = {
    "DEFAULT_BACKEND", "lexls", "problems", "DampingRule", "HqpError", "InUse", "InvalidInput",
    "MissingPackage", "UnknownBackend", "Unsupported", "Command", "Frame", "Order", "Part", "Plant", "Robot",
    "RobotState", "RotationTrajectory", "Trajectory", "FrameTask", "TargetTask", "GradientTask", "Tick", "Side",
    "Status",
    # of contacts: what they refuse is asked in their own tests; and a server that does not return
    "Contact", "Dynamics", "ForceTask", "CenterOfPressureTask", "MomentumTask", "CapturePointTask", "SupportLimit",
    "TorqueTask", "Surface", "Loop", "RigidContactPlant", "live",
}  # fmt: skip

ROOT = Path(hqp.__file__).parents[1]

Call = tuple[Callable[..., Any], list[Any], dict[str, Any]]


def hierarchy() -> Hierarchy:
    limits = Level.bounds([-1.0] * 3, [1.0] * 3, name="limits")
    return Hierarchy(
        [limits, Level([[1.0, 1.0, 0.0]], [0.5], [3.0], name="reach"), Level.equality(np.eye(3), [0.1] * 3)]
    )


def arm(**options: Any) -> PlanarArm:
    return PlanarArm([0.5, 0.4, 0.3], masses=[1.0, 1.0, 1.0], **options)


def position(**options: Any) -> PositionTask:
    return PositionTask([0.5, 0.2], gain=1.0, **options)


def stack() -> Stack:
    return JointVelocityLimit(1.0) >> position() >> PostureTask([0.1, 0.2, 0.3], gain=1.0)


def controller(**options: Any) -> Controller:
    return Controller(arm(), stack(), dt=0.01, **options)


@cache
def urdf(folder: Path) -> str:
    joints = urdf_files.chain({}, {"axis": "0 1 0"}, {"kind": "prismatic"})
    return str(urdf_files.write(folder, *joints, links=4))


@cache
def spatial(folder: Path) -> Any:
    return load_robot(urdf(folder), tip="link3")


def with_a_ball(robot: Any) -> Any:
    """The same robot with one shape, on its first link."""
    import coal
    import pinocchio as pin

    shapes, frame = pin.GeometryModel(), robot.model.getFrameId("link1")
    parent = robot.model.frames[frame].parentJoint
    shapes.addGeometryObject(pin.GeometryObject("ball", parent, frame, pin.SE3.Identity(), coal.Sphere(0.1)))
    return robot.with_geometry(shapes)


@cache
def beside_a_table() -> Any:
    """A robot in a scene."""
    import mujoco

    scene = """<mujoco><worldbody><body name="table"><geom size="0.1"/></body>
    <body name="arm" pos="1 0 0"><joint axis="0 0 1"/><geom size="0.1" pos="0.2 0 0"/></body></worldbody></mujoco>"""
    return load_robot(mujoco.MjModel.from_xml_string(scene))


@cache
def record() -> Record:
    return simulate(controller(), [0.4, 0.3, 0.2], duration=0.05)


def results() -> Iterator[Any]:
    """One of each type that only comes out."""
    h = hierarchy()
    solution, step = hqp.solve(h), controller()([0.4, 0.3, 0.2], [0.0] * 3, 0.0)
    damped = hqp.solve(h, damping={1: 0.1})
    explanation = hqp.solve(Hierarchy([h.levels[0], Level.equality([[1.0, 1.0, 0.0]], [4.0], name="far")])).explain()
    yield from (hqp.backend_info("native"), hqp.solve_batch([h]), solution.certify(), solution.counts, explanation)
    yield from (
        hqp.problems.FAMILIES["vertex"],
        solution.certify().levels[0],
        explanation.levels[0],
        solution.levels[0],
    )
    yield from (explanation.levels[1].parts[0], explanation.levels[1].causes[0], damped, damped.relaxed[0])
    yield from (damped.certify(), solution, hqp.lexls.Problem(h), step, record(), step.state)
    yield from (Stop(0.0, "why", False), tasks.task_degrees(np.eye(2)), tasks.velocity_ellipse(np.eye(2)))
    yield tasks.solve_ik(arm(position_limit=(-3.0, 3.0)), position(), [0.4, 0.3, 0.2], iterations=3)


def calls(folder: Path) -> dict[str, Callable[[], Call]]:
    """A good call of every public name, and of every method with arguments of what comes out."""
    files = {"h.npz": lambda path: hqp.save(path, hierarchy()), "r.npz": lambda path: record().save(path)}
    files["h.dat"] = lambda path: hqp.lexls.write(path, hierarchy())
    for name, write in files.items():
        write(folder / name)
    q, v = [0.4, 0.3, 0.2], [0.0, 0.0, 0.0]
    gain = {"gain": 1.0, "damping_ratio": 1.0, "weight": 1.0, "name": "own"}
    framed = {**gain, "frame": "link3", "relative_to": "link0"}
    seen = {"frame": "link3", "relative_to": "link0", "gain": 1.0, "name": "own"}
    label = [Label("part", "row", "m")]

    def links() -> Any:
        return planar_links(arm(), 0.05)

    def robot() -> Any:
        return spatial(folder)

    def made(make: Callable[..., Any], *args: Any, **kwargs: Any) -> Callable[[], Call]:
        """A call whose arguments are made anew where they are functions called `new`."""

        def fresh(value: Any) -> Any:
            return value() if getattr(value, "__name__", "") == "new" else value

        return lambda: (make, [fresh(x) for x in args], {key: fresh(x) for key, x in kwargs.items()})

    def new(make: Callable[..., Any], *args: Any, **kwargs: Any) -> Callable[[], Any]:
        def new() -> Any:
            return make(*args, **kwargs)

        return new

    h, s, p, a, c = (new(make) for make in (hierarchy, stack, position, arm, controller))
    spatial_robot, mine = new(robot), stack()
    _, first, last = mine
    table: dict[str, Callable[[], Call]] = {
        "Batch": made(Batch, h, 3),
        "BatchSolver": made(BatchSolver, settings=new(Settings), threads=1),
        "Hierarchy": made(lambda levels, n: Hierarchy(levels, n=n), new(lambda: list(hierarchy().levels)), n=3),
        "Label": made(Label, "part", row="row", unit="m", bound=None),
        "Level": made(Level, [[1.0, 2.0, 0.0]], [0.5], [0.7], weights=[2.0], name="own", labels=label),
        "ErrorDamping": made(hqp.ErrorDamping, 1.0, least=0.0),
        "FixedDamping": made(hqp.FixedDamping, 0.1),
        "ManipulabilityDamping": made(hqp.ManipulabilityDamping, 0.1, 0.2),
        "NumericalFiltering": made(hqp.NumericalFiltering, 0.1, 0.2, threshold=0.1),
        "SingularValueDamping": made(hqp.SingularValueDamping, 0.1, 0.2),
        "Settings": made(
            Settings, tolerance=1e-10, rank_tolerance=1e-9, iterations=10, time_limit=1.0, proximal_weight=1e-7,
            proximal_steps=5, polish=True, qp_tolerance=1e-9, qp_iterations=40,
        ),
        "Solver": made(Solver, backend="native", settings=new(Settings), damping={1: 0.1}),
        "available_backends": made(hqp.available_backends),
        "backend_info": made(hqp.backend_info, "native"),
        "certify": made(hqp.certify, h, [0.1] * 3, x_ref=v, unique=True, tolerance=1e-9),
        "load": made(hqp.load, folder / "h.npz"),
        "nearest": made(hqp.nearest, v, np.eye(3), name="own"),
        "read_lexls": made(hqp.lexls.read, folder / "h.dat"),
        "save": made(hqp.save, folder / "out.npz", h, x_ref=v),
        "solve": made(hqp.solve, h, backend="native", x_ref=v, settings=new(Settings), damping={1: 0.1}),
        "solve_batch": made(hqp.solve_batch, new(lambda: [hierarchy()] * 2), x_ref=v, settings=None, threads=1),
        "write_lexls": made(
            hqp.lexls.write, folder / "out.dat", h, x_ref=v, guess=[0] * 7, solution_guess=v, solution=v
        ),
        "AtLeast": made(tasks.AtLeast, p),
        "AtMost": made(tasks.AtMost, p),
        "AvoidanceTask": made(
            tasks.AvoidanceTask, new(links), [Sphere([2.0, 0.0], 0.1)], influence=0.2, speed=0.5, gain=10.0, weight=1.0,
            name="own",
        ),
        "AxisTask": made(tasks.AxisTask, [0.0, 0.0, 1.0], axis=[0.0, 0.0, 1.0], **framed),
        "Box": made(tasks.Box, [0.1, 0.2, 0.3], np.eye(4), name="own"),
        "BoxLimit": made(tasks.BoxLimit, [-1.0] * 3, [1.0] * 3, **seen),
        "Capsule": made(tasks.Capsule, [1.0, 0.0], [2.0, 0.0], 0.1),
        "CenterOfMassTask": made(tasks.CenterOfMassTask, v, relative_to="link0", mask="xyz", **gain),
        "Chain": made(Chain, new(lambda: [Line([0.0, 0.0], [1.0, 0.0], 1.0)])),
        "Change": made(Change, 0.02, s, 0.01, law=tasks.cubic),
        "Circle": made(Circle, [0.0, 0.0], 1.0, 2.0, start=0.0, turn=3.0, timing=tasks.cubic),
        "CollisionLimit": made(
            tasks.CollisionLimit, new(lambda: [tasks.Box([0.1, 0.2, 0.3])]), bodies=None, margin=0.01, gain=1.0, rows=2,
            name="own",
        ),
        "Controller": made(Controller, a, s, order="velocity", dt=0.01, backend="native", settings=None, torque=False),
        "Damped": made(tasks.Damped, p, 0.1),
        "Damping": made(tasks.Damping, 0.1, name="own"),
        "DistanceLimit": made(
            tasks.DistanceLimit, new(links), [Sphere([2.0, 0.0], 0.1)], margin=0.01, gain=1.0, nearest=2, weight=1.0,
            name="own",
        ),
        "DynamicManipulabilityTask": made(tasks.DynamicManipulabilityTask, p, gain=1.0, weight=1.0, name="own"),
        "Fixed": made(Fixed, v),
        "FixedRotation": made(tasks.FixedRotation, np.eye(3)),
        "Freeze": made(tasks.Freeze, [0, 1], all_but=None, weight=1.0, name="own"),
        "FrameVelocityLimit": made(
            tasks.FrameVelocityLimit, 1.0, frame="link3", relative_to="link0", mask="xyz", reference="local", name="own"
        ),
        "Ground": made(tasks.Ground, 0.0, friction=0.8, time_constant=0.01, ratio=1.0, noslip=0, pyramids=False),
        "JointAccelerationLimit": made(tasks.JointAccelerationLimit, 1.0, name="own"),
        "JointCentringTask": made(tasks.JointCentringTask, gain=1.0, weight=1.0, name="own"),
        "JointCouplingTask": made(tasks.JointCouplingTask, {0: 1.0, 1: -1.0}, 0.0, **gain),
        "JointLimits": made(JointLimits, new(JointVelocityLimit, 1.0), new(JointPositionLimit, -1.0, 1.0), name="own"),
        "JointMotion": made(tasks.JointMotion, p, damping=0.1),
        "JointPositionLimit": made(JointPositionLimit, -1.0, 1.0, return_speed=0.5, name="own"),
        "JointTorqueLimit": made(tasks.JointTorqueLimit, 1.0, name="own"),
        "JointVelocityLimit": made(JointVelocityLimit, 1.0, name="own"),
        "JointVelocityTask": made(tasks.JointVelocityTask, [0.1, 0.2], joints=[0, 1], gain=1.0, weight=1.0, name="own"),
        "KineticEnergyTask": made(tasks.KineticEnergyTask, weight=1.0, gain=1.0, name="own"),
        "Line": made(Line, [0.0, 0.0], [1.0, 0.0], 1.0, timing=tasks.cubic),
        "LinearHolonomicTask": made(tasks.LinearHolonomicTask, np.eye(3)[:2], [0.1, 0.2], q, **gain),
        "LinkCapsule": made(tasks.LinkCapsule, "joint0", "joint1", 0.1, name="own"),
        "link_capsules": made(tasks.link_capsules, new(lambda: with_a_ball(robot())), bodies=["link1"]),
        "LookAtTask": made(tasks.LookAtTask, [1.0, 0.0, 1.0], axis=[0.0, 0.0, 1.0], **framed),
        "ManipulabilityTask": made(tasks.ManipulabilityTask, p, gain=1.0, weight=1.0, name="own"),
        "MinimumMotionTask": made(tasks.MinimumMotionTask, 1.0, gain=1.0, name="own"),
        "MinimumTorqueTask": made(tasks.MinimumTorqueTask, torque_range=(-1.0, 1.0), weight=1.0, name="own"),
        "MinorAxisTask": made(tasks.MinorAxisTask, p, gain=1.0, weight=1.0, name="own"),
        "MujocoPlant": made(tasks.MujocoPlant, spatial_robot, contacts=[], ground=None, loops=[], step=0.001),
        "OmniwheelTask": made(
            tasks.OmniwheelTask, 0.1, axle=[0.0, 1.0, 0.0], rollers=0.5, normal=[0.0, 0.0, 1.0], floor=0.0, **framed
        ),
        "OrientationTask": made(OrientationTask, np.eye(3), mask="xyz", reference="local", **framed),
        "PinocchioRobot": made(
            tasks.PinocchioRobot, new(lambda: robot().model), tip="link3", name="own", position_limit=(-1.0, 1.0),
            velocity_limit=1.0, acceleration_limit=1.0, torque_limit=1.0,
        ),
        "PlanarArm": made(
            PlanarArm, [0.5, 0.4, 0.3], masses=[1.0] * 3, position_limit=(-1.0, 1.0), velocity_limit=1.0,
            acceleration_limit=1.0, torque_limit=1.0, name="own",
        ),
        "PlaneLimit": made(tasks.PlaneLimit, [0.0, 1.0, 0.0], 1.0, **seen),
        "PlaneTask": made(tasks.PlaneTask, [0.0, 1.0, 0.0], 1.0, **framed),
        "Polygon": made(tasks.Polygon, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 1.0, timing=tasks.cubic, closed=True),
        "Polyhedron": made(tasks.Polyhedron, np.vstack([np.zeros(3), np.eye(3)]), np.eye(4), name="own"),
        "Polynomial": made(Polynomial, [v, v, v], [q, v, v], 1.0, via={0.5: [[0.1] * 3]}),
        "PoseSetpoint": made(PoseSetpoint, np.eye(4)),
        "PoseTask": made(tasks.PoseTask, v, np.eye(3), mask="x y z rx", reference="local", **framed),
        "PositionTask": made(PositionTask, v, mask="xyz", reference="local", **framed),
        "PostureTask": made(PostureTask, [0.1, 0.2], joints=[0, 1], **gain),
        "Reconstructed": made(tasks.Reconstructed, p, 0.1, above=new(position, name="above")),
        "RollingTask": made(tasks.RollingTask, 0.1, normal=[0.0, 0.0, 1.0], floor=0.0, **framed),
        "RotationSetpoint": made(tasks.RotationSetpoint, np.eye(3)),
        "scene_solids": made(tasks.scene_solids, new(beside_a_table), names=["table"]),
        "SelfCollisionLimit": made(
            tasks.SelfCollisionLimit, pairs=[("link0", "link3")], without=(), margin=0.01, gain=1.0, rows=2, name="own"
        ),
        "Setpoint": made(Setpoint, v),
        "Sphere": made(Sphere, [1.0, 0.0], 0.1),
        "Stack": made(Stack, p, new(PostureTask, v, gain=1.0)),
        "Switch": made(tasks.Switch, 0.02, "left", on=True, duration=0.1),
        "Task": made(tasks.Task, **gain),
        "Turn": made(Turn, np.eye(3), np.eye(3), 1.0, law=tasks.quintic),
        "VelocityRatioTask": made(tasks.VelocityRatioTask, p, [1.0, 0.0], gain=1.0, weight=1.0, name="own"),
        "Within": made(tasks.Within, p, 0.1, below=0.1),
        "available_robots": made(tasks.available_robots),
        **{law.__name__: made(law, 0.5) for law in (tasks.cubic, tasks.quintic, tasks.harmonic, tasks.cycloid)},
        "from_rpy": made(tasks.from_rpy, 0.1, 0.2, 0.3),
        "from_xyzw": made(tasks.from_xyzw, [0.0, 0.0, 0.0, 1.0]),
        "load_robot": made(
            load_robot, urdf(folder), base=None, body=None, mimic="lock", lock=["joint0"], tip="link3",
            position_limit=(-1.0, 1.0), velocity_limit=1.0, acceleration_limit=1.0, torque_limit=1.0,
        ),
        "loop": made(tasks.loop, 200.0, duration=0.1),
        "manipulability": made(tasks.manipulability, np.eye(2)),
        "planar_links": made(planar_links, a, 0.1),
        "simulate": made(
            simulate, c, q, v0=v, duration=0.03, start=0.0, speed_cap=100.0, certify=1, proof=None,
            changes=new(lambda: [Change(0.01, PostureTask([0.1] * 3, gain=1.0), 0.01)]), progress=None, plant=None,
        ),
        "skeleton": made(tasks.skeleton, spatial_robot, q, frames=["link1"]),
        "solve_ik": made(
            tasks.solve_ik, spatial_robot, new(lambda: PositionTask([0.4, 0.1, 0.3], gain=1.0)), q, goal=None,
            tolerance=1e-3, iterations=3, restarts=True, settle=True, seed=0, backend="native",
        ),
        "task_degrees": made(tasks.task_degrees, np.eye(2), tolerance=1e-9),
        "velocity_ellipse": made(tasks.velocity_ellipse, np.eye(2)),
        # Methods
        "Level.equality": made(Level.equality, [[1.0, 2.0, 0.0]], [0.5], weights=[2.0], name="own", labels=label),
        "Level.bounds": made(Level.bounds, [0.5], [0.6], indices=[0], weights=[2.0], name="own", labels=label),
        "Hierarchy.with_numbers": made(lambda x: hierarchy().with_numbers(x), new(lambda: hierarchy().numbers)),
        "Batch.of": made(Batch.of, new(lambda: [hierarchy(), hierarchy()])),
        "Solver.solve": made(lambda h, x_ref: Solver().solve(h, x_ref), h, x_ref=v),
        "BatchSolver.solve": made(
            lambda b, x_ref: BatchSolver(threads=1).solve(b, x_ref), new(lambda: Batch(hierarchy(), 2)), x_ref=v
        ),
        "Solver.solve damped": made(lambda h, x_ref: Solver(damping={1: 0.1}).solve(h, x_ref), h, x_ref=v),
        "Solution.certify": made(lambda **o: hqp.solve(hierarchy()).certify(**o), unique=True, tolerance=1e-9),
        "Solution.explain": made(lambda **o: hqp.solve(hierarchy()).explain(**o), tolerance=1e-9),
        "families": made(hqp.problems.hierarchies, "vertex", 2, seed=0),
        "Controller()": made(lambda q, v, t: controller()(q, v, t), q, v, t=0.0),
        "Controller() acceleration": made(lambda q, v, t: controller(order="acceleration")(q, v, t), q, v, t=0.0),
        "Controller.change": made(
            lambda s, **options: controller().change(s, **options), s, duration=0.1, law=tasks.cubic
        ),
        "Controller() spatial": made(
            lambda q, v, t: Controller(robot(), PositionTask([0.4, 0.1, 0.3], gain=1.0), dt=0.01)(q, v, t), q, v, t=0.0
        ),
        "Setpoint.move": made(lambda *o: Setpoint([0.0] * 3).move(*o), v, v, v),
        "RotationSetpoint.move": made(lambda *o: tasks.RotationSetpoint(np.eye(3)).move(*o), np.eye(3), v, v),
        "PoseSetpoint.move": made(lambda T: PoseSetpoint(np.eye(4)).move(T), np.eye(4)),
        "Stack >>": made(lambda x: stack() >> x, p),
        "Stack +": made(lambda x: position(name="b") + x, p),
        "Stack.without": made(mine.without, first, last),
        "Stack.swapped": made(mine.swapped, first, last),
        "Stack.inserted": made(mine.inserted, p, below=first),
        "Stack.build": made(mine.build, a, "velocity", dt=0.01),
        "Record.save": made(lambda path: record().save(path), folder / "out-record.npz"),
        "Record.load": made(Record.load, folder / "r.npz"),
        "PlanarArm.at": made(lambda q, v: arm().at(q, v), q, v),
        "PlanarArm.check_limits": made(lambda q, **own: arm().check_limits(q, **own), q, tolerance=1.0),
        "PlanarArm.interpolate": made(lambda *o: arm().interpolate(*o), q, q, 0.5),
        "PlanarArm.points": made(lambda q: arm().points(q), q),
        "PinocchioRobot.at": made(lambda q, v: robot().at(q, v), q, v),
        "PinocchioRobot.check_limits": made(lambda q: robot().check_limits(q), q),
        "PinocchioRobot.interpolate": made(lambda *o: robot().interpolate(*o), q, q, 0.5),
        "PinocchioRobot.transform": made(lambda *o: robot().at(q).transform(*o), "link3", "link1"),
        "PinocchioRobot.configuration": made(lambda x: robot().configuration(x), {"joint0": 0.1}),
        "PinocchioRobot.random": made(lambda x: robot().random(x), new(lambda: np.random.default_rng(0))),
        "PinocchioRobot.describe": made(lambda x: robot().describe(x), q),
        "trajectories": made(lambda t: [trajectory(t) for trajectory in SAMPLES], 0.5),
        "as target": made(lambda target: Controller(robot(), PositionTask(target, gain=1.0), dt=0.01)(q, v, 0.1), v),
        "as axis": made(lambda target: Controller(robot(), tasks.AxisTask(target, gain=1.0), dt=0.01)(q, v, 0.1), q),
        "as rotation": made(lambda R: Controller(robot(), OrientationTask(R, gain=1.0), dt=0.01)(q, v, 0.1), np.eye(3)),
        "as part": made(
            lambda *parts: Controller(arm(), Stack(*parts), dt=0.01)(q, v, 0.1), p, new(PostureTask, v, gain=1.0)
        ),
        "torques": made(
            lambda **own: simulate(controller(order="torque"), q, duration=0.02, **own), speed_cap=9.0, plant=None
        ),
    }  # fmt: skip
    for result in results():
        kind = type(result)
        if is_dataclass(kind):
            fields = {key: getattr(result, key) for key in inspect.signature(kind).parameters}
        elif hasattr(result, "_asdict"):
            fields = result._asdict()
        else:
            fields = {key: getattr(result, key) for key in inspect.signature(kind).parameters}
        table[kind.__name__] = made(kind, **fields)
    return table


SAMPLES = [
    Line([0.0, 0.0], [1.0, 0.0], 1.0), Circle([0.0, 0.0], 1.0, 2.0), tasks.Polygon(np.eye(3)[:, :2], 1.0),
    Polynomial(np.zeros((3, 2)), np.ones((3, 2)), 1.0), Turn(np.eye(3), np.eye(3), 1.0), Fixed([0.0]),
]  # fmt: skip


def goes_on(value: Any, folder: Path) -> None:
    """What is done with what came out: parts are put to work on a robot, hierarchies solved, trajectories followed."""
    q, v = [0.4, 0.3, 0.2], [0.0] * 3
    if type(value) is tasks.Task:
        return  # it is to be derived from
    if isinstance(value, tasks.Part | Stack):
        repr(value)
        for machine in arm(), spatial(folder):
            for order in "velocity", "acceleration":
                with suppress(HqpError):
                    control = Controller(machine, JointVelocityLimit(1.0) >> value, order=order, dt=0.01)
                    assert control(q, v, 0.1).solution.status in hqp.Status
    elif isinstance(value, Level):
        repr(value)
        goes_on(Hierarchy([value, value], n=3), folder)
    elif isinstance(value, Hierarchy):
        if value.n <= 10:
            repr(Solver(settings=Settings(iterations=50)).solve(value))
    elif isinstance(value, hqp.DampingRule):
        repr(Solver(damping={1: value}).solve(hierarchy()))
    elif isinstance(value, PlanarArm):
        if value.nv <= 10:
            Controller(value, position())([0.1] * value.nv, [0.0] * value.nv, 0.0)
    elif isinstance(value, tasks.Trajectory) and not isinstance(value, type):
        for t in -1.0, 0.0, 0.3, 5.0:
            value(t)


def place_of(error: BaseException) -> str:
    """Where in the package it came out, or where at all."""
    files = [Path(frame.filename) for frame in traceback.extract_tb(error.__traceback__)]
    ours = [file for file in files if any(file.is_relative_to(ROOT / package) for package in ("hqp", "tasks"))]
    return ours[-1].relative_to(ROOT).as_posix() if ours else files[-1].name


def wrong(error: BaseException) -> bool:
    """Whether an exception is none that may come out."""
    if isinstance(error, TypeError):  # Python's own, of the signature, comes before anything is called
        return not all(frame.filename == __file__ for frame in traceback.extract_tb(error.__traceback__))
    return not isinstance(error, HqpError)


def told(what: str, error: BaseException) -> str:
    frame = traceback.extract_tb(error.__traceback__)[-1]
    said = f"{what}: {type(error).__name__}: {str(error)[:200]} ({place_of(error)}; {frame.filename}:{frame.lineno})"
    return ascii(said)


def fuzz(folder: Path, count: int, seed: int) -> list[str]:
    """What came out of so many calls that should not, once for each place."""
    rng = random.Random(seed)
    table, pool, found = calls(folder), list(JUNK), dict[tuple[str, str], str]()
    for name in islice(cycle(table), count):
        call, args, kwargs = table[name]()
        given: dict[int | str, Any] = {**dict(enumerate(args)), **kwargs}
        chosen = {
            place: rng.choice(pool)
            for place in rng.sample([*given], min(len(given), rng.choice([0, 1, 1, 1, 1, 2, 3])))
        }
        given |= {place: JUNK[junk]() for place, junk in chosen.items()}
        if any(callable(given.get(place)) for place in CALLBACKS & set(chosen)):
            continue  # whose own errors are the caller's
        try:
            positional = [given.pop(k) for k in range(len(args))]
            goes_on(call(*positional, **given), folder)
        except Exception as error:
            if wrong(error):
                place = place_of(error)
                what = f"{name}({', '.join(f'{place}: {junk}' for place, junk in chosen.items())})"
                found.setdefault((place, type(error).__name__), told(what, error))
    return list(found.values())


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where relative names lead: nothing is written elsewhere."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_public_name_is_called(folder: Path) -> None:
    public = {*hqp.__all__, *tasks.__all__}
    assert public - PASSIVE == public & set(calls(folder))


def test_the_calls_are_good_ones(folder: Path) -> None:
    """Without junk all of them go through: what the fuzz finds is about what it changes."""
    for name, make in calls(folder).items():
        call, args, kwargs = make()
        try:
            call(*args, **kwargs)
        except HqpError as error:
            pytest.fail(f"{name}: {error}")


@pytest.mark.parametrize("part", range(PARTS))
def test_whatever_is_given(part: int, folder: Path) -> None:
    assert fuzz(folder, CALLS // PARTS, part) == []


@pytest.mark.sweep
@pytest.mark.parametrize("part", range(PARTS))
def test_whatever_is_given_at_length(part: int, folder: Path) -> None:
    assert fuzz(folder, SWEEP // PARTS, 1000 + part) == []


def damaged(content: bytes, rng: random.Random) -> bytes:
    """A file with some bytes changed, lost or put in."""
    own = bytearray(content)
    for _ in range(rng.choice([1, 1, 2, 5])):
        at = rng.randrange(len(own))
        kind = rng.randrange(5)
        if kind == 0:
            own[at] = rng.randrange(256)
        elif kind == 1:
            own[at] ^= 1 << rng.randrange(8)
        elif kind == 2:
            del own[at : at + rng.randrange(1, 20)]
        elif kind == 3:
            own[at:at] = rng.choice([b"9", b"-", b"\n", b"1e999", b"nan", b"\0", bytes(rng.randrange(9))])
        else:
            del own[at:]
        if not own:
            break
    return bytes(own)


@pytest.mark.parametrize("name", ["h.npz", "r.npz", "h.dat"])
def test_damaged_files(name: str, folder: Path) -> None:
    """They are refused, or are other files of the kind."""
    calls(folder)
    content, rng, found = (folder / name).read_bytes(), random.Random(name), dict[tuple[str, str], str]()
    readers = {"h.npz": hqp.load, "r.npz": Record.load, "h.dat": hqp.lexls.read}
    for k in range(FILES):
        (folder / f"damaged-{name}").write_bytes(damaged(content, rng))
        try:
            came = readers[name](folder / f"damaged-{name}")
            if name == "h.npz":
                repr(Solver().solve(*came))
        except Exception as error:
            if not isinstance(error, HqpError):
                found.setdefault((place_of(error), type(error).__name__), told(f"file {k}", error))
    assert list(found.values()) == []


@pytest.mark.parametrize("part", range(2))
def test_whatever_is_said_to_the_command(part: int, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from tasks.cli import run

    calls(folder)
    rng = random.Random(part)
    words = [
        "",
        "0",
        "-1",
        "1",
        "0.5",
        "nan",
        "inf",
        "1e300",
        "-1e300",
        "1,2,3",
        "0,0,0",
        "a",
        "h.npz",
        "h.dat",
        "r.npz",
    ]
    words += ["r.npz", "arm.urdf", "nowhere", ".", "--", "-", "-b", "native", "link3", "joint0", "9" * 5000, "\udc80"]
    good = [
        ["solve", "h.npz", "--backend", "native", "--x-ref", "0,0,0"],
        ["convert", "h.npz", "out.dat", "--to", "lexls", "--force"],
        ["convert", "h.dat", "out.npz", "--force"],
        ["ik", "arm.urdf", "--position", "0.4,0.1,0.3", "--frame", "link3", "--orientation", "0,0,0",
         "--iterations", "3", "--seed", "0", "--tolerance", "0.1", "--start", "home", "--lock", "joint0",
         "--base", "fixed"],
        ["thesis", "--figure", "nonsense", "--law", "strict", "--out", "out", "--format", "png"],
        ["validate", "--jobs", "0", "--out", "out"],
        ["backends"],
    ]  # fmt: skip
    for _ in range(COMMANDS // 2):
        line = [*rng.choice(good)]
        for place in rng.sample(range(1, len(line)), min(len(line) - 1, rng.choice([0, 1, 1, 2]))):
            if line[0] not in ("thesis", "validate") or place > 2:  # lest they begin
                line[place] = rng.choice(words)
        code = run(line)
        said = capsys.readouterr().err
        assert code in (0, 1, 2), ascii(line)
        assert said.count("\n") == (code == 2), ascii((line, said))
