"""Objects of Pink and mink in a stack: on one level they give the step of their own library, to 1e-8."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import Controller, Damping, PinocchioRobot, PostureTask, load_robot
from tasks.adapters import from_mink, from_pink
from tasks.adapters.joints import MujocoJoints

pin = pytest.importorskip("pinocchio", reason="needs Pinocchio: pip install 'hqp[robots]'")
pink = pytest.importorskip("pink", reason="needs Pink: pip install 'hqp[peers]'")
mink = pytest.importorskip("mink", reason="needs mink: pip install 'hqp[peers]'")
mujoco = pytest.importorskip("mujoco")

DT = 0.01
#: What has one joint of every kind, and geometry that comes close to itself.
SCENE = """
<mujoco>
  <worldbody>
    <body name="base" pos="0 0 0.5">{free}
      <geom name="trunk" type="sphere" size="0.1" mass="3"/>
      <body name="upper" pos="0 0 0.2">
        <joint name="shoulder" type="ball"/>
        <geom name="upper" type="capsule" size="0.03" fromto="0 0 0 0.3 0 0" mass="1"/>
        <body name="lower" pos="0.3 0 0">
          <joint name="elbow" axis="0 1 0" range="-2.5 2.5" limited="true"/>
          <geom name="lower" type="capsule" size="0.03" fromto="0 0 0 0.25 0 0" mass="0.7"/>
          <body name="wrist" pos="0.25 0 0">
            <joint name="slide" type="slide" axis="1 0 0" range="0 0.1" limited="true"/>
            <joint name="turn" axis="1 0 0"/>
            <geom name="hand" type="sphere" size="0.04" mass="0.3"/>
            <site name="tip" pos="0.05 0.01 0"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def step(robot, stack, q):
    """One tick of a controller, certified."""
    step = Controller(robot, stack, dt=DT, damping=None)(q)
    assert step.solution.certify().ok
    return step.v


def turned(rng, placement):
    return placement * pin.exp6(rng.normal(scale=0.1, size=6))


# Pink


@pytest.fixture(scope="module")
def panda():
    return load_robot("panda", lock=["panda_finger_joint1"])


@pytest.fixture(scope="module")
def humanoid():
    return load_robot("g1")


def frame_task(configuration, rng, **options):
    task = pink.tasks.FrameTask("panda_hand_tcp", position_cost=[1.0, 0.5, 2.0], orientation_cost=0.3, **options)
    task.set_target(turned(rng, configuration.get_transform_frame_to_world("panda_hand_tcp")))
    return task


def relative_task(configuration, rng):
    task = pink.tasks.RelativeFrameTask("panda_hand", "panda_link3", position_cost=1.0, orientation_cost=0.5)
    task.set_target(turned(rng, configuration.get_transform("panda_hand", "panda_link3")))
    return task


def velocity_task(configuration, rng):
    task = pink.tasks.JointVelocityTask(cost=0.7)
    task.set_target(rng.normal(size=7), DT)
    return task


def slow_task(configuration, rng):
    task = pink.tasks.LowAccelerationTask(cost=0.7)
    task.set_last_integration(rng.normal(size=7), DT)
    return task


def com_task(configuration, rng):
    task = pink.tasks.ComTask(cost=2.0)
    task.set_target(
        pin.centerOfMass(configuration.model, configuration.data, configuration.q) + np.array([0.01, 0.0, 0.02])
    )
    return task


TASKS = {
    "frame": frame_task,
    "frame, slow": lambda at, rng: frame_task(at, rng, gain=0.1),
    "frame, damped": lambda at, rng: frame_task(at, rng, lm_damping=0.5),
    "relative": relative_task,
    "centre of mass": com_task,
    "joint velocity": velocity_task,
    "low acceleration": slow_task,
    "damping": lambda at, rng: pink.tasks.DampingTask(cost=0.4),
    "coupling": lambda at, rng: pink.tasks.JointCouplingTask(
        ["panda_joint2", "panda_joint4"], [1.0, -0.5], cost=2.0, configuration=at
    ),
    "holonomic": lambda at, rng: pink.tasks.LinearHolonomicTask(
        rng.normal(size=(2, 7)), rng.normal(size=2), at.q.copy(), cost=[1.0, 0.2]
    ),
    "manipulability": lambda at, rng: pink.tasks.ManipulabilityTask("panda_hand_tcp", at.model, cost=0.5),
}


