"""The page in a browser, as a user has it: a target dragged and typed, levels reordered, and the text that follows."""

from __future__ import annotations

import os
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from time import monotonic, sleep
from urllib.parse import urlparse

import numpy as np
import pytest
from browser import CHROMIUM, chromium, drag, page, running
from PIL import Image

from tasks import Record, load_robot, simulate
from tasks.view.live import Window
from tasks.view.session import Session
from tasks.view.stacks import ready_controller

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None or find_spec("playwright") is None, reason="needs Chromium and playwright"),
    pytest.mark.filterwarnings("default"),  # of the browser's driver
]
#: Where screenshots are left, to be looked at.
PICTURES = os.environ.get("HQP_SCREENSHOTS")


def window(name: str, tmp_path: Path, **options) -> Window:
    robot = load_robot(name, **options)
    return Window(Session(ready_controller(robot, 0.01)), port=8300, folder=tmp_path)


def picture(own, name: str) -> None:
    if PICTURES:
        own.screenshot(path=str(Path(PICTURES) / f"{name}.png"))


def until(holds, seconds: float = 30.0) -> bool:
    end = monotonic() + seconds
    while not holds() and monotonic() < end:
        sleep(0.05)
    return bool(holds())


@pytest.fixture(scope="module")
def browser():
    with chromium() as own:
        yield own


@pytest.fixture(scope="module")
def panda(browser, tmp_path_factory):
    folder, asked = tmp_path_factory.mktemp("recordings"), []
    live = window("panda", folder, lock=["panda_finger_joint1"])
    with running(live), page(browser, live.url, asked) as own:
        own.wait_for_selector("text=certified at")
        assert until(live.server.get_clients)
        yield live, own, asked, folder


def test_a_target_is_dragged_and_the_hand_follows(panda):
    live, own, _, _ = panda
    target = live.session.targets[0]
    before = target.p.copy()
    own.wait_for_timeout(2000)
    gizmo = live.scene.gizmos[0]
    along = target.R[:, 1]  # the arrow that is seen from the side
    drag(own, live, before + 0.8 * gizmo.scale * along, before + 0.8 * gizmo.scale * along + 0.2 * along)
    moved = (target.p - before) @ along
    picture(own, "dragged")
    assert moved > 0.1
    assert np.linalg.norm(target.p - before - moved * along) < 1e-3
    tip = live.session.controller.robot.tip
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    assert until(lambda: np.linalg.norm(robot.at(live.session.q, np.zeros(7)).frame(tip).position - target.p) < 1e-3)


def test_a_target_is_typed_and_the_text_says_why_it_is_not_reached(panda):
    live, own, _, _ = panda
    own.get_by_role("tab", name="Targets").click()
    field = own.locator("input").filter(visible=True).nth(1)  # after the speed of time
    field.fill("1.4")
    field.press("Enter")
    assert until(lambda: live.session.targets[0].p[0] == pytest.approx(1.4))
    own.get_by_role("tab", name="Priorities").click()
    own.wait_for_selector("text=/position short by .* m\\/s: /")
    picture(own, "typed")


def test_levels_are_reordered_while_it_moves(panda):
    live, own, _, _ = panda
    own.get_by_role("tab", name="Priorities").click()
    own.get_by_role("button", name="▲").nth(2).click()
    own.wait_for_selector("text=1 orientation")
    assert [level[0].name for level in live.session.controller.stack.levels[1:3]] == ["orientation", "position"]
    own.wait_for_selector("text=orientation met")
    own.get_by_role("button", name="on/off").nth(3).click()
    own.wait_for_selector("text=3 posture (off)")
    assert len(live.session.controller.stack) == 3
    picture(own, "reordered")


def test_it_is_paused_recorded_and_saved(panda):
    live, own, _, folder = panda
    own.get_by_role("button", name="start").click()
    own.wait_for_selector("text=/recording, \\d+ ticks/")
    assert until(lambda: live.session.motion.recorded > 20)
    own.get_by_role("button", name="save data").click()
    assert until(lambda: (folder / "live-1.npz").exists())
    assert len(Record.load(folder / "live-1.npz")) > 20
    own.get_by_role("button", name="pause").click()
    own.wait_for_selector("text=paused")
    t = live.session.motion.t
    own.get_by_role("button", name="step").click()
    assert until(lambda: live.session.motion.t == pytest.approx(t + 0.01))


def test_joints_and_plots_are_shown(panda):
    _, own, _, _ = panda
    own.get_by_role("tab", name="Joints").click()
    own.get_by_text("panda_joint4", exact=True).wait_for()
    picture(own, "joints")
    own.get_by_role("tab", name="Plots").click()
    own.wait_for_selector("text=/joint velocities .* 10 s/")
    wide = "[...document.querySelectorAll('.uplot')].every(plot => plot.clientWidth > 300)"
    own.wait_for_function(wide)  # they are stretched to the panel by the next picture, which may take its time
    picture(own, "plots")


