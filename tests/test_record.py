"""A record on disk: it comes back to the last bit, appears whole or not at all, and nothing else is taken for one."""

from __future__ import annotations

import dataclasses
import json
import re
import zipfile

import numpy as np
import pytest

from hqp import Hierarchy, InvalidInput, Level, Status, solve
from tasks import (
    Controller,
    JointAccelerationLimit,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    Record,
    simulate,
)
from tasks.simulation.account import MOST_TOLD, NEGLIGIBLE, Shortfall, account, shortfalls
from tasks.simulation.record import Stop

ARM = PlanarArm([0.5, 0.4, 0.3])
Q = np.array([0.3, 0.5, -0.4])


def run(**options):
    stack = (
        JointVelocityLimit(0.8) + JointAccelerationLimit(3.0)
        >> PositionTask([0.2, 0.7], gain=3.0, name="hand / \u03c6 \x00")
        >> OrientationTask(1.0, gain=1.0)
        >> OrientationTask(0.0, gain=1.0)
    )
    return simulate(Controller(ARM, stack, order="acceleration", dt=0.02), Q, duration=0.4, certify=5, **options)


@pytest.fixture(scope="module")
def record():
    return run()


def changed(record, **fields):
    return dataclasses.replace(record, **fields)


def assert_same(one, other):
    for field in dataclasses.fields(Record):
        if field.name == "robot":  # which no file holds
            continue
        mine, theirs = getattr(one, field.name), getattr(other, field.name)
        assert type(mine) is type(theirs), field.name
        if isinstance(mine, dict):
            assert list(mine) == list(theirs)
            pairs = list(zip(mine.values(), theirs.values(), strict=True))
        elif isinstance(mine, np.ndarray):
            pairs = [(mine, theirs)]
        else:
            assert mine == theirs
            continue
        for a, b in pairs:
            assert (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes()), field.name
            assert not b.flags.writeable


def test_a_record_comes_back_to_the_last_bit(record, tmp_path):
    record.save(tmp_path / "run.npz")
    assert_same(record, Record.load(str(tmp_path / "run.npz")))
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]


@pytest.mark.parametrize(
    "fields",
    [
        {"tau": None, "manipulability": None},
        {"errors": {}, "active": {}},
        {"stopped": Stop(0.1 + 0.2, "diverged at t = 0.3 s: \u03b1", diverged=True)},
        {"stopped": Stop(0.4, "failed", diverged=False)},
        {"status": (Status.FAILED, *[Status.OPTIMAL] * 18, Status.FAILED)},
        {"checked_t": np.zeros(0), "ranks": np.zeros((0, 4), dtype=np.int64), "shortfalls": (), "certified": 0},
        {"t": np.array([np.nan, -0.0, np.inf, 5e-324] + [1.0] * 17)},
    ],
    ids=lambda fields: "+".join(fields),
)
def test_all_that_a_record_can_be_comes_back(record, fields, tmp_path):
    other = changed(record, **fields)
    other.save(tmp_path / "run.npz")
    assert_same(other, Record.load(tmp_path / "run.npz"))


def test_a_run_that_was_stopped_before_it_began_comes_back(tmp_path):
    tick = Controller(ARM, JointVelocityLimit(1.0), dt=0.01, backend="pseudoinverse")
    record = simulate(tick, Q, duration=0.1)
    assert (len(record), record.stopped.diverged) == (0, False)
    record.save(tmp_path / "run.npz")
    assert_same(record, Record.load(tmp_path / "run.npz"))


def test_numpy_can_read_it(record, tmp_path):
    record.save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz", allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["q"], record.q)


def test_saving_again_takes_the_place_of_the_old(record, tmp_path):
    record.save(tmp_path / "run.npz")
    changed(record, certified=0).save(tmp_path / "run.npz")
    assert Record.load(tmp_path / "run.npz").certified == 0
    assert len(list(tmp_path.iterdir())) == 1


def test_a_save_that_fails_leaves_the_old_file_alone(record, tmp_path):
    record.save(tmp_path / "run.npz")
    with pytest.raises(InvalidInput, match=r"cannot write '.*run\.npz'"):
        changed(record, q=np.array([object()])).save(tmp_path / "run.npz")
    assert_same(record, Record.load(tmp_path / "run.npz"))
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("place", ["missing/run.npz", "file/run.npz", "folder", "run\x00.npz"])
def test_refuses_places_that_cannot_be_written(record, tmp_path, place):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidInput, match="cannot write"):
        record.save(tmp_path / place)
    assert {path.name for path in tmp_path.iterdir()} == {"folder", "file"}


