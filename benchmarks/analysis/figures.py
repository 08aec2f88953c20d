"""The figures of a run: performance profiles, growth, accuracy against time, and tails."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from hqp import InvalidInput

from ..families import FAMILIES
from ..sweep.cell import STARTS
from .growth import CURVES, Growth, growth
from .metrics import DEADLINE, ENTRANT, entrants, of_entrant, shifted_geometric_mean
from .profiles import profiles
from .summary import YARDSTICK

#: The native solver in black, the others in colours that everybody can tell apart, then again with broken lines.
_FIRST, _COLOURS = "#000000", ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c")
_LINES, _MARKERS = ("-", "--", ":"), "osD^vP"
#: Factors of a profile, and errors, beyond which nothing is shown.
_FURTHEST, _LEAST = 1e4, 1e-16
#: What the axes of growth get on top for a legend of three lines above all curves, as a share of their decades.
_HEADROOM = 0.35


class Styles:
    """One colour and line a method, the same in all figures of a run."""

    def __init__(self, rows: pd.DataFrame) -> None:
        self.names = [name for name in rows["method"].cat.categories if name != YARDSTICK[0]]

    def __call__(self, method: str) -> dict[str, Any]:
        if method == YARDSTICK[0]:
            return {"color": _FIRST, "ls": "-", "lw": 2.2, "zorder": 5}
        number = self.names.index(method)
        again, colour = divmod(number, len(_COLOURS))
        return {"color": _COLOURS[colour], "ls": _LINES[again % len(_LINES)], "lw": 1.2}

    def marker(self, method: str) -> dict[str, Any]:
        """The same for a point."""
        number = 0 if method == YARDSTICK[0] else 1 + self.names.index(method)
        return {"color": self(method)["color"], "marker": _MARKERS[number % len(_MARKERS)]}


def draw_profiles(rows: pd.DataFrame, path: Path) -> None:
    """Performance profiles of certified answers: share of the problems over the factor to the fastest method."""
    rows, styles = tight(rows), Styles(rows)
    parts = {"first level feasible": controllable(rows), "all families": general(rows)}
    with _figure(path, (10.0, 6.8), 2, 2) as (figure, grid):
        for axes, (what, start) in zip(grid.flat, product(parts, STARTS), strict=True):
            here = parts[what][parts[what]["start"] == start]
            for profile in profiles(here, here["certified"]):
                factors = np.concatenate([[1.0], profile.factors, [_FURTHEST]])
                shares = np.concatenate([[0.0], profile.shares, profile.shares[-1:] if len(profile.shares) else [0.0]])
                axes.step(factors, 100 * shares, where="post", label=profile.method, **styles(profile.method))
            axes.set(xscale="log", xlim=(1.0, _FURTHEST), ylim=(0, 101), title=f"{what}, {start}")
            axes.set(xlabel="times the fastest", ylabel="problems certified [%]")
        _legend(figure, grid[0, 0])


def draw_growth(rows: pd.DataFrame, path: Path) -> None:
    """Time over unknowns, levels and rows, with exponents: the native solver, the two best others, and the rest."""
    curves, styles = growth(tight(rows)), Styles(rows)
    if not curves:
        raise InvalidInput("no growth curve has three points; families of the group 'size' make them")
    with _figure(path, (11.0, 6.4), len(STARTS), len(CURVES)) as (_, grid):
        for line, start in zip(grid, STARTS, strict=True):
            for axes, (curve, what) in zip(line, CURVES.items(), strict=True):
                here = [each for each in curves if (each.curve, each.start) == (curve, start)]
                named = [YARDSTICK[0], *best_others(here)]
                for each in here:
                    style = styles(each.method) if each.method in named else {"color": "#d0d0d0", "lw": 0.8}
                    label = f"{each.method}: {each.exponent:.2f}" if each.method in named else None
                    axes.loglog(each.sizes, 1e6 * each.seconds, marker=".", label=label, **style)
                axes.set(title=f"{start}, over {what}", xlabel=what)
                if here:
                    axes.set_xticks(here[0].sizes, [f"{size:.0f}" for size in here[0].sizes])
                    axes.minorticks_off()
                    bottom, top = axes.get_ylim()
                    axes.set_ylim(bottom, top * (top / bottom) ** _HEADROOM)
                    axes.legend(loc="upper left")
            line[0].set_ylabel("median time [us]")


def best_others(curves: Sequence[Growth]) -> list[str]:
    """The two methods, the native one left out, that take least time, geometric mean along the curve."""
    means = {each.method: float(np.mean(np.log(each.seconds))) for each in curves if each.method != YARDSTICK[0]}
    return sorted(means, key=means.__getitem__)[:2]


def draw_accuracy(rows: pd.DataFrame, path: Path) -> None:
    """Error against time, a point an entrant, warm: median of the errors, with the share that is not certified."""
    styles = Styles(rows)
    warm = general(rows[rows["start"] == "warm"])
    with _figure(path, (10.0, 4.6), 1, 2) as (figure, grid):
        for method, setting in entrants(warm):
            here = of_entrant(warm, method, setting)
            time = 1e6 * shifted_geometric_mean(here.assign(wrong=False, claimed=True))
            filled = {} if setting == YARDSTICK[1] else {"mfc": "white"}
            style = styles.marker(method) | filled | {"ls": "", "ms": 7}
            label = method if setting == YARDSTICK[1] else None
            error = max(_LEAST, float(here["error"].quantile(0.9)))
            grid[0, 0].loglog(time, error, label=label, **style)
            grid[0, 1].semilogx(time, 100 * (1.0 - here["certified"].mean()), **style)
        grid[0, 0].set(xlabel="time, geometric mean [us]", ylabel="relative error, 90 % of the problems below")
        grid[0, 1].set(xlabel="time, geometric mean [us]", ylabel="answers not certified [%]")
        grid[0, 1].set_title("filled: tight; hollow: loose")
        _legend(figure, grid[0, 0])


def draw_tails(rows: pd.DataFrame, path: Path) -> None:
    """Share of the problems that take longer than a time; the shortest rounds, to exclude the machine."""
    rows, styles = controllable(tight(rows)), Styles(rows)
    if rows.empty:
        raise InvalidInput("tails are those of families whose first level can be met; there is none in the run")
    with _figure(path, (10.0, 4.2), 1, 2) as (figure, grid):
        for axes, start in zip(grid[0], STARTS, strict=True):
            here = rows[rows["start"] == start]
            for method, setting in entrants(here):
                seconds = np.sort(of_entrant(here, method, setting)["seconds"].to_numpy())
                longer = 1.0 - np.arange(len(seconds)) / len(seconds)
                axes.loglog(1e6 * seconds, 100 * longer, label=method, **styles(method))
            axes.axvline(1e6 * DEADLINE, color="#8c8c8c", lw=0.8)
            axes.annotate(
                "1 kHz ", (1e6 * DEADLINE, 0.02), xycoords=("data", "axes fraction"), ha="right", color="#8c8c8c"
            )
            axes.set(title=start, xlabel="t [us]")
        grid[0, 0].set_ylabel("problems that take longer than t [%]")
        _legend(figure, grid[0, 0])


FIGURES: dict[str, Callable[[pd.DataFrame, Path], None]] = {
    "profiles": draw_profiles,
    "growth": draw_growth,
    "accuracy": draw_accuracy,
    "tails": draw_tails,
}


def tight(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows at the setting at which methods are compared.

    Raises
    ------
    InvalidInput
        If there are none.
    """
    found = rows[rows["setting"] == YARDSTICK[1]]
    if found.empty:
        raise InvalidInput(f"the run has no answer at the setting {YARDSTICK[1]!r}, at which methods are compared")
    return found


