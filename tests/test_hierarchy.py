"""The problem statement: one buffer, views, and refusals that name level and row."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse

from hqp import Hierarchy, InvalidInput, Label, Level, Settings, Solver, Status, solve
from hqp.arrays import real_array


def small() -> Hierarchy:
    return Hierarchy(
        [
            Level.bounds([-1.0, -2.0], [1.0, 2.0], indices=[2, 0], name="limits"),
            Level.equality([[1.0, 2.0, 3.0]], [4.0], name="hand"),
            Level([[0.0, 1.0, 0.0], [1.0, 1.0, 1.0]], [-np.inf, 0.0], [1.0, 2.0], weights=[2.0, 3.0]),
        ]
    )


def test_all_numbers_live_in_one_place() -> None:
    h = small()
    assert (h.n, h.m, h.pointers) == (3, 5, (0, 2, 3, 5))
    assert h.A.shape == (3, 3)
    assert h.columns.tolist() == [2, 0, -1, -1, -1]
    assert h.levels[0].A is None
    assert h.levels[0].indices is not None
    for k in (1, 2):
        assert np.shares_memory(h.levels[k].A, h.A)
    for k in range(3):
        assert np.shares_memory(h.levels[k].lower, h.lower)
        assert np.shares_memory(h.levels[k].weights, h.weights)
    assert np.shares_memory(h.A, h.upper.base)


def test_refill_in_place_and_solve_again() -> None:
    h = small()
    before = solve(h)
    h.levels[1].A[:] = [[1.0, 0.0, 0.0]]
    h.levels[1].lower[:] = h.levels[1].upper[:] = 1.5
    assert solve(h).x[0] == pytest.approx(1.5)
    assert before.hierarchy.levels[1].lower[0] == 4.0  # a solution keeps the numbers that it solved
    assert before.certify().ok


def test_numbers_given_are_copied() -> None:
    A, b = np.eye(2), np.ones(2)
    h = Hierarchy([Level.equality(A, b)])
    A[0, 0] = b[0] = 7.0
    assert h.A[0, 0] == 1.0
    assert h.lower[0] == 1.0


def test_product_and_norms_agree_with_the_dense_rows() -> None:
    h = small()
    x = np.array([1.0, -2.0, 0.5])
    dense = np.concatenate([h.matrix(k) for k in range(3)])
    np.testing.assert_array_equal(h.dense(), dense)
    np.testing.assert_allclose(h.product(x), dense @ x)
    np.testing.assert_allclose(h.row_norms(), np.linalg.norm(dense, axis=1))


def test_copy_is_independent() -> None:
    h = small()
    twin = h.copy()
    h.lower[:] = 0.0
    h.levels[1].A[:] = 0.0
    assert twin.levels[1].lower[0] == 4.0
    assert twin.levels[1].A is not None
    assert twin.levels[1].A[0, 2] == 3.0
    assert np.shares_memory(twin.levels[1].A, twin.A)


def test_a_level_is_frozen_so_that_a_view_cannot_be_lost() -> None:
    with pytest.raises(AttributeError):
        small().levels[1].A = np.zeros((1, 3))  # type: ignore[misc]


def test_repr_says_what_is_inside() -> None:
    text = repr(small())
    assert "3 levels, 5 rows, 3 unknowns" in text
    assert "'hand', rows: 1 equality" in text
    assert "1 two-sided, 1 one-sided" in text
    assert "bounds on x[2, 0]" in text


def test_scalars_stand_for_every_row() -> None:
    level = Level(np.eye(3), 0.0, np.inf, weights=2.0)
    assert level.lower.tolist() == [0.0] * 3
    assert level.weights.tolist() == [2.0] * 3
    assert len(Level.bounds(-1.0, np.ones(4))) == 4


@pytest.mark.parametrize("levels", [[], [Level(np.zeros((0, 3)), [], [])]])
def test_nothing_to_do_gives_x_ref(levels: list[Level]) -> None:
    solution = solve(Hierarchy(levels, n=3), x_ref=[1.0, 2.0, 3.0])
    assert solution.x.tolist() == [1.0, 2.0, 3.0]
    assert solution.certify().ok


SHAPE_FAULTS = {
    "lower": (
        lambda: Level([[1.0, 2.0]], [1.0, 2.0], [1.0], name="hand"),
        r"level 'hand': lower has shape \(2,\).*\(1,\)",
    ),
    "A axes": (lambda: Level([1.0, 2.0], [1.0], [1.0], name="hand"), r"level 'hand': A has shape \(2,\)"),
    "A words": (lambda: Level([["a"]], [1.0], [1.0], name="hand"), r"level 'hand': A is not an array of real numbers"),
    "ragged": (lambda: Level([[1.0], [1.0, 2.0]], 0.0, 1.0, name="hand"), r"level 'hand': A is not an array"),
    "weights": (lambda: Level.equality([[1.0]], [1.0], weights=[1.0, 2.0], name="a"), r"level 'a': weights has shape"),
    "scalars": (lambda: Level.bounds(-1.0, 1.0, name="a"), r"level 'a': scalar bounds do not say how many"),
    "index": (lambda: Level.bounds(0.0, 1.0, indices=[0, -1], name="a"), r"level 'a', row 1: index -1 is negative"),
    "index kind": (lambda: Level.bounds(0.0, 1.0, indices=[0.5], name="a"), r"level 'a': indices must be .* integers"),
    "unknowns": (
        lambda: Hierarchy([Level.equality(np.eye(2), 0.0), Level.equality(np.eye(3), 0.0, name="b")]),
        r"level 1 \('b'\): A has shape \(3, 3\), but the hierarchy has 2 unknowns",
    ),
    "index range": (
        lambda: Hierarchy([Level.equality(np.eye(2), 0.0), Level.bounds(0.0, 1.0, indices=[1, 5], name="b")]),
        r"level 1 \('b'\), row 1: index 5, but the hierarchy has 2 unknowns",
    ),
    "not a level": (
        lambda: Hierarchy([Level.equality(np.eye(2), 0.0), "b"]),
        r"level 1 is a str; it must be a hqp.Level",
    ),
    "one level": (lambda: Hierarchy(Level.equality(np.eye(2), 0.0)), r"takes a sequence of levels"),
    "no n": (lambda: Hierarchy([]), r"how many unknowns there are; give n"),
    "n": (lambda: Hierarchy([], n=-1), r"n = -1 must be an integer of at least 0"),
    "n true": (lambda: Hierarchy([], n=True), r"n = True must be an integer"),
    "n fraction": (lambda: Hierarchy([], n=2.0), r"n = 2.0 must be an integer"),
    "no levels": (lambda: Hierarchy(None), r"takes a sequence of levels, highest first, not None"),
    "number of levels": (lambda: Hierarchy(3), r"takes a sequence of levels, highest first, not 3"),
    "index slip": (
        lambda: Hierarchy([Level.bounds(0.0, 1.0, indices=[2**40])]),
        r"index 1099511627776 makes 1099511627777 unknowns; if so many are meant, give n",
    ),
    "index ragged": (lambda: Level.bounds(0.0, 1.0, indices=[[1], [2, 3]], name="a"), r"level 'a': indices must be"),
    "index huge": (
        lambda: Level.bounds(0.0, 1.0, indices=[2**70], name="a"),
        r"level 'a': indices must be .* integers",
    ),
    "name": (lambda: Level([[1.0]], 0.0, 1.0, name=5), r"name of a level = 5 is a int; it must be a str"),
    "name of bounds": (lambda: Level.bounds([0.0], [1.0], name=None), r"name of a level = None"),
}


@pytest.mark.parametrize("fault", SHAPE_FAULTS)
def test_wrong_shapes_are_refused_when_built(fault: str) -> None:
    build, message = SHAPE_FAULTS[fault]
    with pytest.raises(InvalidInput, match=message):
        build()


@pytest.mark.parametrize("weight", [0.0, -1.0, np.inf, np.nan])
def test_weights_must_be_positive(weight: float) -> None:
    with pytest.raises(InvalidInput, match=r"level 'hand', row 1: weight .* must be positive and finite"):
        Level.equality(np.eye(2), [0.0, 1.0], weights=[1.0, weight], name="hand")


NUMBER_FAULTS = {
    "nan in A": (lambda h: h.levels[2].A.__setitem__((1, 0), np.nan), r"level 2, row 1: A\[0\] = nan must be finite"),
    "inf in A": (lambda h: h.levels[1].A.__setitem__((0, 2), np.inf), r"level 1 \('hand'\), row 0: A\[2\] = inf"),
    "nan bound": (lambda h: h.levels[0].lower.__setitem__(1, np.nan), r"level 0 \('limits'\), row 1: lower = nan"),
    "crossed": (lambda h: h.levels[2].lower.__setitem__(1, 3.0), r"level 2, row 1: lower = 3.0 > upper = 2.0"),
    "lower +inf": (lambda h: h.levels[1].lower.__setitem__(0, np.inf), r"level 1 \('hand'\), row 0: lower = inf"),
    "both +inf": (lambda h: (h.lower.fill(np.inf), h.upper.fill(np.inf)), r"level 0 .*, row 0: .*must be below \+inf"),
    "both -inf": (lambda h: (h.lower.fill(-np.inf), h.upper.fill(-np.inf)), r"level 0 .*, row 0: .*upper above -inf"),
    "weight": (lambda h: h.levels[2].weights.__setitem__(0, 0.0), r"level 2, row 0: weight 0.0 must be positive"),
}


@pytest.mark.parametrize("fault", NUMBER_FAULTS)
def test_bad_numbers_raise_in_solve_and_are_a_status_in_a_solver(fault: str) -> None:
    spoil, message = NUMBER_FAULTS[fault]
    h = small()
    solver = Solver()
    solver.solve(h)
    spoil(h)
    with pytest.raises(InvalidInput, match=message):
        solve(h)
    solution = solver.solve(h)
    assert solution.status is Status.INVALID
    assert not solution.ok
    assert np.isfinite(solution.x).all()
    assert solution.levels == ()
    with pytest.raises(InvalidInput, match=message):
        raise InvalidInput(solution.message)
    assert solver.solve(small()).ok  # and the loop goes on


def test_many_unknowns_are_fine_where_they_are_meant() -> None:
    assert Hierarchy([Level.bounds(np.zeros(20_000), 1.0)]).n == 20_000
    assert Hierarchy([Level.bounds(0.0, 1.0, indices=[20_000])], n=30_000).n == 30_000


STRANGERS = {
    "huge integer": [[10**400, 1]],
    "complex": [[1.0, 1j]],
    "digits": [["1", "2"]],
    "date": [[np.datetime64("2026-01-01"), np.datetime64("2026-01-02")]],
    "record": np.zeros((1, 2), dtype=[("a", float)]),
    "mixed": np.array([[1.0, "2"]], dtype=object),
    "none": [[1.0, None]],
    "masked": np.ma.masked_array([[1.0, 2.0]], mask=[[False, True]]),
    "sparse": scipy.sparse.eye_array(2, format="csr"),
    "dictionary": {1: 2},
}


@pytest.mark.parametrize("stranger", STRANGERS)
def test_what_is_no_real_number_is_never_made_one(stranger: str) -> None:
    value = STRANGERS[stranger]
    with pytest.raises(InvalidInput, match="level 'hand': A is not an array of real numbers"):
        Level(value, 0.0, 1.0, name="hand")  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="level 'hand': upper is not an array of real numbers"):
        Level(np.eye(2), 0.0, value, name="hand")  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [[True, False], [1, 2], np.ma.masked_array([1.0, 2.0]), [Fraction(1, 2), 10**30]])
def test_whatever_holds_real_numbers_is_taken(value: object) -> None:
    assert real_array(value, "value").tolist() == [float(item) for item in value]  # type: ignore[arg-type, attr-defined]


@pytest.mark.parametrize("x_ref", ["a", 1j, {}, [1j, 0, 0], scipy.sparse.eye_array(3), [[1], [2, 3]], "abc"])
def test_an_x_ref_that_is_no_vector_raises_even_in_a_solver(x_ref: object) -> None:
    for attempt in (lambda: Solver().solve(small(), x_ref), lambda: solve(small(), x_ref=x_ref)):  # type: ignore[arg-type]
        with pytest.raises(InvalidInput, match="x_ref is not an array of real numbers"):
            attempt()


@pytest.mark.parametrize("settings", ["x", {}, 0, Settings])
def test_settings_must_be_settings(settings: object) -> None:
    with pytest.raises(InvalidInput, match=r"settings = .* is a \w+; it must be a Settings"):
        Solver(settings=settings)  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match=r"settings = .* is a \w+; it must be a Settings"):
        solve(small(), settings=settings)  # type: ignore[arg-type]


def test_x_ref_is_checked() -> None:
    h = small()
    with pytest.raises(InvalidInput, match=r"x_ref has shape \(2,\); it must be \(3,\)"):
        solve(h, x_ref=[1.0, 2.0])
    with pytest.raises(InvalidInput, match=r"x_ref\[1\] = nan must be finite"):
        solve(h, x_ref=[1.0, np.nan, 0.0])
    assert Solver().solve(h, [1.0, np.nan, 0.0]).status is Status.INVALID
    with pytest.raises(InvalidInput, match=r"takes a hqp\.Hierarchy, not a list"):
        solve([Level.equality(np.eye(2), 0.0)])  # type: ignore[arg-type]
    for stranger in (None, SimpleNamespace(n=3), SimpleNamespace(n=3, structure=None)):
        with pytest.raises(InvalidInput, match=r"takes a hqp\.Hierarchy, not a "):
            Solver().solve(stranger)  # type: ignore[arg-type]


def test_numbers_of_another_size_or_kind_are_refused():
    h = small()
    for wrong in (h.numbers[:-1], h.numbers.astype(np.float32), np.repeat(h.numbers, 2)[::2]):
        with pytest.raises(InvalidInput, match="they must be contiguous, of shape"):
            h.with_numbers(wrong)
    twin = h.with_numbers(h.numbers.copy())
    twin.levels[1].A[0, 0] = 9.0
    assert h.levels[1].A[0, 0] == 1.0


def test_rows_called_otherwise_are_the_same_rows() -> None:
    """Whoever has the hierarchy of before has its words; both have the same numbers."""
    given = small()
    before, after = (given.with_labels({1: [Label("hand", row)]}) for row in "ab")
    assert (before.label_of(2).row, after.label_of(2).row) == ("a", "b")
    assert after.label_of(0) == given.label_of(0)
    after.levels[1].upper[:] = 5.0
    assert before.upper[2] == given.upper[2] == 5.0
    assert after.structure == given.structure
    with pytest.raises(InvalidInput, match=r"level 1 \('hand'\): labels: 2 for 1 rows; there must be one a row"):
        given.with_labels({1: [Label("hand", "b")] * 2})
