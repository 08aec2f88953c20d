"""The picture of the report: accuracy of every backend near a singularity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..settings import Settings
from . import ACCURACY, PLACES, UNDECIDABLE, Parting, Point

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Okabe and Ito's colours, which the colour-blind can tell apart, and black first.
COLOURS = ("#000000", "#E69F00", "#56B4E9", "#009E73", "#0072B2", "#CC79A7", "#882255", "#a6761d", "#332288")
MARKERS = "osv^D<>Xph*P"
#: Of those that promise nothing.
NONE, UNPOLISHED, FORMULA = "#D55E00", "#999999", "#5c5c5c"
#: What is less is drawn here.
LEAST = 1e-17
LABEL: dict[str, Any] = {"fontsize": 7.5, "color": "#444444"}
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def draw(points: Sequence[Point], partings: Sequence[Parting]) -> Figure:
    """Differences from the closed forms over the smallest singular value, and Eq. 4.8 against the strict stack."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12.0, 14.0), layout="constrained")
        grid = figure.subplots(4, len(PLACES), sharex=True, sharey="row")
        rows: list[tuple[str, str, Callable[[Point], Array]]] = [
            ("Eq. 3.17", "difference in x", lambda point: point.x),
            ("Eq. 3.17", "difference in residual", lambda point: point.residual),
            ("Eq. 4.8", "difference in x", lambda point: point.x),
        ]
        looks = _looks(points)
        for axes, (formula, what, value) in zip(grid, rows, strict=False):
            for panel, place in zip(axes, PLACES, strict=True):
                own = [p for p in points if (p.formula, p.place, p.targets) == (formula, place, "in reach")]
                _backends(panel, own, value, looks)
                if formula == "Eq. 3.17" or place == "inside level 0":
                    _laws(panel, cut=place != "between the levels" and "residual" not in what)
                for promise in (ACCURACY["exact"], ACCURACY["first-order"]):
                    panel.axhline(promise, color="#444444", lw=0.6, ls=(0, (6, 4)))
                panel.set_ylim(LEAST / 2, 1e3)
            axes[0].set_ylabel(f"{what} from {formula}")
        for panel, place in zip(grid[3], PLACES, strict=True):
            _two_formulas(panel, [p for p in partings if p.relation == place])
        grid[3, 0].set_ylabel("Eq. 4.8 against the strict stack")
        for panel, place in zip(grid[0], PLACES, strict=True):
            panel.set_title(f"singular {place}")
        for panel in grid[-1]:
            panel.set_xlabel("smallest singular value σ")
            panel.set_xlim(5e-15, 2.0)
            panel.set_xticks(10.0 ** np.arange(-14, 1, 2))
        for panel in grid.flat:
            _zones(panel)
        _names_of_zones(grid[0, 0])
        handles = {
            label: line for panel in grid.flat for line, label in zip(*panel.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, fontsize=8.5)
    return figure


def _looks(points: Sequence[Point]) -> dict[str, dict[str, object]]:
    """Colour, marker and line of every backend."""
    looks: dict[str, dict[str, object]] = {}
    for number, point in enumerate({point.name: point for point in points}.values()):
        solid = sum(look["ls"] == "-" for look in looks.values())
        if not point.polished:
            colour, line = UNPOLISHED, "--"
        elif np.isinf(point.allowed):
            colour, line = NONE, "-."
        elif point.backend.startswith("pseudoinverse"):
            colour, line = FORMULA, ":"
        else:
            colour, line = COLOURS[solid % len(COLOURS)], "-"
        looks[point.name] = {"color": colour, "ls": line, "marker": MARKERS[number % len(MARKERS)]}
    return looks


def _backends(
    panel: Axes, points: Sequence[Point], value: Callable[[Point], Array], looks: dict[str, dict[str, object]]
) -> None:
    """A line a backend, its median, in the band from the least to the largest."""
    for number, name in enumerate(dict.fromkeys(point.name for point in points)):
        own = sorted((point for point in points if point.name == name), key=lambda point: point.sigma)
        values = np.maximum([value(point) for point in own], LEAST)
        if (values == LEAST).all():  # the formula against itself
            continue
        sigma = [point.sigma for point in own]
        panel.fill_between(sigma, values.min(axis=1), values.max(axis=1), color=looks[name]["color"], alpha=0.04, lw=0)
        # Most lines lie on each other: every fifth marker, each backend's where the others have none.
        panel.loglog(
            sigma, np.median(values, axis=1), label=name, lw=1.1, ms=4.5, markevery=(number % 5, 5), **looks[name]
        )


def _laws(panel: Axes, cut: bool) -> None:
    """What round-off and the cut explain."""
    tolerance = Settings().rank_tolerance
    sigma = np.array([tolerance, 1.0])
    panel.loglog(sigma, np.finfo(float).eps / sigma, color="#c4c4c4", lw=4.5, zorder=1.5, label="ε / σ: round-off")
    if cut:
        sigma = np.array([5e-15, tolerance])
        panel.loglog(sigma, sigma, color="#9ecae1", lw=4.5, zorder=1.5, label="σ: which direction is cut")


def _two_formulas(panel: Axes, partings: Sequence[Parting]) -> None:
    own = sorted(partings, key=lambda parting: parting.sigma)
    lines: tuple[tuple[str, str, str, Callable[[Parting], Array]], ...] = (
        ("|x| of the strict stack", "#0072B2", "-", lambda p: p.strict),
        ("|x| of Eq. 4.8", "#E69F00", "-", lambda p: p.joint),
        ("their distance / |x| of the strict stack", "#009E73", "--", lambda p: p.x),
        ("residual of level 1 that Eq. 4.8 adds / |b|", "#CC79A7", "-.", lambda p: p.residual),
    )
    sigma = [parting.sigma for parting in own]
    for label, colour, line, value in lines:
        values = np.maximum([value(parting) for parting in own], LEAST)
        panel.fill_between(sigma, values.min(axis=1), values.max(axis=1), color=colour, alpha=0.12, lw=0)
        panel.loglog(sigma, np.median(values, axis=1), color=colour, ls=line, lw=1.8, label=label)
    panel.set_ylim(LEAST / 2, 1e12)


def _zones(panel: Axes) -> None:
    panel.axvspan(*UNDECIDABLE, color="#f1ead7", lw=0, zorder=0)
    panel.axvline(Settings().rank_tolerance, color="#444444", lw=0.8, ls="--", zorder=1)
    panel.axvline(Settings().proximal_weight ** 0.5, color="#444444", lw=0.8, ls=":", zorder=1)
    panel.grid(color="#e6e6e6", lw=0.6)
    panel.set_axisbelow(True)


def _names_of_zones(panel: Axes) -> None:
    """Once, above all data."""
    settings = Settings()
    top = {"va": "top", "transform": panel.get_xaxis_transform(), **LABEL}
    panel.text(1.3e-12, 0.99, "rank\nundecidable", ha="left", **top)
    panel.text(1.4 * settings.rank_tolerance, 0.99, "rank\ntolerance", ha="left", **top)
    panel.text(1.4 * settings.proximal_weight**0.5, 0.99, "σ² = ρ of\nthe QPs", ha="left", **top)
    for name, promise in list(ACCURACY.items())[:2]:
        panel.text(7e-15, 1.3 * promise, name, va="bottom", **LABEL)