@pytest.mark.parametrize("make", TASKS.values(), ids=TASKS)
def test_a_task_of_pink_gives_the_step_of_pink(panda, make) -> None:
    rng = np.random.default_rng(3)
    for _ in range(3):
        q = panda.home + rng.normal(scale=0.1, size=7)
        configuration = pink.Configuration(panda.model, panda.model.createData(), q)
        task, posture = make(configuration, rng), pink.tasks.PostureTask(cost=0.2)
        posture.set_target(panda.home)
        problem = pink.build_ik(configuration, [task, posture], DT, damping=0.0, limits=[])
        theirs = -np.linalg.solve(problem.P, problem.q) / DT
        ours = step(panda, from_pink(task) + from_pink(posture), q)
        assert np.abs(ours - theirs).max() <= 1e-8 * max(1.0, np.abs(theirs).max())


@pytest.mark.parametrize("kind", ["RollingTask", "OmniwheelTask"])
def test_a_wheel_of_pink_on_a_floating_base(humanoid, kind) -> None:
    rng = np.random.default_rng(4)
    q = pin.integrate(humanoid.model, humanoid.home, rng.normal(scale=0.1, size=humanoid.nv))
    configuration = pink.Configuration(humanoid.model, humanoid.model.createData(), q)
    task = getattr(pink.tasks, kind)("left_ankle_roll_link", "universe", wheel_radius=0.05, cost=1.0, gain=0.1)
    posture, still = pink.tasks.PostureTask(cost=0.2, gain=0.5), pink.tasks.FrameTask("pelvis", 1.0, 1.0)
    posture.set_target(humanoid.home)
    still.set_target(configuration.get_transform_frame_to_world("pelvis"))
    parts = [task, posture, still]
    problem = pink.build_ik(configuration, parts, DT, damping=0.0, limits=[])
    theirs = -np.linalg.solve(problem.P, problem.q) / DT
    ours = step(humanoid, from_pink(task) + from_pink(posture) + from_pink(still), q)
    assert np.abs(ours - theirs).max() <= 1e-8 * np.abs(theirs).max()


def bounded(problem):
    """The exact answer of a problem of Pink or mink, by the level of its constraints above that of its cost."""
    from hqp import Hierarchy, Level, solve

    root = np.linalg.cholesky(problem.P).T
    constraints = Level(problem.G, np.full(len(problem.h), -np.inf), problem.h)
    solution = solve(Hierarchy([constraints, Level.equality(root, -np.linalg.solve(root.T, problem.q))]))
    assert solution.certify().ok
    return solution.x


BARRIERS = {
    "position": lambda: pink.barriers.PositionBarrier("panda_hand_tcp", p_max=np.array([0.31, 0.0, 0.6]), gain=100.0),
    "sphere": lambda: pink.barriers.BodySphericalBarrier(
        ("panda_hand", "panda_link0"), d_min=0.6, gain=1.0, safe_displacement_gain=0.0
    ),
    "velocity": lambda: None,
    "acceleration": lambda: None,
}


