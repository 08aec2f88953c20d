"""Robots of MJCF files are what MuJoCo makes of them, whatever the idiom; see `mjcf_idioms`."""

from __future__ import annotations

import logging
import struct

import numpy as np
import pytest
from mjcf_idioms import ALONE, CUBE, READ, REFUSED, STL, TABLE, TARGET, arm

from hqp import InvalidInput
from tasks import Controller, JointLimits, PositionTask, PostureTask, load_robot, simulate

mujoco = pytest.importorskip("mujoco", reason="MJCF needs MuJoCo: pip install 'hqp[mujoco]'")

FREE, BALL, SLIDE, HINGE = range(4)
SIZES = {FREE: (7, 6), BALL: (4, 3), SLIDE: (1, 1), HINGE: (1, 1)}
UNITS = {FREE: "mmmrrr", BALL: "rrr", SLIDE: "m", HINGE: "r"}


def packed(
    vertices=((0, 0, 0), (0.2, 0, 0), (0, 0.1, 0), (0, 0, 0.3)), faces=((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
):
    """A tetrahedron as a binary STL."""
    rows = [struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in vertices[i]), 0) for face in faces]
    return bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows)


def written(folder, text, files=(), name="robot.xml"):
    for place, content in dict(files).items():
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).write_bytes(packed() if content == STL else content.encode())
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


