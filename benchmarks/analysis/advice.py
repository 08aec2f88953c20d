"""A recommendation of a backend for each use: one sentence from the rows of a run, and a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from hqp import InvalidInput

from .figures import FIGURES, general, tight
from .metrics import METRICS, PROBLEM, entrants, of_entrant, share, shifted_geometric_mean

if TYPE_CHECKING:
    from rich.console import Console

    from ..sweep.store import Store

#: The picture that a run leaves beside its cells, and its file.
FIGURE, PICTURE = "profiles", "profiles.png"
#: What each start stands for.
USES = {"warm": "in a control loop (warm)", "cold": "for one problem (cold)"}


def conclude(printer: Console, store: Store) -> None:
    """Draw the picture, and print which backend to use; where nothing was measured that compares, say so."""
    rows = store.table()
    try:
        FIGURES[FIGURE](rows, store.folder / PICTURE)
        text = f"picture: {store.folder / PICTURE}\n{advice(rows)}"
    except InvalidInput as reason:
        text = f"no picture and no advice: {reason}"
    printer.print(text, markup=False, highlight=False, soft_wrap=True)


def advice(rows: pd.DataFrame) -> str:
    """The sentence: best methods warm, cold and for a second opinion, faster ones, and silently wrong ones.

    Best is the least shifted geometric mean of the time, in which an answer that cannot be used counts as 10 ms, of
    those that took part in all families. A second opinion is the one most often certified, of the others.
    """
    rows = tight(rows)
    whole = general(rows)
    parts = []
    for start, use in USES.items():
        best, here = _best(whole, start)
        parts.append(f"{use}: {best}, {_told(here)}")
    best, _ = _best(whole, "warm")
    others = {name: of for name, of in _by_method(whole).items() if name != best and not _silent(of)}
    if others:
        second = max(others, key=lambda name: (_certified(others[name]), -shifted_geometric_mean(others[name])))
        parts.append(f"for a second opinion: {second}, {_told(others[second])}")
    parts += [f"on {where}: {name}, {_told(of)}" for name, where, of in _faster(rows, best)]
    misleading = [f"{name} ({share(_silent(of))} %)" for name, of in _by_method(rows).items() if _silent(of)]
    if misleading:
        parts.append(f"wrong without a word: {', '.join(misleading)}")
    text = "; ".join(parts)
    return f"Which backend, for what? {text[:1].upper()}{text[1:]}."


def _best(rows: pd.DataFrame, start: str) -> tuple[str, pd.DataFrame]:
    """The method with the least mean, and its rows."""
    methods = _by_method(rows[rows["start"] == start])
    name = min(methods, key=lambda name: shifted_geometric_mean(methods[name]))
    return name, methods[name]


def _faster(rows: pd.DataFrame, best: str) -> list[tuple[str, str, pd.DataFrame]]:
    """Methods that took part in some families only and are better there, warm: name, groups, rows."""
    warm = rows[rows["start"] == "warm"]
    methods = _by_method(warm)
    leader = methods[best].set_index(PROBLEM)
    found = []
    for name, of in methods.items():
        shared = leader[leader.index.isin(pd.MultiIndex.from_frame(of[PROBLEM]))]
        part = of["family"].nunique() < methods[best]["family"].nunique()
        if part and len(shared) and shifted_geometric_mean(of) < shifted_geometric_mean(shared):
            found.append((name, ", ".join(map(str, dict.fromkeys(of["group"]))), of))
    return found


def _by_method(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """The rows of each method, at the one setting that these rows have."""
    return {method: of_entrant(rows, method, setting) for method, setting in entrants(rows)}


def _certified(rows: pd.DataFrame) -> float:
    return METRICS["certified"].of(rows)


def _silent(rows: pd.DataFrame) -> float:
    return METRICS["silent"].of(rows)


def _told(rows: pd.DataFrame) -> str:
    return f"{METRICS['median'].text(rows)} us, {share(_certified(rows))} % certified"