@pytest.mark.parametrize("kind", BARRIERS)
def test_barriers_and_limits_of_pink_bound_the_step_as_there(panda, kind) -> None:
    q = panda.home.copy()
    configuration = pink.Configuration(panda.model, panda.model.createData(), q)
    hand, posture = pink.tasks.FrameTask("panda_hand_tcp", 1.0, 0.1), pink.tasks.PostureTask(cost=0.2)
    at = configuration.get_transform_frame_to_world("panda_hand_tcp")
    hand.set_target(pin.SE3(at.rotation, at.translation + np.array([0.3, 0.2, -0.3])))
    posture.set_target(q)
    barrier, limits = BARRIERS[kind](), []
    if kind == "velocity":
        limits = [pink.limits.VelocityLimit(panda.model)]
    if kind == "acceleration":
        limits = [pink.limits.AccelerationLimit(panda.model, np.full(7, 5.0))]
        limits[0].set_last_integration(np.full(7, 0.1), DT)
    problem = pink.build_ik(
        configuration, [hand, posture], DT, damping=0.0, limits=limits, barriers=[barrier] if barrier else []
    )
    given = from_pink(barrier or limits[0])
    stack = given >> from_pink(hand) + from_pink(posture)
    ours, theirs = step(panda, stack, q), bounded(problem) / DT
    assert given.is_limit
    assert np.abs(ours - theirs).max() <= 1e-8 * max(1.0, np.abs(theirs).max())
    free = step(panda, from_pink(hand) + from_pink(posture), q)
    assert np.abs(ours - free).max() > 1e-3  # it bounds


def test_a_cost_of_a_barrier_has_a_level_of_its_own(panda) -> None:
    """Its constraints above all, its cost below: what one QP mixes."""
    barrier = pink.barriers.BodySphericalBarrier(("panda_hand", "panda_link0"), d_min=0.2, safe_displacement_gain=3.0)
    with pytest.raises(InvalidInput, match="take them apart"):
        from_pink(barrier)
    stack = from_pink(barrier, half="bounds") >> PostureTask([0.1] * 7, gain=1.0, weight=0.1) + from_pink(
        barrier, half="cost"
    )
    q = panda.home
    configuration = pink.Configuration(panda.model, panda.model.createData(), q)
    H, c = barrier.compute_qp_objective(configuration)
    target = np.full(7, 0.1) - q
    expected = np.linalg.solve(0.01 * np.eye(7) + H, 0.01 * target - c / DT)
    assert np.abs(step(panda, stack, q) - expected).max() < 1e-8


def test_what_is_set_on_an_object_counts_at_the_next_tick(panda) -> None:
    rng, q = np.random.default_rng(5), panda.home
    configuration = pink.Configuration(panda.model, panda.model.createData(), q)
    task = frame_task(configuration, rng)
    controller = Controller(panda, from_pink(task) >> PostureTask(q, gain=1.0), dt=DT, damping=None)
    first = controller(q).v
    task.gain = 0.5
    assert np.abs(controller(q).v - 0.5 * first).max() < 1e-9 * np.abs(first).max()
    task.set_target(configuration.get_transform_frame_to_world("panda_hand_tcp"))
    assert np.abs(controller(q).v).max() < 1e-12


def test_under_strict_priorities_and_explained(panda) -> None:
    """The hand of Pink above a posture of ours: the posture moves it by nothing, which in one QP it does."""
    rng, q = np.random.default_rng(6), panda.home
    configuration = pink.Configuration(panda.model, panda.model.createData(), q)
    task = frame_task(configuration, rng, gain=0.05)
    controller = Controller(panda, from_pink(task, name="hand") >> PostureTask(q + 1.0, gain=2.0), dt=DT, damping=None)
    solution = controller(q).solution
    J, e = task.compute_jacobian(configuration), task.compute_error(configuration)
    assert np.abs(J @ solution.x + 0.05 * e / DT).max() < 1e-9
    assert "hand" in str(solution.explain())
    assert "Python" in str(controller.describe())


def test_a_configuration_with_a_collision_model(panda) -> None:
    geometry = pin.GeometryModel()
    for name, x in ("a", 0.0), ("b", 0.15):
        link = panda.model.getFrameId("panda_hand" if name == "a" else "panda_link4")
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        parent = panda.model.frames[link].parentJoint
        geometry.addGeometryObject(pin.GeometryObject(name, parent, link, place, pin.hppfcl.Sphere(0.05)))
    geometry.addCollisionPair(pin.CollisionPair(0, 1))
    q = panda.home
    configuration = pink.Configuration(
        panda.model, panda.model.createData(), q, collision_model=geometry, collision_data=geometry.createData()
    )
    barrier = pink.barriers.SelfCollisionBarrier(1, gain=20.0, safe_displacement_gain=0.0, d_min=0.4)
    v = step(panda, from_pink(barrier, configuration) >> PostureTask(q + 0.5, gain=5.0), q)
    G, h = barrier.compute_qp_inequalities(configuration, DT)
    assert (G @ v * DT - h).max() < 1e-9