class Twin:
    """The robot as MuJoCo has it: its bodies, those of its joints that move on their own, and what is tied to them."""

    def __init__(self, path, idiom):
        m = self.model = mujoco.MjModel.from_xml_path(str(path))
        self.data = mujoco.MjData(m)
        mimic = idiom.options.get("mimic", "lock")
        self.follows = mimic == "follow"
        roots = {m.body(name).id for name in idiom.robot}
        self.bodies = [b for b in range(1, m.nbody) if not roots or roots & set(self.above(b))]
        self.sites = [s for s in range(m.nsite) if m.site_bodyid[s] in self.bodies]
        self.ties = {
            int(m.eq_obj1id[e]): (int(m.eq_obj2id[e]), *m.eq_data[e, :2])
            for e in range(m.neq)
            if m.eq_type[e] == mujoco.mjtEq.mjEQ_JOINT and m.eq_active0[e] and mimic != "free"
        }
        own = [j for j in range(m.njnt) if m.jnt_bodyid[j] in self.bodies]
        self.limited = [j for j in own if m.jnt_limited[j]]
        self.start = m.qpos0.copy()
        for j in own:
            if j not in self.ties and m.jnt_type[j] in (SLIDE, HINGE):
                self.start[m.jnt_qposadr[j]] = np.clip(m.qpos0[m.jnt_qposadr[j]], *self.range(j))
        self.start = self.tied(self.start)
        for joint, (leader, offset, ratio) in list(self.ties.items()):
            if self.follows and leader > joint:  # the one that comes first in the tree is independent
                del self.ties[joint]
                self.ties[leader] = joint, -offset / ratio, 1.0 / ratio
        self.joints = [j for j in own if j not in self.ties]
        carriers = {int(m.jnt_bodyid[j]) for j in (own if self.follows else self.joints)}
        self.moving = [b for b in self.bodies if carriers & set(self.above(b))]
        self.free = any(m.jnt_type[j] == FREE for j in self.joints)

    def above(self, body):
        """The body, and all that carry it."""
        while body:
            yield body
            body = int(self.model.body_parentid[body])

    def of(self, joint):
        """Where the joint is in qpos and in qvel."""
        m = self.model
        (nq, nv), q, v = SIZES[int(m.jnt_type[joint])], m.jnt_qposadr[joint], m.jnt_dofadr[joint]
        return slice(q, q + nq), slice(v, v + nv)

    def range(self, joint):
        """Of one joint, and of what is tied to it."""
        m, zero = self.model, self.model.qpos0
        low, high = m.jnt_range[joint] if m.jnt_limited[joint] else (-np.inf, np.inf)
        for follower, (leader, offset, ratio) in self.ties.items():
            if leader == joint:
                moved = np.array(self.range(follower)) - zero[m.jnt_qposadr[follower]] - offset
                least, most = sorted(moved / ratio + zero[m.jnt_qposadr[joint]])
                low, high = max(low, least), min(high, most)
        return low, high

    def tied(self, qpos):
        """The same with what is tied where it belongs: with its leader, or where that one starts."""
        places, zero = self.model.jnt_qposadr, self.model.qpos0
        qpos = qpos.copy()
        for _ in self.ties:  # one may be tied to another
            for joint, (leader, offset, ratio) in self.ties.items():
                led = places[leader]
                source = qpos if self.follows or leader in self.ties else self.start
                share = ratio * (source[led] - zero[led]) if leader >= 0 else 0.0
                qpos[places[joint]] = zero[places[joint]] + offset + share
        return qpos

    def random(self, rng):
        m, qpos = self.model, self.start.copy()
        for joint in self.joints:
            own, kind = self.of(joint)[0], m.jnt_type[joint]
            if kind in (FREE, BALL):
                turn = rng.normal(size=4)
                place = rng.uniform(-1, 1, 3) if kind == FREE else ()
                qpos[own] = [*place, *turn / np.linalg.norm(turn)]
            else:
                ends = self.range(joint)
                qpos[own] = rng.uniform(*(ends if np.isfinite(ends).all() else (-2.0, 2.0)))
        return self.tied(qpos)

    def configuration(self, qpos):
        """q of the robot: quaternions with the scalar last."""
        parts = [qpos[self.of(joint)[0]] for joint in self.joints]
        return np.concatenate([np.r_[p[:-4], p[-3:], p[-4]] if len(p) > 1 else p for p in parts])

    def qpos(self, q):
        """The other way round."""
        qpos, at = self.start.copy(), 0
        for joint in self.joints:
            own = self.of(joint)[0]
            size = own.stop - own.start
            part, at = q[at : at + size], at + size
            qpos[own] = np.r_[part[:-4], part[-1], part[-4:-1]] if size > 1 else part
        return self.tied(qpos)

    def velocities(self, qpos):
        """T, such that qvel = T v: what is tied follows, and a free base moves along its own axes."""
        m = self.model
        nv = sum(SIZES[int(m.jnt_type[j])][1] for j in self.joints)
        T, at = np.zeros((m.nv, nv)), 0
        for joint in self.joints:
            own_q, own_v = self.of(joint)
            size = own_v.stop - own_v.start
            T[own_v, at : at + size] = np.eye(size)
            if m.jnt_type[joint] == FREE:
                R = np.empty(9)
                mujoco.mju_quat2Mat(R, qpos[own_q][3:])
                T[own_v, at : at + size][:3, :3] = R.reshape(3, 3)
            at += size
        for _ in self.ties if self.follows else ():
            for joint, (leader, _, ratio) in self.ties.items():
                if leader >= 0:
                    T[m.jnt_dofadr[joint]] = ratio * T[m.jnt_dofadr[leader]]
        return T

    def at(self, qpos, qvel=0.0):
        """MuJoCo's data there."""
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        mujoco.mj_forward(self.model, self.data)
        return self.data

    def frames(self):
        """Name, kind and number of every body and site that has a name."""
        named = [("body", b, self.model.body(b).name) for b in self.bodies]
        named += [("site", s, self.model.site(s).name) for s in self.sites]
        return [(name, kind, number) for kind, number, name in named if name]

    def seen(self, kind, number):
        """Position, rotation and Jacobians, linear and angular, in qvel."""
        J = np.zeros((2, 3, self.model.nv))
        ask = mujoco.mj_jacBody if kind == "body" else mujoco.mj_jacSite
        ask(self.model, self.data, J[0], J[1], number)
        d = self.data
        place, turn = (d.xpos, d.xmat) if kind == "body" else (d.site_xpos, d.site_xmat)
        return place[number], turn[number].reshape(3, 3), *J


@pytest.fixture(scope="module", params=READ)
def pair(request, tmp_path_factory):
    """Each robot, and its twin."""
    idiom, folder = READ[request.param], tmp_path_factory.mktemp("mjcf")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)  # where MuJoCo writes its log
        path = written(folder, idiom.text, idiom.files)
        return load_robot(path, velocity_limit=20.0, **idiom.options), Twin(path, idiom)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of its own to stand in, as MuJoCo writes its log there."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def close(a, b, tolerance=1e-9, **options):
    np.testing.assert_allclose(a, b, rtol=0.0, atol=tolerance, **options)


def configurations(twin, count=3):
    rng = np.random.default_rng(7)
    return [twin.random(rng) for _ in range(count)]


# The robot.


