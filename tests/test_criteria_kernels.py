"""Secondary criteria as loops: their gradients are those of their values, on every kind of chain."""

from __future__ import annotations

import numpy as np
import pytest
from kernels import compiled, plain

from tasks import (
    AxisTask,
    CenterOfMassTask,
    Controller,
    DynamicManipulabilityTask,
    GradientTask,
    JointCentringTask,
    JointMotion,
    KineticEnergyTask,
    Line,
    ManipulabilityTask,
    MinimumMotionTask,
    MinimumTorqueTask,
    MinorAxisTask,
    OrientationTask,
    PlanarArm,
    PoseTask,
    PositionTask,
    Stack,
    Turn,
    VelocityRatioTask,
    load_robot,
    velocity_ellipse,
)
from tasks.base.kernels import algebra, rotation
from tasks.base.loops import Call
from tasks.base.rotations import exp
from tasks.criteria.kernels import gradient, joints, measures
from tasks.criteria.kernels.joints import write_kinetic_energy
from tasks.frames.kernels import placement as frames
from tasks.frames.kernels.placement import LOCAL, SPATIAL, WORLD
from tasks.robots.block import fill, relative
from tasks.robots.chain import APART, chain_order, closed_form
from tasks.robots.kernels import block
from tasks.robots.robot import integrate
from tasks.rows.kernels import law
from tasks.rows.part import Tick

pin = pytest.importorskip("pinocchio")
from tasks.robots.pinocchio import PinocchioRobot  # noqa: E402

NAMES = ("manipulability", "velocity_ratio", "desired_velocity_ratio")
SIX = np.eye(6)
#: Position, orientation, both, some of both, one, and rows that are no mask.
READINGS = [SIX[:3], SIX[3:], SIX, SIX[[0, 2, 4]], SIX[[5]], np.random.default_rng(0).standard_normal((2, 6))]
STEP = 1e-5


@pytest.fixture(scope="module", params=["compiled", "plain"])
def kernels(request):
    if request.param == "compiled":
        return compiled(measures, *NAMES)
    return plain(rotation, algebra, law, frames, gradient, joints, measures)


@pytest.fixture(scope="module")
def loops():
    return compiled(measures, *NAMES)


def chain(*joints):
    """Joints one after the other, at random places, with a tip."""
    pin.seed(3)
    model, parent = pin.Model(), 0
    for i, joint in enumerate(joints):
        parent = model.addJoint(parent, joint, pin.SE3.Random(), f"j{i}")
        model.appendBodyToJoint(parent, pin.Inertia.Random(), pin.SE3.Identity())
    model.addFrame(pin.Frame("tip", parent, 0, pin.SE3.Random(), pin.FrameType.OP_FRAME))
    model.lowerPositionLimit[:], model.upperPositionLimit[:] = -2.0, 2.0
    return PinocchioRobot(model, tip="tip", name="a chain")


def composite():
    joint = pin.JointModelComposite(pin.JointModelRX(), pin.SE3.Random())
    for part in pin.JointModelPY(), pin.JointModelRZ():
        joint.addJoint(part, pin.SE3.Random())
    return joint


X, Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
BETWEEN = {
    "sliding": lambda: (pin.JointModelPY(), pin.JointModelRZ(), pin.JointModelPX()),
    "screw": lambda: (pin.JointModelHZ(0.2), pin.JointModelRY()),
    "circle": lambda: (pin.JointModelRUBY(), pin.JointModelRZ()),
    "ball": lambda: (pin.JointModelSpherical(),),
    "angles": lambda: (pin.JointModelSphericalZYX(),),
    "universal": lambda: (pin.JointModelUniversal(X, Y), pin.JointModelPZ()),
    "translation": lambda: (pin.JointModelTranslation(),),
    "planar": lambda: (pin.JointModelPlanar(),),
    "free": lambda: (pin.JointModelFreeFlyer(),),
    "composite": lambda: (composite(),),
}
FRAMES = {
    "arm": lambda: (PlanarArm([0.6, 0.5, 0.4, 0.3]), None, None),
    "arm, link": lambda: (PlanarArm([0.6, 0.5, 0.4, 0.3]), "link3", None),
    "panda": lambda: (load_robot("panda", lock=["panda_finger_joint1"]), None, None),
    "panda, finger that follows": lambda: (load_robot("panda", mimic="follow"), "panda_rightfinger", None),
    "panda, from a link": lambda: (load_robot("panda"), "panda_hand_tcp", "panda_link3"),
    "panda, seen from the hand": lambda: (load_robot("panda"), "panda_link1", "panda_link6"),
    "ur5": lambda: (load_robot("ur5"), None, None),
    "tiago": lambda: (load_robot("tiago"), None, None),
    "g1": lambda: (load_robot("g1"), "left_rubber_hand", None),
    "g1, hand to hand": lambda: (load_robot("g1"), "left_rubber_hand", "right_rubber_hand"),
} | {
    name: lambda between=between: (chain(pin.JointModelRX(), *between(), pin.JointModelRZ()), None, None)
    for name, between in BETWEEN.items()
}