def controllable(rows: pd.DataFrame) -> pd.DataFrame:
    """The families whose first level can be met, as in a controller, and those who take them all."""
    feasible = [key for key in rows["family"].cat.categories if FAMILIES[key].feasible]
    return general(rows[rows["family"].isin(feasible)])


def general(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows without methods that took part in some families only, which would have other problems."""
    families = rows.groupby(ENTRANT, observed=True)["family"].nunique()
    here = set(families.index[families == families.max()])
    mine = [key in here for key in zip(rows["method"], rows["setting"], strict=True)]
    return rows[np.array(mine, dtype=bool)]


@contextmanager
def _figure(path: Path, size: tuple[float, float], rows: int, columns: int) -> Iterator[tuple[Figure, Any]]:
    style = {"font.size": 8, "axes.titlesize": 9, "axes.titlelocation": "left", "legend.frameon": False}
    with mpl.rc_context(style):
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False)
        yield figure, grid
        for axes in grid.flat:
            axes.grid(color="#e6e6e6")
            axes.spines[["top", "right"]].set_visible(False)
        # Nothing in a picture of pixels but what it shows: the same numbers make the same file.
        pixels = (
            {"metadata": {"Software": None}, "pil_kwargs": {"optimize": True}} if path.suffix.lower() == ".png" else {}
        )
        figure.savefig(path, dpi=110, **pixels)


def _legend(figure: Figure, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(5, max(1, len(labels))))