def test_joints_and_their_names(pair):
    """As many as MuJoCo has, in its order, under their own names, and all names differ."""
    robot, twin = pair
    kinds = [int(twin.model.jnt_type[j]) for j in twin.joints]
    assert robot.nq == sum(SIZES[kind][0] for kind in kinds)
    assert robot.nv == sum(SIZES[kind][1] for kind in kinds)
    assert len(robot.joint_names) == len(set(robot.joint_names)) == robot.nv
    assert all(robot.joint_names)
    column = 0
    for joint, kind in zip(twin.joints, kinds, strict=True):
        size, name = SIZES[kind][1], twin.model.joint(joint).name
        expected = (name,) if size == 1 else tuple(f"{name}[{i}]" for i in range(size))
        if name:
            assert robot.joint_names[column : column + size] == expected
        column += size
    assert [unit[0] for unit in robot.joint_units] == list("".join(UNITS[kind] for kind in kinds))
    assert set(robot.joint_units) <= {"m", "rad"}
    assert robot.base == (6 if twin.free else 0)


def test_ranges_and_torques(pair):
    """Those of the joints that are limited, and no others; and no joint leaves the range of one that follows it."""
    robot, twin = pair
    m, ranges, torques = twin.model, [], []
    for j in twin.joints:
        ranges += [twin.range(j)] * SIZES[int(m.jnt_type[j])][1]
        on_joints = np.flatnonzero(m.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT)
        own = [i for i in on_joints if m.actuator_trnid[i, 0] == j]
        motor = m.actuator_forcerange[own[0], 1] if len(own) == 1 and m.actuator_forcelimited[own[0]] else np.inf
        joint = m.jnt_actfrcrange[j, 1] if m.jnt_actfrclimited[j] else np.inf
        torques += [min(joint, motor)] * SIZES[int(m.jnt_type[j])][1]
    for own, expected in (robot.position_limit, np.transpose(ranges)), (robot.torque_limit, np.array(torques)):
        if np.isfinite(expected).any():
            close(own, expected, 1e-12 if twin.ties else 0.0)
        else:
            assert own is None


def test_where_it_starts(pair):
    """Neutral is qpos0 inside the ranges; home, and every other name of a keyframe, is that keyframe."""
    robot, twin = pair
    close(robot.neutral, twin.configuration(twin.start), 1e-12)
    keys = {twin.model.key(k).name: twin.model.key_qpos[k] for k in range(twin.model.nkey)}
    close(robot.home, twin.configuration(keys.get("home", twin.start)), 1e-12)
    for name, qpos in keys.items():
        if name:
            close(robot.configuration(name), twin.configuration(qpos), 1e-12)


def test_frames_are_where_mujoco_has_them(pair):
    """Bodies and sites, under their own names: a body before a site, a site before a joint, or by kind."""
    robot, twin = pair
    bodies = {name for name, kind, _ in twin.frames() if kind == "body"}
    for qpos in [twin.start, *configurations(twin)]:
        twin.at(qpos)
        state = robot.at(twin.configuration(qpos), np.zeros(robot.nv))
        for name, kind, number in twin.frames():
            position, rotation, _, _ = twin.seen(kind, number)
            plain = [name] if kind == "body" or name not in bodies else []
            for asked in [f"{kind}:{name}", *plain]:
                close(state.frame(asked).position, position, err_msg=asked)
                close(state.frame(asked).rotation, rotation, err_msg=asked)
            assert name in robot.frame_names


def test_frames_of_joints_are_on_their_axes(pair):
    robot, twin = pair
    for qpos in configurations(twin):
        data = twin.at(qpos)
        state = robot.at(twin.configuration(qpos), np.zeros(robot.nv))
        for joint in twin.joints:
            name, kind = twin.model.joint(joint).name, twin.model.jnt_type[joint]
            if name and kind in (HINGE, BALL):
                off = state.frame(f"joint:{name}").position - data.xanchor[joint]
                close(np.cross(off, data.xaxis[joint]) if kind == HINGE else off, 0.0, err_msg=name)


def test_jacobians_are_those_of_mujoco(pair):
    """With the velocities of a free base along its own axes, and with what is tied."""
    robot, twin = pair
    for qpos in configurations(twin):
        twin.at(qpos)
        T = twin.velocities(qpos)
        state = robot.at(twin.configuration(qpos), np.zeros(robot.nv))
        for name, kind, number in twin.frames():
            _, _, linear, angular = twin.seen(kind, number)
            close(state.frame(f"{kind}:{name}").linear, linear @ T, err_msg=name)
            close(state.frame(f"{kind}:{name}").angular, angular @ T, err_msg=name)


