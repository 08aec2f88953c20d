"""Pictures of ``tasks.thesis``: what lies above what, what is outside the panels, and what goes into a paper."""

from __future__ import annotations

import os
from dataclasses import replace
from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.text import Text
from PIL import Image

from hqp import InvalidInput
from tasks import cli
from tasks.thesis import figures, ideas, plain, report, runs, scenarios, sheet, store, style
from tasks.thesis.arms import ellipses
from tasks.thesis.drawings import DRAWINGS
from tasks.thesis.measuring import measure
from tasks.thesis.runs import Job, run
from tasks.thesis.scenarios import scenario

LIMITED = "cascade:proxsuite"


def records(figure, *laws, tick=0.6):
    """Coarse runs of a figure under some laws, by a backend that takes limits; None for all laws."""
    item = replace(scenario(figure), tick=tick, free_tick=tick)
    return item, {job: run(job) for law in runs.laws_of(item, laws or runs.NAMES) for job in [Job(item, law, LIMITED)]}


@pytest.fixture(scope="module")
def shown():
    """Figures with three links upright, one that diverges, two columns, one column, and four links."""
    return {
        "4.9": records("4.9"),
        "4.5": records("4.5", "thesis", "strict"),
        "4.26": records("4.26"),
        "4.37": records("4.37", "damped"),
    }


@pytest.fixture
def short_figures(monkeypatch):
    coarse = {figure: replace(item, tick=0.6, free_tick=0.6) for figure, item in scenarios.SCENARIOS.items()}
    monkeypatch.setattr(scenarios, "SCENARIOS", coarse)


def arms(figure):
    """The panels of a figure that show an arm."""
    return [axis for axis in figure.axes if any(line.get_label() == "desired path" for line in axis.lines)]


def boxes(figure):
    """Of all panels, of all legends, and of all other texts outside of panels, in pixels."""
    figure.canvas.draw()
    panels = [axis.get_window_extent() for axis in figure.axes]
    legends = [*figure.legends, *(axis.get_legend() for axis in figure.axes if axis.get_legend())]
    return panels, [legend.get_window_extent() for legend in legends]


def crosses(a, b):
    """Whether two boxes share more than an edge."""
    width = min(a.x1, b.x1) - max(a.x0, b.x0)
    height = min(a.y1, b.y1) - max(a.y0, b.y0)
    return width > 0.5 and height > 0.5


def assert_inside(drawing):
    """Nothing that is drawn is cut off by the edge of the paper [inch]."""
    width, height = drawing.get_size_inches()
    box = drawing.get_tightbbox()
    assert box.x0 > -0.01
    assert box.y0 > -0.01
    assert box.x1 < width + 0.01
    assert box.y1 < height + 0.01


@pytest.mark.parametrize("figure", ["4.9", "4.5", "4.26", "4.37"])
def test_links_lie_above_paths_and_the_last_link_above_all(figure, shown):
    item, by_law = shown[figure]
    drawing = figures.draw(item, by_law)
    assert len(arms(drawing)) == len(by_law)
    for axis in arms(drawing):
        paths = {line.get_label(): line.zorder for line in axis.lines if line.get_label().endswith("path")}
        chains = {chain.get_label(): chain.zorder for chain in axis.collections}
        assert max(paths["desired path"], paths["actual path"]) < chains["velocity ratio"] < chains["links"]
        assert chains["links"] < chains["last link"]
    named = [text.get_text() for text in drawing.legends[0].get_texts()]
    assert {"last link", "links, darker is later"} <= set(named)


def test_the_last_link_is_the_last_link_and_later_is_darker(shown):
    item, by_law = shown["4.9"]
    record = next(iter(by_law.values()))
    axis = arms(figures.draw(item, by_law))[0]
    chains = {chain.get_label(): chain for chain in axis.collections}
    ends = [segment[-1] for segment in chains["last link"].get_segments()]
    np.testing.assert_allclose(ends[0], record.pose[0, :2])
    np.testing.assert_allclose(ends[-1], record.pose[-1, :2])
    for name in "links", "last link":
        brightness = chains[name].get_colors()[:, :3].sum(axis=1)
        assert np.all(np.diff(brightness) < 0)


