"""Which row stopped which level: laws of the causes, and what is said of them."""

from __future__ import annotations

import copy
import doctest
import json
import pickle
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import hqp
import hqp.hierarchy.label
import hqp.solution.solution
from hqp import Explanation, Hierarchy, InvalidInput, Label, Level, Side, Solution, Solver, solve
from hqp.certificate import LevelExplanation
from hqp.certificate.causes import by_share
from hqp.problems import FAMILIES, hierarchies
from hqp.solution.softening import direction_in_words, strongest


def speed_or_position(side: Side, value: float) -> str:
    """Of a row that two limits share: what is tighter than 1 is the position limit."""
    return "velocity limit" if abs(value) >= 1.0 else "position limit"


LABELS = [Label("joint limit", f"joint{i}", "rad/s", speed_or_position) for i in range(3)]


def reach() -> Hierarchy:
    return Hierarchy(
        [
            Level.bounds([-1.0] * 3, [1.0, 0.5, 1.0], labels=LABELS),
            Level.equality([[2.0, 1.0, 0.0]], [4.0], name="reach", labels=[Label("reach", "x", "m/s")]),
            Level.equality([[0.0, 1.0, 1.0]], [5.0], name="posture"),
        ]
    )


def random(seed: int, n: int = 8) -> Hierarchy:
    """Bounds that all levels press against, above equalities and inequalities that cannot all be met."""
    rng = np.random.default_rng(seed)
    levels = [Level.bounds(-rng.uniform(0.2, 1.0, n), rng.uniform(0.2, 1.0, n), name="limits")]
    for k in range(3):
        A, b = rng.standard_normal((2, n)), 2.0 * rng.standard_normal(2)
        levels.append(Level(A, b, b + np.array([0.0, k % 2]), weights=rng.uniform(0.5, 2.0, 2), name=f"task {k}"))
    return Hierarchy(levels)


SEEDS = range(40)


def gradient(h: Hierarchy, k: int, missing: np.ndarray) -> np.ndarray:
    return -h.matrix(k).T @ (h.levels[k].weights ** 2 * missing)


def missing(level: LevelExplanation) -> np.ndarray:
    """Of all rows of a level whose rows are all of one part."""
    (part,) = level.parts
    return part.missing


def residual(solution: Solution, k: int) -> float:
    return solution.levels[k].residual_norm


@pytest.mark.parametrize("seed", SEEDS)
def test_the_forces_of_the_causes_sum_to_minus_the_gradient(seed: int) -> None:
    solution = solve(random(seed))
    for k, level in enumerate(solution.explain().levels):
        balance = gradient(solution.hierarchy, k, missing(level)) + sum(cause.force for cause in level.causes)
        assert np.linalg.norm(balance) <= 1e-5 * max(1.0, sum(cause.strength for cause in level.causes))
        assert [cause.strength for cause in level.causes] == sorted((c.strength for c in level.causes), reverse=True)
        assert sum(cause.share for cause in level.causes) == pytest.approx(1.0 if level.causes else 0.0, abs=1e-5)


@pytest.mark.parametrize("seed", SEEDS)
def test_inequality_causes_are_active_and_push_inwards(seed: int) -> None:
    solution = solve(random(seed))
    h, value = solution.hierarchy, solution.hierarchy.product(solution.x)
    for level in solution.explain().levels:
        for cause in level.causes:
            if cause.level > 0:
                continue  # one that is violated may push either way
            (row,) = cause.rows
            bound = h.upper if cause.side is Side.UPPER else h.lower
            assert value[row] == pytest.approx(bound[row], abs=1e-8)
            assert np.sign(cause.force[row]) == cause.side


@pytest.mark.parametrize("seed", SEEDS)
def test_met_levels_have_no_causes_and_the_others_have(seed: int) -> None:
    for level in solve(random(seed)).explain().levels:
        assert level.proved
        assert not level.contradicts
        assert level.met == (not level.causes)
        assert level.met == (not missing(level).any())