def test_refusals_of_pink(panda) -> None:
    with pytest.raises(InvalidInput, match="this is a PostureTask"):
        from_pink(PostureTask(panda.home, gain=1.0))
    with pytest.raises(InvalidInput, match="only a barrier has two halves"):
        from_pink(pink.tasks.DampingTask(cost=1.0), half="cost")
    hand = from_pink(pink.tasks.FrameTask("panda_hand_tcp", 1.0, 1.0))
    with pytest.raises(InvalidInput, match="FrameTask"):  # no target
        Controller(panda, hand, dt=DT)
    with pytest.raises(InvalidInput, match="velocity order"):
        Controller(panda, from_pink(pink.tasks.DampingTask(cost=1.0)), order="acceleration", dt=DT)


# mink


@pytest.fixture(scope="module", params=["", "<freejoint/>"], ids=["fixed", "floating"])
def twin(request):
    """A robot, and the model of mink that it was read from."""
    model = mujoco.MjModel.from_xml_string(SCENE.format(free=request.param))
    return load_robot(model), model


def drawn(robot, model, rng):
    """A configuration of the robot, and of mink."""
    q = pin.integrate(robot.model, pin.neutral(robot.model), rng.normal(scale=0.5, size=robot.nv))
    slide = robot.model.joints[robot.model.getJointId("slide")].idx_q
    q[slide] = 0.05
    return q, mink.Configuration(model)


def of_frame(configuration, rng, task, **options):
    task = task("tip", "site", position_cost=[1.0, 0.5, 2.0], orientation_cost=0.3, **options)
    task.set_target(configuration.get_transform_frame_to_world("tip", "site") @ mink.SE3.exp(0.1 * rng.normal(size=6)))
    return task


def of_relative(configuration, rng):
    task = mink.RelativeFrameTask("tip", "site", "upper", "body", position_cost=1.0, orientation_cost=0.5)
    task.set_target_from_configuration(configuration)
    return task


def of_energy(configuration, rng):
    task = mink.KineticEnergyRegularizationTask(cost=0.3)
    task.set_dt(DT)
    return task


def of_com(configuration, rng):
    task = mink.ComTask(cost=2.0)
    task.set_target(configuration.data.subtree_com[1] + [0.01, 0.0, 0.02])
    return task


MINK = {
    "frame": lambda at, rng: of_frame(at, rng, mink.FrameTask),
    "frame, slow": lambda at, rng: of_frame(at, rng, mink.FrameTask, gain=0.1),
    "frame, damped": lambda at, rng: of_frame(at, rng, mink.FrameTask, lm_damping=0.5),
    "relative": of_relative,
    "centre of mass": of_com,
    "damping": lambda at, rng: mink.DampingTask(at.model, cost=0.4),
    "freezing": lambda at, rng: mink.DofFreezingTask(at.model, dof_indices=[at.model.joint("elbow").dofadr[0]]),
    "energy": of_energy,
}


@pytest.mark.parametrize("make", MINK.values(), ids=MINK)
def test_a_task_of_mink_gives_the_step_of_mink(twin, make) -> None:
    robot, model = twin
    rng = np.random.default_rng(7)
    for _ in range(3):
        q, configuration = drawn(robot, model, rng)
        joints = MujocoJoints(robot, model, "test")
        configuration.update(joints.qpos(q, model.qpos0))
        task = make(configuration, rng)
        problem = mink.build_ik(configuration, [task], DT, damping=0.04, limits=[])
        theirs = -np.linalg.solve(problem.P, problem.q) / DT
        ours = joints.velocities(q) @ step(robot, from_mink(task, configuration) + Damping(0.2), q)
        assert np.abs(ours - theirs).max() <= 1e-8 * max(1.0, np.abs(theirs).max())