def test_a_step_leads_where_mujoco_goes(pair):
    """A velocity means the same to both: a free base moves along its own axes, in both its parts."""
    robot, twin = pair
    rng, h = np.random.default_rng(3), 1e-5
    for qpos in configurations(twin):
        v = rng.uniform(-1.0, 1.0, robot.nv)
        q = robot.integrate(twin.configuration(qpos), h * v)
        mujoco.mj_integratePos(twin.model, qpos, twin.velocities(qpos) @ v, h)
        twin.at(qpos)
        state = robot.at(q, v)
        for name, kind, number in twin.frames():
            position, rotation, _, _ = twin.seen(kind, number)
            close(state.frame(f"{kind}:{name}").position, position, 1e-8, err_msg=name)
            close(state.frame(f"{kind}:{name}").rotation, rotation, 1e-8, err_msg=name)


def test_masses_are_those_of_mujoco(pair):
    """What moves, all together; the mass matrix, with the inertias of motors; and what gravity and speed ask for."""
    robot, twin = pair
    m = twin.model
    masses = [inertia.mass for inertia in robot.model.inertias][1:]
    np.testing.assert_allclose(sum(masses), m.body_mass[twin.moving].sum(), rtol=1e-8)
    rng = np.random.default_rng(11)
    for qpos in configurations(twin):
        T, v = twin.velocities(qpos), rng.uniform(-1.0, 1.0, robot.nv)
        data = twin.at(qpos, T @ v)
        M = np.empty((m.nv, m.nv))
        mujoco.mj_fullM(m, data, M)
        expected, q = T.T @ M @ T, twin.configuration(qpos)
        close(robot.mass_matrix(q), expected, 1e-8 * np.abs(expected).max())
        turning = np.zeros(m.nv)  # the acceleration of MuJoCo's velocities while those of the robot are constant
        for joint in twin.joints:
            if m.jnt_type[joint] == FREE:
                dofs = twin.of(joint)[1]
                turning[dofs][:3] = T[dofs][:3, :3] @ np.cross(v[3:6], v[:3])
        bias = T.T @ (data.qfrc_bias + M @ turning - m.dof_armature * turning)
        close(robot.bias(q, v), bias, 1e-8 * max(np.abs(bias).max(), np.abs(expected).max()))


# The loop.


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_loop_keeps_the_ranges_of_mujoco(pair, side):
    """Sent far beyond them, every joint comes to rest on the end of its range, and at no tick is it outside."""
    robot, twin = pair
    m, far = twin.model, np.full(robot.nv, 100.0 * side)
    if robot.nv == robot.base:
        frame = next(name for name, _, _ in twin.frames())
        task = PositionTask(far[:3], frame=frame, gain=2.0)
    else:
        task = PostureTask(robot.integrate(robot.neutral, far), gain=2.0)
    record = simulate(
        Controller(robot, JointLimits() >> task, dt=0.01, damping=None), robot.neutral, duration=1.0, certify=0
    )
    assert record.stopped is None
    run = np.array([twin.qpos(q) for q in record.q])
    for joint in twin.limited:
        place, (low, high) = m.jnt_qposadr[joint], m.jnt_range[joint]
        assert run[:, place].min() >= low - 1e-9
        assert run[:, place].max() <= high + 1e-9
    for joint in twin.joints:
        if m.jnt_type[joint] in (SLIDE, HINGE):
            place, end = m.jnt_qposadr[joint], twin.range(joint)[int(side > 0)]
            if np.isfinite(end):
                close(run[-1, place], end, 1e-6)
            else:
                assert side * (run[-1, place] - run[0, place]) > 1.0


# The scene.


def test_what_is_left_out_is_said(pair, request):
    robot, idiom = pair[0], READ[request.node.callspec.params["pair"]]
    for name in idiom.left:
        assert any(name in line for line in robot.left_out)
    if "body" not in idiom.options and not idiom.left:
        assert robot.left_out == ()


def test_what_is_left_out_is_told_once(folder, caplog):
    text = f"<mujoco><worldbody>{CUBE}{TABLE}{TARGET}{arm()}</worldbody></mujoco>"
    for name in "cube", "table", "target":
        text = text.replace(f'"{name}"', f'"{name}_told_once"')
    path = written(folder, text, name="told_once.xml")
    with caplog.at_level(logging.WARNING, logger="hqp"):
        for _ in range(3):
            robot = load_robot(path)
    assert len(robot.left_out) == 3
    told = [record.getMessage() for record in caplog.records if record.name == "hqp"]
    for name in "cube", "table", "target":
        assert sum(f"{name}_told_once" in line for line in told) == 1