class Measures:
    """The measures of one frame with their gradients, at any configuration."""

    def __init__(self, kernels, robot, frame, relative_to):
        self.kernels, self.robot, self.frame, self.relative_to = kernels, robot, frame, relative_to
        self.order = chain_order(robot, frame, relative_to)

    def block(self, q):
        state = self.robot.at(q, np.zeros(self.robot.nv))
        frame = state.frame(self.frame)
        if self.relative_to is not None:
            frame = relative(state.frame(self.relative_to), frame, state.v)
        numbers = np.zeros(block.size(self.robot.nv))
        fill(numbers, frame, state.v, np.zeros(1))
        return numbers

    def __call__(self, name, q, axes, reading, along=None):
        n, rows = self.robot.nv, len(reading)
        slope, work = np.empty(n), np.full(measures.work_size(n, rows), np.nan)
        told = (self.block(q), n, axes, reading.ravel(), rows, self.order)
        if name == "manipulability":
            value = self.kernels.manipulability(*told, slope, work)
        elif name == "velocity_ratio":
            value = self.kernels.velocity_ratio(*told, along, slope, np.empty(rows), work)
        else:
            value = self.kernels.desired_velocity_ratio(*told, along, slope, work)
        return value, slope

    def difference(self, name, q, *told):
        """The same gradient by central differences."""
        slope = np.zeros(self.robot.nv)
        for i in np.flatnonzero(self.order != APART):
            step = STEP * np.eye(self.robot.nv)[i]
            ahead, behind = (self(name, integrate(self.robot, q, way), *told)[0] for way in (step, -step))
            slope[i] = (ahead - behind) / (2.0 * STEP)
        return slope


def check_gradients(measures, states):
    rng = np.random.default_rng(5)
    random = getattr(measures.robot, "random", lambda rng: rng.uniform(-2.0, 2.0, measures.robot.nv))
    checked = 0
    for k in range(states):
        q, reading, axes = random(rng), READINGS[k % len(READINGS)], (k + k // 3) % 3
        here = measures.block(q)[block.JACOBIAN :].reshape(6, -1)
        if np.linalg.cond(reading @ here) > 1e4 and np.linalg.matrix_rank(here, 1e-9) >= len(reading):
            continue  # too near a singularity for a difference over a finite step
        u, desired = rng.standard_normal(len(reading)), rng.standard_normal(6)
        for name, along in ("manipulability", None), ("velocity_ratio", u), ("desired_velocity_ratio", desired):
            value, slope = measures(name, q, axes, reading, along)
            if value < 1e-8:
                continue
            expected = measures.difference(name, q, axes, reading, along)
            scale = 1.0 + np.abs(expected).max()
            np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-7 * scale, err_msg=f"{name} {axes} {reading}")
            checked += 1
    assert checked >= states  # of three times as many


@pytest.mark.parametrize("name", FRAMES)
def test_a_gradient_is_that_of_its_measure(loops, name):
    check_gradients(Measures(loops, *FRAMES[name]()), 30 * len(READINGS) if name in ("panda", "ur5", "arm") else 36)


def test_and_so_it_is_for_the_interpreter(kernels):
    check_gradients(Measures(kernels, *FRAMES["panda"]()), 9)