@pytest.mark.parametrize("kind", ["collision", "velocity", "configuration"])
def test_limits_of_mink_bound_the_step_as_there(twin, kind) -> None:
    robot, model = twin
    q, configuration = drawn(robot, model, np.random.default_rng(8))
    joints = MujocoJoints(robot, model, "test")
    configuration.update(joints.qpos(q, model.qpos0))
    task = mink.FrameTask("tip", "site", position_cost=1.0, orientation_cost=0.1)
    here = configuration.get_transform_frame_to_world("tip", "site")
    trunk = configuration.get_transform_frame_to_world("base", "body").translation()
    task.set_target(mink.SE3.from_rotation_and_translation(here.rotation(), trunk))  # into the trunk
    limit = {
        "collision": lambda: mink.CollisionAvoidanceLimit(model, [(["hand", "lower"], ["trunk"])], gain=0.1),
        "velocity": lambda: mink.VelocityLimit(model, {"elbow": 0.5, "slide": 0.1}),
        "configuration": lambda: mink.ConfigurationLimit(model),
    }[kind]()
    problem = mink.build_ik(configuration, [task], DT, damping=0.04, limits=[limit])
    finite = np.isfinite(problem.h)
    problem.G, problem.h = problem.G[finite], problem.h[finite]
    stack = from_mink(limit, configuration) >> from_mink(task, configuration) + Damping(0.2)
    ours, theirs = joints.velocities(q) @ step(robot, stack, q), bounded(problem) / DT
    assert np.abs(ours - theirs).max() <= 1e-8 * max(1.0, np.abs(theirs).max())


def test_refusals_of_mink(twin, panda) -> None:
    robot, model = twin
    configuration = mink.Configuration(model)
    damping = mink.DampingTask(model, cost=1.0)
    with pytest.raises(InvalidInput, match=r"must be a mink\.Configuration"):
        from_mink(damping, model)
    with pytest.raises(InvalidInput, match="this is a str"):
        from_mink("hand", configuration)
    with pytest.raises(InvalidInput, match="'panda_joint1' is not in mink's model"):
        Controller(panda, from_mink(damping, configuration), dt=DT)
    with pytest.raises(InvalidInput, match="FrameTask"):  # no target
        Controller(robot, from_mink(mink.FrameTask("tip", "site", 1.0, 1.0), configuration), dt=DT)


# What is wrong with an object of another library is told in words, at once


class Own(pink.tasks.Task):
    """A task with any rows."""

    def __init__(self, J, e) -> None:
        super().__init__(cost=1.0)
        self.J, self.e = J, e

    def compute_error(self, configuration):
        return self.e

    def compute_jacobian(self, configuration):
        return self.J

    def __repr__(self) -> str:
        return "Own"


WRONG = {
    "columns": (Own(np.ones((2, 3)), np.ones(2)), r"shapes \(2, 3\) and \(2,\)"),
    "rows": (Own(np.ones((4, 7)), np.ones(5)), "Own 'own' raised ValueError"),
    "a column of errors": (Own(np.ones((7, 7)), np.ones((7, 1))), "they must be"),
    "nothing": (Own(None, None), "Own 'own' raised TypeError"),
    "not a number": (Own(np.ones((2, 7)), np.array([0.0, np.nan])), "row 1 is not finite"),
    "no number in the matrix": (Own(np.full((2, 7), np.inf), np.ones(2)), "row 0 is not finite"),
}


@pytest.mark.parametrize(("task", "told"), WRONG.values(), ids=WRONG)
def test_rows_that_are_none_are_refused_in_words(panda, task, told) -> None:
    with pytest.raises(InvalidInput, match=told):
        Controller(panda, from_pink(task) >> PostureTask(panda.home, gain=1.0), dt=DT)(panda.home)


