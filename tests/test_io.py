"""A hierarchy in a file: it comes back to the last bit, whatever its numbers, and nothing else is taken for one."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hqp
from hqp import Hierarchy, InvalidInput, Level, Solver
from hqp.problems import FAMILIES, hierarchies

ARRAYS = ("A", "lower", "upper", "weights", "columns")


def example() -> Hierarchy:
    return Hierarchy(
        [
            Level.bounds([-1.0, -2.0, 0.0], [1.0, np.inf, 0.0], indices=[3, 0, 3], name="limits"),
            Level([[1.0, 2.0, 0.0, -0.0]], [-np.inf], [3.0], weights=[7.0], name="hand / \u03c6 \x00 \ud800"),
            Level(np.zeros((0, 4)), [], [], name="no rows"),
            Level.bounds([], [], indices=[], name="no bounds"),
            Level.equality(np.eye(4)[:2], [0.1 + 0.2, 5e-324]),
        ]
    )


def assert_same(one: Hierarchy, other: Hierarchy) -> None:
    assert one.structure == other.structure
    assert [level.name for level in one.levels] == [level.name for level in other.levels]
    for name in ARRAYS:
        mine, theirs = getattr(one, name), getattr(other, name)
        assert (mine.dtype, mine.shape, mine.tobytes()) == (theirs.dtype, theirs.shape, theirs.tobytes()), name


def test_a_hierarchy_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    h = example()
    assert hqp.save(tmp_path / "h.npz", h) is None
    again, x_ref = hqp.load(str(tmp_path / "h.npz"))
    assert_same(h, again)
    assert x_ref is None
    assert [path.name for path in tmp_path.iterdir()] == ["h.npz"]


@pytest.mark.parametrize("name", FAMILIES)
def test_every_family_comes_back(name: str, tmp_path: Path) -> None:
    for h in hierarchies(name, 5):
        hqp.save(tmp_path / "h.npz", h)
        assert_same(h, hqp.load(tmp_path / "h.npz")[0])


def test_numbers_that_a_solver_refuses_come_back(tmp_path: Path) -> None:
    h = example()
    (payload,) = struct.unpack("<d", struct.pack("<Q", 0x7FF8_0000_DEAD_BEEF))  # a NaN that says more
    h.A[0, 1], h.lower[1], h.upper[0] = payload, np.inf, -5.0
    h.weights[2:4] = np.nan, -1.0
    hqp.save(tmp_path / "h.npz", h, [payload, -0.0, np.inf, 1e-320])
    again, x_ref = hqp.load(tmp_path / "h.npz")
    assert_same(h, again)
    assert x_ref is not None
    assert x_ref.tobytes() == np.array([payload, -0.0, np.inf, 1e-320]).tobytes()
    assert Solver().solve(again).message == Solver().solve(h).message


@pytest.mark.parametrize(
    "h", [Hierarchy([], n=3), Hierarchy([Level(np.zeros((2, 0)), 0.0, 1.0)])], ids=["no levels", "n 0"]
)
def test_the_least_hierarchies_come_back(h: Hierarchy, tmp_path: Path) -> None:
    hqp.save(tmp_path / "h.npz", h)
    assert_same(h, hqp.load(tmp_path / "h.npz")[0])


def test_what_comes_back_is_a_hierarchy_to_work_with(tmp_path: Path) -> None:
    hqp.save(tmp_path / "h.npz", example(), np.ones(4))
    h, x_ref = hqp.load(tmp_path / "h.npz")
    h.levels[1].A[:] = 2.0
    h.levels[1].lower[:] = 1.0
    x_ref[0] = 2.0
    assert (h.A[0] == 2.0).all()
    assert Solver().solve(h, x_ref).certify().ok


def test_a_file_is_small_and_the_same_for_the_same_hierarchy(tmp_path: Path) -> None:
    h = Hierarchy([Level.bounds(-np.ones(40), np.ones(40)), Level.equality(np.eye(40), np.ones(40))])
    hqp.save(tmp_path / "a.npz", h)
    hqp.save(tmp_path / "b.npz", h)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert (tmp_path / "a.npz").stat().st_size < 3000 < h.A.nbytes


def test_numpy_can_read_it(tmp_path: Path) -> None:
    hqp.save(tmp_path / "h.npz", example())
    with np.load(tmp_path / "h.npz", allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["lower"], example().lower)
        assert json.loads(str(archive["head"]))["levels"][0] == {"name": "limits", "rows": 3, "bounds": True}


def test_a_save_that_fails_leaves_the_old_file_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hqp.save(tmp_path / "h.npz", example())

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np.lib.format, "write_array", full)
    with pytest.raises(InvalidInput, match=r"cannot write '.*h\.npz': No space left on device"):
        hqp.save(tmp_path / "h.npz", Hierarchy([], n=3))
    monkeypatch.undo()
    assert_same(example(), hqp.load(tmp_path / "h.npz")[0])
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((None,), "the hierarchy = None is a NoneType"),
        ((example(), [1.0]), r"x_ref has shape \(1,\); it must be \(4,\)"),
        ((example(), "near"), "x_ref is not an array of real numbers"),
    ],
)
def test_refuses_what_is_no_hierarchy_and_no_x_ref(arguments: tuple[Any, ...], said: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=said):
        hqp.save(tmp_path / "h.npz", *arguments)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", [None, 3, "", "."])
def test_refuses_what_is_no_name_of_a_file(path: Any) -> None:
    for call in (lambda: hqp.save(path, example()), lambda: hqp.load(path)):
        with pytest.raises(InvalidInput, match=r"path = .*must be the name of a file"):
            call()


def test_refuses_a_file_that_is_missing_or_a_folder(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"cannot read '.*h\.npz': No such file"):
        hqp.load(tmp_path / "h.npz")
    with pytest.raises(InvalidInput, match=r"cannot read .*: Is a directory"):
        hqp.load(tmp_path)


def test_refuses_what_is_no_npz(tmp_path: Path) -> None:
    path = tmp_path / "h.npz"
    for content in (b"", b"no archive", (np.arange(3.0)).tobytes()):
        path.write_bytes(content)
        with pytest.raises(
            InvalidInput, match=re.escape(f"{str(path)!r} is no hierarchy, or damaged: File is not a zip")
        ):
            hqp.load(path)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_refuses_a_file_that_is_cut_off(share: float, tmp_path: Path) -> None:
    path = tmp_path / "h.npz"
    hqp.save(path, example())
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InvalidInput, match=r"h\.npz' is no hierarchy, or damaged"):
        hqp.load(path)


def rewritten(path: Path, **changes: Any) -> None:
    """The file of the example with other arrays; None leaves one out, and a dict changes the head."""
    hqp.save(path, example(), np.zeros(4))
    with np.load(path) as archive:
        arrays = dict(archive)
    head = json.loads(str(arrays["head"])) | changes.pop("head", {})
    arrays["head"] = np.array(json.dumps({name: value for name, value in head.items() if value is not None}))
    arrays |= changes
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"head": {"format": "hqp hierarchy 2"}}, "its format is 'hqp hierarchy 2'; it must be 'hqp hierarchy 1'"),
        ({"head": {"format": None}}, "its format is None; it must be 'hqp hierarchy 1'"),
        ({"head": {"n": None}}, "its head does not tell n and the list of levels"),
        ({"head": {"n": -1}}, "its n = -1 must be an integer of at least 0"),
        ({"head": {"levels": 3}}, "its head does not tell n and the list of levels"),
        ({"head": {"levels": [{"name": "a"}]}}, "its head does not tell name, rows and bounds of level 0"),
        ({"head": {"levels": [{"name": 3, "rows": 1, "bounds": True}]}}, "name of level 0 = 3 is a int"),
        ({"head": {"levels": [{"name": "", "rows": 0.5, "bounds": True}]}}, "rows of level 0 = 0.5 must be an integer"),
        ({"head": {"levels": [{"name": "", "rows": 1, "bounds": 1}]}}, "bounds of level 0 = 1 must be True or False"),
        ({"head": {"n": 5}}, r"its array 'A' has shape \(3, 4\); it must be \(3, 5\)"),
        ({"A": None}, "it has no array 'A'"),
        ({"weights": None}, "it has no array 'weights'"),
        ({"lower": np.zeros(5)}, r"its array 'lower' has shape \(5,\); it must be \(6,\)"),
        ({"x_ref": np.zeros(3)}, r"its array 'x_ref' has shape \(3,\); it must be \(4,\)"),
        ({"columns": np.zeros(6)}, "its array 'columns' holds float64; it must hold integers"),
        ({"upper": np.array(["a"] * 6)}, "its array 'upper' holds <U1; it must hold floats"),
        ({"upper": np.array([{}] * 6)}, "Object arrays cannot be loaded"),
        (
            {"columns": np.array([4] * 3 + [-1] * 3)},
            r"level 0 \('limits'\), row 0: index 4, but the hierarchy has 4 unknowns",
        ),
        ({"columns": np.full(6, -2)}, "level 'limits', row 0: index -2 is negative"),
        ({"columns": np.arange(6) % 4}, "its columns of level 1, which has rows of its own, must be -1"),
    ],
)
def test_refuses_files_in_which_something_is_wrong_and_says_what(
    changes: dict[str, Any], said: str, tmp_path: Path
) -> None:
    path = tmp_path / "h.npz"
    rewritten(path, **changes)
    with pytest.raises(InvalidInput, match=re.escape(f"{str(path)!r} is no hierarchy, or damaged: ") + ".*" + said):
        hqp.load(path)


@pytest.mark.parametrize("labels", [None, "abc", {"a": 1}, ["xyz", "xyz", "xyz"], [["a", "b"]]], ids=str)
def test_refuses_labels_that_are_none_and_says_of_which_level(labels: Any, tmp_path: Path) -> None:
    path = tmp_path / "h.npz"
    hqp.save(path, Hierarchy([Level.equality(np.eye(3), 0.0)]))
    with np.load(path) as archive:
        arrays = dict(archive)
    head = json.loads(str(arrays["head"]))
    head["levels"][0]["labels"] = labels
    np.savez(path, **arrays | {"head": np.array(json.dumps(head))})
    with pytest.raises(InvalidInput, match="its head does not tell part, row and unit of every label of level 0"):
        hqp.load(path)


def test_x_ref_of_another_program_is_float64_whatever_its_kind_in_the_file(tmp_path: Path) -> None:
    for kind in (">f8", "f4", np.longdouble):
        rewritten(tmp_path / "h.npz", x_ref=np.arange(4.0).astype(kind))
        _, x_ref = hqp.load(tmp_path / "h.npz")
        assert x_ref is not None
        assert x_ref.dtype == np.float64
        assert x_ref.dtype.isnative
        np.testing.assert_array_equal(x_ref, np.arange(4.0))


@pytest.mark.parametrize(
    ("members", "said"),
    [
        ({"q": np.zeros(3)}, "it has no array 'head'"),
        ({"head": np.zeros(3)}, r"its array 'head' has shape \(3,\); it must be \(\)"),
        ({"head": np.array(3.0)}, "its array 'head' holds float64; it must hold text"),
        ({"head": np.array("[]")}, "its format is None"),
        ({"head": np.array("{")}, "Expecting property name"),
    ],
)
def test_refuses_files_of_other_things(members: dict[str, np.ndarray], said: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", **members)
    with pytest.raises(InvalidInput, match=f"is no hierarchy, or damaged: {said}"):
        hqp.load(tmp_path / "other.npz")
