"""Hierarchies in the text format of LexLS: the same problem comes back, and what is malformed is named by its line."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hqp
from hqp import Hierarchy, InvalidInput, Label, Level, Side, certify, lexls, solve
from hqp.lexls import as_lexls
from hqp.problems import random_hierarchy

#: By hand, in the manner of the test problems of LexLS.
FILE = """\
# Exported by hand

#HierType
210
#nVar
3

#nObj
3
#nCtr
2 2 1
#ObjType
100 200 200

#OBJECTIVE 0
 3 -1 1 0
 1 0.5 0.5 3

#OBJECTIVE 1 "hand"
 1 1 0 -1000000000000 1 2
 0 1 -1 0 0 3

#OBJECTIVE 2
 1 0 0 2 1e31 1

#SolGuess
 0.25
 0
 -.5e-1
#Solution
 0.5 0.5 0.5
"""

SEEDS = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("lexls") / "h.dat"


def random_one(seed: int, weighted: bool = True) -> Hierarchy:
    h = random_hierarchy(np.random.default_rng(seed))
    if not weighted:
        h.weights[:] = 1.0
    return h


def assert_same(one: Hierarchy, other: Hierarchy) -> None:
    assert one.structure == other.structure
    assert one.numbers.tobytes() == other.numbers.tobytes()
    assert [level.name for level in one.levels] == [level.name for level in other.levels]


def residuals(h: Hierarchy, x: np.ndarray) -> list[float]:
    return [level.residual_norm for level in certify(h, x).levels]


@given(SEEDS)
def test_numbers_and_names_come_back_to_the_last_bit(file: Path, seed: int) -> None:
    h = random_one(seed, weighted=False)
    lexls.write(file, h)
    again = lexls.read(file).hierarchy
    assert_same(again, as_lexls(h))
    assert again.pointers == h.pointers
    for name in "lower", "upper":
        assert getattr(again, name).tobytes() == getattr(h, name).tobytes()
    assert again.dense().tobytes() == h.dense().tobytes()


@given(SEEDS)
def test_weights_bounds_and_all_it_is_the_same_problem(file: Path, seed: int) -> None:
    h = random_one(seed)
    lexls.write(file, h)
    again = lexls.read(file).hierarchy
    x = solve(h).x
    assert certify(again, x).ok
    assert certify(h, solve(again).x).ok
    np.testing.assert_allclose(residuals(again, x), residuals(h, x), rtol=1e-12, atol=1e-12 * (1.0 + abs(x).max()))


@given(SEEDS)
def test_x_ref_becomes_one_more_level(file: Path, seed: int) -> None:
    h = random_one(seed)
    x_ref = np.random.default_rng(seed).standard_normal(h.n)
    lexls.write(file, h, x_ref, guess=np.zeros(h.m, dtype=int))
    problem = lexls.read(file)
    assert len(problem.hierarchy.levels) == len(h.levels) + 1
    assert (problem.guess[h.m :] == Side.EQUALITY).all()
    assert certify(problem.hierarchy, solve(h, x_ref=x_ref).x, np.full(h.n, 7.0)).ok  # no other x_ref matters


@given(SEEDS)
def test_guess_and_points_come_back_to_the_last_bit(file: Path, seed: int) -> None:
    h = random_one(seed)
    solution = solve(h)
    sides, start = np.concatenate([level.active for level in solution.levels]), np.random.default_rng(seed).random(h.n)
    lexls.write(file, h, guess=sides, solution_guess=start, solution=solution.x)
    problem = lexls.read(file)
    assert problem.guess.tolist() == sides.tolist()
    assert problem.solution_guess.tobytes() == start.tobytes()
    assert problem.solution.tobytes() == solution.x.tobytes()


def test_the_first_level_keeps_its_bounds_if_the_format_can_hold_them(file: Path) -> None:
    plain = Level.bounds([-1.0, -np.inf], [np.inf, 2.0], indices=[4, 0])
    weighted = Level.bounds([-1.0, 0.0], [1.0, 2.0], indices=[4, 0], weights=[1.0, 3.0])
    twice = Level.bounds([-1.0, 0.0], [1.0, 2.0], indices=[4, 4])
    for levels, kept in ([plain, plain], 1), ([weighted], 0), ([twice], 0):
        lexls.write(file, Hierarchy(levels, n=5))
        again = lexls.read(file).hierarchy
        assert [level.indices is not None for level in again.levels] == [k < kept for k in range(len(levels))]
    assert again.A.tolist() == [[0.0, 0.0, 0.0, 0.0, 1.0]] * 2


@pytest.mark.parametrize(
    ("lower", "upper", "kind"),
    [([1.0, 0.0], [1.0, 0.0], 100), ([1.0, -0.0], [1.0, 0.0], 200), ([-np.inf, 5e-324], [-1e30, np.inf], 200)],
)
def test_equalities_are_written_once_and_infinity_in_no_word(
    lower: list[float], upper: list[float], kind: int, file: Path
) -> None:
    h = Hierarchy([Level([[0.1 + 0.2], [-0.0]], lower, upper)])
    lexls.write(file, h)
    text = file.read_text(encoding="ascii")
    assert f"#HierType\n{kind}\n" in text
    assert not re.search(r"^[^#]*inf", text, re.MULTILINE)
    assert_same(lexls.read(file).hierarchy, h)


@given(SEEDS)
def test_a_file_is_laid_out_as_lexls_reads_it(file: Path, seed: int) -> None:
    """Its reader wants fields alone on their line, the rows right below, and passes over the line after the rows."""
    h = random_one(seed)
    lexls.write(file, h, solution=np.zeros(h.n))
    lines = file.read_text().split("\n")
    assert [line for line in lines if line.startswith("#") and " " not in line][-1] == "#Solution"
    for k, level in enumerate(h.levels):
        (start,) = (i for i, line in enumerate(lines) if line.startswith(f"#OBJECTIVE {k}"))
        rows = lines[start + 1 : start + 1 + len(level)]
        assert lines[start - 1] == lines[start + 1 + len(level)] == ""
        assert len({len(row.split()) for row in rows}) <= 1
        assert all(rows)


@pytest.mark.parametrize("name", ["", "limits", "hand / \u03c6 \x00 \ud800", 'a "quoted"\n#nVar', " 7 ", "\u2028"])
def test_names_come_back(name: str, file: Path) -> None:
    lexls.write(file, Hierarchy([Level([[1.0]], 0.0, 1.0, name=name)]))
    assert lexls.read(file).hierarchy.levels[0].name == name


def read(text: str | bytes, file: Path) -> hqp.lexls.Problem:
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return lexls.read(file)


def test_a_file_by_hand(file: Path) -> None:
    problem = read(FILE, file)
    h = problem.hierarchy
    expected = Hierarchy(
        [
            Level.bounds([-1.0, 0.5], [1.0, 0.5], indices=[2, 0]),
            Level([[1, 1, 0], [0, 1, -1]], [-1e12, 0], [1, 0], name="hand"),
            Level([[1, 0, 0]], [2], [np.inf]),
        ]
    )
    assert_same(h, expected)
    assert problem.guess.tolist() == [Side.INACTIVE, Side.EQUALITY, Side.UPPER, Side.EQUALITY, Side.LOWER]
    assert problem.solution_guess.tolist() == [0.25, 0.0, -0.05]
    assert problem.solution.tolist() == [0.5, 0.5, 0.5]
    assert solve(h).x.round(9).tolist() == [0.5, 0.0, 0.0]
    assert not certify(h, problem.solution).ok
    assert certify(h, problem.solution, unique=False).ok


def test_equalities_by_hand(file: Path) -> None:
    text = "#nObj\n2\n#nCtr\n1 1\n#HierType\n100\n#ObjType\n100 200\n#nVar\n2\n#OBJECTIVE\n2 -3\n#OBJECTIVE\n1 1 4"
    problem = read(text, file)
    assert_same(
        problem.hierarchy, Hierarchy([Level.bounds([-3], [-3], indices=[1]), Level.equality([[1, 1]], [4])], n=2)
    )
    assert (problem.guess, problem.solution_guess, problem.solution) == (None, None, None)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", " \t\n\n"),
        lambda text: text.replace("\n", "\n# in between\n"),
        lambda text: text.replace(" 1 1 0 ", " 1.0e0 +1. 0 ").replace("1 2\n", "1 2  # pushes\n"),
        lambda text: text.replace("#nVar\n3\n", "").replace("#OBJECTIVE 0", "# n Var\n3\n# OBJECTIVE 0"),
        lambda text: text.replace("1e31", "inf").replace("\n 0\n -.5e-1", " 0 -.5e-1"),
        lambda text: text.replace("1e31", "1e999").replace("#OBJECTIVE 2", "#OBJECTIVE2"),
        lambda text: "\ufeff" + text.replace('"hand"', "hand").rstrip(),
    ],
)
def test_what_is_harmless_changes_nothing(change: Any, file: Path) -> None:
    plain, changed = read(FILE, file), read(change(FILE), file)
    assert_same(plain.hierarchy, changed.hierarchy)
    assert plain.guess.tolist() == changed.guess.tolist()
    assert plain.solution_guess.tolist() == changed.solution_guess.tolist()


def replaced(number: int, line: str | None) -> bytes:
    """The file by hand with another line of that number, or without it."""
    lines = FILE.splitlines()
    lines[number - 1 : number] = [] if line is None else [line]
    return "\n".join(lines).encode("utf-8", "surrogateescape")


@pytest.mark.parametrize(
    ("number", "line", "said"),
    [
        # the header
        (1, "Exported by hand", "line 1: found 'Exported by hand'; expected one of the fields #HierType, #nVar, #nObj"),
        (3, None, "line 3: found '210'; expected one of the fields"),
        (3, "#Hiertype", "line 4: found '210'; expected one of the fields"),
        (3, "#nVar", "line 5: found #nVar again; expected it once, as on line 4"),
        (4, None, "line 4: found '#nVar'; expected the numbers of #HierType"),
        (4, "201", "line 4: found #HierType 201; expected 100 or 200 or 210"),
        (4, "210 210", "line 4: found numbers of #HierType: 2; expected 1"),
        (5, "# 3 unknowns", "line 6: found '3'; expected a field or #OBJECTIVE 0: #HierType is complete"),
        (6, "three", "line 6: found 'three'; expected #nVar in whole numbers"),
        (6, "3.0", "line 6: found '3.0'; expected #nVar in whole numbers"),
        (6, "-3", "line 6: found '-3'; expected #nVar in whole numbers"),
        (6, "\u0663", "line 6: found '\u0663'; expected #nVar in whole numbers"),
        (6, "3" * 5000, "expected #nVar in whole numbers"),
        (6, "4000000000", "line 6: found '4000000000'; expected #nVar in whole numbers"),
        (6, "2", "line 16: found '3'; expected the number of a variable, from 1 to 2"),
        (6, "4", "line 20: found a row of 6; expected one of 7: 4 of A, lower, upper, activation"),
        (9, "0", "line 9: found #nObj 0; expected at least 1"),
        (9, "2", "line 11: found numbers of #nCtr: 3; expected 2"),
        (11, "2 2", "line 11: found numbers of #nCtr: 2; expected 3"),
        (11, "1 2 1", "line 17: found '1 0.5 0.5 3'; expected a field: objective 0 is complete with #nCtr 1"),
        (11, "3 2 1", "line 19: found '#OBJECTIVE 1 \"hand\"'; expected row 2 of the 3 of objective 0"),
        (11, "2 2 9999999999", "line 11: found '9999999999'; expected #nCtr in whole numbers"),
        (12, "# types", "line 13: found '100 200 200'; expected a field or #OBJECTIVE 0: #nCtr is complete"),
        (13, "100 200", "line 13: found numbers of #ObjType: 2; expected 3"),
        (13, "100 300 200", "line 13: found #ObjType 300; expected 100 or 200"),
        (
            13,
            "100 200 100",
            "line 13: found #ObjType 100 for objective 2; expected 200: only objective 0 may be bounds",
        ),
        (14, "#nVar", "line 14: found #nVar again; expected it once, as on line 6"),
        # the rows
        (15, None, "line 15: found '3 -1 1 0'; expected a field or #OBJECTIVE 0: #ObjType is complete"),
        (15, "#OBJECTIVE 1", "line 15: found '#OBJECTIVE 1'; expected #OBJECTIVE 0"),
        (15, "#Solution", "line 15: found '#Solution'; expected #OBJECTIVE 0"),
        (16, "0 -1 1 0", "line 16: found '0'; expected the number of a variable, from 1 to 3"),
        (16, "4 -1 1 0", "line 16: found '4'; expected the number of a variable, from 1 to 3"),
        (16, "1.5 -1 1 0", "line 16: found '1.5'; expected the number of a variable, from 1 to 3"),
        (17, "3 -1 1 0", "line 17: found variable 3 again; expected it once, as on line 16"),
        (
            16,
            "3 -1 1",
            "line 16: found a row of 3; expected one of 4: the number of a variable, lower, upper, activation",
        ),
        (16, "3 -1 1 0 0", "line 16: found a row of 5; expected one of 4"),
        (16, "3 1 -1 0", "line 16: found lower = 1.0 and upper = -1.0; expected lower at most upper, lower below inf"),
        (
            16,
            "3 inf inf 0",
            "line 16: found lower = inf and upper = inf; expected lower at most upper, lower below inf",
        ),
        (16, "3 -inf -1e31 0", "line 16: found lower = -inf and upper = -inf; expected lower at most upper"),
        (16, "3 nan 1 0", "line 16: found lower = 'nan'; expected a number, or inf or -inf"),
        (16, "3 -1 one 0", "line 16: found upper = 'one'; expected a number, or inf or -inf"),
        (16, "3 -1 1 4", "line 16: found '4'; expected activation 0, 1, 2 or 3"),
        (16, "3 -1 1 1.0", "line 16: found '1.0'; expected activation 0, 1, 2 or 3"),
        (19, '#OBJECTIVE 1 "hand', "line 19: found the name '\"hand'; expected a string of JSON"),
        (20, "1 1 x -1 1 2", "line 20: found A[2] = 'x'; expected a finite number of at most 1e+30 in size"),
        (20, "1 1_0 0 -1 1 2", "line 20: found A[1] = '1_0'; expected a finite number"),
        (20, "1 inf 0 -1 1 2", "line 20: found A[1] = 'inf'; expected a finite number"),
        (20, "1 nan 0 -1 1 2", "line 20: found A[1] = 'nan'; expected a finite number"),
        (20, "1 2e30 0 -1 1 2", "line 20: found A[1] = '2e30'; expected a finite number of at most 1e+30"),
        (20, "1 0x10 0 -1 1 2", "line 20: found A[1] = '0x10'; expected a finite number"),
        (20, f"1 {'1' * 9999}x 0 -1 1 2", "line 20: found A[1] = '111"),
        (20, "1 1 0 -1 1", "line 20: found a row of 5; expected one of 6: 3 of A, lower, upper, activation"),
        (20, None, "line 22: found '#OBJECTIVE 2'; expected row 1 of the 2 of objective 1"),
        (20, "\x00\x01\x02", "line 20: found a row of 1; expected one of 6"),
        (20, "1 \udcff", "line 20: found the byte 0xff; expected UTF-8 text"),
        (23, "#OBJECTIVE 1", "line 23: found '#OBJECTIVE 1'; expected #OBJECTIVE 2"),
        (23, "#SolGuess", "line 23: found '#SolGuess'; expected #OBJECTIVE 2"),
        # what comes after them
        (26, "#OBJECTIVE 3", "line 26: found '#OBJECTIVE 3'; expected #SolGuess or #Solution or the end of the file"),
        (26, "#nVar", "line 26: found '#nVar'; expected #SolGuess or #Solution or the end of the file"),
        (26, None, "line 26: found '0.25'; expected a field: objective 2 is complete with #nCtr 1"),
        (27, None, "line 29: found '#Solution'; expected number 2 of the 3 of #SolGuess"),
        (28, "0 0 0", "line 28: found numbers of #SolGuess: 4; expected 3"),
        (
            28,
            "0 0",
            "line 29: found '-.5e-1'; expected a field or the end of the file: #SolGuess is complete with #nVar 3",
        ),
        (28, "nan", "line 28: found x[1] = 'nan'; expected a finite number"),
        (30, "#SolGuess", "line 30: found '#SolGuess'; expected #Solution or the end of the file"),
        (31, None, "line 30: found the end of the file; expected number 0 of the 3 of #Solution"),
        (31, "1 1", "line 31: found the end of the file; expected number 2 of the 3 of #Solution"),
    ],
)
def test_a_malformed_file_is_refused_by_line_with_what_is_there_and_what_should_be(
    number: int, line: str | None, said: str, file: Path
) -> None:
    with pytest.raises(InvalidInput) as refusal:
        read(replaced(number, line), file)
    assert str(refusal.value).startswith(f"{str(file)!r} is no hierarchy, or damaged: line ")
    assert said in str(refusal.value)
    assert len(str(refusal.value)) < 300


@pytest.mark.parametrize("field", ["#HierType", "#nVar", "#nObj", "#nCtr", "#ObjType"])
def test_a_header_that_lacks_a_field_is_refused(field: str, file: Path) -> None:
    text = re.sub(rf"{field}\n.*\n", "", FILE)
    with pytest.raises(InvalidInput, match=rf"line 13: found '#OBJECTIVE 0'; expected {field} before it"):
        read(text, file)


def test_a_file_that_is_cut_off_is_refused_unless_only_a_point_is_missing(file: Path) -> None:
    lines = FILE.splitlines(keepends=True)
    for count in range(len(lines)):
        whole = count in (24, 25, 29)  # complete after the rows, and after #SolGuess
        if whole:
            read("".join(lines[:count]), file)
            continue
        with pytest.raises(InvalidInput, match=rf"line {count}: found the end of the file; expected "):
            read("".join(lines[:count]), file)


@pytest.mark.parametrize("content", [b"", b"\x7fELF\x02\x01", bytes(range(256)) * 9, "\u2028#nVar".encode("utf-16")])
def test_rubbish_is_refused_by_line(content: bytes, file: Path) -> None:
    with pytest.raises(InvalidInput, match=r"line \d+: found "):
        read(content, file)


@given(st.data())
def test_no_change_of_a_file_raises_anything_else(file: Path, data: st.DataObject) -> None:
    content = bytearray(FILE.encode())
    for _ in range(data.draw(st.integers(1, 4), "changes")):
        place = data.draw(st.integers(0, len(content)), "place")
        length = data.draw(st.integers(0, 6), "length")
        words = [
            b"",
            b"\n",
            b"#",
            b" 0",
            b"-",
            b"9",
            b"e9",
            b"nan",
            b"#nVar\n",
            b"#OBJECTIVE 1\n",
            b"\xff",
            b'"',
            b"\0",
        ]
        content[place : place + length] = data.draw(st.sampled_from(words) | st.binary(max_size=4), "instead")
    said = ""
    try:
        assert read(bytes(content), file).hierarchy.find_fault() is None
    except InvalidInput as refusal:
        said = str(refusal)
    assert not said or re.search(r"damaged: line \d+: found ", said)


ONE = Hierarchy([Level([[1.0, 0.0]], 0.0, 1.0)])


@pytest.mark.parametrize(
    ("arguments", "options", "said"),
    [
        ((None,), {}, "the hierarchy = None is a NoneType"),
        ((Hierarchy([], n=3),), {}, "the hierarchy has no level"),
        ((Hierarchy([Level([[np.nan]], 0.0, 1.0, name="hand")]),), {}, r"level 0 \('hand'\), row 0: A\[0\] = nan must"),
        (
            (Hierarchy([Level([[1e20]], 0.0, 1.0, weights=[1e20])]),),
            {},
            r"row 0: A\[0\] = 1e\+40 must be at most 1e\+30 in size, its weight included",
        ),
        ((ONE, [1.0]), {}, r"x_ref has shape \(1,\); it must be \(2,\)"),
        ((ONE,), {"solution": [1.0, np.nan]}, r"#Solution\[1\] = nan must be finite"),
        ((ONE,), {"solution_guess": [1.0]}, r"#SolGuess has shape \(1,\); it must be \(2,\)"),
        ((ONE,), {"guess": [0, 0]}, r"guess = \[0, 0\] must be a hqp.Side for each of 1 rows"),
        ((ONE,), {"guess": [3]}, r"guess = \[3\] must be a hqp.Side for each of 1 rows"),
        ((ONE,), {"guess": [0.5]}, "guess must be one axis of integers"),
    ],
)
def test_refuses_to_write_what_the_format_cannot_hold(
    arguments: tuple[Any, ...], options: dict[str, Any], said: str, tmp_path: Path
) -> None:
    with pytest.raises(InvalidInput, match=said):
        lexls.write(tmp_path / "h.dat", *arguments, **options)
    assert list(tmp_path.iterdir()) == []


def test_labels_have_no_place(file: Path) -> None:
    lexls.write(file, Hierarchy([Level.bounds([0.0], [1.0], labels=[Label("limit", "joint 1")])]))
    assert lexls.read(file).hierarchy.levels[0].labels is None


def test_load_reads_either_format_whatever_the_file_is_called(tmp_path: Path) -> None:
    h = as_lexls(random_one(7))
    lexls.write(tmp_path / "text", h)
    hqp.save(tmp_path / "archive.npz", h, np.ones(h.n))
    (tmp_path / "archive.npz").rename(tmp_path / "archive.dat")
    for name, expected in ("text", None), ("archive.dat", [1.0] * h.n):
        again, x_ref = hqp.load(tmp_path / name)
        assert_same(again, h)
        assert expected == (None if x_ref is None else x_ref.tolist())


def test_a_file_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    lexls.write(tmp_path / "h.dat", ONE)
    before = (tmp_path / "h.dat").read_bytes()
    with pytest.raises(InvalidInput, match="cannot write"):
        lexls.write(tmp_path / "missing" / "h.dat", ONE)
    lexls.write(tmp_path / "h.dat", ONE)
    assert [path.name for path in tmp_path.iterdir()] == ["h.dat"]
    assert (tmp_path / "h.dat").read_bytes() == before  # the same hierarchy, the same bytes
