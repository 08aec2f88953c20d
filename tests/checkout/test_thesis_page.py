"""docs/thesis.md says what ``hqp thesis`` finds: its tables are those of claims.md, row by row."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from thesis_page import PAGE, refreshed, tables

import hqp
from tasks.thesis import report
from tasks.thesis.measuring import measure
from tasks.thesis.run_result import RunResult
from tasks.thesis.runs import jobs_of, run
from tasks.thesis.scenarios import SCENARIOS, scenario
from tasks.thesis.studies import STUDIES
from tasks.thesis.tables import COLUMNS, UNDECIDED, against_claims, to_markdown

CLAIMS, LINES, STACKS, TICKS = (
    "Claims against results",
    "Other lines, finer ticks",
    "Other stacks",
    "Not converged in the tick",
)
#: Change of a joint angle [deg] with the tick beyond which a run magnifies round-off too: its marks are compared alone.
SENSITIVE = 2.0
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]


def rows(text: str, heading: str) -> list[list[str]]:
    return [cells(line) for line in tables(text)[heading][2:]]


def same(said: str, found: str, *, marks_only: bool = False) -> bool:
    """Whether two cells agree: their words, and their numbers within one unit of the last digit printed."""
    if marks_only:
        return re.sub(r"[^✓✗?]", "", said) == re.sub(r"[^✓✗?]", "", found)
    if NUMBER.sub("#", said) != NUMBER.sub("#", found):
        return False
    pairs = zip(NUMBER.findall(said), NUMBER.findall(found), strict=True)
    return all(abs(float(one) - float(other)) <= max(unit(one), unit(other)) * (1 + 1e-9) for one, other in pairs)


def unit(number: str) -> float:
    """Of the last digit: 0.01 in 0.66; 10 in 140, which is rounded to two digits."""
    whole, _, decimals = number.partition(".")
    return 10.0 ** -len(decimals) if decimals else 10.0 ** (len(whole) - len(whole.rstrip("0")))


@pytest.fixture(scope="module")
def page() -> str:
    return PAGE.read_text(encoding="utf-8")


def test_numbers_agree_within_a_unit_of_their_last_digit_and_words_to_the_letter() -> None:
    assert same("0.66 ✓ ↻26", "0.67 ✓ ↻27")
    assert not same("0.66 ✓", "0.68 ✓")
    assert not same("0.66 ✓", "0.66 ✗")
    assert not same("0.66 ✓", "0.66 ✓ ↻2")
    assert same("350 mm", "360 mm")
    assert same("0.66 ✓ ↻26", "0.9 ✓", marks_only=True)
    assert not same("0.66 ✓", "0.66 ?", marks_only=True)


def test_tables_are_copied_under_their_headings() -> None:
    claims = "# One\n\n| a |\n|---|\n| 1 |\n\nlegend\n\n# Two\n\n| b |\n|---|\n| 2 |\n"
    own = "text\n\n### One\n\nmore\n\n| a |\n|---|\n| 0 |\n\n| not this |\n\n### Other\n\n| c |\n"
    assert tables(refreshed(own, claims)) == {"One": ["| a |", "|---|", "| 1 |"], "Other": ["| c |"]}
    assert refreshed(own, claims) == own.replace("| 0 |", "| 1 |")


def test_every_claim_has_its_row(page: str) -> None:
    said = [row[:3] for row in rows(page, CLAIMS)]
    expected = [row[:3] for figure in SCENARIOS for row in against_claims([nothing(figure)])]
    assert said == expected
    for row in rows(page, CLAIMS):
        open_to_doubt = bool(SCENARIOS[row[0]].undecided)
        assert all((UNDECIDED in cell) == open_to_doubt for cell in row[3:] if cell)


def test_every_study_has_its_table(page: str) -> None:
    for name, heading in (("lines", LINES), ("stacks", STACKS)):
        study = STUDIES[name]
        section = study.tabulate({run: nothing(run[0].figure, run[1].title) for run in study.runs()})
        assert section.title == heading
        assert cells(tables(page)[heading][0]) == list(section.headings)
        words = 4 if name == "lines" else 2
        assert [row[:words] for row in rows(page, heading)] == [row[:words] for row in section.rows]


@pytest.mark.parametrize("figure", ["4.6", "4.7"])
def test_what_the_page_says_of_a_figure_is_what_is_found(page: str, figure: str) -> None:
    """Two that are cheap and hang on nothing; the sweep below compares all."""
    jobs = [job for job in jobs_of(scenario(figure), hqp.DEFAULT_BACKEND) if not job.closed_form]
    (found,) = against_claims([measure(job, run(job)) for job in jobs])
    (said,) = (row for row in rows(page, CLAIMS) if row[0] == figure)
    assert all(same(one, other) for one, other in zip(said, found, strict=True)), f"{said} is now {found}"


@pytest.mark.sweep
def test_all_tables_of_the_page_are_what_is_found(page: str, tmp_path: Path) -> None:
    report.report([], None, tmp_path)
    fresh = (tmp_path / "claims.md").read_text(encoding="utf-8")
    open_ticks = {(row[0], law): row[i] for row in rows(fresh, TICKS) for i, law in enumerate(COLUMNS, 1)}
    wrong = []
    for heading in CLAIMS, LINES, STACKS:
        head, said, found = cells(tables(page)[heading][0]), rows(page, heading), rows(fresh, heading)
        for one, other in zip(said, found, strict=True):
            for column, mine, theirs in zip(head, one, other, strict=True):
                tick = open_ticks.get((one[0], column)) if heading == CLAIMS else one[-1] if heading == STACKS else ""
                # Of the lines no differences to other ticks are known.
                sensitive = (heading == LINES and column.startswith("to ")) or float(tick or 0) > SENSITIVE
                if not same(mine, theirs, marks_only=sensitive):
                    wrong.append(f"{heading}, {one[0]}, {column}: {mine} is now {theirs}")
    assert not wrong, "\n".join(wrong)
    assert [row[0] for row in rows(page, TICKS)] == [row[0] for row in rows(fresh, TICKS)]


def nothing(figure: str, law: str = "") -> RunResult:
    """A run of which no number means anything."""
    numbers = dict.fromkeys(RunResult.__dataclass_fields__, float("nan")) | {"reversals": 0}
    return RunResult(**(numbers | {"figure": figure, "law": law, "backend": "", "note": ""}))  # type: ignore[arg-type]


def test_the_page_shows_tables_of_claims_md(page: str) -> None:
    """What the command that refreshes the page would copy: every table of the studies and of the claims."""
    assert {CLAIMS, LINES, STACKS, TICKS} <= set(tables(page))
    assert CLAIMS in to_markdown([nothing("4.6")])