def test_what_is_set_wrong_later_is_refused_and_the_controller_goes_on(panda) -> None:
    task = pink.tasks.PostureTask(cost=1.0)
    task.set_target(panda.home + 0.1)
    controller = Controller(panda, from_pink(task), dt=DT, damping=None)
    before = controller(panda.home).v.copy()
    for name, wrong in ("target_q", np.zeros(3)), ("cost", np.ones(3)), ("gain", np.nan), ("gain", "fast"):
        kept = getattr(task, name)
        setattr(task, name, wrong)
        with pytest.raises(InvalidInput, match="PostureTask"):
            controller(panda.home)
        setattr(task, name, kept)
        assert np.array_equal(controller(panda.home).v, before)


def test_a_new_controller_takes_the_rows_that_an_object_has_now(panda) -> None:
    """The refusal asks for a new one, and it works; and so does another robot with more joints."""
    task = pink.tasks.PostureTask(cost=1.0)
    task.set_target(panda.home + 0.1)
    part = from_pink(task)
    controller = Controller(panda, part, dt=DT, damping=None)
    task.lm_damping = 1.0
    with pytest.raises(InvalidInput, match="make a new one"):
        controller(panda.home)
    assert np.array_equal(step(panda, part, panda.home), step(panda, from_pink(task), panda.home))
    other, still = load_robot("ur5"), from_pink(pink.tasks.DampingTask(cost=1.0))
    for robot in other, panda:
        assert len(Controller(robot, still, dt=DT).hierarchy.levels[0].lower) == robot.nv


def test_a_configuration_of_other_joints_is_refused() -> None:
    """Of as many, in another order: Pink would move one joint for another."""

    def model(names):
        found, parent = pin.Model(), 0
        for name in names:
            place = pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.0]))
            parent = found.addJoint(parent, pin.JointModelRZ(), place, name)
        return found

    robot, other = PinocchioRobot(model("abc")), model("acb")
    configuration = pink.Configuration(other, other.createData(), np.zeros(3))
    with pytest.raises(InvalidInput, match="has joint 'c' where the robot has 'b'"):
        Controller(robot, from_pink(pink.tasks.DampingTask(cost=1.0), configuration), dt=DT)
    for made in other, robot.model:
        made.upperPositionLimit[:], made.lowerPositionLimit[:] = [1.0, 2.0, 3.0], [-1.0, -2.0, -3.0]
    with pytest.raises(InvalidInput, match="its model has joint 'c' where the robot has 'b'"):
        Controller(robot, from_pink(pink.limits.ConfigurationLimit(other)), dt=DT)
    Controller(robot, from_pink(pink.limits.ConfigurationLimit(robot.model)), dt=DT)(np.zeros(3))


def test_limits_of_another_model_and_names_that_are_none(panda, twin) -> None:
    robot, model = twin
    other = mujoco.MjModel.from_xml_string(SCENE.format(free="").replace('<joint name="turn" axis="1 0 0"/>', ""))
    with pytest.raises(InvalidInput, match="of the model that it was made of is"):
        Controller(robot, from_mink(mink.ConfigurationLimit(other), mink.Configuration(model)), dt=DT)
    with pytest.raises(InvalidInput, match="must be a str"):
        from_pink(pink.tasks.DampingTask(cost=1.0), name=3)


TWO = """<mujoco><worldbody><body><joint name="{}" axis="0 0 1" range="-1 1"/><geom size=".1"/>
<body pos=".3 0 0"><joint name="{}" axis="0 0 1" range="-2 2"/><geom size=".1"/></body></body></worldbody></mujoco>"""


def test_limits_of_a_model_with_its_joints_in_another_order_are_refused_by_name() -> None:
    mujoco = pytest.importorskip("mujoco")
    model, other = (mujoco.MjModel.from_xml_string(TWO.format(*names)) for names in ("ab", "ba"))
    robot, configuration = load_robot(model, velocity_limit=1.0), mink.Configuration(model)
    for made in model, mujoco.MjModel.from_xml_string(TWO.format("a", "b")):
        Controller(robot, from_mink(mink.ConfigurationLimit(made), configuration), dt=DT)(robot.home)
    with pytest.raises(InvalidInput, match="joint 0 of the model that it was made of is 'b', of the configuration 'a'"):
        Controller(robot, from_mink(mink.ConfigurationLimit(other), configuration), dt=DT)(robot.home)
