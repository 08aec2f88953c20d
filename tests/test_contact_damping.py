"""Damped levels where contact forces are unknowns: at rest damping costs nothing, as forces bear the robot."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from contact_scenes import DT, Scene, advanced, humanoid, moved, quadruped

from tasks import (
    CenterOfMassTask,
    Contact,
    Controller,
    Damped,
    Damping,
    Dynamics,
    PositionTask,
    PostureTask,
    Stack,
    SupportLimit,
    Surface,
    from_rpy,
    load_robot,
)
from tasks.contacts.kernels import layout

HAND = "right_rubber_hand"


def controller_of(scene: Scene, level: Damped | CenterOfMassTask | PositionTask) -> Controller:
    return Controller(scene.robot, scene.limits >> level >> scene.rest(), order="torque", dt=DT)


@pytest.mark.parametrize("damping", [0.01, 0.03])
def test_a_damped_level_in_reach_is_met_at_rest(damping: float) -> None:
    scene = humanoid()
    level = CenterOfMassTask(scene.com + np.array([0.0, 0.02, -0.01]), gain=5.0)
    controller, q, v = controller_of(scene, Damped(level, damping)), scene.q, scene.v
    for k in range(1500):
        step = controller(q, v, DT * k)
        q, v = advanced(scene.robot, q, v, step.a)
    assert step.solution.certify().ok
    off = level.target(0.0)[0] - scene.robot.at(q, v).center_of_mass.position
    assert np.linalg.norm(off) < 1e-4
    assert np.abs(v).max() < 1e-2


def test_a_damped_hand_lets_the_robot_stand() -> None:
    scene = humanoid()
    start = scene.robot.at(scene.q, scene.v).frame(HAND).position
    hand = PositionTask(start + np.array([0.1, 0.0, 0.1]), frame=HAND, gain=3.0)
    stack = scene.limits >> SupportLimit(0.02) >> Damped(hand, 0.3) >> scene.rest()
    controller, q, v = Controller(scene.robot, stack, order="torque", dt=DT), scene.q, scene.v
    for k in range(1000):
        step = controller(q, v, DT * k)
        q, v = advanced(scene.robot, q, v, step.a)
    borne = sum(force[:, 2].sum() for force in step.forces.values())
    weight = 9.81 * scene.robot.mass_matrix(scene.q)[0, 0]
    assert borne == pytest.approx(weight, rel=0.05)
    assert (
        scene.robot.at(q, v).frame("pelvis").position[2] > 0.9 * scene.robot.at(scene.q, v).frame("pelvis").position[2]
    )


def scene_of(name: str) -> tuple[Scene, Stack]:
    """A robot that stands, and its limits."""
    if name == "wrenches":
        scene = humanoid(rectangle=True, wrench=True)
    elif name == "tilted":
        tilted = from_rpy(0.05, 0.1, 0.0)
        scene = humanoid(surface=Surface(np.zeros(3), tilted))
    else:
        scene = humanoid()
    return scene, scene.limits >> SupportLimit(0.02) if name == "support" else scene.limits


def controller_in(name: str, damping: float = 0.1) -> tuple[Scene, Controller]:
    scene, limits = scene_of(name)
    level = Damped(CenterOfMassTask(scene.com + np.array([0.0, 0.02, -0.01]), gain=5.0), damping)
    return scene, Controller(scene.robot, limits >> level >> scene.rest(), order="torque", dt=DT)


def bearing(controller: Controller) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The forces that damped levels are pulled towards, the map G of the base, and its bias."""
    nv, shared = controller.robot.nv, controller._rows.shared
    (aim,) = controller.aims.values()
    return aim[nv:], shared.wrenches[:, :6], shared.blocks.bias()[:6]


SCENES = "points", "wrenches", "tilted", "support"