def exactly(solution: Solution, k: int) -> Hierarchy:
    """The same levels down to k, those above it asked for what they attain, so that they give nothing away."""
    h = Hierarchy(solution.hierarchy.levels[: k + 1])
    above = h.pointers[k]
    value = h.product(solution.x)
    out = (value < h.lower - 1e-9) | (value > h.upper + 1e-9)
    out[above:] = False
    h.lower[out] = h.upper[out] = value[out]
    return h


def relax(h: Hierarchy, rows: list[int]) -> Hierarchy:
    h = h.copy()
    h.lower[rows], h.upper[rows] = -np.inf, np.inf
    return h


@pytest.mark.parametrize("seed", SEEDS)
def test_without_its_causes_a_level_gets_more(seed: int) -> None:
    solution = solve(random(seed))
    h, rows = solution.hierarchy, solution.certify().levels
    for k, level in enumerate(solution.explain().levels):
        pressing = np.concatenate([s.active != Side.INACTIVE for s in solution.levels[:k]] or [[]]).astype(bool)
        normals = h.dense()[: len(pressing)][pressing]
        if level.met or np.linalg.matrix_rank(normals) < len(normals):
            continue  # where rows depend on each other, another one may hold as well
        held = exactly(solution, k)
        assert residual(solve(held), k) == pytest.approx(rows[k].residual_norm, rel=1e-7)
        freed = relax(held, [row for cause in level.causes for row in cause.rows])
        assert residual(solve(freed), k) < rows[k].residual_norm * (1.0 - 1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_rows_that_are_met_and_cause_nothing_change_nothing(seed: int) -> None:
    solution = solve(random(seed))
    h, levels = solution.hierarchy, solution.explain().levels
    for k in range(1, len(levels)):
        causes = {row for level in levels[: k + 1] for cause in level.causes for row in cause.rows}
        idle = [
            row
            for j in range(k)
            for row in range(h.pointers[j], h.pointers[j + 1])
            if row not in causes and not missing(levels[j])[row - h.pointers[j]]
        ]
        freed = solve(relax(h, idle))
        for j in range(k + 1):
            assert residual(freed, j) == pytest.approx(residual(solution, j), rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("factor", [1e-3, 0.5, 20.0])
def test_shares_do_not_depend_on_the_unit_of_a_level_or_of_a_row_above(factor: float) -> None:
    plain = solve(random(3)).explain()
    for k in range(4):
        h = random(3)
        level, own = h.levels[k], slice(*h.pointers[k : k + 2])
        if level.A is not None:
            level.A[:] *= factor
            h.lower[own] *= factor
            h.upper[own] *= factor
        h.weights[own] /= factor if level.A is not None else 1.0
        for one, other in zip(plain.levels, solve(h).explain().levels, strict=True):
            assert [str(cause) for cause in one.causes] == [str(cause) for cause in other.causes]
            np.testing.assert_allclose([c.share for c in one.causes], [c.share for c in other.causes], rtol=1e-6)
            np.testing.assert_allclose([c.strength for c in one.causes], [c.strength for c in other.causes], rtol=1e-6)


def test_every_backend_is_explained_alike(general_backend: str) -> None:
    solution = solve(reach(), backend=general_backend)
    tolerance = 1e-9 if hqp.backend_info(general_backend).accuracy == "exact" else 1e-4
    assert str(solution.explain(tolerance=tolerance)) == str(solve(reach()).explain())


@pytest.mark.parametrize("name", FAMILIES)
def test_what_breaks_solvers_is_explained(name: str) -> None:
    for h in hierarchies(name, 5):
        explanation = Solver().solve(h).explain()
        json.dumps(explanation.data(), allow_nan=False)
        for level in explanation.levels:
            assert not (level.met and level.causes)
            assert all(np.isfinite(cause.strength) for cause in level.causes)
            assert level.met or level.causes or level.contradicts or not level.proved, str(level)
            assert str(level)


def test_what_is_said() -> None:
    assert str(solve(reach()).explain()).splitlines() == [
        "joint limit met (3 of 3 rows at a bound)",
        "reach short by 1.5 m/s: joint0 velocity limit (upper), then joint1 position limit (upper)",
        "posture short by 3.5: joint1 position limit (upper), then joint2 velocity limit (upper)",
    ]


def test_a_level_whose_own_rows_contradict_each_other_has_no_cause_above() -> None:
    h = Hierarchy(
        [
            Level.bounds([-9.0] * 3, [9.0] * 3),
            Level.equality([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0]], [0.0, 1.0], name="sum"),
            Level.equality([[0.0, 0.0, 0.0]], [1.0], name="nothing"),
            Level.equality([[0.0, 0.0, 0.0]] * 2, [1.0, 1.0], name="twice"),
            Level.equality([[1.0, 1.0, 0.0]] * 2, [0.0, 1.0], name="the sum again"),
            Level.equality([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [1.0, 1.0], name="half"),
        ]
    )
    explanation = solve(h).explain()
    assert str(explanation).splitlines() == [
        "level 0 met (0 of 3 rows at a bound)",
        "sum short by 0.707: its own rows contradict each other (rank 1 of 2)",
        "nothing short by 1: its own row is zero (rank 0 of 1)",
        "twice short by 1.41: its own rows are zero (rank 0 of 2)",
        "the sum again short by 0.707: its own rows contradict each other (rank 0 of 2)",
        "half short by 1: of its own rows row 0 is zero (rank 1 of 2)",
    ]
    assert [level.contradicts for level in explanation.levels] == [False, *[True] * 5]


@pytest.mark.parametrize("damping", [0.1, 10.0])
def test_what_nothing_moves_is_no_matter_of_damping(damping) -> None:
    """A damped level is short where its rows are zero, and where it gave way; what is most of it is told."""
    labels = [Label("arm", "x", "m/s"), Label("arm", "y", "m/s")]
    for ends, told in ([1.0, 0.1], "nothing moves it in this direction (x)"), ([1.0, 90.0], "damped, lambda = "):
        h = Hierarchy([Level.equality([[0.0, 0.0], [0.0, 1.0]], ends, labels=labels)])
        level = solve(h, damping={0: damping}).explain().levels[0]
        assert (told in str(level)) == (damping > 1.0 or ends[1] < 1.0)


def test_the_direction_told_is_the_one_in_which_most_was_given_up() -> None:
    """Not the weakest one; and of directions that are softened alike, the one between them that is missing."""
    h = Hierarchy([Level.equality(np.diag([0.1, 1.0, 1.0]), [1e-4, 3.0, -4.0])])
    softs = solve(h, damping={0: 1.0}).relaxed[0].softened
    direction = strongest(softs, np.array([1e-4, 1.5, -2.0])).direction
    np.testing.assert_allclose(direction, [0.0, 0.6, -0.8], atol=1e-9)


def test_parts_and_units_of_one_level_are_told_apart() -> None:
    labels = [Label("pose", "x", "m/s"), Label("pose", "z", "rad/s"), Label("tool", "w", "rad/s"), Label("grip")]
    h = Hierarchy(
        [
            Level.bounds([0.0] * 4, [1.0] * 4, name="box"),
            Level.equality(np.eye(4), [1.02, -0.1, 0.5, 2.0], labels=labels),
        ]
    )
    level = solve(h).explain().levels[1]
    assert str(level).startswith("pose short by 0.02 m/s and 0.1 rad/s, tool met, grip short by 1: x[3] box (upper)")
    assert str(level.causes[1]) == "x[1] box (lower)"
    pose = level.parts[0].data()
    assert pose["met"] is False
    assert pose["residual"] == pytest.approx({"m/s": 0.02, "rad/s": 0.1})
    assert [row["missing"] for row in pose["rows"]] == pytest.approx([0.02, -0.1])
    assert (level.rows, level.rank, level.fixing) == (4, 4, 4)


def test_three_causes_are_named_and_the_others_counted() -> None:
    h = Hierarchy(
        [
            Level.bounds([-1.0] * 5, [1.0] * 5, name="box"),
            Level.equality([[5.0, 4.0, 3.0, -2.0, 1.0]], [99.0], name="far"),
        ]
    )
    assert str(solve(h).explain().levels[1]).endswith(
        ": x[0] box (upper), then x[1] box (upper), then x[2] box (upper) and 2 more"
    )


def test_limits_that_leave_one_value_are_told_one_by_one() -> None:
    h = reach()
    h.levels[0].lower[1] = 0.5
    assert "joint1 position limit (equal)" in str(solve(h).explain())


def test_an_answer_that_is_not_optimal_is_not_explained_away() -> None:
    wrong = replace(solve(reach()), x=np.zeros(3))
    assert str(wrong.explain().levels[1]) == "reach short by 4 m/s: nothing above; not proved optimal"


def test_where_nothing_was_solved_there_is_the_message_alone() -> None:
    h = reach()
    unsupported = hqp.Solver("pseudoinverse").solve(h).explain()
    h.levels[1].lower[0] = np.nan
    invalid = hqp.Solver().solve(h).explain()
    for explanation, said in (unsupported, "is an inequality"), (invalid, "must be a number"):
        assert explanation.levels == ()
        assert said in str(explanation)
        assert "\n" not in str(explanation)
        assert explanation.data() == {"message": str(explanation), "levels": []}


def test_as_a_table_and_as_json() -> None:
    explanation = solve(reach()).explain()
    assert json.loads(json.dumps(explanation.data())) == explanation.data()
    assert explanation.data()["levels"][1]["causes"][0] == {
        "level": 0, "part": "velocity limit", "row": "joint0", "side": "upper", "rows": [0],
        "strength": pytest.approx(3.0), "share": pytest.approx(2 / 3), "left": False,
    }  # fmt: skip
    console = Console(width=120)
    with console.capture() as captured:
        console.print(explanation)
    text = captured.get()
    assert re.search(r"1 +reach +short +1\.5 m/s +1 of 1 +joint0 velocity limit \(upper\) 67%", text)
    assert re.search(r"^ +joint1 position limit \(upper\) 33%", text, re.MULTILINE)


def test_a_table_takes_names_as_they_stand() -> None:
    console = Console(width=120)
    h = Hierarchy([Level.equality([[1.0]], [1.0], name="[red]")])
    with console.capture() as captured:
        console.print(solve(h).explain())
    assert "[red]" in captured.get()


def test_rows_without_labels_are_called_by_level_and_number() -> None:
    h = Hierarchy(
        [
            Level.bounds([0.0], [1.0], indices=[3], name="limits"),
            Level.equality(np.eye(4)[:2], 0.0),
            Level.equality(np.eye(4)[:1], 0.0, labels=[Label("hand")]),
        ]
    )
    expected = [Label("limits", "x[3]"), Label("level 1", "row 0"), Label("level 1", "row 1"), Label("hand")]
    assert [h.label_of(row) for row in range(4)] == expected


@pytest.mark.parametrize(
    "again",
    [
        Hierarchy.copy, copy.copy, copy.deepcopy, lambda h: pickle.loads(pickle.dumps(h)),
        lambda h: h.with_numbers(h.numbers.copy()), lambda h: Hierarchy(h.levels), lambda h: solve(h).hierarchy,
    ],
)  # fmt: skip
def test_labels_are_kept_and_are_no_part_of_the_structure(again: Any) -> None:
    h = reach()
    twin = again(h)
    assert [level.labels for level in twin.levels] == [tuple(LABELS), (Label("reach", "x", "m/s"),), None]
    assert twin.structure == h.structure == Hierarchy([Level.bounds([0.0] * 3, 0.0), *h.levels[1:]]).structure


def test_a_solution_that_was_pickled_explains_itself() -> None:
    solution = solve(reach())
    again = pickle.loads(pickle.dumps(solution))
    assert str(again.explain()) == str(solution.explain())
    assert isinstance(solution.explain(), Explanation)


def test_files_keep_the_texts_of_labels(tmp_path: Path) -> None:
    odd = Label("a\x00", "[\ud800]", "\u03c6 ")
    h = Hierarchy([*reach().levels, Level.equality(np.eye(3)[:1], 0.0, labels=[odd])])
    hqp.save(tmp_path / "h.npz", h)
    again, _ = hqp.load(tmp_path / "h.npz")
    plain = tuple(Label(label.part, label.row, label.unit) for label in LABELS)
    assert [level.labels for level in again.levels] == [plain, (Label("reach", "x", "m/s"),), None, (odd,)]


@pytest.mark.parametrize("labels", [3, [["a"]], [["a", "b", 3]], [["a", "b", "c"]] * 2])
def test_files_with_other_labels_are_refused(labels: Any, tmp_path: Path) -> None:
    hqp.save(tmp_path / "h.npz", Hierarchy([Level.equality([[1.0]], [1.0])]))
    with np.load(tmp_path / "h.npz") as archive:
        arrays = dict(archive)
    head = json.loads(str(arrays["head"]))
    head["levels"][0]["labels"] = labels
    np.savez(tmp_path / "h.npz", **(arrays | {"head": np.array(json.dumps(head))}))
    with pytest.raises(InvalidInput, match="is no hierarchy, or damaged"):
        hqp.load(tmp_path / "h.npz")


@pytest.mark.parametrize(
    ("labels", "said"),
    [
        ([Label("a")], "level 'limits': labels: 1 for 2 rows; there must be one a row"),
        (Label("a"), "level 'limits': labels = Label(.*) must be a sequence of hqp.Label, one a row"),
        ("ab", "level 'limits': labels = 'ab' must be a sequence"),
        (3, "level 'limits': labels = 3 must be a sequence"),
        ([Label("a"), "b"], r"level 'limits': labels\[1\] = 'b' is a str; it must be a Label"),
    ],
)
def test_wrong_labels_are_refused(labels: Any, said: str) -> None:
    for make in (
        lambda: Level(np.eye(2), 0.0, 1.0, name="limits", labels=labels),
        lambda: Level.equality(np.eye(2), 0.0, name="limits", labels=labels),
        lambda: Level.bounds([0.0, 0.0], 1.0, name="limits", labels=labels),
    ):
        with pytest.raises(InvalidInput, match=said):
            make()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((3,), "part of a label = 3 is a int; it must be a str"),
        (("a", None), "row of a label = None is a NoneType; it must be a str"),
        (("a", "b", 3), "unit of a label = 3 is a int; it must be a str"),
        (("a", "b", "c", 3), "bound of a label = 3 must be a function of side and value, or None"),
    ],
)
def test_a_label_is_made_of_texts(arguments: tuple[Any, ...], said: str) -> None:
    with pytest.raises(InvalidInput, match=said):
        Label(*arguments)