def test_the_measures_are_what_they_are_by_definition(kernels):
    measures, rng = Measures(kernels, *FRAMES["panda"]()), np.random.default_rng(8)
    for _ in range(10):
        q, u = measures.robot.random(rng), rng.standard_normal(3)
        J = measures.block(q)[block.JACOBIAN :].reshape(6, -1)[:3]
        w, _ = measures("manipulability", q, LOCAL, SIX[:3])
        r, _ = measures("velocity_ratio", q, WORLD, SIX[:3], u)
        assert w == pytest.approx(np.sqrt(np.linalg.det(J @ J.T)), rel=1e-9)
        assert r == pytest.approx((u @ np.linalg.solve(J @ J.T, u) / (u @ u)) ** -0.5, rel=1e-9)


def test_where_rank_is_lost_nothing_is_asked(kernels):
    """A stretched arm: every small motion raises w, and there is no way that does so the fastest."""
    measures, q = Measures(kernels, PlanarArm([0.6, 0.5, 0.4]), None, None), np.array([0.3, 0.0, 0.0])
    w, slope = measures("manipulability", q, WORLD, SIX[:2])
    assert w == pytest.approx(0.0, abs=1e-15)
    assert slope.tolist() == [0.0] * 3
    out = np.array([np.cos(0.3), np.sin(0.3)])
    r, slope = measures("velocity_ratio", q, WORLD, SIX[:2], out)
    assert r == pytest.approx(0.0, abs=1e-15)
    assert slope.tolist() == [0.0] * 3
    # More rows than joints: no volume, whatever the joints do.
    w, slope = measures("manipulability", q + 1.0, WORLD, SIX)
    assert (w, slope.tolist()) == (0.0, [0.0] * 3)
    # No direction, none wanted.
    r, slope = measures("velocity_ratio", q + 1.0, WORLD, SIX[:2], np.zeros(2))
    assert (r, slope.tolist()) == (0.0, [0.0] * 3)
    # Along what can still be moved, the longest half axis.
    still = np.zeros(3)
    r, slope = measures("velocity_ratio", still, WORLD, SIX[:2], np.array([0.0, 1.0]))
    assert r == pytest.approx(velocity_ellipse(measures.robot.jacobian(still)[:2]).half_axes[0], rel=1e-12)
    assert np.isfinite(slope).all()


@pytest.mark.parametrize("axes", [WORLD, LOCAL, SPATIAL])
def test_what_is_not_finite_gives_nan(kernels, axes):
    measures = Measures(kernels, PlanarArm([0.6, 0.5, 0.4]), None, None)
    q = np.array([0.3, np.nan, 0.1])
    for name, along in ("manipulability", None), ("velocity_ratio", np.ones(2)), ("desired_velocity_ratio", np.ones(6)):
        value, slope = measures(name, q, axes, SIX[:2], along)
        assert np.isnan([value, *slope]).all()


def test_chains_that_have_no_closed_form():
    ellipsoid = chain(pin.JointModelRX(), pin.JointModelEllipsoid(0.1, 0.2, 0.3), pin.JointModelRZ())
    assert not closed_form(ellipsoid, None)
    ball = chain(pin.JointModelRX(), pin.JointModelSpherical(), pin.JointModelRZ())
    assert closed_form(ball, "tip")
    assert not closed_form(ball, "universe", "tip")
    tied = chain(pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ()).model
    tied = PinocchioRobot(pin.transformJointIntoMimic(tied, 1, 3, 0.5, 0.1), tip="tip", name="a tied chain")
    assert not closed_form(tied, "tip")
    assert not closed_form(object(), None)


def test_the_order_of_a_chain():
    panda = load_robot("panda")
    assert chain_order(panda, None).tolist() == [0, 1, 2, 3, 4, 5, 6, APART]
    assert chain_order(panda, "panda_link2", "panda_link4").tolist() == [APART, APART, 1, 0, APART, APART, APART, APART]
    assert chain_order(PlanarArm([1.0, 1.0, 1.0]), "link2").tolist() == [0, 1, APART]


def panda():
    return load_robot("panda", lock=["panda_finger_joint1"])


def arm():
    return PlanarArm([0.6, 0.5, 0.4], position_limit=(-2.0, 2.5))


