"""Secondary criteria: gradients are those of their scalars, which improve below a task; least motion and torque."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    Controller,
    DynamicManipulabilityTask,
    GradientTask,
    JointCentringTask,
    KineticEnergyTask,
    Line,
    ManipulabilityTask,
    MinimumMotionTask,
    MinimumTorqueTask,
    MinorAxisTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    VelocityRatioTask,
    load_robot,
    simulate,
)

pytest.importorskip("pinocchio")

RANGE = (-2.5, [2.0, 2.5, 3.0])
ARMS = {
    "3R": PlanarArm([0.6, 0.5, 0.4], position_limit=RANGE),
    "4R": PlanarArm([0.5, 0.4, 0.4, 0.3], position_limit=(-2.0, 2.5)),
}


@pytest.fixture(scope="module")
def spatial():
    return {
        "panda": load_robot("panda", lock=["panda_finger_joint1"]),
        "ur5": load_robot("ur5"),
        "g1": load_robot("g1"),
    }


@pytest.fixture(params=["3R", "4R", "panda", "ur5"])
def robot(request, spatial):
    return ARMS.get(request.param) or spatial[request.param]


def tip(robot):
    return PositionTask([0.4, 0.1] if isinstance(robot, PlanarArm) else [0.4, 0.1, 0.3], gain=10.0)


def criteria(robot):
    task = tip(robot)
    u = np.arange(1.0, 1.0 + task.rows)
    return {
        "manipulability": ManipulabilityTask(task, gain=1.0),
        "minor axis": MinorAxisTask(task, gain=1.0),
        "dynamic": DynamicManipulabilityTask(task, gain=0.1),
        "ratio": VelocityRatioTask(task, u, gain=1.0),
        "centring": JointCentringTask(gain=1.0),
    }


def states(robot, count=4):
    rng = np.random.default_rng(3)
    random = getattr(robot, "random", None)
    for _ in range(count):
        q = rng.uniform(-2.0, 2.0, robot.nv) if random is None else random(rng)
        yield q, rng.uniform(-1.0, 1.0, robot.nv)


def scalar(robot, name, q):
    """The same scalars by determinants and by their definitions."""
    state = robot.at(q, np.zeros(robot.nv))
    J = tip(robot).jacobian(state)
    u = np.arange(1.0, 1.0 + len(J))
    u /= np.linalg.norm(u)
    A = J @ np.linalg.inv(robot.mass_matrix(q))
    low, high = robot.position_limit
    return {
        "manipulability": lambda: np.sqrt(np.linalg.det(J @ J.T)),
        "dynamic": lambda: np.sqrt(np.linalg.det(A @ A.T)),
        "ratio": lambda: 1.0 / np.sqrt(u @ np.linalg.solve(J @ J.T, u)),
        "centring": lambda: np.mean((2.0 * q - low - high) ** 2 / (high - low) ** 2),
    }[name]()


@pytest.mark.parametrize("name", ["manipulability", "dynamic", "ratio", "centring"])
def test_a_gradient_is_that_of_its_scalar(robot, name):
    task = criteria(robot)[name]
    for q, _ in states(robot):
        here = scalar(robot, name, q)
        assert task.value(robot, q) == pytest.approx(here, rel=1e-6, abs=1e-9)
        slope, way = task.gradient(robot, q), np.random.default_rng(4).normal(size=robot.nv)
        step = 1e-4 * way / np.linalg.norm(way)
        expected = (scalar(robot, name, q + step) - scalar(robot, name, q - step)) / 2.0
        assert slope @ step == pytest.approx(expected, rel=1e-3, abs=1e-8 * (1.0 + here))


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("name", ["manipulability", "dynamic", "ratio", "centring"])
def test_the_law(robot, name, order):
    task = criteria(robot)[name]
    K, sign = task.gain, -1.0 if name == "centring" else 1.0
    q, v = next(states(robot))
    x = Controller(robot, task, order=order, damping=None)(q, v).solution.x
    climb = sign * task.gradient(robot, q)
    own = task.variables(robot)
    np.testing.assert_allclose(x[own], (K * climb if order == "velocity" else K**2 * climb - 2 * K * v)[own], atol=1e-9)


@pytest.mark.parametrize("name", ["manipulability", "dynamic", "ratio", "centring"])
@pytest.mark.parametrize("which", ["3R", "4R", "panda"])
def test_it_improves_while_the_tip_stands_still(which, name, spatial):
    """Ticks so short that the chord of each is the arc: the tip stays within 1e-9 m."""
    robot = ARMS.get(which) or spatial[which]
    q = np.array([0.3, 0.9, -0.5, 0.4][: robot.nv]) if which in ARMS else robot.home
    frame = robot.at(q, np.zeros(robot.nv)).frame()
    above = PositionTask(frame.position[: 2 if which in ARMS else 3], gain=1e3)
    below = criteria(robot)[name]
    below.gain = 1e-2 / np.linalg.norm(below.gradient(robot, q))  # [rad/s], at first
    record = simulate(Controller(robot, above >> below, dt=1e-3, damping=None), q, duration=0.1)
    assert np.linalg.norm(record.errors["position"], axis=1).max() < 1e-9
    values = np.array([below.value(robot, q) for q in record.q])
    gained = np.diff(values) if name != "centring" else -np.diff(values)
    assert np.all(gained > 0.0)
    assert record.certified == record.checked > 0


def test_a_floating_base_is_left_alone(spatial):
    g1 = spatial["g1"]
    hand = PositionTask([0.3, 0.2, 0.1], frame="left_rubber_hand", relative_to="torso_link", gain=1.0)
    for task in (ManipulabilityTask(hand, gain=1.0), JointCentringTask(gain=1.0)):
        q = g1.home
        assert not task.gradient(g1, q)[:6].any()
        rng = np.random.default_rng(1)
        q = g1.integrate(q, 0.1 * rng.normal(size=g1.nv))
        step = 1e-4 * rng.normal(size=g1.nv)
        ends = [task.value(g1, g1.integrate(q, side)) for side in (step, -step)]
        slope = task.gradient(g1, q)
        assert slope @ step == pytest.approx((ends[0] - ends[1]) / 2.0, rel=1e-3)  # the base moves neither
        x = Controller(g1, task, damping=None)(q, np.zeros(g1.nv)).solution.x
        np.testing.assert_allclose(x, (1.0 if not task.descend else -1.0) * slope, atol=1e-8)


def test_the_velocity_ratio_follows_the_path():
    arm = ARMS["3R"]
    q = np.array([0.4, 0.8, -0.3])
    here = arm.pose(q)[:2]
    path = Line(here, here + np.array([0.2, -0.1]), duration=2.0)
    along = VelocityRatioTask(PositionTask(path, gain=1.0), gain=1.0)
    fixed = VelocityRatioTask(PositionTask(path, gain=1.0), [0.2, -0.1], gain=1.0)
    np.testing.assert_allclose(along.gradient(arm, q, 1.0), fixed.gradient(arm, q), atol=1e-9)
    assert not along.gradient(arm, q, 5.0).any(), "at its end the path stands still"
    # The ratio is the speed of the task per joint speed of the least motion along u.
    J, u = arm.jacobian(q)[:2], np.array([2.0, -1.0]) / np.sqrt(5.0)
    assert fixed.value(arm, q) == pytest.approx(1.0 / np.linalg.norm(np.linalg.pinv(J) @ u))
    assert fixed.value(arm, np.zeros(3)) == pytest.approx(0.0, abs=1e-12), "stretched, it cannot move along x"


def test_joints_without_range_have_no_row():
    arm = PlanarArm([0.5, 0.5, 0.5], position_limit=([-1.0, -np.inf, -1.0], [2.0, 1.0, 3.0]))
    task = JointCentringTask(gain=2.0)
    assert task.variables(arm).tolist() == [0, 2]
    np.testing.assert_allclose(task.gradient(arm, np.array([1.0, 9.0, 1.0])), [0.5 / 2.25, 0.0, 0.0])
    assert task.value(arm, np.array([2.0, 9.0, -1.0])) == pytest.approx(1.0)
    last = JointCentringTask(gain=1.0) >> PostureTask([0.0, 0.7, 0.0], gain=1.0)
    x = Controller(arm, last, damping=None)([0.5, 0.0, 1.0], np.zeros(3)).solution.x
    np.testing.assert_allclose(x, [0.0, 0.7, 0.0], atol=1e-12)


def weighted(J, h, W, x0):
    """``argmin (x - x0)^T W (x - x0)`` subject to J x = h."""
    inverse = np.linalg.inv(W)
    return x0 + inverse @ J.T @ np.linalg.solve(J @ inverse @ J.T, h - J @ x0)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_least_motion_is_the_weighted_pseudoinverse(robot, order):
    weight = np.linspace(0.5, 2.0, robot.nv)
    for q, v in states(robot):
        controller = Controller(robot, tip(robot) >> MinimumMotionTask(weight, gain=3.0), order=order, damping=None)
        energy = Controller(robot, tip(robot) >> KineticEnergyTask(gain=3.0), order=order, damping=None)
        x = controller(q, v).solution.x
        J, h = controller.hierarchy.levels[0].A, controller.hierarchy.levels[0].lower
        rest = np.zeros(robot.nv) if order == "velocity" else -3.0 * v
        close(x, weighted(J, h, np.diag(weight**2), rest))
        close(energy(q, v).solution.x, weighted(J, h, robot.mass_matrix(q), rest))


@pytest.mark.parametrize("ranged", [False, True])
def test_least_torque_is_the_weighted_pseudoinverse(robot, ranged):
    low, high = -np.linspace(20.0, 5.0, robot.nv), np.linspace(30.0, 9.0, robot.nv)
    task = MinimumTorqueTask(torque_range=(low, high) if ranged else None)
    middle, half = ((low + high) / 2.0, (high - low) / 2.0) if ranged else (0.0, np.ones(robot.nv))
    for q, v in states(robot):
        controller = Controller(robot, tip(robot) >> task, order="acceleration", torque=True, damping=None)
        step = controller(q, v)
        J, h = controller.hierarchy.levels[0].A, controller.hierarchy.levels[0].lower
        M = robot.mass_matrix(q)
        W = M / half**2 @ M
        close(step.a, weighted(J, h, W, np.linalg.solve(M, middle - robot.bias(q, v))))
        # Nothing the task does not see lowers the sum: its slope along the null space is 0.
        free = np.linalg.svd(J)[2][len(J) :]
        slope = free @ M @ ((step.tau - middle) / half**2)
        assert np.abs(slope).max() < 1e-9 * (1.0 + np.abs(step.tau).max())


def close(x, expected):
    np.testing.assert_allclose(x, expected, atol=1e-9 * (1.0 + np.abs(expected).max()))


def test_a_balance_of_torque_and_motion():
    arm = ARMS["3R"]
    q, v = np.array([0.4, 0.8, -0.3]), np.array([0.2, 0.5, -1.0])
    stack = tip(arm) >> MinimumTorqueTask() + MinimumMotionTask(0.3, gain=4.0)
    controller = Controller(arm, stack, order="acceleration", damping=None)
    x = controller(q, v).solution.x
    J, h = controller.hierarchy.levels[0].A, controller.hierarchy.levels[0].lower
    M, b = arm.mass_matrix(q), arm.bias(q, v)
    W = M @ M + 0.09 * np.eye(3)
    close(x, weighted(J, h, W, np.linalg.solve(W, -M @ b - 0.09 * 4.0 * v)))


def test_the_motion_equation_by_its_parts(robot):
    for q, v in states(robot):
        a = v[::-1].copy()
        M, b = robot.mass_matrix(q), robot.bias(q, v)
        np.testing.assert_allclose(M, M.T, rtol=0.0, atol=1e-14)
        assert np.linalg.eigvalsh(M).min() > 0.0
        np.testing.assert_allclose(M @ a + b, robot.inverse_dynamics(q, v, a), atol=1e-10)
    q, v = (np.array(x) for x in zip(*states(robot), strict=True))
    assert robot.mass_matrix(q).shape == (4, robot.nv, robot.nv)
    np.testing.assert_allclose(robot.mass_matrix(q)[2], robot.mass_matrix(q[2]), atol=1e-14)
    np.testing.assert_allclose(robot.bias(q[None], v[None])[0, 1], robot.bias(q[1], v[1]), atol=1e-13)


def test_dynamics_do_not_disturb_a_state_asked_before(spatial):
    panda = spatial["panda"]
    v = np.linspace(-1.0, 1.0, 7)
    state = panda.at(panda.home, v)
    before = state.frame("panda_link4").linear.copy()
    other = np.array(panda.random(np.random.default_rng(0)))
    panda.mass_matrix(other)
    panda.bias(other, v)
    np.testing.assert_array_equal(panda.at(panda.home, v).frame("panda_link4").linear, before)
    np.testing.assert_array_equal(
        state.frame("panda_link5").linear, panda.at(panda.home, v).frame("panda_link5").linear
    )


def test_a_criterion_of_ones_own():
    class Height(GradientTask):
        def value(self, robot, q, t=0.0):
            return robot.pose(q)[1]

    arm = ARMS["3R"]
    q = np.array([0.4, 0.8, -0.3])
    np.testing.assert_allclose(Height(gain=1.0).gradient(arm, q), arm.jacobian(q)[1], atol=1e-9)
    assert repr(Height(gain=2.0)) == "Height(gain=2)"
    with pytest.raises(NotImplementedError, match="GradientTask must define value"):
        GradientTask(gain=1.0).gradient(arm, q)


def test_what_is_not_finite_is_for_the_solver_to_report(robot):
    parts = [*criteria(robot).values(), KineticEnergyTask()]
    q = np.full(robot.nq, np.nan)
    for part in parts:
        assert not Controller(robot, part, damping=None)(q, np.zeros(robot.nv)).ok
    assert not Controller(robot, MinimumTorqueTask(), order="acceleration", damping=None)(q, np.zeros(robot.nv)).ok


class Bare:
    """A robot that tells neither its masses nor its limits."""

    nq = nv = 3
    position_limit = velocity_limit = acceleration_limit = None
    at = ARMS["3R"].at

    def __repr__(self):
        return "Bare()"


def test_refusals_name_the_task(spatial):
    arm, g1, task = ARMS["3R"], spatial["g1"], PositionTask([0.4, 0.1], gain=1.0)
    hand = PositionTask([0.4, 0.1, 0.0], frame="left_rubber_hand", gain=1.0)

    class Massless(PlanarArm):
        def mass_matrix(self, q):
            return np.zeros((2, 2))

    class Light(PlanarArm):
        def mass_matrix(self, q):
            return np.diag([2.0, 0.0])

    massless, light = Massless([0.5, 0.5]), Light([0.5, 0.5])
    for wrong, message in (
        (lambda: JointCentringTask(gain=0.0), "JointCentringTask 'jointcentring': gain = 0.0 1/s must be positive"),
        (
            lambda: Controller(Bare(), JointCentringTask(gain=1.0), damping=None),
            "'jointcentring': takes a robot with position limits",
        ),
        (lambda: DynamicManipulabilityTask(3, gain=1.0), "DynamicManipulabilityTask takes a Task, not a int"),
        (
            lambda: Controller(Bare(), DynamicManipulabilityTask(task, gain=1.0), damping=None),
            "'dynamic manipulability of position': takes a robot that has mass_matrix",
        ),
        (
            lambda: Controller(g1, DynamicManipulabilityTask(hand, gain=1.0), damping=None),
            "takes a robot with a fixed base",
        ),
        (lambda: VelocityRatioTask(task, [0.0, 0.0], gain=1.0), "'velocity ratio of position': direction = .* zero"),
        (lambda: VelocityRatioTask(task, [0.0, np.inf], gain=1.0), "direction.* must be finite"),
        (
            lambda: Controller(arm, VelocityRatioTask(task, [1.0], gain=1.0), damping=None),
            r"direction has shape \(1,\).* \(2,\)",
        ),
        (lambda: MinimumMotionTask(-1.0), "MinimumMotionTask 'minimum motion': weight"),
        (
            lambda: Controller(arm, MinimumMotionTask(), order="acceleration", damping=None),
            "'minimum motion': gain = None",
        ),
        (lambda: Controller(arm, MinimumMotionTask([1.0, 2.0]), damping=None), r"weight has shape \(2,\)"),
        (
            lambda: Controller(arm, KineticEnergyTask(), order="acceleration", damping=None),
            "'kinetic energy': gain = None",
        ),
        (
            lambda: Controller(Bare(), KineticEnergyTask(), damping=None),
            "'kinetic energy': takes a robot that has mass_matrix",
        ),
        (
            lambda: Controller(massless, DynamicManipulabilityTask(task, gain=1.0), damping=None),
            "positive definite mass matrix",
        ),
        (lambda: Controller(massless, KineticEnergyTask(), damping=None), "without any mass: joint 0, joint 1$"),
        (lambda: Controller(light, KineticEnergyTask(), damping=None), "without any mass: joint 1$"),
        (lambda: Controller(arm, MinimumTorqueTask(), damping=None), "'minimum torque': order = 'velocity'"),
        (lambda: Controller(Bare(), MinimumTorqueTask(), order="acceleration", damping=None), "that has mass_matrix"),
        (
            lambda: Controller(g1, MinimumTorqueTask(), order="acceleration", damping=None),
            "takes a robot with a fixed base",
        ),
        (lambda: MinimumTorqueTask(torque_range=5.0), "torque range = 5.0 must be a pair"),
        (lambda: MinimumTorqueTask(torque_range=(1.0, 1.0)), "the lowest must be below the highest"),
        (
            lambda: MinimumTorqueTask(torque_range=([-1, -1], [1, 1, 1])),
            "torque range and weight have shapes .* must agree",
        ),
        (lambda: MinimumTorqueTask(torque_range=(-np.inf, 1.0)), "torque range.* must be finite"),
        (
            lambda: Controller(
                arm, MinimumTorqueTask(torque_range=([-1, -1], [1, 1])), order="acceleration", damping=None
            ),
            r"shape \(2,\)",
        ),
    ):
        with pytest.raises(InvalidInput, match=message):
            wrong()


def test_reprs_and_labels(spatial):
    task = PositionTask([0.4, 0.1], gain=1.0)
    assert repr(VelocityRatioTask(task, [1, 0], gain=2)).endswith("[1.0, 0.0], gain=2)")
    assert repr(MinimumMotionTask(gain=2)) == "MinimumMotionTask(1.0, gain=2)"
    assert repr(KineticEnergyTask()) == "KineticEnergyTask()"
    assert repr(MinimumTorqueTask(torque_range=(-1, 1))) == "MinimumTorqueTask(torque_range=(-1.0, 1.0))"
    label = MinimumTorqueTask().labels(spatial["panda"], "acceleration")[3]
    assert (label.part, label.row, label.unit) == ("minimum torque", "panda_joint4", "N m")