@pytest.mark.parametrize("name", [name for name, idiom in READ.items() if not idiom.left and not idiom.options])
def test_nothing_is_told_of_a_robot_that_is_alone(folder, caplog, nothing_told, name):
    """But for joints that are held."""
    path = written(folder, READ[name].text, READ[name].files, name="alone.xml")
    with caplog.at_level(logging.DEBUG, logger="hqp"):
        load_robot(path)
    assert len(caplog.records) == (1 if Twin(path, READ[name]).ties else 0)


def test_a_weld_to_what_the_mouse_drags_is_said(folder):
    idiom = READ["a hand tied to what the mouse drags"]
    left = load_robot(written(folder, idiom.text)).left_out
    assert any("weld" in line or "drag" in line for line in left)


# The source.


@pytest.mark.parametrize("name", READ)
def test_a_compiled_model_is_the_same_robot(folder, name):
    idiom = READ[name]
    path = written(folder, idiom.text, idiom.files)
    one, other = (load_robot(s, **idiom.options) for s in (path, mujoco.MjModel.from_xml_path(str(path))))
    for what in "nq", "nv", "base", "joint_names", "joint_units", "frame_names", "left_out":
        assert getattr(one, what) == getattr(other, what)
    for what in "position_limit", "velocity_limit", "torque_limit", "neutral", "home":
        np.testing.assert_array_equal(getattr(one, what), getattr(other, what))
    q = one.random(np.random.default_rng(0))
    np.testing.assert_array_equal(one.mass_matrix(q), other.mass_matrix(q))
    for frame in one.frame_names:
        a, b = (robot.at(q, np.zeros(one.nv)).frame(frame) for robot in (one, other))
        np.testing.assert_array_equal(a.position, b.position)
        np.testing.assert_array_equal(a.rotation, b.rotation)


def test_a_model_is_not_changed_by_reading_it(folder):
    model = mujoco.MjModel.from_xml_string(READ["a finger that follows"].text)
    before = mujoco.MjModel.from_xml_string(READ["a finger that follows"].text)
    load_robot(model)
    for what in "qpos0", "body_pos", "body_quat", "body_inertia", "jnt_pos", "jnt_range", "eq_data", "eq_active0":
        np.testing.assert_array_equal(getattr(model, what), getattr(before, what))


@pytest.mark.parametrize("suffix", ["xml", "mjcf", "urdf"])
def test_a_file_is_what_its_root_says(folder, suffix):
    robot = load_robot(written(folder, READ["a head before the robot"].text, name=f"arm.{suffix}"))
    assert robot.joint_names == ("shoulder", "elbow")


def test_limits_that_are_given_stand_for_those_of_the_file(folder):
    path = written(folder, READ["torques of motors"].text)
    robot = load_robot(path, position_limit=(-1, 1), velocity_limit=2.0, torque_limit=[1, 2, 3, 4], tip="four")
    np.testing.assert_array_equal(robot.position_limit, [[-1] * 4, [1] * 4])
    np.testing.assert_array_equal(robot.torque_limit, [1, 2, 3, 4])
    assert robot.tip == "four"
    assert load_robot(path).velocity_limit is None


@pytest.mark.parametrize(("torques", "largest"), [("-10 30", 10.0), ("-30 10", 10.0), ("0 30", None), ("-30 0", None)])
@pytest.mark.usefixtures("nothing_told")
def test_a_motor_that_is_weaker_one_way(folder, torques, largest, caplog):
    """Its limit is what it can both ways, and told; one that can do nothing one way is refused."""
    text = f"""<mujoco><worldbody><body name="one"><joint name="weak" actuatorfrcrange="{torques}"/><geom size=".1"/>
      </body></worldbody></mujoco>"""
    path = written(folder, text)
    if largest is None:
        with pytest.raises(InvalidInput, match="weak"):
            load_robot(path)
    else:
        with caplog.at_level("WARNING"):
            np.testing.assert_array_equal(load_robot(path).torque_limit, [largest])
        assert "the smaller end of the range of its motor counts for both directions: weak" in caplog.text


def test_joints_that_are_locked(folder):
    robot = load_robot(written(folder, f"<mujoco>{ALONE}</mujoco>"), lock={"shoulder": 0.5})
    whole = load_robot(folder / "robot.xml")
    assert robot.joint_names == ("elbow",)
    tips = [r.at(q, np.zeros(r.nv)).frame("tip") for r, q in ((robot, [-0.3]), (whole, [0.5, -0.3]))]
    close(tips[0].position, tips[1].position)
    close(tips[0].linear[:, 0], tips[1].linear[:, 1])


