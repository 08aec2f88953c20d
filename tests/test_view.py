"""A controller by hand, without a browser: levels moved and switched, targets dragged, gains set, motions recorded."""

from __future__ import annotations

import _thread
import sys
import threading
from types import SimpleNamespace
from urllib.parse import urlparse
from urllib.request import urlopen

import numpy as np
import pinocchio as pin
import pytest
from contact_scenes import humanoid
from interrupts import heard

import tasks
from hqp import FixedDamping, InvalidInput, MissingPackage
from tasks import (
    AxisTask,
    CenterOfMassTask,
    Controller,
    Damped,
    ForceTask,
    JointLimits,
    JointVelocityLimit,
    LookAtTask,
    OrientationTask,
    PinocchioRobot,
    PlanarArm,
    PoseTask,
    PositionTask,
    PostureTask,
    Record,
    Setpoint,
    Turn,
    Within,
    from_rpy,
    link_capsules,
    load_robot,
)
from tasks.cli import run
from tasks.drawing import stage
from tasks.drawing.meshes import CELLS, MOST_TRIANGLES, _thinned, meshes_of
from tasks.view.live import Window
from tasks.view.panel import UP
from tasks.view.session import CHANGE, Session
from tasks.view.stacks import BRAKES, ready_controller, ready_stack
from tasks.view.targets import targets_of
from tasks.view.words import BAD, joints

ARM = PlanarArm([0.5, 0.4, 0.3])
Q = np.array([0.3, 0.5, -0.4])
#: A page that has set a value, as viser tells it; and this program.
PAGE, OURSELVES = SimpleNamespace(client=object()), SimpleNamespace(client=None)


def stack():
    return (
        JointVelocityLimit(2.0)
        >> PositionTask([0.2, 0.7], gain=3.0)
        >> OrientationTask(1.0, gain=1.0)
        >> PostureTask(Q, gain=1.0)
    )


def session(**options) -> Session:
    """Past its first tick, which loads loops and what judges an answer, and may take longer than a clock waits."""
    live = Session(Controller(ARM, stack(), dt=0.01), Q, **options)
    live.motion.tick()
    live.reset()
    return live


@pytest.fixture
def unhurried(monkeypatch):
    """No tick takes time, however busy the machine is."""
    monkeypatch.setattr("tasks.view.session.perf_counter", lambda: 0.0)


@pytest.fixture(scope="module")
def ur5():
    return load_robot("ur5")


@pytest.fixture
def window(ur5, tmp_path):
    pytest.importorskip("viser")
    own = Window(Session(ready_controller(ur5, 0.01)), port=8500, folder=tmp_path)
    yield own
    own.close()


# Priorities.


def test_levels_are_moved_and_the_controller_follows_within_the_time_of_a_change(unhurried):
    live = session()
    for _ in range(5):
        live.motion.tick()
    live.move_level(2, -1)
    assert [level[0].name for level in live.controller.stack.levels] == live.priorities.names
    live.motion.tick()
    assert live.motion.step.share < 1.0
    for _ in range(round(CHANGE / 0.01) + 2):
        live.motion.tick()
    assert live.motion.step.share == 1.0
    q, v = live.motion.q, live.motion.v
    live.motion.tick()
    moved = Controller(ARM, live.controller.stack, dt=0.01)
    assert [task.name for task, *_ in moved.stack.levels[1:3]] == ["orientation", "position"]
    assert np.allclose(live.motion.step.v, moved(q, v).v, atol=1e-9)


def test_a_level_is_switched_off_and_on_and_finds_its_rows_again():
    live = session()
    begun = live.controller.stack
    live.switch_level(1, False)
    assert len(live.controller.stack) == 3
    assert live.priorities.on == [True, False, True, True]
    live.switch_level(1, True)
    assert live.controller.stack is begun


