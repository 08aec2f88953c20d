"""The ROS 2 node of docs/ros.md, with stand-ins for the modules of ROS: it listens, follows, and stops."""

from __future__ import annotations

import contextlib
import io
import sys
from collections.abc import Callable, Iterator
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command import ROOT
from test_docs import blocks

from tasks import load_robot

PAGE = ROOT / "docs" / "ros.md"
DT = 0.005
LOOKING_DOWN = (1.0, 0.0, 0.0, 0.0)


class Time(int):
    """Nanoseconds."""

    @property
    def nanoseconds(self) -> int:
        return int(self)

    def __sub__(self, other: int) -> Time:
        return Time(int(self) - int(other))


class FakeNode:
    """What the page uses of rclpy's Node; the clock and the timer are moved by hand."""

    def __init__(self, name: str) -> None:
        self.name, self.heard, self.sent, self.clock = name, {}, [], 0

    def create_subscription(self, kind: type, topic: str, callback: Callable[[Any], None], depth: int) -> None:
        self.heard[topic] = kind, callback

    def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
        return SimpleNamespace(publish=lambda message: self.sent.append((topic, message)))

    def create_timer(self, period: float, callback: Callable[[], None]) -> None:
        self.period, self.callback = period, callback

    def get_clock(self) -> Any:
        return SimpleNamespace(now=lambda: Time(self.clock))


class Message(SimpleNamespace):
    pass


class JointState(Message):
    pass


class PoseStamped(Message):
    pass


class Float64MultiArray(Message):
    pass


def modules(spun: list[FakeNode]) -> dict[str, ModuleType]:
    own = {
        "rclpy": {"init": lambda: None, "spin": spun.append},
        "rclpy.node": {"Node": FakeNode},
        "geometry_msgs": {},
        "geometry_msgs.msg": {"PoseStamped": PoseStamped},
        "sensor_msgs": {},
        "sensor_msgs.msg": {"JointState": JointState},
        "std_msgs": {},
        "std_msgs.msg": {"Float64MultiArray": Float64MultiArray},
    }
    found = {}
    for name, members in own.items():
        found[name] = ModuleType(name)
        found[name].__dict__.update(members)
    return found


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The node of the page, on a Panda in place of a file."""
    spun: list[FakeNode] = []
    for name, module in modules(spun).items():
        monkeypatch.setitem(sys.modules, name, module)
    space: dict[str, Any] = {"__name__": "docs_ros"}
    (follower,) = [text for language, text, *_ in blocks(PAGE) if language == "python"]
    (sketch,) = [text for language, text, *_ in blocks(PAGE) if language == "py"]
    with contextlib.redirect_stdout(io.StringIO()):
        exec(compile(follower, str(PAGE), "exec"), space)
    space["load_robot"] = lambda file, tip: load_robot("panda", lock=["panda_finger_joint1"])
    exec(compile(sketch, str(PAGE), "exec"), space)
    return spun[0]


def hear(node: Any, q: np.ndarray) -> None:
    """Where the joints are, in an order of the message's own, with a joint that is none of the robot's."""
    names = ["finger", *reversed(node.robot.joint_names)]
    kind, callback = node.heard["joint_states"]
    callback(kind(name=names, position=[0.02, *q[::-1]]))


def target(node: Any, position: tuple[float, float, float]) -> None:
    kind, callback = node.heard["target"]
    x, y, z, w = LOOKING_DOWN
    point = SimpleNamespace(**dict(zip("xyz", position, strict=True)))
    callback(kind(pose=SimpleNamespace(position=point, orientation=SimpleNamespace(x=x, y=y, z=z, w=w))))


def tick(node: Any) -> np.ndarray:
    node.clock += round(DT * 1e9)
    node.callback()
    topic, message = node.sent[-1]
    assert topic == "velocity_controller/commands"
    assert all(type(number) is float for number in message.data)
    return np.array(message.data)


def test_it_listens_and_says_nothing_before_it_knows_where_it_is(node: Any) -> None:
    assert {topic: kind for topic, (kind, _) in node.heard.items()} == {
        "joint_states": JointState,
        "target": PoseStamped,
    }
    assert node.period == DT
    target(node, (0.5, 0.2, 0.4))
    node.callback()
    assert not node.sent


def test_it_follows_a_target_within_its_limits_also_out_of_reach(node: Any) -> None:
    robot, q = node.robot, node.robot.home
    low, high = robot.position_limit
    hear(node, q)
    np.testing.assert_allclose(tick(node), 0.0, atol=1e-9)
    for goal, ticks in ((0.5, 0.2, 0.4), 600), ((2.0, 1.0, 0.4), 400):
        target(node, goal)
        for _ in range(ticks):
            hear(node, q)
            v = tick(node)
            q = q + DT * v
            assert (np.abs(v) <= robot.velocity_limit + 1e-9).all()
            assert ((q >= low - 1e-9) & (q <= high + 1e-9)).all()
        if goal[0] < 1.0:
            np.testing.assert_allclose(robot.at(q).frame().position, goal, atol=1e-3)


def test_it_stops_where_the_joints_are_no_longer_heard_of(node: Any) -> None:
    q = node.robot.home
    hear(node, q)
    tick(node)
    target(node, (0.5, 0.2, 0.4))
    for _ in range(10):
        hear(node, q)
        v = tick(node)
        q = q + DT * v
    assert np.abs(v).max() > 0.01
    for _ in range(21):
        v = tick(node)
    np.testing.assert_array_equal(v, 0.0)
    hear(node, q)
    assert np.abs(tick(node)).max() > 0.0