# Names of configurations and of frames.


def test_keyframes_by_name(folder):
    idiom = READ["keyframes"]
    robot = load_robot(written(folder, idiom.text))
    np.testing.assert_array_equal(robot.home, [0.7, -0.3])
    np.testing.assert_array_equal(robot.configuration("ready"), [-0.5, 0.4])
    close(robot.neutral, [np.pi / 6, 0.2], 1e-12)
    close(robot.configuration({"b": 0.3}), [np.pi / 6, 0.3], 1e-12)
    with pytest.raises(InvalidInput, match=r"raedy.*ready"):
        robot.configuration("raedy")


def test_a_keyframe_of_a_free_base(folder):
    """The scalar of a quaternion comes last."""
    robot = load_robot(written(folder, READ["a free base with keyframes"].text))
    np.testing.assert_array_equal(robot.configuration("stand"), [0, 0, 0.3, 0, 0, 0, 1, 0.5, -1])
    np.testing.assert_array_equal(robot.configuration("lie"), [1, 2, 0.1, 0.5, -0.5, 0.5, 0.5, 1, -2.5])
    np.testing.assert_array_equal(robot.home, robot.neutral)


def test_a_keyframe_of_two_robots_is_cut(folder):
    idiom = READ["keyframes of two robots"]
    path = written(folder, idiom.text)
    np.testing.assert_array_equal(load_robot(path, body="right_base").home, [0.3, -0.4])
    np.testing.assert_array_equal(load_robot(path, body="left_base").configuration("up"), [0.5, -0.6])
    both = load_robot(path, body=["left_base", "right_base"])
    np.testing.assert_array_equal(both.home, [0.1, 0.2, 0.3, -0.4])


def test_a_frame_is_asked_for_by_its_kind(folder):
    robot = load_robot(written(folder, READ["one name for a body, a joint and a site"].text))
    state = robot.at([0.0, 0.0], np.zeros(2))
    places = {"one": (0, 0, 0.1), "body:one": (0, 0, 0.1), "site:one": (0, 0.2, 0.1), "tip": (0.3, 0, 0.5)}
    for asked, place in places.items():
        close(state.frame(asked).position, place)
    close(state.frame("joint:one").position[:2], [0.1, 0.0])  # on its axis
    close(state.frame("joint:tip").position[[0, 2]], [0.4, 0.1])
    for asked in "body:tip", "site:two", "joint:two", "geom:one":
        with pytest.raises(InvalidInput, match="is no frame of"):
            state.frame(asked)


# What is refused.


@pytest.mark.parametrize("name", REFUSED)
def test_refuses_by_name(folder, name):
    refusal = REFUSED[name]
    path = written(folder, refusal.text)
    with pytest.raises(InvalidInput) as caught:
        load_robot(path, **refusal.options)
    for word in refusal.named:
        assert word in str(caught.value)


def test_a_range_that_is_turned_around_is_refused_and_not_taken_for_none(folder):
    text = "<mujoco><worldbody><body><joint name='a' range='90 -90'/><geom size='.1'/></body></worldbody></mujoco>"
    with pytest.raises(InvalidInput, match="joint 'a' has the range 90 to -90; it must be in order"):
        load_robot(written(folder, text))


MOTORS = """<mujoco><worldbody><body><joint name="a"/><geom size=".1"/>
<body><joint name="b" actuatorfrcrange="-5 5"/><geom size=".1"/></body></body></worldbody>
<actuator>{}</actuator></mujoco>"""