def test_what_a_bound_returns_is_a_text() -> None:
    with pytest.raises(InvalidInput, match="what bound of label 'a' returned = 3 is a int; it must be a str"):
        Label("a", bound=lambda side, value: 3).part_at(Side.UPPER, 1.0)  # type: ignore[arg-type, return-value]


@pytest.mark.parametrize(("module", "examples"), [(hqp.hierarchy.label, 1), (hqp.solution.solution, 4)])
def test_the_examples_in_docstrings_are_true(module: Any, examples: int) -> None:
    assert doctest.testmod(module) == (0, examples)


def test_parts_of_one_level_hold_each_other_back() -> None:
    labels = [Label("left"), Label("right")]
    wishes = Level.equality([[1.0, 0.0], [1.0, 0.0]], [0.0, 2.0], labels=labels)
    limit = Level.bounds([-np.inf], [0.25], indices=[0], name="limit")
    (held,) = solve(Hierarchy([limit, wishes])).explain().levels[1:]
    # left pulls down by 0.25 and right up by 1.75: they cancel all but the 1.5 that the limit holds.
    assert held.inner == pytest.approx(0.5)
    assert str(held) == "left short by 0.25, right short by 1.75: x[0] limit (upper), then each other"
    alone = solve(Hierarchy([limit, Level.equality([[1.0, 0.0]], [2.0])])).explain().levels[1]
    assert (alone.inner, "each other" in str(alone)) == (0.0, False)