@pytest.mark.parametrize("figure", ["4.9", "4.5", "4.26", "4.37"])
def test_nothing_is_clipped_and_no_legend_lies_on_a_panel(figure, shown):
    item, by_law = shown[figure]
    drawing = figures.draw(item, by_law)
    for axis, record in zip(arms(drawing), by_law.values(), strict=True):
        (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
        outlines = ellipses(item, record).reshape(-1, 2)
        assert left < outlines[:, 0].min()
        assert outlines[:, 0].max() < right
        assert low < outlines[:, 1].min()
        assert outlines[:, 1].max() < high
    panels, legends = boxes(drawing)
    whole = drawing.bbox
    for legend in legends:
        assert not any(crosses(legend, panel) for panel in panels)
        assert whole.x0 <= legend.x0
        assert legend.x1 <= whole.x1
    assert not any(crosses(a, b) for a, b in combinations(panels, 2))


@pytest.mark.parametrize("figure", ["4.9", "4.5", "4.26", "4.37"])
def test_panels_of_the_plane_fill_their_column(figure, shown):
    """No band is left beside a view: equal scales in a box that is made for them."""
    item, by_law = shown[figure]
    drawing = figures.draw(item, by_law)
    drawing.canvas.draw()
    for axis in arms(drawing):
        assert axis.get_window_extent().width == pytest.approx(sheet.COLUMN * drawing.dpi, abs=1.0)


def test_only_laws_with_limits_have_a_panel_of_limits(shown):
    for item, by_law in shown.values():
        drawing = figures.draw(item, by_law)
        limited = sum(job.law.inequalities for job in by_law)
        named = [axis for axis in drawing.axes if axis.get_legend() and "velocity" in legend_of(axis)]
        assert len(named) == limited
        assert len(drawing.axes) == 5 * len(by_law) + limited
        words = [text.get_text() for text in drawing.texts].count("no joint limits")
        assert words == (len(by_law) - limited if limited else 0)


def test_the_foot_names_every_claim_and_whether_it_is_decided():
    item, job = scenario("4.27"), Job(scenario("4.27"), runs.laws_of(scenario("4.27"))[0], LIMITED)
    told = figures.foot(item, [job, job])
    assert all(claim.says in told for claim in item.claims)
    assert told.endswith(f". Undecided: the text does not give the line. Solved by {LIMITED}.")
    assert "Undecided" not in figures.foot(scenario("4.9"), [job])


def test_a_joint_that_turns_at_the_end_stands_over_its_column(shown):
    for item, by_law in shown.values():
        drawing = figures.draw(item, by_law)
        for axis, (job, record) in zip(arms(drawing), by_law.items(), strict=True):
            over = [text.get_text() for text in axis.texts]
            told = any(text.startswith("at the end a joint still turns") for text in over)
            assert told == measure(job, record).turning


def legend_of(axis):
    return [text.get_text() for text in axis.get_legend().get_texts()]


@pytest.mark.parametrize("figure", ["4.9", "4.5", "4.26", "4.37"])
def test_a_plain_figure_fits_a_column_of_a_paper(figure, shown):
    """3.4 inch wide, every text of 8 pt and inside, one panel, and a caption that names the law."""
    for job, record in shown[figure][1].items():
        drawing = plain.draw_plain(job, record)
        drawing.canvas.draw()
        assert drawing.get_figwidth() == 3.4
        assert len(drawing.axes) == 1
        texts = [text for text in drawing.findobj(Text) if text.get_text() and text.get_visible()]
        assert {text.get_fontsize() for text in texts} == {8.0}
        assert_inside(drawing)
        caption = drawing.texts[0].get_text().replace("\n", " ").replace("\N{NO-BREAK SPACE}", " ")
        assert caption.startswith(f"Figure {figure}: {job.law.title}, links ")
        assert ("diverges" in caption) == bool(record.stopped)
        panels, legends = boxes(drawing)
        assert not any(crosses(legend, panels[0]) for legend in legends)


@pytest.mark.parametrize("name", list(DRAWINGS))
def test_drawings_fit_a_paper_and_stay_inside(name):
    drawing = DRAWINGS[name].draw()
    drawing.canvas.draw()
    assert drawing.get_figwidth() in (style.COLUMN, style.PAGE)
    assert_inside(drawing)
    assert drawing.texts[-1].get_text().startswith(f"Figure {name}: ")


def test_drawings_need_no_simulation(tmp_path, monkeypatch, capsys):
    assert list(DRAWINGS) == ["2.1", "3.1", "3.2", "3.3", "3.4", "3.5", "4.1"]
    monkeypatch.setattr(report, "run", None)
    assert cli.run(["thesis", "-f", "3.1", "-f", "4.1", "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert f"runs simulated: 0, pictures drawn: 2, all in {tmp_path}" in capsys.readouterr().out
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == ["figure-3.1.pdf", "figure-3.1.png", "figure-4.1.pdf", "figure-4.1.png", "runs"]


@pytest.mark.parametrize("name", ["3.6", "2.2", "1.1", "4.38", "4.1-plain"])
def test_what_is_no_figure_is_refused_with_what_is_one(name, tmp_path):
    with pytest.raises(
        InvalidInput,
        match=rf"figure '{name}' is unknown; available: 2.1, 3.1, .*, 4.1, 4.2, .*, 4.37, argument, .*, stacks",
    ):
        report.report([name], None, tmp_path / "new", processes=1)
    assert not (tmp_path / "new").exists()


def test_figures_come_full_and_plain_and_nothing_is_drawn_twice(short_figures, tmp_path, capsys):
    def make():
        report.report(["4.6", "4.1"], "pseudoinverse", tmp_path, processes=1)
        return {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("figure-*")}

    first = make()
    files = ("figure-4.6.png", "figure-4.6-plain.png", "figure-4.6-plain.pdf", "figure-4.1.png", "figure-4.1.pdf")
    assert sorted(first) == sorted(files)
    assert make() == first
    assert "runs simulated: 0, pictures drawn: 0" in capsys.readouterr().out
    (tmp_path / "figure-4.6-plain.pdf").unlink()
    again = make()
    assert "runs simulated: 0, pictures drawn: 1" in capsys.readouterr().out
    assert {name for name in files if again[name] != first[name]} == {"figure-4.6-plain.pdf"}
    with Image.open(tmp_path / "figure-4.6-plain.png") as picture:
        assert picture.width == round(3.4 * style.PRINT)
    table = store.Drawn(tmp_path, tmp_path / "runs" / "drawn.json")
    assert set(table.keys) == set(files)


@pytest.mark.parametrize("form", ["png", "pdf", "svg"])
def test_what_goes_into_a_paper_comes_in_pixels_and_in_lines(form, short_figures, tmp_path):
    report.report(["4.6", "2.1"], "pseudoinverse", tmp_path, laws=["thesis"], form=form, processes=1)
    lines = "svg" if form == "svg" else "pdf"
    made = {path.name for path in tmp_path.glob("figure-*")}
    paper = {f"figure-{name}.{suffix}" for name in ("4.6-plain", "2.1") for suffix in ("png", lines)}
    assert made == {f"figure-4.6.{form}"} | paper


def test_letters_stay_letters_in_small_files_and_settings_stay_as_they_are(shown, tmp_path):
    before = dict(mpl.rcParams)
    job, record = next(iter(shown["4.9"][1].items()))
    files = [tmp_path / "plain.pdf", tmp_path / "plain.svg", tmp_path / "again.pdf"]
    for file in files:
        style.save(plain.draw_plain(job, record), file)
    assert b"/FontFile2" in files[0].read_bytes()  # TrueType, as it is: type 42
    assert b"/Type3" not in files[0].read_bytes()
    assert "desired path" in files[1].read_text(encoding="utf-8")
    assert all(os.path.getsize(file) < 100_000 for file in files)
    assert files[0].read_bytes() == files[2].read_bytes()
    assert dict(mpl.rcParams) == before


def test_ideas_have_their_legends_outside():
    item = replace(scenario(ideas.FIGURE), tick=0.3, free_tick=0.3)
    for idea in ideas.IDEAS.values():
        by_law = {job: run(job) for law in idea.laws for job in [Job(item, law, LIMITED)]}
        panels, legends = boxes(idea.draw(by_law))
        assert legends
        assert not any(crosses(legend, panel) for legend in legends for panel in panels)


def ruled(panel, upright):
    """Where the lines of a panel's grid are that stand for an axis without numbers."""
    chains = [chain for chain in panel.collections if isinstance(chain, LineCollection)]
    lines = [line for chain in chains for line in chain.get_segments() if chain.get_alpha() == style.GRID]
    return [line[0][0 if upright else 1] for line in lines if (line[0][0] == line[1][0]) == upright]


def test_a_panel_without_numbers_has_the_grid_of_the_one_whose_numbers_it_shares(shown):
    drawing = figures.draw(*shown["4.9"])
    first = {round(panel.get_position().y0, 6): panel for panel in drawing.axes if panel.get_ylabel()}
    without = [panel for panel in drawing.axes if not panel.yaxis.get_visible()]
    assert len(without) > 12
    for panel in without:
        numbered = first[round(panel.get_position().y0, 6)]
        assert numbered.yaxis.get_visible()
        assert panel.get_ylim() == numbered.get_ylim()
        np.testing.assert_array_equal(ruled(panel, upright=False), numbered.get_yticks())


def test_the_time_of_a_column_stands_below_it_and_rules_all_of_it(shown):
    drawing = figures.draw(*shown["4.9"])
    columns = {}
    for panel in drawing.axes:
        if panel not in arms(drawing):
            columns.setdefault(round(panel.get_position().x0, 6), []).append(panel)
    assert len(columns) == 4
    for *above, last in columns.values():
        assert last.get_xlabel() == "time [min]"
        np.testing.assert_allclose(last.get_xticks(), [0.0, 0.25, 0.5, 0.75, 1.0])
        for panel in above:
            assert not panel.xaxis.get_visible()
            np.testing.assert_allclose(ruled(panel, upright=True), last.get_xticks())