@pytest.mark.parametrize(
    ("motor", "largest"),
    [
        ('<motor joint="a" gear="100" ctrlrange="-1 1"/>', 100.0),
        ('<motor joint="a" gear="-20" ctrlrange="-1 2"/>', 20.0),
        ('<motor joint="a" gear="2" ctrlrange="-9 9" forcerange="-4 5"/>', 8.0),
        ('<position joint="a" kp="1e6" gear=".5" ctrlrange="-1 1" forcerange="-87 87"/>', 43.5),
        ('<velocity joint="a" kv="1e6" forcerange="-7 7"/>', 7.0),
        ('<general jointinparent="a" gainprm="-3" ctrlrange="-1 1"/>', 3.0),
        ('<motor joint="b" gear="3" ctrlrange="-1 1"/>', 3.0),
        ('<motor joint="b" gear="9" ctrlrange="-1 1"/>', 5.0),
    ],
)
def test_the_one_motor_of_a_joint_limits_its_torque(folder, motor, largest):
    """To what MuJoCo gives both ways, however much is asked for."""
    path = written(folder, MOTORS.format(motor))
    robot, mj = load_robot(path), mujoco.MjModel.from_xml_path(str(path))
    joint, given = int(mj.actuator_trnid[0, 0]), []
    for asked in -1e6, 1e6:
        data = mujoco.MjData(mj)
        data.ctrl[:] = asked
        mujoco.mj_forward(mj, data)
        given.append(data.qfrc_actuator[mj.jnt_dofadr[joint]])
    assert robot.left_out == ()
    assert robot.torque_limit[joint] == largest == pytest.approx(min(-min(given), max(given)))


@pytest.mark.parametrize(
    "motors",
    [
        '<motor joint="a" gear="100" ctrlrange="0 1"/>',
        '<motor joint="a" ctrlrange="-1 1"/><motor joint="a" ctrlrange="-2 2"/>',
        '<motor joint="a" ctrlrange="-1 1"/><position joint="a" kp="3"/>',
        '<general joint="a" forcerange="-9 0"/>',
    ],
    ids=["one way", "two", "one of two", "only pulls"],
)
def test_limits_of_motors_that_are_not_read_are_said(folder, motors):
    robot = load_robot(written(folder, MOTORS.format(motors)))
    assert robot.left_out == ("limits of the motors of the joints a (torque_limit= gives them)",)
    assert robot.torque_limit[0] == np.inf


ELSEWHERE = """<mujoco><worldbody><site name="anchor" pos="1 1 1"/><body name="cart"><joint name="a"/>
<geom size=".1"/><site name="tip" pos=".1 0 0"/><body><joint name="b"/><geom size=".1"/></body></body>
<body name="cube"><freejoint/><geom size=".1"/><site name="lid"/></body></worldbody>
<tendon><fixed name="sum"{}><joint joint="a" coef="1"/><joint joint="b" coef="-1"/></fixed>
<spatial name="rope"><site site="tip"/><site site="anchor"/></spatial></tendon><actuator>{}</actuator></mujoco>"""


@pytest.mark.parametrize(
    ("tendon", "motor", "said"),
    [
        ("", '<motor name="m" tendon="sum" gear="9" ctrlrange="-1 1"/>', "actuator m"),
        ("", '<position name="m" tendon="rope" forcerange="-9 9"/>', "actuator m"),
        ("", '<motor site="tip" gear="0 0 1 0 0 0" forcerange="-9 9"/>', "actuator number 0"),
        (' actuatorfrcrange="-9 9"', '<motor tendon="sum"/>', "tendon sum"),
        ("", '<motor tendon="sum"/>', None),
        ("", '<motor site="lid" gear="0 0 1 0 0 0" forcerange="-9 9"/>', None),
    ],
)
def test_limits_of_motors_that_are_on_no_joint_are_said(folder, tendon, motor, said):
    left_out = [
        line for line in load_robot(written(folder, ELSEWHERE.format(tendon, motor))).left_out if "limits" in line
    ]
    told = [] if said is None else [f"limits of the forces of {said} (torques of the joints do not keep them)"]
    assert left_out == told


@pytest.mark.parametrize(
    "motor",
    [
        '<velocity joint="a" kv="1" ctrlrange="-1 1"/>',
        '<motor joint="a" gear="2"/>',
        '<general joint="a" dyntype="integrator" actdim="1" ctrlrange="-1 1"/>',
    ],
)
def test_nothing_is_said_of_motors_that_limit_no_torque(folder, motor):
    robot = load_robot(written(folder, MOTORS.format(motor)))
    assert robot.left_out == ()
    assert robot.torque_limit[0] == np.inf


def test_ranges_of_controls_that_mujoco_does_not_keep_are_none(folder):
    text = MOTORS.format('<motor joint="a" ctrlrange="-1 1"/>')
    text = text.replace("<mujoco>", '<mujoco><option><flag clampctrl="disable"/></option>')
    assert load_robot(written(folder, text)).torque_limit[0] == np.inf


