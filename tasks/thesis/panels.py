"""Panels over time: the orientation, the joints one line each, and which of them is at a limit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..base.checks import Array
from ..simulation.record import Record
from .measuring import HELD as WITHIN
from .runs import phi_error
from .scenarios import MINUTE, Scenario
from .style import ACTUAL, AT_LIMIT, DESIRED, GRID, HELD, JOINTS, MUTED

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

#: Columns of a stripe: each some dots wide on a screen, so that a limit met for a moment shows, beside the frame too.
STRIPES = 100


def draw_phi(axis: Axes, scenario: Scenario, record: Record) -> None:
    """Error of phi, linear within the degree that counts as held; phi itself where none is desired."""
    t = record.t / MINUTE
    if scenario.phi is None:
        axis.plot(t, np.degrees(record.pose[:, 2]), color=ACTUAL)
        return
    axis.axhspan(-WITHIN, WITHIN, color=HELD, alpha=0.18, lw=0)
    axis.plot(t, np.degrees(phi_error(scenario, record)), color=ACTUAL)
    axis.set_yscale("symlog", linthresh=WITHIN, linscale=0.6)
    axis.set_ylim(-200, 200)
    _number(axis.yaxis, [-100, -10, -1, 0, 1, 10, 100])


def draw_joints(axis: Axes, t: Array, values: Array, limit: float = 0.0) -> None:
    """One line a joint, and the limit of all joints, if there is one."""
    for joint, line in enumerate(values.T):
        axis.plot(t / MINUTE, line, color=JOINTS[joint % len(JOINTS)], lw=1.2, label=f"joint {joint + 1}")
    if limit:
        for side in -1, 1:
            axis.axhline(side * limit, color=MUTED, ls="--", lw=1.0)


def draw_limits(axis: Axes, scenario: Scenario, record: Record) -> None:
    """A stripe a joint: when it is at its velocity limit, at its acceleration limit, or at both."""
    from matplotlib.colors import ListedColormap

    joints = len(scenario.lengths)
    axis.set_ylim(joints + 0.5, 0.5)
    axis.set_yticks(range(1, joints + 1))
    axis.tick_params(axis="y", labelsize=8)
    if not len(record):
        return
    kinds = np.zeros((len(record), joints), dtype=np.uint8)
    for bit, name in ((1, "velocity"), (2, "acceleration")):
        if name in record.active:
            kinds |= np.uint8(bit) * (record.active[name] != 0)
    # A limit that is met between two columns still shows.
    bins = np.array_split(kinds, STRIPES) if len(kinds) >= STRIPES else [kinds[k : k + 1] for k in range(len(kinds))]
    stripes = np.array([np.bitwise_or.reduce(block, axis=0) for block in bins]).reshape(-1, joints).T
    if not stripes.any():
        axis.text(0.5, 0.5, "at none", transform=axis.transAxes, ha="center", va="center", fontsize=8, color=MUTED)
    axis.imshow(
        stripes, aspect="auto", interpolation="nearest", extent=(0, record.t[len(record)] / MINUTE, joints + 0.5, 0.5),
        cmap=ListedColormap(AT_LIMIT), vmin=-0.5, vmax=3.5,
    )  # fmt: skip


def draw_time(axis: Axes, scenario: Scenario, record: Record, *, last: bool = True) -> None:
    """The time axis of the whole motion, numbered in the last panel; shaded from where a run ended early."""
    end = scenario.duration / MINUTE
    axis.set_xlim(0, end)
    _number(axis.xaxis, np.linspace(0.0, end, 5).tolist())
    axis.grid(alpha=GRID)
    axis.xaxis.set_visible(last)
    if last:
        axis.set_xlabel("time [min]")
    if record.stopped:
        axis.axvspan(record.stopped.t / MINUTE, end, color=DESIRED, alpha=0.08, lw=0)
        axis.axvline(record.stopped.t / MINUTE, color=DESIRED, lw=1.0, ls=":")


def _number(axis: Axis, at: Sequence[float]) -> None:
    """Number an axis here, and nowhere between."""
    from matplotlib.ticker import FixedLocator, NullLocator, StrMethodFormatter

    axis.set_major_locator(FixedLocator(at))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_locator(NullLocator())


def name_above(axis: Axes, handles: Sequence[Artist], labels: Sequence[str]) -> None:
    """A legend in one line above a panel, where it hides nothing."""
    axis.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(labels), fontsize=8, frameon=False,
        borderpad=0.1, borderaxespad=0.2, handlelength=1.4, handletextpad=0.5, columnspacing=1.2,
    )  # fmt: skip


def name_joints(axis: Axes, limit: float = 0.0) -> None:
    """Which line is which joint, and which the limits, where there are any and the panel reaches so far."""
    from matplotlib.lines import Line2D

    handles, labels = axis.get_legend_handles_labels()
    if 0.0 < limit < axis.get_ylim()[1]:
        handles, labels = [*handles, Line2D([], [], color=MUTED, ls="--", lw=1.0)], [*labels, "limit"]
    name_above(axis, handles, labels)


def name_limits(axis: Axes) -> None:
    """Which colour is which limit."""
    from matplotlib.patches import Patch

    colors = [Patch(color=color) for color in AT_LIMIT[1:]]
    name_above(axis, [Patch(alpha=0.0), *colors], ["joint at a limit:", "velocity", "acceleration", "both"])


def speed_range(scenario: Scenario, records: Iterable[Record]) -> tuple[float, float]:
    """The range of a panel of joint speeds [rad/min]: all speeds, but not those of a run that diverges."""
    peak = MINUTE * max(np.abs(record.v).max() for record in records)
    limit = MINUTE * scenario.velocity_limit
    top = 1.15 * min(peak or limit, 2.2 * limit)
    if 0.9 * limit < top < 1.1 * limit:
        top = 1.1 * limit  # lest the frame hide the limits
    return -top, top


def torque_range(records: Iterable[Record]) -> tuple[float, float] | None:
    """The range of a panel of joint torques [N m]: a run that diverges may leave it; None if all do."""
    whole = [record.tau for record in records if not record.stopped and record.tau is not None]
    top = 1.1 * max((float(np.abs(tau).max()) for tau in whole), default=0.0)
    return (-top, top) if top else None
