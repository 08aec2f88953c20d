"""``hqp ik`` at the command: a place, the joints for it, and an exit code that tells whether they reach it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tasks.cli import run
from tasks.cli.ik import joined

pytest.importorskip("pinocchio")

PLACE = ["--position", "0.4", "-0.3", "0.3"]
URDF = """<robot name="post"><link name="a"/><link name="b"/>
<joint name="up" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="0" upper="0.5" velocity="1" effort="1"/></joint></robot>"""


def ik(*words: str) -> int:
    return run(["ik", *words])


def found(text: str) -> np.ndarray:
    match = re.search(r"^q = \[(.*)\]$", text, re.MULTILINE)
    assert match
    return np.array([float(number) for number in match[1].split(",")])


def test_what_is_reached_is_exit_code_0(capsys: pytest.CaptureFixture[str]) -> None:
    from tasks import load_robot

    assert ik("ur5", "--frame", "tool0", *PLACE, "--orientation", "3.14", "0", "0") == 0
    text = capsys.readouterr().out
    robot = load_robot("ur5")
    tip = robot.at(found(text), np.zeros(6)).frame("tool0")
    np.testing.assert_allclose(tip.position, [0.4, -0.3, 0.3], atol=1e-4)
    assert re.search(r"^position: \S+ mm away$", text, re.MULTILINE)
    assert re.search(r"^orientation: \S+ deg away$", text, re.MULTILINE)
    assert "position met (rank 3 of 3)\norientation met (rank 3 of 3)\n" in text
    assert re.search(r"^ shoulder_pan_joint +-?\d\.\d{4} +-6\.2832 +6\.2832 *$", text, re.MULTILINE)
    assert re.search(r"^reached after \d+ iterations$", text, re.MULTILINE)


def test_what_is_not_reached_is_exit_code_1_and_told_why(capsys: pytest.CaptureFixture[str]) -> None:
    assert ik("ur5", "--position", "3", "0", "0") == 1
    text = capsys.readouterr().out
    assert "position short by 2.05 m" in text
    assert "not reached" in text


def test_a_joint_at_its_limit_is_marked_and_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "post.urdf"
    file.write_text(URDF)
    assert ik(str(file), "--frame", "b", "--position", "0", "0", "0.2") == 0
    capsys.readouterr()
    assert ik(str(file), "--frame", "b", "--position", "0", "0", "0.7") == 1
    text = capsys.readouterr().out
    assert re.search(r"^ up +0\.5000 +0\.0000 +0\.5000 +at its upper limit", text, re.MULTILINE)
    assert "position: 200 mm away" in text
    assert "position is held back by up position limit (upper)" in text


def test_numbers_come_in_several_ways(capsys: pytest.CaptureFixture[str]) -> None:
    ways = [
        ["--position", "0.4", "-0.3", "0.3", "--orientation", "-1.5", "0", "0.5"],
        ["--position", "0.4,-0.3,0.3", "--orientation", "-1.5,0,0.5"],
        ["--position=0.4 -0.3 0.3", "--orientation=-1.5,0,0.5"],
    ]
    told = []
    for way in ways:
        assert ik("ur5", *way) == 0
        told.append(found(capsys.readouterr().out))
        np.testing.assert_array_equal(told[0], told[-1])
    assert ik(*ways[0], "ur5") == 0
    np.testing.assert_array_equal(told[0], found(capsys.readouterr().out))
    assert joined(["--orientation", "1", "2", "ur5"]) == ["--orientation=1,2", "ur5"]
    assert joined(["ur5", "--position"]) == ["ur5", "--position"]


def test_three_numbers_are_rpy_and_four_a_quaternion(capsys: pytest.CaptureFixture[str]) -> None:
    answers = []
    for numbers in ["1.5707963267948966", "0", "0"], ["0.5", "0", "0", "0.5"], ["7", "0", "0", "7"]:
        assert ik("ur5", *PLACE, "--orientation", *numbers) == 0
        answers.append(found(capsys.readouterr().out))
    np.testing.assert_allclose(answers[1:], [answers[0]] * 2, atol=1e-9)


def test_starts_and_seeds(capsys: pytest.CaptureFixture[str]) -> None:
    answers = {}
    for words in ["home"], ["neutral"], ["random"], ["random", "--seed", "1"]:
        assert ik("panda", "--position", "0.5", "0.1", "0.4", "--start", *words) == 0
        answers[tuple(words)] = found(capsys.readouterr().out)
        assert ik("panda", "--position", "0.5", "0.1", "0.4", "--start", *words) == 0
        np.testing.assert_array_equal(answers[tuple(words)], found(capsys.readouterr().out))
    assert len({tuple(q.round(6)) for q in answers.values()}) == 4


def test_a_base_floats_or_does_not(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["go2", "--frame", "FL_foot", "--position", "3", "0", "0.4", "--iterations", "60"]
    assert ik(*words) == 0
    assert len(found(capsys.readouterr().out)) == 19
    assert ik(*words, "--start", "random") == 0
    capsys.readouterr()
    assert ik(*words, "--base", "fixed") == 1
    assert len(found(capsys.readouterr().out)) == 12


def test_the_robot_is_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "deep" / "ur5.png"
    assert ik("ur5", *PLACE, "--orientation", "0", "0", "0", "--plot", str(picture)) == 0
    assert f"drawn: {picture}" in capsys.readouterr().out
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert ik("go2", "--frame", "FL_foot", "--position", "9", "0", "0", "--base", "fixed", "--plot", str(picture)) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["ur6", *PLACE], "unknown robot 'ur6'; did you mean 'ur5'"),
        (["none.urdf", *PLACE], "there is no file 'none.urdf'"),
        (["ur5", *PLACE, "--frame", "tol0"], "frame 'tol0' is no frame of PinocchioRobot('ur5', 6 degrees of freedom)"),
        (["ur5", *PLACE, "--frame", "tol0"], "did you mean 'tool0'?"),
        (["kinova", *PLACE], "has no tip; give the task a frame"),
        (["ur5", "--position", "0", "nan", "0"], "--position[1] = nan must be finite"),
        (["ur5", "--position", "0", "0", "inf"], "--position[2] = inf must be finite"),
        (["ur5", "--position", "0", "0"], "--position 0,0: 2 numbers; give 3 numbers, as in --position 0.5 0 0.4"),
        (["ur5", "--position", "0,0,0,0"], "--position 0,0,0,0: 4 numbers; give 3 numbers"),
        (["ur5", "--position", "left"], "--position left: 'left' is no number; give 3 numbers"),
        (["ur5", "--position", "0,0_1,0"], "--position 0,0_1,0: '0_1' is no number"),
        (["ur5", *PLACE, "--tolerance", "1_0"], "'1_0' is no number"),
        (["ur5", "--position"], "--position"),
        (["ur5"], "--position"),
        ([*PLACE], "ROBOT"),
        (["ur5", *PLACE, "--orientation", "1", "2"], "--orientation 1,2: 2 numbers; give 3 or 4 numbers"),
        (["ur5", *PLACE, "--orientation", "1", "2", "3", "4", "5"], "--orientation 1,2,3,4,5: 5 numbers; give 3 or 4"),
        (["ur5", *PLACE, "--orientation", "0", "0", "0", "0"], "quaternion (x, y, z, w) is zero"),
        (["ur5", *PLACE, "--orientation", "nan", "0", "0"], "--orientation[0] = nan must be finite"),
        (["ur5", *PLACE, "--start", "there"], "--start"),
        (["ur5", *PLACE, "--iterations", "0"], "--iterations"),
        (["ur5", *PLACE, "--seed", "-1"], "--seed"),
        (["ur5", *PLACE, "--tolerance", "-1"], "tolerance = -1.0 must be positive"),
        (["ur5", *PLACE, "--tolerance", "nan"], "tolerance = nan must be positive"),
        (["ur5", *PLACE, "--plot", ""], "it is empty"),
        (["ur5", *PLACE, "--plot", "a.jpg"], "'--plot': 'a.jpg'; a picture is called .png"),
        (["ur5", *PLACE, "--plot", "/dev/null/here/a.png"], "cannot write to the folder '/dev/null/here': "),
        (["ur5", *PLACE, "--plot", "."], "'.'; a picture is called .png"),
    ],
)
def test_wrong_input_is_one_line_and_exit_code_2(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ik(*words) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert said in told.err
    assert told.err.startswith("hqp: ")
    assert told.err.count("\n") == 1