def test_the_last_level_stays_on_and_places_exist():
    live = Session(Controller(ARM, PositionTask([0.2, 0.7], gain=3.0), dt=0.01), Q)
    with pytest.raises(InvalidInput, match="last level"):
        live.switch_level(0, False)
    with pytest.raises(InvalidInput, match=r"no level 1; it must be 0 \.\. 0"):
        live.move_level(0, 1)
    assert live.priorities.on == [True]


def test_an_order_that_a_controller_refuses_is_taken_back(monkeypatch):
    live = session()

    def refuse(*_, **__):
        raise InvalidInput("no")

    monkeypatch.setattr(Controller, "change", refuse)
    before = live.priorities.names
    with pytest.raises(InvalidInput, match="no"):
        live.move_level(1, 1)
    assert live.priorities.names == before


def test_damping_goes_with_its_level():
    rule = FixedDamping(0.1)
    live = Session(
        Controller(
            ARM,
            JointVelocityLimit(2.0)
            >> Damped(PositionTask([0.2, 0.7], gain=3.0), rule)
            >> OrientationTask(1.0, gain=1.0),
            dt=0.01,
        ),
        Q,
    )
    live.move_level(1, 1)
    assert live.controller.stack.damping == (None, None, rule)


# Time.


def test_the_clock_decides_how_many_ticks_are_due(unhurried):
    live = session()
    assert live.advance(0.055) == 5
    assert live.motion.t == pytest.approx(0.05)
    live.speed = 2.0
    assert live.advance(0.0101) in (2, 3)
    live.pause()
    assert live.advance(1.0) == 0
    live.step()
    assert not live.running
    before = live.motion.ticks
    live.reset()
    assert (before > 0, live.motion.ticks, live.motion.t) == (True, 0, 0.0)
    np.testing.assert_array_equal(live.q, Q)


def test_time_that_was_lost_does_not_pile_up():
    live = session()
    assert live.advance(1000.0) <= 11


def test_a_reset_in_the_middle_of_a_change_goes_on():
    live = session()
    live.advance(0.05)
    live.move_level(1, 1)
    live.advance(0.05)
    live.reset()
    live.motion.tick()
    assert live.motion.step.share == 1.0


def test_a_reset_lets_contacts_hold_where_the_robot_is_put():
    scene = humanoid()
    controller = Controller(scene.robot, scene.limits >> scene.rest(), order="torque", dt=2e-3)
    way = np.zeros(scene.robot.nv)
    way[0] = 0.5
    controller(scene.robot.integrate(scene.q, way), scene.v)
    live = Session(controller, scene.q)
    live.reset()
    live.motion.tick()
    assert abs(live.motion.step.a).max() < 1.0


def test_what_another_thread_wishes_is_done_between_ticks_and_refusals_become_the_message():
    live = session()
    live.do(lambda: live.switch_level(9, True))
    live.do(lambda: setattr(live, "speed", 0.5))
    live.serve()
    assert "no level 9" in live.message
    assert live.speed == 0.5
    with pytest.raises(InvalidInput, match="speed of time"):
        live.speed = 0.0


def test_it_runs_by_the_clock_until_it_is_ended():
    live = session()
    loop = threading.Thread(target=live.run)
    loop.start()
    moved = threading.Event()
    live.do(moved.set)
    assert moved.wait(20.0)
    live.end()
    loop.join(20.0)
    assert not loop.is_alive()


def test_a_fault_stops_the_time_and_is_told(unhurried):
    live = session()
    live.motion.q = np.full(3, np.nan)
    live.advance(0.02)
    assert not live.running
    assert "invalid" in live.message.lower()
    live.reset()
    live.pause(False)
    assert live.advance(0.02) == 2


def test_what_is_needed_is_asked_for_at_once():
    with pytest.raises(InvalidInput, match="give it dt"):
        Session(Controller(ARM, stack()), Q)
    with pytest.raises(InvalidInput, match="shape"):
        Session(Controller(ARM, stack(), dt=0.01), np.zeros(2))


# Gains, and what is told.