def check_least(f: np.ndarray, G: np.ndarray, b: np.ndarray, shares: np.ndarray) -> None:
    """f at points are the least that bear b and push: f = shares G y, but 0 for normal forces where G y is negative."""
    normal = np.arange(len(f)) % 3 == 2
    np.testing.assert_allclose(G.T @ f, b, rtol=0.0, atol=1e-6)
    assert (f[normal] >= 0.0).all()
    free = (shares > 0.0) & ~(normal & (f == 0.0))
    y = np.linalg.lstsq(G[free], f[free] / shares[free], rcond=None)[0]
    np.testing.assert_allclose((shares * (G @ y))[free], f[free], rtol=0.0, atol=1e-5)
    assert (shares * (G @ y))[~free & normal].max(initial=0.0) < 1e-5


@pytest.mark.parametrize("name", SCENES)
def test_forces_are_pulled_to_the_least_ones_that_bear_the_robot_at_rest(name: str) -> None:
    scene, controller = controller_in(name)
    for seed in range(3):
        controller.settle()
        controller(*moved(scene, seed, 0.3))
        f, G, b = bearing(controller)
        if name == "wrenches":
            np.testing.assert_allclose(G.T @ f, b, rtol=0.0, atol=1e-6)
        else:
            check_least(f, G, b, np.ones(len(f)))