@pytest.mark.parametrize("path", [None, 3, "", ".", "/"])
def test_refuses_what_is_no_name_of_a_file(record, path):
    with pytest.raises(InvalidInput, match=r"path = .*must be the name of a file"):
        record.save(path)
    with pytest.raises(InvalidInput, match=r"path = .*must be the name of a file"):
        Record.load(path)


def test_refuses_a_file_that_is_missing(tmp_path):
    with pytest.raises(InvalidInput, match=r"cannot read '.*run\.npz': No such file"):
        Record.load(tmp_path / "run.npz")


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_refuses_a_file_that_is_cut_off(record, tmp_path, share):
    path = tmp_path / "run.npz"
    record.save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InvalidInput, match=re.escape(f"{str(path)!r} is no record, or damaged")):
        Record.load(path)


def test_refuses_arrays_that_are_no_record_and_says_what_is_missing(tmp_path):
    path = tmp_path / "run.npz"
    np.savez(path, q=np.zeros(3))
    with pytest.raises(InvalidInput, match="is no record, or damaged: it has no 'head'"):
        Record.load(path)


def test_refuses_a_file_with_a_wrong_bit(record, tmp_path):
    path = tmp_path / "run.npz"
    record.save(path)
    data = bytearray(path.read_bytes())
    data[data.index(record.q.tobytes()) + 7] ^= 1
    path.write_bytes(data)
    with pytest.raises(InvalidInput, match="is no record, or damaged"):
        Record.load(path)


@pytest.mark.parametrize(
    "members",
    [
        {"q": np.zeros(3)},
        {"head": np.zeros(3)},
        {"head": np.array("{}")},
        {"head": np.array({}, dtype=object)},
    ],
    ids=["an array", "a head of numbers", "an empty head", "a pickle"],
)
def test_refuses_files_of_other_things(members, tmp_path):
    np.savez(tmp_path / "other.npz", **members)
    with pytest.raises(InvalidInput, match="is no record, or damaged"):
        Record.load(tmp_path / "other.npz")


def test_refuses_records_of_another_format(tmp_path):
    np.savez(tmp_path / "old.npz", head=np.array(json.dumps({"format": "hqp record 0"})))
    with pytest.raises(InvalidInput, match=r"no record.*: its format is 'hqp record 0'; it must be 'hqp record 3'"):
        Record.load(tmp_path / "old.npz")


def test_refuses_a_record_that_lacks_something(record, tmp_path):
    record.save(tmp_path / "run.npz")
    with zipfile.ZipFile(tmp_path / "run.npz") as archive, zipfile.ZipFile(tmp_path / "less.npz", "w") as less:
        for name in archive.namelist():
            if name != "q.npy":
                less.writestr(name, archive.read(name))
    with pytest.raises(InvalidInput, match="is no record, or damaged"):
        Record.load(tmp_path / "less.npz")


@pytest.mark.parametrize("name", ["t", "q", "v", "a", "tau", "pose", "manipulability", "status", "ranks", "checked_t"])
def test_refuses_arrays_of_different_motions(record, tmp_path, name):
    path = tmp_path / "run.npz"
    record.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    for other in arrays[name][:-1], np.concatenate([arrays[name], arrays[name][-1:]]):
        np.savez(path, **(arrays | {name: other}))
        with pytest.raises(InvalidInput, match=r"entries; it must have \d+, one a|certified = \d+, but"):
            Record.load(path)


@pytest.mark.parametrize("field", ["errors 0", "active 0"])
def test_refuses_errors_and_sides_of_another_motion(record, tmp_path, field):
    path = tmp_path / "run.npz"
    record.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **(arrays | {field: arrays[field][1:]}))
    with pytest.raises(InvalidInput, match=rf"{field.split()[0]} of '.*' has \d+ entries; it must have"):
        Record.load(path)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("certified", 10_000, "certified = 10000, but"),
        ("unknowns", "7", "unknowns = '7' must be an integer"),
        ("unknowns", -5, "unknowns = -5 must be an integer"),
        ("shortfalls", [], "shortfalls has 0 entries"),
    ],
)
def test_refuses_counts_that_no_motion_has(record, tmp_path, key, value, said):
    path = tmp_path / "run.npz"
    record.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    arrays["head"] = np.array(json.dumps(json.loads(str(arrays["head"])) | {key: value}))
    np.savez(path, **arrays)
    with pytest.raises(InvalidInput, match=said):
        Record.load(path)


def test_a_device_is_no_file(record, tmp_path):
    """As root, a file put in the place of a device would replace it."""
    for call in (record.save, Record.load):
        with pytest.raises(InvalidInput, match="path = '/dev/null' is a device; it must be a file"):
            call("/dev/null")
    link = tmp_path / "link.npz"
    link.symlink_to(tmp_path / "file.npz")
    record.save(link)
    assert link.is_symlink()
    assert len(Record.load(tmp_path / "file.npz")) == len(record)