def test_no_request_leaves_the_machine(panda):
    live, own, asked, _ = panda
    assert own.get_by_text("Share").count() == 0
    assert {urlparse(url.removeprefix("blob:")).hostname for url in asked if not url.startswith("data:")} == {
        "127.0.0.1"
    }
    live.server.request_share_url()  # what a page of somebody else's might ask for
    assert live.server._share_tunnel is None


def test_a_humanoid_on_its_feet(browser, tmp_path):
    live = window("g1", tmp_path)
    with running(live), page(browser, live.url) as own:
        own.wait_for_selector("text=certified at")
        assert until(live.server.get_clients)
        hand = next(target for target in live.session.targets if target.name == "left hand")
        live.session.do(lambda: hand.move(p=hand.p + np.array([0.4, 0.0, 0.2])))
        own.wait_for_selector("text=/left hand/")
        own.wait_for_timeout(4000)
        picture(own, "humanoid")
        assert own.get_by_text("left foot").count() > 0
        feet = [target for target in live.session.targets if target.name in ("left foot", "right foot")]
        robot = live.session.controller.robot
        for foot, side in zip(feet, ("left", "right"), strict=True):
            there = robot.at(live.session.motion.q).frame(f"{side}_ankle_roll_link").position
            assert np.linalg.norm(there - foot.p) < 1e-3  # the hand is out of reach, and the feet stand


GEOMS = """<mujoco><asset><mesh name="wedge" vertex="0 0 0 .12 0 0 0 .12 0 0 0 .16"/></asset><worldbody>
<body name="base" pos="0 0 .1"><geom type="box" size=".15 .12 .1" rgba=".2 .3 .8 1"/>
  <body name="column" pos="0 0 .1"><joint name="pan" axis="0 0 1"/>
    <geom type="cylinder" size=".06" fromto="0 0 0 0 0 .4" rgba=".8 .2 .2 1"/>
    <body name="upper" pos="0 0 .45"><joint name="lift" axis="0 1 0"/>
      <geom type="capsule" size=".05" fromto="0 0 0 .4 0 0" rgba=".9 .7 .1 1"/>
      <body pos=".45 0 0"><joint name="elbow" axis="0 1 0"/><geom type="sphere" size=".07" rgba=".2 .7 .3 1"/>
        <geom type="ellipsoid" size=".2 .05 .03" pos=".25 0 0" rgba=".6 .2 .7 1"/>
        <body name="hand" pos=".5 0 0"><joint name="roll" axis="1 0 0"/>
          <geom type="mesh" mesh="wedge" rgba=".1 .7 .8 1"/><site name="tip" pos=".1 0 0"/>
</body></body></body></body></body></worldbody></mujoco>"""


def test_geoms_of_an_mjcf_are_seen_in_their_colours(browser, tmp_path):
    """Of every kind, on a body without a name too: by the hue of the pixels, whatever the light."""
    pytest.importorskip("mujoco")
    path = tmp_path / "geoms.xml"
    path.write_text(GEOMS)
    live = window(str(path), tmp_path, tip="tip", velocity_limit=2.0)
    live.session.targets[0].move(p=np.array([0.6, 0.3, 0.4]))
    with running(live), page(browser, live.url) as own:
        own.wait_for_selector("text=certified at")
        own.add_style_tag(content="[class*=Notifications-root] { display: none }")
        own.wait_for_timeout(12_000)  # the picture fades in
        picture(own, "geoms")
        shot = Image.open(BytesIO(own.locator("canvas").first.screenshot())).convert("HSV")
    hue, saturation, _ = np.asarray(shot).astype(int).reshape(-1, 3)[:, [0, 1, 2]].T
    for geom, degrees in {
        "box": 230, "cylinder": 0, "capsule": 45, "sphere": 132, "ellipsoid": 288, "mesh": 189,
    }.items():  # fmt: skip
        off = np.abs((hue * 360.0 / 255.0 - degrees + 180.0) % 360.0 - 180.0)
        assert np.sum((off < 12.0) & (saturation > 80)) > 60, geom


def test_a_saved_page_plays_from_a_file(browser, tmp_path):
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    record = simulate(ready_controller(robot, 0.02), robot.neutral, duration=1.0)
    record.save_html(tmp_path / "motion.html", rate=10)
    asked: list[str] = []
    with page(browser, (tmp_path / "motion.html").as_uri(), asked, (800, 600)) as own:
        own.wait_for_selector("canvas")
        own.wait_for_timeout(4000)
        picture(own, "page")
        assert {url.split(":")[0] for url in asked} <= {"file", "data", "blob"}
