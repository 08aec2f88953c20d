"""Libraries in interpreters of their own: they are asked for the same, and what happens to them is told."""

from __future__ import annotations

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio")

from benchmarks import strictness
from benchmarks.strictness import METHODS, STACKS, first_level, missed, optima
from benchmarks.teleoperation.setups import Elsewhere
from benchmarks.ticks import apart
from benchmarks.ticks.apart import MODULES, Apart, check_apart
from benchmarks.ticks.ours import Ours
from benchmarks.ticks.stream import Stream, record
from hqp import InvalidInput

APART = [method for method in METHODS if isinstance(method, Elsewhere)]
#: Goes to the posture of the tick, and has no answer at every third one; its joints are in reverse order.
PLAIN = """
import numpy as np
from joints import Joints

class Library(Joints):
    def __init__(self, scene, given, fails=3):
        self.columns, self.fails = [*range(len(scene["joints"]))][::-1], fails
        self.q, self.postures = (self.configured(given[name]) for name in ("q", "posture"))
        assert (given["low"] < given["high"]).all() and (given["speed"] > 0.0).all()

    def step(self, k):
        if k % self.fails == 1:
            raise RuntimeError("no answer")
        return None if k % self.fails == 2 else self.postures[k] - self.q[k]
"""


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> str:
    """The name of a library that needs nothing but NumPy."""
    there = tmp_path / "there"
    shutil.copytree(apart.SCRIPTS, there)
    (there / "on_plain.py").write_text(PLAIN)
    monkeypatch.setattr(apart, "SCRIPTS", there)
    return "plain"


@pytest.fixture(scope="module")
def stream() -> Stream:
    return record(STACKS[0], 12)


def test_answers_come_back_in_the_order_of_the_joints(plain: str, stream: Stream) -> None:
    driver = Apart(plain, sys.executable, stream, name="plain slow", fails=4)
    ns, v = driver.run(0, 8)
    parts = driver.split(0, 2)
    driver.close()
    home = stream.scene.posture_step / stream.scene.dt * (stream.robot.home - stream.q[:8])
    answered = np.arange(8) % 4 != 1
    answered &= np.arange(8) % 4 != 2
    np.testing.assert_allclose(v[answered], home[answered], atol=1e-9)
    assert np.isnan(v[~answered]).all()
    assert (ns > 0).all()
    assert np.isnan(parts).all()
    assert driver.name == "plain slow"


def test_no_answer_is_an_infinite_loss_and_resting_one_that_is_measured(plain: str, stream: Stream) -> None:
    ticks = np.arange(6)
    off = missed(Elsewhere(plain, python=sys.executable), stream, ticks, list(optima(stream, ticks)))
    assert np.isinf(off[ticks % 3 != 0]).all()
    assert np.isfinite(off[ticks % 3 == 0]).all()


def test_a_library_that_does_not_start_says_why(plain: str, stream: Stream) -> None:
    with pytest.raises(InvalidInput, match="nowhere: ModuleNotFoundError: No module named 'on_nowhere'"):
        Apart("nowhere", sys.executable, stream)
    with pytest.raises(InvalidInput, match="unexpected keyword argument 'colour'"):
        Apart(plain, sys.executable, stream, colour="red")


def test_each_has_a_row_or_the_option_that_gives_it_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strictness, "METHODS", tuple(APART))
    _, rows, left_out = strictness.strictness(1)
    assert not rows
    assert len(left_out) == len(APART)
    assert {method.library for method in APART} == set(MODULES)
    for method, why in zip(APART, left_out, strict=True):
        assert why == f"{method.name}: left out, name a Python that has it: --{method.library} PYTHON"


@pytest.mark.parametrize("method", APART, ids=lambda method: method.name)
def test_where_nothing_is_limited_all_agree(method: Elsewhere, stream: Stream) -> None:
    try:
        check_apart(method.library, sys.executable)
    except InvalidInput as error:
        pytest.skip(str(error))
    here, ticks = replace(method, python=sys.executable), np.arange(1, len(stream))
    best = list(optima(stream, ticks))
    assert missed(here, stream, ticks, best).max() < 1e-4
    assert missed(here, first_level(stream), ticks, best)[:, 0].max() < 1e-6
    ours, theirs = Ours(stream), here.driver(stream)
    (_, v), (_, w) = ours.run(1, len(stream)), theirs.run(1, len(stream))
    theirs.close()
    np.testing.assert_allclose(w, v, atol=1e-3)