# The whole motion in a few lines.


def test_an_account_tells_which_level_was_short_from_when_to_when_and_held_by_what(record):
    told = record.explain()
    short = {stretch.level for stretch in told.stretches}
    assert "orientation + orientation" not in short
    for stretch in told.stretches:
        assert record.checked_t[0] <= stretch.begin <= stretch.end <= record.checked_t[-1]
        assert all(norm > 0.0 for norm in stretch.most.values())
    lines = str(told).splitlines()
    assert (
        lines[0]
        == f"t = 0 .. {record.checked_t[-1]:g} s, {record.certified} of {record.checked} checked ticks certified"
    )
    levels = {stretch.level: sum(each.level == stretch.level for each in told.stretches) for stretch in told.stretches}
    assert len(lines) == 1 + sum(min(number, MOST_TOLD + 1) for number in levels.values())


def test_an_account_is_short_however_often_a_level_is():
    """The worst stretches have their lines; one line has the number, the times and the most of all others."""
    sizes = [3e-5, 0.2, 1e-6, 0.5, 2e-4, 0.1, 4e-5, 0.3]
    met_between = [size for each in sizes for size in (each, None)]
    ticks = [[] if size is None else [Shortfall("hand", {"m/s": size}, ("damping",))] for size in met_between]
    told = account(np.arange(len(ticks)) * 0.1, ticks, len(ticks), None)
    assert [stretch.most["m/s"] for stretch in told.stretches] == sizes
    lines = str(told).splitlines()[1:]
    assert len(lines) == MOST_TOLD + 1
    for line, words in zip(lines, ("from 0 to 1.2 s, by at most 0.1", "at 0.2 s", "at 0.6 s", "at 1.4 s"), strict=True):
        assert words in line
    assert "5 other times" in lines[0]


@pytest.mark.parametrize(("missing", "told"), [(0.5 * NEGLIGIBLE, []), (2.0 * NEGLIGIBLE, ["reach"])])
def test_a_level_that_lacks_no_more_than_damping_leaves_is_met(missing, told):
    limit = Level.bounds([-1.0], [1.0], name="limit")
    solution = solve(Hierarchy([limit, Level.equality([[1.0]], [1.0 + missing], name="reach")]))
    assert solution.levels[1].residual_norm == pytest.approx(missing)
    assert [short.level for short in shortfalls(solution)] == told


def test_a_motion_that_lacks_nothing_says_so_and_one_that_was_not_checked_too():
    easy = Controller(ARM, OrientationTask(0.3, gain=1.0), dt=0.02)
    assert str(simulate(easy, Q, duration=0.2, certify=5).explain()).endswith("\nall levels met")
    assert "no tick was checked" in str(simulate(easy, Q, duration=0.2, certify=0).explain())


def test_an_account_comes_back_from_a_file(record, tmp_path):
    record.save(tmp_path / "run.npz")
    assert record.explain() == Record.load(tmp_path / "run.npz").explain()


def test_files_of_the_format_before_are_read_and_have_no_account(record, tmp_path):
    record.save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as archive:
        arrays = dict(archive)
    head = json.loads(str(arrays["head"]))
    del head["shortfalls"]
    arrays["head"] = np.array(json.dumps(head | {"format": "hqp record 1"}))
    np.savez(tmp_path / "old.npz", **arrays)
    old = Record.load(tmp_path / "old.npz")
    np.testing.assert_array_equal(old.q, record.q)
    with pytest.raises(InvalidInput, match="'hqp record 1' does not say"):
        old.explain()


def test_a_motion_becomes_a_page(record, tmp_path):
    pytest.importorskip("viser")
    record.save_html(tmp_path / "run.html", rate=10)
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert "__VISER_EMBED_DATA__" in page
    loaded = changed(record, robot=None)
    with pytest.raises(InvalidInput, match="give save_html the robot"):
        loaded.save_html(tmp_path / "other.html")
    with pytest.raises(InvalidInput, match=r"the robot takes \(states, 2\)"):
        loaded.save_html(tmp_path / "other.html", robot=PlanarArm([0.5, 0.5]))
    with pytest.raises(InvalidInput, match="rate"):
        record.save_html(tmp_path / "other.html", rate=0.0)
    with pytest.raises(InvalidInput, match="at most 240"):
        record.save_html(tmp_path / "other.html", rate=1e9)
    with pytest.raises(InvalidInput, match=r"other\.png'; a page is called \.html or \.htm"):
        record.save_html(tmp_path / "other.png")
    assert not (tmp_path / "other.png").exists()
    assert not (tmp_path / "other.html").exists()