def test_gains_are_set_live_and_keep_their_ratios(ur5):
    state = ur5.at(ur5.home, np.zeros(6))
    task = PoseTask.hold(state, gain=[2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
    live = Session(Controller(ur5, JointLimits() >> task, dt=0.01))
    live.set_gain(task, 10.0)
    np.testing.assert_allclose(task.gain, [10, 10, 10, 5, 5, 5])
    with pytest.raises(InvalidInput, match="gain"):
        live.set_gain(task, 1e4)
    np.testing.assert_allclose(task.gain, [10, 10, 10, 5, 5, 5])


def test_every_so_many_ticks_are_put_to_the_certificate_and_explained():
    live = session(certify=5)
    live.priorities.parts[1].target = [2.0, 0.0]  # out of reach
    for _ in range(200):
        live.motion.tick()
    verdict = live.motion.verdict
    assert verdict.certified
    assert verdict.t == pytest.approx(1.95)
    assert [met for _, met, _ in verdict.levels][:2] == [True, False]
    assert "position short by" in verdict.levels[1][2]


def test_samples_are_of_the_last_ten_seconds():
    live = session(certify=0)
    for _ in range(1500):
        live.motion.tick()
    t = [sample.t for sample in live.motion.samples]
    assert t[-1] - t[0] == pytest.approx(10.0, abs=0.1)
    assert set(live.motion.samples[0].residuals) == set(live.priorities.names)


# Targets.


def test_position_and_rotation_of_one_frame_are_one_target_and_move_their_tasks(ur5):
    state = ur5.at(ur5.home, np.zeros(6))
    hand = state.frame()
    position, rotation = PositionTask(hand.position, gain=1.0), OrientationTask(hand.rotation, gain=1.0)
    (target,) = targets_of([position, rotation, PostureTask(ur5.home, gain=1.0)], state)
    R = from_rpy(0.1, 0.2, 0.3)
    target.move([0.4, 0.1, 0.3], R)
    np.testing.assert_allclose(position.target(0.0)[0], [0.4, 0.1, 0.3])
    np.testing.assert_allclose(rotation.target(0.0)[0], R, atol=1e-12)
    assert target.draggable
    assert target.free == (True, True, True)


def test_a_masked_target_moves_along_its_mask(ur5):
    state = ur5.at(ur5.home, np.zeros(6))
    task = Within(CenterOfMassTask(state.center_of_mass.position[:2], mask="xy", gain=1.0), 0.01)
    (target,) = targets_of([task], state)
    height = state.center_of_mass.position[2]
    target.move(np.array([0.1, 0.2, 9.0]))
    np.testing.assert_allclose(target.p, [0.1, 0.2, height])
    np.testing.assert_allclose(task.task.target(0.0)[0], [0.1, 0.2])
    assert target.free == (True, True, False)


def test_poses_setpoints_points_and_directions_are_targets_too(ur5):
    state = ur5.at(ur5.home, np.zeros(6))
    own = Setpoint(state.frame().position)
    pose = PoseTask(own, state.frame().rotation, gain=1.0)
    look, axis = LookAtTask([1.0, 0.0, 0.5], gain=1.0), AxisTask([0.0, 0.0, -2.0], gain=1.0)
    for task, p, R in (pose, np.ones(3), np.eye(3)), (look, np.ones(3), None), (axis, None, np.eye(3)):
        (target,) = targets_of([task], state)
        target.move(p, R)
    np.testing.assert_allclose(own(0.0)[0], np.ones(3))
    np.testing.assert_allclose(pose.rotation(0.0)[0], np.eye(3))
    np.testing.assert_allclose(look.target(0.0)[0], np.ones(3))
    np.testing.assert_allclose(axis.target(0.0)[0], [0.0, 0.0, 1.0])


def test_the_angle_of_a_planar_arm_is_unwrapped():
    task = OrientationTask(3.0, gain=1.0)
    (target,) = targets_of([task], ARM.at(Q, np.zeros(3)))
    target.move(R=from_rpy(0.0, 0.0, -3.1))
    assert task.target(0.0)[0][0] == pytest.approx(2.0 * np.pi - 3.1)


def test_a_target_in_time_goes_its_own_way(ur5):
    state = ur5.at(ur5.home, np.zeros(6))
    (target,) = targets_of([OrientationTask(Turn(np.eye(3), from_rpy(0, 0, 1.0), 2.0), gain=1.0)], state)
    assert not target.draggable
    target.follow(2.0)
    np.testing.assert_allclose(target.R, from_rpy(0, 0, 1.0), atol=1e-12)


def test_what_a_task_refuses_leaves_its_target_where_it_was(ur5):
    state = ur5.at(ur5.home, np.zeros(6))
    (target,) = targets_of([PositionTask(state.frame().position, gain=1.0)], state)
    with pytest.raises(InvalidInput):
        target.move(np.array([np.nan, 0.0, 0.0]))
    np.testing.assert_array_equal(target.p, state.frame().position)


# Recording.


def test_a_recording_is_a_record_with_the_changes_in_it(tmp_path):
    live = session(certify=5)
    live.record()
    for _ in range(20):
        live.motion.tick()
    live.switch_level(1, False)
    for _ in range(20):
        live.motion.tick()
    record = live.save(tmp_path / "run.npz")
    assert (len(record), record.checked, record.certified) == (40, 8, 8)
    np.testing.assert_array_equal(Record.load(tmp_path / "run.npz").q, record.q)
    assert set(record.errors) == {"position", "orientation", "posture"}
    np.testing.assert_allclose(np.diff(record.q, axis=0), 0.01 * record.v[1:], atol=1e-12)


def test_nothing_recorded_is_nothing_to_save(tmp_path):
    with pytest.raises(InvalidInput, match="nothing was recorded"):
        session().save(tmp_path / "run.npz")


# Stacks to begin with.


def test_an_arm_is_led_by_its_tip_and_braked(ur5):
    controller = ready_controller(load_robot("ur5"), 0.01)
    names = [[part.name for part in level] for level in controller.stack.levels]
    assert names == [["joint limits"], ["position"], ["orientation"], ["posture"]]
    assert (controller.robot.acceleration_limit == BRAKES).all()
    assert controller(ur5.home, np.zeros(6)).ok


def test_a_humanoid_stands_on_its_feet_and_is_led_by_its_hands():
    robot = load_robot("g1")
    levels = ready_stack(robot).levels
    assert [[part.name for part in level] for level in levels] == [
        ["joint limits"],
        ["left foot", "right foot"],
        ["center of mass"],
        ["left hand", "right hand"],
        ["posture"],
    ]
    controller = ready_controller(robot, 0.01)
    assert np.isinf(robot.acceleration_limit[:6]).all()
    assert controller(robot.home, np.zeros(robot.nv)).solution.certify().ok


def test_a_quadruped_stands_on_four():
    names = [[part.name for part in level] for level in ready_stack(load_robot("solo12")).levels]
    assert [len(level) for level in names] == [1, 4, 1, 1, 1]
    assert names[3] == ["trunk"]


# The picture, without anybody who looks.


def test_meshes_hang_on_the_joints_that_are_left_when_others_are_locked():
    free, held = load_robot("ur5"), load_robot("ur5", lock=["wrist_3_joint"])
    whole, fewer = free.visuals(), held.visuals()
    assert len(whole.geometryObjects) == len(fewer.geometryObjects)
    for robot, shapes in (free, whole), (held, fewer):
        data, own = robot.model.createData(), shapes.createData()
        pin.updateGeometryPlacements(robot.model, data, shapes, own, robot.neutral)
        places = np.array([T.homogeneous for T in own.oMg])
        if robot is free:
            wanted = places
    np.testing.assert_allclose(places, wanted, atol=1e-12)


GEOMS = """<mujoco><asset><mesh name="wedge" vertex="0 0 0 .2 0 0 0 .1 0 0 0 .1"/>
<material name="red" rgba=".8 .1 .1 1"/></asset><worldbody><geom type="plane" size="1 1 1"/>
<body name="one" pos="0 0 .5" euler="0 30 0"><joint name="a" axis="0 1 0"/>
<geom type="capsule" size=".04" fromto=".05 0 .02 .4 .1 0" rgba="0 0 1 .5"/><geom type="sphere" size=".3" group="3"/>
<geom type="sphere" size=".3" rgba="0 0 0 0"/><body name="two" pos=".4 0 0"><joint name="b" axis="0 0 1"/>
<geom type="box" size=".2 .04 .03" pos=".2 0 0" material="red" contype="0" conaffinity="0"/>
<geom type="mesh" mesh="wedge" pos="0 .1 0"/></body></body></worldbody></mujoco>"""


def test_geoms_of_an_mjcf_are_drawn_as_they_are_and_where_mujoco_has_them():
    pytest.importorskip("trimesh")
    mujoco = pytest.importorskip("mujoco")
    mj = mujoco.MjModel.from_xml_string(GEOMS)
    robot, data = load_robot(mj), mujoco.MjData(mj)
    meshes, note = meshes_of(robot)
    assert note == "drawn by the visual shapes of the file"
    assert [mesh.joint for mesh in meshes] == [1, 2, 2]  # no floor, nothing of group 3, nothing that is not seen
    assert [mesh.color for mesh in meshes] == [
        pytest.approx(color, abs=1e-6) for color in ((0, 0, 1), (0.8, 0.1, 0.1), (0.5, 0.5, 0.5))
    ]
    assert meshes[0].opacity == pytest.approx(0.5)
    data.qpos[:] = 0.4, -0.7
    mujoco.mj_kinematics(mj, data)
    pin.forwardKinematics(robot.model, robot.data, data.qpos)
    seen = []
    for geom, mesh in zip((1, 4, 5), meshes, strict=True):
        place = robot.data.oMi[mesh.joint]
        world = mesh.vertices @ place.rotation.T + place.translation
        seen.append((world - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3))
    radius, half = mj.geom_size[1, :2]
    off = seen[0] - np.clip(seen[0][:, 2:], -half, half) * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(np.linalg.norm(off, axis=1), radius, atol=1e-6)  # it is the capsule, and no other
    assert np.ptp(seen[0][:, 2]) == pytest.approx(2.0 * (half + radius), abs=1e-6)
    np.testing.assert_allclose(np.abs(seen[1]), np.broadcast_to(mj.geom_size[4], seen[1].shape), atol=1e-9)
    np.testing.assert_allclose(seen[2], mj.mesh_vert, atol=1e-6)


def test_bodies_without_a_name_are_drawn_and_collide():
    pytest.importorskip("trimesh")
    mujoco = pytest.importorskip("mujoco")
    ball = '<geom type="sphere" size=".1"/>'
    text = f"""<mujoco><worldbody><body><joint axis="0 1 0"/>{ball}<body pos="0 0 .5" name="body1">
        <joint name="k" axis="0 1 0"/>{ball}<body pos="0 0 .5"><joint axis="0 1 0"/>{ball}</body></body></body>
        </worldbody></mujoco>"""
    robot = load_robot(mujoco.MjModel.from_xml_string(text), velocity_limit=2.0)
    assert [mesh.joint for mesh in meshes_of(robot)[0]] == [1, 2, 3]
    assert [capsule.frame for capsule in link_capsules(robot)] == ["body1_", "body1", "body3"]


def test_an_address_of_another_machine_is_refused_at_once():
    with pytest.raises(InvalidInput, match="no address of this machine"):
        stage.open_stage("192.0.2.1", 8650)


@pytest.mark.parametrize("place", ["0 0 0.3", "0 0 0"])
def test_a_robot_of_one_joint_is_shown_whatever_it_has_to_be_drawn(place, tmp_path):
    """Also where nothing can be: two joints at one point, no shapes."""
    pytest.importorskip("trimesh")
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    links = "".join(
        f'<link name="{n}"><inertial><mass value="1"/>{inertia}</inertial></link>' for n in ("my base", "b")
    )
    path = tmp_path / "one.urdf"
    path.write_text(
        f'<robot name="one">{links}<joint name="elbow &lt;b&gt; &amp; co" type="revolute"><parent link="my base"/>'
        f'<child link="b"/><origin xyz="{place}"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>'
    )
    session = Session(ready_controller(load_robot(path), 0.01), certify=1)
    session.targets[0].move(p=np.array([0.3, 0.0, 0.1]))
    with Window(session, port=8600) as window:
        session.motion.tick()
        window.show()
        assert "elbow &lt;b&gt; &amp; co" in window.panel.joints.content
        assert "of its own rows x and z are zero" in window.panel.reasons.content
        drawn = "nothing is drawn" if place == "0 0 0" else "capsules from joint to joint"
        assert drawn in window.scene.figure.note
        assert np.isfinite(window.scene.figure.bounds).all()
    assert session.motion.verdict.certified


def test_a_model_without_shapes_is_drawn_as_capsules_and_says_so():
    pytest.importorskip("trimesh")
    robot = PinocchioRobot(pin.buildSampleModelManipulator(), tip="effector_body", velocity_limit=2.0)
    meshes, note = meshes_of(robot)
    assert "capsules from joint to joint" in note
    assert {mesh.joint for mesh in meshes} <= set(range(robot.model.njoints))
    for mesh in meshes:
        assert mesh.faces.max() < len(mesh.vertices)


def test_large_meshes_are_thinned_and_keep_their_shape():
    creation = pytest.importorskip("trimesh.creation")
    ball = creation.icosphere(subdivisions=5)
    vertices, faces = _thinned(np.array(ball.vertices), np.array(ball.faces))
    assert len(ball.faces) > MOST_TRIANGLES
    assert len(faces) < len(ball.faces)
    assert np.abs(np.linalg.norm(vertices, axis=1) - 1.0).max() < 4.0 / CELLS


def test_the_page_is_told_what_happens_and_does_what_it_is_told(window):
    live, panel = window.session, window.panel
    live.motion.tick()
    window.show()
    assert "certified at 0.00 s" in panel.status.content
    assert "position met" in panel.reasons.content
    assert "elbow_joint" in panel.joints.content
    assert [group.label for group in panel.levels] == ["0 joint limits", "1 position", "2 orientation", "3 posture"]

    _click(panel.levels[2], UP)
    live.serve()
    assert [group.label for group in panel.levels][1:3] == ["1 orientation", "2 position"]
    task, slider = panel.gains[0]
    _set(slider, 7.0)
    live.serve()
    assert task.gain == 7.0
    slider.value = 3.0  # this program's own doing is no wish
    live.serve()
    assert task.gain == 7.0


def test_a_target_that_is_typed_moves_its_gizmo_and_one_that_is_dragged_its_numbers(window):
    live, target = window.session, window.session.targets[0]
    point, turn = window.panel._typed[id(target)]
    _set(point, (0.3, 0.2, 0.5))
    live.serve()
    np.testing.assert_allclose(window.scene.gizmos[0].position, [0.3, 0.2, 0.5])
    _set(turn, (180.0, 0.0, 90.0))
    live.serve()
    np.testing.assert_allclose(target.R, from_rpy(np.pi, 0.0, 0.5 * np.pi), atol=1e-12)
    gizmo = window.scene.gizmos[0]
    gizmo.position = (0.4, 0.1, 0.2)
    _run(window.scene._dragging(target, 0, gizmo)(PAGE))
    live.serve()
    np.testing.assert_allclose(point.value, [0.4, 0.1, 0.2])
    np.testing.assert_allclose(target.point.target(0.0)[0], [0.4, 0.1, 0.2])


def test_recordings_are_saved_under_the_next_name_in_their_own_folder(window, tmp_path):
    window.session.record()
    for _ in range(5):
        window.session.motion.tick()
    assert [window.panel.save(word).name for word in ("save data", "save page", "save page")] == [
        "live-1.npz",
        "live-1.html",
        "live-2.html",
    ]
    page = (tmp_path / "live-1.html").read_text()
    assert "__VISER_EMBED_DATA__" in page


def test_it_listens_to_this_machine_alone_and_opens_no_tunnel(window):
    assert window.server.get_host() == "127.0.0.1"
    assert window.server.request_share_url() is None
    assert window.server._share_tunnel is None


@pytest.mark.parametrize("end", [0, 1])
def test_the_bar_of_a_joint_is_red_where_it_is_at_an_end_of_its_range(ur5, end):
    q = np.zeros(6)
    assert BAD not in joints(ur5, q)
    q[2] = ur5.position_limit[end][2]
    rows = joints(ur5, q).split("</div>")
    assert [name for name in ur5.joint_names if any(name in row and BAD in row for row in rows)] == ["elbow_joint"]


def test_buttons_stay_where_they_are_whatever_the_texts_say(window):
    """What grows stands below what is clicked; above it, texts have as many lines at any time."""
    live, panel = window.session, window.panel
    lines = panel.status.content.count("<div")
    for far, message in (0.4, ""), (1.4, "saved: live-1.npz"):
        live.targets[0].move(p=np.array([far, 0.3, 0.4]))
        live.record()
        live.motion.tick()
        live.message = message
        panel.show()
        assert message in panel.status.content
        assert panel.status.content.count("<div") == lines
    assert max(group.order for group in panel.levels) < panel.reasons.order


def test_a_wider_host_is_warned_of(caplog):
    pytest.importorskip("viser")
    with caplog.at_level("WARNING", "hqp"):
        server = stage.open_stage("0.0.0.0", 8700)
    server.stop()
    assert "no password" in caplog.text


@pytest.mark.parametrize("host", ["0.0.0.0", "", "127.0.0.1", "localhost", "::", "::1"])
def test_the_address_it_names_can_be_opened(host):
    """0.0.0.0 is where it listens, and none that a browser may open; an address with colons stands in brackets."""
    pytest.importorskip("viser")
    try:
        server = stage.open_stage(host, 8720)
    except InvalidInput:  # a machine without this kind of address
        assert ":" in host
        return
    url = stage.page_of(server)
    assert urlparse(url).hostname in ("127.0.0.1", "localhost", "::1")
    assert urlparse(url).port == server.get_port()
    with urlopen(url, timeout=60) as answer:
        assert answer.status == 200
    server.stop()


SHAPELESS = """<robot name="mast"><link name="foot"/>
<link name="pole"><visual><geometry><box size=".1 .1 .3"/></geometry></visual></link><link name="hand"/>
<joint name="turn" type="continuous"><parent link="foot"/><child link="pole"/><axis xyz="0 0 1"/></joint>
<joint name="slide" type="prismatic"><parent link="pole"/><child link="hand"/><origin xyz="0 0 2"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


@pytest.mark.parametrize("relative_to", [None, "pole"])
def test_a_page_starts_with_every_target_in_view(relative_to, tmp_path):
    """Also where what carries the frame has no shape, and a target is far from all that has one."""
    pytest.importorskip("viser")
    (tmp_path / "mast.urdf").write_text(SHAPELESS)
    robot = load_robot(tmp_path / "mast.urdf")
    hand = PositionTask([0.5, 0.0, 2.0], frame="hand", relative_to=relative_to, gain=1.0)
    own = Window(Session(Controller(robot, JointLimits() >> hand, dt=0.01)), port=8620, folder=tmp_path)
    camera = own.server.initial_camera
    there, ahead = np.array([0.5, 0.0, 2.0]) - camera.position, np.asarray(camera.look_at) - camera.position
    own.close()
    assert there @ ahead > np.cos(0.5 * camera.fov) * np.linalg.norm(there) * np.linalg.norm(ahead)


def test_a_planar_arm_is_drawn_as_lines(tmp_path):
    pytest.importorskip("viser")
    own = Window(session(), port=8600, folder=tmp_path)
    own.session.motion.tick()
    own.show()
    own.close()
    assert own.scene.figure.note.startswith("drawn as lines")


def test_without_viser_it_says_how_to_get_it(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingPackage, match=r"hqp\[live\]"):
        tasks.live(Controller(ARM, stack(), dt=0.01), Q)
    assert run(["live", "panda"]) == 2
    assert "pip install 'hqp[live]'" in capsys.readouterr().err


@pytest.mark.parametrize("wrench", [False, True], ids=["points", "wrench"])
def test_forces_of_contacts_are_arrows_as_long_as_they_are_strong(wrench, tmp_path):
    pytest.importorskip("viser")
    scene = humanoid(rectangle=wrench, wrench=wrench)
    rest = CenterOfMassTask(scene.com, gain=5.0) >> PostureTask(scene.q, gain=4.0) + ForceTask(weight=1e-2)
    stack = scene.limits >> rest
    own = Session(Controller(scene.robot, stack, order="torque", dt=2e-3), scene.q)
    window = Window(own, port=8900, folder=tmp_path)
    try:
        arrows, polygon = (
            window.server.scene.get_handle_by_name(f"/contacts/{name}") for name in ("forces", "support")
        )
        assert not arrows.visible
        assert not polygon.visible
        own.motion.tick()
        window.show()
        step, lines = own.motion.step, np.array(arrows.points)
        at, ends = lines[:, 0], lines[:, 1]
        forces = np.concatenate([step.forces[foot.name].reshape(-1, 6 if wrench else 3)[:, :3] for foot in scene.feet])
        ratio = np.linalg.norm(ends - at, axis=1) / np.linalg.norm(forces, axis=1)
        assert np.ptp(ratio) < 1e-5 * ratio.max()
        soles = [scene.robot.at(scene.q).frame(foot.frame) for foot in scene.feet]
        corners = [s.position + foot.shape.points @ s.rotation.T for s, foot in zip(soles, scene.feet, strict=True)]
        low, high = np.concatenate(corners).min(axis=0), np.concatenate(corners).max(axis=0)
        edges = np.array(polygon.points).reshape(-1, 3)
        assert np.allclose([edges.min(axis=0)[:2], edges.max(axis=0)[:2]], [low[:2], high[:2]], atol=1e-5)
        assert (at.min(axis=0)[:2] >= low[:2] - 1e-5).all()
        assert (at.max(axis=0)[:2] <= high[:2] + 1e-5).all()
    finally:
        window.close()


def test_it_tells_its_address_and_ends_by_an_interruption(capsys):
    pytest.importorskip("viser")
    with heard():
        threading.Timer(0.5, _thread.interrupt_main).start()
        tasks.live(Controller(ARM, stack(), dt=0.01), Q, port=8800)
    assert "open http://127.0.0.1:8" in capsys.readouterr().out


def _click(group, word: str) -> None:
    """A button of a group, as a page clicks it."""
    group._impl.value = word
    for callback in list(group._impl.update_cb):
        _run(callback(PAGE))


def _set(handle, value) -> None:
    """A value, as a page sets it."""
    callbacks, handle._impl.update_cb = handle._impl.update_cb, []
    handle.value = value
    handle._impl.update_cb = callbacks
    for callback in callbacks:
        _run(callback(PAGE))


def _run(coroutine) -> None:
    """A coroutine that waits for nothing."""
    with pytest.raises(StopIteration):
        coroutine.send(None)