def test_a_wrench_bears_what_the_corners_of_its_rectangle_do() -> None:
    wrenches, corners = [], []
    for wrench, kept in ((True, wrenches), (False, corners)):
        scene = humanoid(rectangle=True, wrench=wrench)
        level = Damped(CenterOfMassTask(scene.com, gain=5.0), 0.1)
        controller = controller_of(scene, level)
        for seed in range(3):
            controller(scene.q, moved(scene, seed)[1])  # with both soles flat on the ground
            f, G, _ = bearing(controller)
            half = len(f) // 2
            kept.append([G[:half].T @ f[:half], G[half:].T @ f[half:]])
    np.testing.assert_allclose(wrenches, corners, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("name", SCENES)
def test_an_old_controller_a_fresh_one_and_a_copy_answer_alike(name: str) -> None:
    scene, old = controller_in(name)
    q, v = scene.q, scene.v
    for k in range(30):
        step = old(q, v, DT * k)
        q, v = advanced(scene.robot, q, v, step.a)
    copied, (_, fresh) = copy.deepcopy(old), controller_in(name)
    fresh(scene.q, scene.v)  # where its contacts are held
    there, t = moved(scene, 1, 0.2), 0.06
    expected = old(*there, t)
    for other in old, copied, fresh:
        step = other(*there, t)
        np.testing.assert_allclose(step.a, expected.a, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(step.tau, expected.tau, rtol=0.0, atol=1e-6)


def test_a_contact_bears_by_the_share_of_its_ramp() -> None:
    scene, controller = controller_in("points")
    right, half = scene.feet[1], 12
    there = scene.q, scene.v

    def borne(t: float) -> np.ndarray:
        controller(*there, t)
        f, G, b = bearing(controller)
        share = right.slot(controller._rows.shared).numbers[layout.SHARE]
        if share > 0.5:  # with less no forces bear it
            check_least(f, G, b, np.repeat([1.0, share], half))
        return f.copy()

    both = borne(0.0)
    controller.release("right", duration=0.1)
    loads = [np.abs(borne(0.02 * k)[half:]).sum() for k in range(6)]
    assert loads[0] == pytest.approx(np.abs(both[half:]).sum())
    assert (np.diff(loads) < 0.0).all()
    assert loads[-1] == 0.0
    controller(*there, 0.3)
    controller.release("left")
    controller(*there, 0.4)
    assert not bearing(controller)[0].any()  # in the air
    controller.make("left")
    controller.make("right", duration=0.1)
    loads = [np.abs(borne(1.0 + 0.02 * k)[half:]).sum() for k in range(6)]
    assert loads[0] == 0.0
    np.testing.assert_allclose(borne(1.2), both, rtol=0.0, atol=1e-6)


def test_where_nothing_bears_the_robot_forces_stay_bounded() -> None:
    scene, controller = controller_in("points")
    for seed in range(10):
        q, v = moved(scene, seed, 4.0)
        controller.settle()
        controller(q, 5.0 * v)
        f, _, b = bearing(controller)
        points = f.reshape(-1, 3)
        assert (points[:, 2] >= 0.0).all()
        assert (points[:, 2] <= np.linalg.norm(b[:3]) * (1.0 + 1e-9)).all()
        assert (np.linalg.norm(points[:, :2], axis=1) <= points[:, 2] + 1e-9).all()


def test_on_two_points_forces_are_least_squares() -> None:
    scene = quadruped()
    level = Damped(CenterOfMassTask(scene.com, gain=5.0), 0.1)
    controller = Controller(scene.robot, scene.limits >> level >> scene.rest("base"), order="torque", dt=DT)
    controller(scene.q, scene.v)
    controller.release(scene.feet[0])
    controller.release(scene.feet[3])
    controller(scene.q, scene.v, DT)
    f, G, b = bearing(controller)
    on = np.repeat([False, True, True, False], 3)
    assert not f[~on].any()
    expected = np.linalg.lstsq(G[on].T, b, rcond=1e-9)[0]
    np.testing.assert_allclose(f[on], expected, rtol=0.0, atol=1e-4)


def test_a_biped_stands_on_one_foot_on_a_damped_level() -> None:
    scene = humanoid()
    ankle = scene.robot.at(scene.q, scene.v).frame("left_ankle_roll_link").position
    goal = np.array([scene.com[0], ankle[1], scene.com[2]])
    task = CenterOfMassTask(goal, gain=4.0)
    controller, q, v = controller_of(scene, Damped(task, 0.03)), scene.q, scene.v
    for k in range(1900):
        if k == 700:
            controller.release("right", duration=0.2)
        step = controller(q, v, DT * k)
        q, v = advanced(scene.robot, q, v, step.a)
    assert controller.loaded == ("left",)
    assert np.linalg.norm(scene.robot.at(q, v).center_of_mass.position - goal) < 1e-3


@pytest.mark.parametrize("damping", [0.03, 0.1])
@pytest.mark.parametrize("way", [(0.05, 0.08, -0.01), (0.0, 0.11, -0.01)])
def test_near_the_edge_of_the_support_a_damped_level_is_met(way: tuple[float, float, float], damping: float) -> None:
    scene = humanoid()
    goal = scene.com + np.array(way)
    level = Damped(CenterOfMassTask(goal, gain=5.0), damping)
    stack = scene.limits >> SupportLimit(0.002) >> level >> scene.rest()
    controller, q, v = Controller(scene.robot, stack, order="torque", dt=DT), scene.q, scene.v
    for k in range(2000):
        step = controller(q, v, DT * k)
        q, v = advanced(scene.robot, q, v, step.a)
    off = scene.robot.at(q, v).center_of_mass.position - goal
    assert np.linalg.norm(off) < (1e-4 if damping < 0.1 else 1e-2)


def test_without_a_floating_base_forces_are_pulled_to_none() -> None:
    robot = load_robot("panda", acceleration_limit=50.0)
    hand = robot.at(robot.home, np.zeros(robot.nv)).frame("panda_hand").position
    contact = Contact("panda_hand", friction=0.6, unilateral=False)
    stack = Dynamics() + contact >> Damped(PositionTask(hand, frame="panda_hand", gain=3.0), 0.1)
    controller = Controller(robot, stack, order="torque", dt=DT)
    controller(robot.home, np.zeros(robot.nv))
    (aim,) = controller.aims.values()
    assert not aim.any()


def test_who_is_left_strict_says_so() -> None:
    scene = humanoid()
    level = CenterOfMassTask(scene.com, gain=5.0)
    assert "strict, as forces are unknowns" in repr(controller_of(scene, level))
    assert "strict" not in repr(controller_of(scene, Damped(level, 0.1)))
    hand = PositionTask([0.2, -0.1, 0.8], frame=HAND, gain=3.0)
    assert "strict" not in repr(Controller(scene.robot, hand, dt=DT))
    beside = scene.limits >> hand + PostureTask(scene.q, gain=4.0, weight=0.1) + Damping(0.1)
    assert "strict" not in repr(Controller(scene.robot, beside, order="torque", dt=DT))
    asked = Controller(scene.robot, scene.limits >> level, order="torque", dt=DT, damping=None)
    assert "damping=None" in repr(asked)
    assert "strict" not in repr(asked)