def reach(robot, **options):
    return PositionTask([0.4, 0.1] if isinstance(robot, PlanarArm) else [0.4, 0.1, 0.3], gain=10.0, **options)


#: All that loops write, by order; and a moving target, which only the velocity ratio asks for.
ALWAYS = [
    lambda robot: ManipulabilityTask(reach(robot), gain=2.0),
    lambda robot: MinorAxisTask(reach(robot), gain=2.0),
    lambda robot: VelocityRatioTask(reach(robot), np.arange(1.0, 1.0 + reach(robot).rows), gain=2.0),
    lambda robot: VelocityRatioTask(PositionTask(Line([0.0, 0.0], [1.0, 0.5], 2.0), gain=1.0), gain=2.0),
    lambda robot: JointCentringTask(gain=3.0),
    lambda robot: MinimumMotionTask(gain=3.0),
    lambda robot: KineticEnergyTask(gain=3.0),
]
PARTS = {
    "velocity": ALWAYS,
    "acceleration": [
        *ALWAYS,
        lambda robot: MinimumTorqueTask(),
        lambda robot: MinimumTorqueTask(torque_range=(-1.0, np.arange(robot.nv))),
    ],
}
IN_SPACE = [
    lambda: OrientationTask(np.eye(3), reference="local", mask="xz", gain=1.0),
    lambda: PoseTask(Line(np.zeros(3), np.ones(3), 2.0), Turn(np.eye(3), exp([0.3, 0.2, 1.0]), 2.0), gain=1.0),
    lambda: PoseTask(np.zeros(3), Turn(np.eye(3), exp([0.3, 0.2, 1.0]), 2.0), reference="local", gain=1.0),
    lambda: PoseTask(np.zeros(3), Turn(np.eye(3), exp([0.3, 0.2, 1.0]), 2.0), reference="world", gain=1.0),
    lambda: AxisTask(Line([1.0, 0.0, 0.0], [0.0, 1.0, 0.5], 2.0), gain=1.0),
    lambda: PositionTask(np.zeros(3), relative_to="panda_link2", gain=1.0),
]


def check_rows(robot, part, order, atol):
    """What loops write is what the part writes in Python."""
    rows, rng = Stack(part).build(robot, order), np.random.default_rng(4)
    [(_, plan)] = rows.plans
    assert plan.python is None
    level = rows.hierarchy.levels[0]
    for _ in range(5):
        q = rng.uniform(-2.0, 2.0, robot.nv) if isinstance(robot, PlanarArm) else robot.random(rng)
        state = robot.at(q, rng.standard_normal(robot.nv))
        rows.fill(state, 0.7)
        A = None if level.A is None else np.zeros_like(level.A)
        lower, upper = np.zeros((2, len(level.lower)))
        if isinstance(part, GradientTask):
            K, slope = part.gain, part.gradient(robot, q, 0.7)[part.variables(robot)] * (-1.0 if part.descend else 1.0)
            v = state.v[part.variables(robot)]
            lower[:] = K * slope if order == "velocity" else K**2 * slope - 2.0 * K * v
        else:
            part.write(Tick(robot, state, 0.7, order, None), A, lower, upper)
        np.testing.assert_allclose(level.lower, lower, rtol=atol, atol=atol)
        np.testing.assert_array_equal(level.upper, level.lower)
        if A is not None:
            np.testing.assert_allclose(level.A, A, rtol=0, atol=1e-12 * np.abs(A).max())


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("make", [arm, panda])
def test_loops_write_what_python_writes(make, order):
    robot = make()
    for part in PARTS[order]:
        made = part(robot)
        check_rows(robot, made, order, 1e-6 if hasattr(made, "task") else 1e-12)


@pytest.mark.parametrize("which", range(len(IN_SPACE)))
def test_loops_climb_the_measures_of_all_tasks_of_a_frame(which):
    for part in ManipulabilityTask, MinorAxisTask, VelocityRatioTask:
        check_rows(panda(), part(IN_SPACE[which](), gain=2.0), "velocity", 1e-6)


class Doubled(PositionTask):
    """Reads what its parent does not know."""

    def jacobian(self, state):
        return 2.0 * super().jacobian(state)