@pytest.mark.parametrize(("position", "told"), [("0.7", False), ("45", True)])
def test_a_keyframe_outside_the_ranges_is_moved_and_told(folder, caplog, position, told):
    text = f"""<mujoco><worldbody><body name="arm {position}"><joint name="a" range="-90 90"/><geom size=".1"/></body>
    </worldbody><keyframe><key name="home" qpos="{position}"/></keyframe></mujoco>"""
    with caplog.at_level(logging.WARNING, logger="hqp"):
        robot = load_robot(written(folder, text))
    assert robot.home == pytest.approx(np.pi / 2 if told else 0.7)
    assert ("configuration 'home' is outside the ranges, and is moved into them: a" in caplog.text) == told


@pytest.mark.parametrize(
    ("base", "elsewhere"), [("fixed", "moved, turned, tilted"), ("planar", "tilted"), ("floating", ""), (None, "")]
)
def test_keyframes_whose_base_cannot_be_there_are_told(folder, base, elsewhere):
    """A base that floats in the file, and is held, or moves in the plane."""
    text = """<mujoco><worldbody><body name="base" pos="0 0 .5"><freejoint/><geom size=".1"/>
    <body><joint name="j"/><geom size=".1"/></body></body></worldbody><keyframe>
    <key name="still" qpos="0 0 .5 1 0 0 0 .3"/><key name="moved" qpos="1 2 .5 1 0 0 0 .3"/>
    <key name="turned" qpos="0 0 .5 1 0 0 1 0"/><key name="tilted" qpos="0 0 .5 1 0 1 0 0"/></keyframe></mujoco>"""
    left_out = load_robot(written(folder, text), base=base).left_out
    assert left_out == ((f"places of the base in the keyframes {elsewhere} (base= holds it)",) if elsewhere else ())


@pytest.mark.parametrize("joint", ['axis="0 1 0"', 'type="slide" axis="0 1 0"'])
@pytest.mark.parametrize("on", ["joint", "jointinparent"])
def test_rotors_of_motors_are_part_of_the_robot(folder, joint, on):
    """Their inertia is in the torques, and their damping in that of the model, as in MuJoCo."""
    text = f"""<mujoco><worldbody><body><joint name="a" {joint} armature=".1" damping=".2"/><geom size=".1"/>
    </body></worldbody><actuator><motor {on}="a" gear="10" armature=".01" damping=".02"/></actuator></mujoco>"""
    robot = load_robot(written(folder, text))
    m = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(m)
    data.qacc[:], data.qvel[:] = 3.0, 2.0
    mujoco.mj_inverse(m, data)
    drag = robot.model.damping * 2.0
    close(robot.inverse_dynamics([0.0], [2.0], [3.0]) + drag, data.qfrc_inverse, 1e-9 * abs(data.qfrc_inverse[0]))
    assert robot.left_out == ()


UNMODELLED = """<mujoco><option {option}/><worldbody><body><joint name="a" {joint}/><geom size=".1"/>
<body pos=".3 0 0"><joint name="b" type="ball"/><geom size=".1"/></body></body></worldbody>{more}</mujoco>"""
TENDON = '<tendon><fixed name="t" {}><joint joint="a" coef="1"/></fixed></tendon>'


@pytest.mark.parametrize(
    ("said", "parts"),
    [
        ("the forces of the medium", {"option": 'density="1.2" wind="3 0 0"'}),
        ("the forces of the medium", {"option": 'viscosity="0.1"'}),
        ("springs of the joints a", {"joint": 'stiffness="0 1"'}),
        ("damping that is not linear of the joints a", {"joint": 'damping="0 1"'}),
        ("springs, dampers, friction and armature of the tendons t", {"more": TENDON.format('frictionloss="1"')}),
        ("springs, dampers, friction and armature of the tendons t", {"more": TENDON.format('damping="0 1"')}),
        (
            "armature and damping of the actuators m",
            {"more": '<actuator><motor name="m" joint="b" gear="1 2 0" armature=".1"/></actuator>'},
        ),
        (
            "armature and damping of the actuators m",
            {"more": TENDON.format("") + '<actuator><motor name="m" tendon="t" damping=".1"/></actuator>'},
        ),
        (
            "armature and damping of the actuators m",
            {"more": '<actuator><motor name="m" joint="a" damping="0 1"/></actuator>'},
        ),
        (None, {"option": 'wind="3 0 0"'}),
        (None, {"more": TENDON.format("")}),
    ],
)
def test_what_mujoco_has_and_the_robot_has_not_is_said(folder, said, parts):
    text = UNMODELLED.format(**{"option": "", "joint": "", "more": ""} | parts)
    told = () if said is None else (f"{said} (torques do not count them)",)
    assert load_robot(written(folder, text)).left_out == told
