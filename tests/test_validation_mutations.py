"""The validation fails on wrong solvers, and says who is wrong and by which kind of check."""

from __future__ import annotations

import pytest
from mutants import MUTATIONS, Mutation, mutate

from hqp.validation.results import KINDS, Results, run
from tasks.cli import run as command

#: Mutation -> the kinds of checks that find it at the least count, one stack a case and one hierarchy a size.
FOUND_BY = {
    "drops the second level": {"closed forms", "singularities", "random hierarchies", "known answers"},
    "swaps the first two levels": {"closed forms", "known answers"},
    "merges the first two levels": {"closed forms", "known answers"},
    "ignores weights": {"closed forms", "random hierarchies", "known answers"},
    "squares weights": {"closed forms", "random hierarchies", "known answers"},
    "takes weights for priorities": {"closed forms", "random hierarchies", "known answers"},
    "ignores lower bounds": {"random hierarchies", "known answers"},
    "ignores upper bounds": {"random hierarchies", "known answers"},
    "ignores x_ref": {"closed forms", "random hierarchies", "known answers"},
    "ignores x_ref above n = 10": {"random hierarchies", "known answers"},
    "ignores inequalities below the top": {"random hierarchies", "known answers"},
    "drops rows of norm > 1": {"closed forms", "random hierarchies", "known answers"},
    "takes rows of norm > 1 for rows of norm 1": {"closed forms", "random hierarchies", "known answers"},
    "ignores levels deeper than 4": {"random hierarchies", "known answers"},
    "stops one level early": {"closed forms", "random hierarchies", "known answers"},
    "takes inequalities for equalities": {"random hierarchies", "known answers"},
    "is off by 1e-4": {"closed forms", "random hierarchies", "known answers"},
    "is off by 5e-7": {"random hierarchies", "known answers"},
}
EACH = pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.name)


def judged(name: str, kinds: tuple[str, ...] = tuple(KINDS)) -> Results:
    return run([name], count=1, seed=0, jobs=1, kinds=kinds)


def test_every_mutation_is_told_by_whom_it_is_found() -> None:
    assert set(FOUND_BY) == {mutation.name for mutation in MUTATIONS}
    assert len(MUTATIONS) >= 15


def test_without_a_mutation_nothing_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    mutate(monkeypatch, "native", Mutation("is right", 0, lambda levels, x_ref: (levels, x_ref)))
    assert judged("native").wrong == []


@EACH
def test_a_wrong_solver_is_named_with_the_checks_that_it_fails(
    monkeypatch: pytest.MonkeyPatch, mutation: Mutation
) -> None:
    mutate(monkeypatch, "native", mutation)
    results = judged("native")
    assert set(results.outside) == {"native"}
    assert set(results.outside["native"]) >= FOUND_BY[mutation.name]
    assert results.wrong[0] == f"native ({', '.join(results.outside['native'])})"


@pytest.mark.parametrize("kind", ["closed forms", "random hierarchies", "known answers"])
def test_it_does_not_matter_whose_backend_is_wrong(monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    (mutation,) = [mutation for mutation in MUTATIONS if mutation.name == "ignores x_ref"]
    mutate(monkeypatch, "cascade:osqp", mutation)
    results = run(["native", "cascade:osqp"], count=1, seed=0, jobs=1, kinds=(kind,))
    assert results.outside == {"cascade:osqp": [kind]}


@pytest.mark.sweep
@EACH
def test_the_command_fails_and_names_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], mutation: Mutation
) -> None:
    """By all backends, with the default count; in this process, for no other knows of the mutation."""
    mutate(monkeypatch, "native", mutation)
    assert command(["validate", "--jobs", "1"]) == 1
    (told,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("outside their class: ")]
    named = told.removeprefix("outside their class: ")
    assert named.startswith("native (")
    assert "cascade" not in named
    for kind in FOUND_BY[mutation.name]:
        assert kind in named[: named.index(")")]