def test_what_has_no_closed_form_is_taken_by_differences():
    for task in CenterOfMassTask(np.zeros(3), gain=1.0), Doubled(np.zeros(3), gain=1.0):
        for part in ManipulabilityTask(task, gain=1.0), VelocityRatioTask(task, np.ones(3), gain=1.0):
            [(_, plan)] = Stack(part).build(panda(), "velocity").plans
            assert plan.python is not None
            assert "differences" in plan.why
    [(_, plan)] = Stack(DynamicManipulabilityTask(reach(arm()), gain=1.0)).build(arm(), "velocity").plans
    assert "differences" in plan.why


def test_a_criterion_of_ones_own_is_written_in_python():
    class Stretched(GradientTask):
        def value(self, robot, q, t=0.0):
            return float(robot.at(q, np.zeros(robot.nv)).frame().position[0])

    rows, q = Stack(Stretched(gain=2.0)).build(arm(), "velocity"), np.array([0.3, -0.5, 0.7])
    [(_, plan)] = rows.plans
    assert "Stretched has its own value()" in plan.why
    rows.fill(arm().at(q, np.zeros(3)), 0.0)
    np.testing.assert_allclose(rows.hierarchy.levels[0].lower, 2.0 * arm().jacobian(q)[0], atol=1e-8)


def test_no_root_of_a_mass_matrix_is_nan():
    n = 3
    bounds, A = np.zeros((2, n)), np.zeros((n, n))
    Call(write_kinetic_energy, n, np.zeros(1), np.zeros(n), *bounds, -np.eye(n), A).run()
    assert np.isnan(A).all()
    assert np.isnan(bounds).all()


@pytest.mark.parametrize("damping", [0.0, 0.2])
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_the_motion_that_a_task_would_make_alone(order, damping):
    robot, task, rng = panda(), PoseTask(np.ones(3), np.eye(3), gain=2.0), np.random.default_rng(9)
    rows = Stack(JointMotion(task, damping=damping)).build(robot, order)
    itself = Stack(task).build(robot, order)
    assert rows.compiled
    for _ in range(5):
        state = robot.at(robot.random(rng), rng.standard_normal(robot.nv))
        rows.fill(state, 0.0)
        J, h = itself.fill(state, 0.0).levels[0].A, itself.hierarchy.levels[0].lower
        x = J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(6), h)
        np.testing.assert_allclose(rows.hierarchy.levels[0].lower, x, rtol=1e-9, atol=1e-9 * np.abs(x).max())


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize(
    ("make", "changes"),
    [
        (ManipulabilityTask, {"gain": 3.0, "weight": 2.0}),
        (VelocityRatioTask, {"gain": 3.0, "weight": 2.0, "direction": [0.0, 1.0, 2.0]}),
        (JointCentringTask, {"gain": 3.0, "weight": 2.0}),
        (MinimumMotionTask, {"gain": 3.0, "weight": 2.0}),
        (KineticEnergyTask, {"gain": 3.0, "weight": 2.0}),
        (MinimumTorqueTask, {"weight": 2.0}),
        (JointMotion, {"damping": 0.3}),
    ],
)
def test_a_number_that_is_changed_is_that_of_a_fresh_controller(make, changes, order):
    if make is MinimumTorqueTask and order == "velocity":
        pytest.skip("torques belong to accelerations")
    robot, rng = panda(), np.random.default_rng(11)
    given = (reach(robot),) if make in (ManipulabilityTask, VelocityRatioTask, JointMotion) else ()
    options = {"gain": 1.0} if "gain" in changes else {}
    if make is VelocityRatioTask:
        options["direction"] = [1.0, 0.0, 0.0]
    if make is MinimumTorqueTask:
        options["torque_range"] = (-1.0, 3.0)
    above = OrientationTask(np.eye(3), gain=1.0)
    q, v = robot.random(rng), 0.1 * rng.standard_normal(robot.nv)
    for name, value in changes.items():
        part = make(*given, **options)
        controller = Controller(robot, above >> part, order=order, damping=None)
        controller(q, v)
        setattr(part, name, value)
        fresh = Controller(robot, above >> make(*given, **options | {name: value}), order=order, damping=None)
        np.testing.assert_array_equal(controller(q, v).solution.x, fresh(q, v).solution.x)