def test_what_is_missing_is_in_the_units_of_the_rows_and_weights_are_said() -> None:
    labels = [Label("speed", "x", "m/s"), Label("force", "f", "N"), Label("rest", "y"), Label("rest", "z")]
    level = Level.equality(np.eye(4), [2.0, 30.0, 2.0, 3.0], weights=[1.0, 0.01, 2.0, 3.0], labels=labels)
    limits = Level.bounds([-1.0] * 4, [1.0] * 4, name="limits")
    told = solve(Hierarchy([limits, level])).explain().levels[1]
    assert str(told).startswith(
        "speed short by 1 m/s, force short by 29 N (weight 0.01), rest short by 2.24 (weights 2 to 3): "
    )
    assert [row["weight"] for row in told.parts[2].data()["rows"]] == [2.0, 3.0]


def test_the_name_of_a_level_is_told_where_no_part_has_it() -> None:
    labels = [Label("left hand", "x", "m"), Label("right hand", "x", "m")]
    for name, beside in ("reaching", "reaching: "), ("left hand + right hand", ""), ("", ""):
        h = Hierarchy([Level.equality(np.eye(2), [1.0, 1.0], labels=labels, name=name)])
        assert str(solve(h).explain()) == f"{beside}left hand and right hand met (rank 2 of 2)"


