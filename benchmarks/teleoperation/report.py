"""The motions of one scene as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees

import numpy as np

from ..tables import Row
from ..ticks.stream import Stream
from .measure import Measure
from .metrics import fast_share
from .scenes import Scene

#: Columns that are told in any scene; and, beside them, those of scenes that ask for them.
SHOWN = (
    "scene", "method", "mm", "max", "deg", "jerk", ">3 Hz", "frozen", "longest", "raised", "out", "over", "moved",
    "pushed", "reach", "soonest", "caught", "p50", "p99",
)  # fmt: skip
COMING_BACK = "back"
STANDING = ("feet", "end", "end ik")
#: Columns that are left out where they are empty: of angles nobody asks for, and of a first level of several tasks.
OPTIONAL = ("deg", "moved", "pushed", "reach", "soonest", "end", "end ik")


def hand_share(stream: Stream) -> float:
    """The share of the power of the targets' own velocities that is fast."""
    dt = stream.scene.dt
    moves = [np.gradient(stream.positions[frame], dt, axis=0) for frame in stream.scene.led]
    return fast_share(np.hstack(moves), dt)


def title(scene: Scene) -> str:
    """What a scene is called: with its gain and tick where these are not the usual ones."""
    usual = type(scene)("", "", "", ())
    own = "" if (scene.gain, scene.dt) == (20.0, usual.dt) else f", K {scene.gain:g} /s, dt {1e3 * scene.dt:g} ms"
    return scene.name + own


def table(scene: Scene, measured: Mapping[str, Measure]) -> list[Row]:
    """One row a run; the columns are explained in the documentation of teleoperation."""
    return [_row(scene, name, m) for name, m in measured.items()]


def shown(scene: Scene, rows: Sequence[Row]) -> list[Row]:
    """What of it fits a terminal."""
    columns = [*SHOWN, *([COMING_BACK] if scene.beyond else []), *(STANDING if scene.standing else [])]
    empty = {column for column in OPTIONAL if not any(row[column] for row in rows)}
    return [{column: row[column] for column in row if column in columns and column not in empty} for row in rows]


def _row(scene: Scene, name: str, m: Measure) -> Row:
    return {
        "scene": scene.name,
        "gain": f"{scene.gain:g}",
        "dt": f"{1e3 * scene.dt:g}",
        "method": name,
        "mm": f"{1e3 * m.excess:.1f}",
        "max": f"{1e3 * m.excess_max:.1f}",
        "whole mm": f"{1e3 * m.far:.1f}",
        "whole max": f"{1e3 * m.far_max:.1f}",
        "deg": "" if m.turned is None else f"{degrees(m.turned):.2f}",
        "deg max": "" if m.turned_max is None else f"{degrees(m.turned_max):.2f}",
        "jerk": f"{m.jerk:.0f}" if m.jerk >= 10.0 else f"{m.jerk:.1f}",
        ">3 Hz": f"{100 * m.fast:.2f}%",
        "frozen": str(m.frozen),
        "longest": f"{1e3 * scene.dt * m.longest:.0f}",
        "raised": str(m.raised),
        "raised by": m.by,
        "out ticks": str(m.out_ticks),
        "out": _small(m.out, m.out_ticks),
        "back": _seconds(m.back),
        "further": _small(m.further, int(m.further > 0.0)),
        "over ticks": str(m.over_ticks),
        "over": _small(m.over, m.over_ticks),
        "moved": "" if m.moved is None else f"{1e3 * m.moved:.3f}",
        "pushed": "" if m.pushed is None else f"{1e3 * m.pushed:.3f}",
        "reach": "" if m.reach is None else f"{m.reach:.2f}",
        "soonest": "" if m.soonest is None else f"{m.soonest:.2f}",
        "caught": str(m.caught),
        "feet": "" if m.strayed is None else f"{1e3 * m.strayed:.2f}",
        "end": "" if m.end is None else f"{1e3 * m.end:.1f}",
        "end ik": "" if m.forced is None else f"{1e3 * m.forced:.1f}",
        "p50": f"{m.p50:.0f}",
        "p99": f"{m.p99:.0f}",
    }


def _small(worst: float, ticks: int) -> str:
    """By how much a limit was passed, at worst; nothing where it is round-off."""
    return f"{worst:.0e}" if ticks else "0"


def _seconds(value: float | None) -> str:
    return "never" if value is None else f"{value:.2f}"
