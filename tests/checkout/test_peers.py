"""Programs of Pink and mink that were written on this library run, and the page that translates leaves nothing out."""

from __future__ import annotations

import contextlib
import io
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from peers import lines, public_of_mink, public_of_pink

ROOT = Path(__file__).parents[2]
PROGRAMS = sorted((ROOT / "examples" / "peers").glob("[a-z]*.py"))
PAGE = ROOT / "docs" / "coming-from-pink-or-mink.md"
LIST = ROOT / "docs" / "ported-programs.md"
MOST_LINES = 60

#: What each must print, whatever the machine.
SAYS = {
    "arm_follows": "kinova 1.009 mm off in the last 2 s",
    "base_speed": "fastest [0.3 0.  0.  0.  0.  0. ], at the end 0.0e+00 m off",
    "flying_arms": "hands 0.679 mm off",
    "humanoid_squat": "centre of mass 0.147 mm off",
    "joint_speeds": "joint3 position or acceleration limit (upper)",
    "manipulability": "two links: elbow at 89.9 deg",
    "mobile_arm": "base stands: it goes 0.00 m, hand 0.00 mm off",
    "omniwheels": "wheels at most at 20.000 rad/s",
    "panda_live": "order now: joint limits, orientation, position, posture",
    "pendulums": "solve_ik: 5.500 rad",
    "quadruped_squat": "to 0.0000 m and up to 0.3500 m",
    "smooth_speeds": "accelerations up to 20.0 rad/s^2",
    "two_arms": "with it: arms at least 50.0 mm apart, hands 0.1 mm off at the end",
    "ur10_ik": "reached after 10 iterations",
    "wall": "gone from -0.4000 to 0.6000 m",
    "wheeled_biped": "steps 0.024 mm off",
}
NEEDS = {"panda_live": "viser", "two_arms": "mujoco"}


def test_every_program_is_expected():
    assert [path.stem for path in PROGRAMS] == sorted(SAYS)


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_program(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    assert len(path.read_text(encoding="utf-8").splitlines()) < MOST_LINES
    if path.stem in NEEDS:
        pytest.importorskip(NEEDS[path.stem])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(path)])
    monkeypatch.syspath_prepend(path.parent)  # where it looks if it runs alone
    runpy.run_path(str(path), run_name="__main__")
    assert SAYS[path.stem] in capsys.readouterr().out
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("library", "names"), [("pink", public_of_pink), ("mink", public_of_mink)])
def test_every_name_has_its_row(library, names):
    pytest.importorskip(library)
    rows = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    missing = [name for name in names() if not any(name in row for row in rows)]
    assert not missing


def test_the_list_names_every_program_and_its_length():
    text = LIST.read_text(encoding="utf-8")
    for path in PROGRAMS:
        assert f"`{path.stem}` {lines(path.read_text(encoding='utf-8'))}" in text


def blocks(language: str) -> list[tuple[str, str]]:
    """Blocks of the page in a language, each with the text below it."""
    parts = PAGE.read_text(encoding="utf-8").split("```")[1::2]
    follow = [*parts[1:], ""]
    return [
        (own.removeprefix(language + "\n"), after.removeprefix("text\n") if after.startswith("text\n") else "")
        for own, after in zip(parts, follow, strict=True)
        if own.startswith(language + "\n")
    ]


@pytest.mark.parametrize("library", ["pink", "mink"])
def test_an_object_of_theirs_in_a_stack(library):
    """The blocks of the page that need their packages: they print what is shown."""
    pytest.importorskip(library)
    own = [(code, shown) for code, shown in blocks("py") if f"import from_{library}" in code]
    assert own
    for code, shown in own:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(code, str(PAGE), "exec"), {})
        assert out.getvalue() == shown


@pytest.mark.parametrize("library", ["pink", "mink"])
def test_one_level_is_their_motion(library):
    """The first block of the page, beside the loop of their own: error and jerk to three digits."""
    pytest.importorskip(library)
    space: dict = {}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(compile(blocks("python")[0][0], str(PAGE), "exec"), space)
    theirs = {"pink": of_pink, "mink": of_mink}[library](space)
    np.testing.assert_allclose(space["measured"](theirs), space["measured"](space["motion"]), rtol=1e-3)
    assert np.abs(theirs - space["motion"]).max() < 1e-3


def of_pink(space: dict) -> np.ndarray:
    import pink
    import pinocchio as pin

    robot, dt, goal, rotation = (space[name] for name in ("robot", "dt", "goal", "rotation"))
    hand = pink.tasks.FrameTask(robot.tip, position_cost=1.0, orientation_cost=0.5, gain=0.05)
    posture = pink.tasks.PostureTask(cost=0.1, gain=0.01)
    posture.set_target(robot.home)
    configuration = pink.Configuration(robot.model, robot.model.createData(), robot.home)
    motion = [robot.home]
    for k in range(len(space["motion"]) - 1):
        hand.set_target(pin.SE3(rotation, goal(k * dt)))
        v = pink.solve_ik(configuration, [hand, posture], dt, solver="quadprog", damping=1e-4)
        configuration.integrate_inplace(v, dt)
        motion.append(configuration.q.copy())
    return np.array(motion)


def of_mink(space: dict) -> np.ndarray:
    import mink
    import mujoco

    robot, dt, goal, rotation = (space[name] for name in ("robot", "dt", "goal", "rotation"))
    model = mujoco.MjModel.from_xml_string(chain(robot))
    hand = mink.FrameTask("tip", "site", position_cost=1.0, orientation_cost=0.5, gain=0.05)
    posture = mink.PostureTask(model, cost=0.1, gain=0.01)
    posture.set_target(robot.home)
    configuration = mink.Configuration(model, robot.home)
    speeds = mink.VelocityLimit(model, dict(zip(robot.joint_names, SPEEDS, strict=True)))
    limits = [mink.ConfigurationLimit(model), speeds]
    motion = [robot.home]
    for k in range(len(space["motion"]) - 1):
        target = mink.SE3.from_rotation_and_translation(mink.SO3.from_matrix(rotation), goal(k * dt))
        hand.set_target(target)
        v = mink.solve_ik(configuration, [hand, posture], dt, "quadprog", damping=1e-4, limits=limits)
        configuration.integrate_inplace(v, dt)
        motion.append(configuration.q.copy())
    return np.array(motion)


SPEEDS = [2.175] * 4 + [2.61] * 3  # [rad/s]


def chain(robot) -> str:
    """An MJCF of an arm of Pinocchio: the same joints, places and ranges."""
    import pinocchio as pin

    def place(at: pin.SE3) -> str:
        x, y, z, w = pin.Quaternion(at.rotation).coeffs()
        return f'pos="{" ".join(map(repr, map(float, at.translation)))}" quat="{w} {x} {y} {z}"'

    text, model = "", robot.model
    for i in range(1, model.njoints):
        low, high = model.lowerPositionLimit[i - 1], model.upperPositionLimit[i - 1]
        text += f"<body {place(model.jointPlacements[i])}>"
        text += f'<joint name="{model.names[i]}" axis="0 0 1" range="{low} {high}"/><geom size="0.01"/>'
    tip = model.frames[model.getFrameId(robot.tip)].placement
    text += f'<site name="tip" {place(tip)}/>' + "</body>" * (model.njoints - 1)
    return f'<mujoco><compiler angle="radian" autolimits="true"/><worldbody>{text}</worldbody></mujoco>'