def test_a_damped_level_says_so_and_does_not_contradict_itself() -> None:
    h = Hierarchy(
        [Level.equality([[1.0, 0.0], [0.0, 2.0]], [1.0, 1.0], name="reach"), Level.equality([[1.0, 1.0]], [0.0])]
    )
    reach, below = solve(h, damping={0: 0.1}).explain().levels
    assert str(reach) == "reach short by 0.0102: damped, lambda = 0.1"
    assert not reach.contradicts
    assert [part.part for part in reach.parts] == ["reach"]
    assert str(below).endswith(": reach")
    for least in 1e-5, 1e-7:
        assert str(solve(h, damping={0: least}).explain().levels[0]) == "reach met (rank 2 of 2)"
    own = Hierarchy([Level.equality([[1.0], [1.0]], [0.0, 1.0], name="sum")])
    assert "contradict" in str(solve(own).explain())
    assert "nothing moves it in this direction (0.71 row 0, -0.71 row 1)" in str(solve(own, damping={0: 0.5}).explain())


@pytest.mark.parametrize("off", [0.0, 1e-16, -1e-12])
def test_equal_causes_are_told_in_the_order_of_their_rows(off: float) -> None:
    """Two joints hold a reach back alike: by the limits above it, damped or not, the first one is named first."""
    limits = Level.bounds([-1.0] * 2, [1.0] * 2, labels=LABELS[:2])
    reach = Level.equality([[1.0, 1.0 + off]], [4.0], name="reach")
    below = Level.equality([[1.0, -0.5]], [0.0])
    for damping in None, {2: 0.1}:
        told = solve(Hierarchy([limits, reach, below]), damping=damping).explain().levels[1]
        assert [cause.row for cause in told.causes] == ["joint0", "joint1"]
    equal = [replace(cause, share=0.5 + sign * off) for cause, sign in zip(told.causes, (-1.0, 1.0), strict=True)]
    assert [cause.row for cause in by_share(equal)] == ["joint0", "joint1"]


@pytest.mark.parametrize("off", [0.0, 1e-16, -1e-16, 1e-12, -1e-12])
def test_the_words_of_a_direction_are_no_matter_of_round_off(off: float) -> None:
    labels = [Label("arm", row) for row in "xyz"]
    for sign in 1.0, -1.0:
        direction = sign * np.array([-(0.5**0.5), 0.5**0.5 + off, 1e-3])
        assert direction_in_words(direction, labels) == "0.71 x, -0.71 y"
