"""Texts of the page as HTML: the certificate's verdict, the residual of each level and why, and the joint positions."""

from __future__ import annotations

from html import escape

import numpy as np

from ..base.checks import Array
from ..robots.robot import Robot, joint_names, joint_units, limit_of, on_pinocchio
from .session import Session

GOOD, BAD, QUIET, BAR = "#2b8a3e", "#c92a2a", "#868e96", "#4c6ef5"
#: A joint is at its limit if it is at most this far from an end of its range [rad], [m].
AT_LIMIT = 2e-3


def status(session: Session) -> str:
    """HTML of the time and the speed, and below it of the verdict on the last checked tick: what is below stays put."""
    motion = session.motion
    state = "running" if session.running else "paused"
    clock = [f"<b>t = {motion.t:.2f} s</b>, {state}", f"{session.rate:.0f} ticks/s"]
    if session.running and session.rate:
        real = session.rate * motion.dt
        clock.append(f"{real:.2g} x real time")
    told = ["nothing was checked yet"]
    if motion.verdict is not None:
        color, said = (GOOD, "certified") if motion.verdict.certified else (BAD, "not certified")
        told = [f"<span style='color:{color}'>{said} at {motion.verdict.t:.2f} s</span>"]
    if motion.recording:
        told.append(f"<span style='color:{BAD}'>recording, {motion.recorded} ticks</span>")
    lines = "".join(f"<div>{' &middot; '.join(shown)}</div>" for shown in (clock, told))
    return _page(f"{lines}<div style='color:{QUIET}'>{escape(session.message) or '&nbsp;'}</div>")


def reasons(session: Session) -> str:
    """HTML with a line for each level: met, or what it lacks and what holds it back."""
    verdict = session.motion.verdict
    if verdict is None:
        return _page("nothing was checked yet")
    lines = []
    for number, (_, met, told) in enumerate(verdict.levels):
        color = GOOD if met else BAD
        lines.append(f"<div style='margin-top:3px'><b style='color:{color}'>{number}</b> {escape(told)}</div>")
    return _page("".join(lines))


def joints(robot: Robot, q: Array) -> str:
    """HTML with a bar for each joint: its position in its range, red at an end of the range."""
    rows = []
    for name, position, low, high in _described(robot, q):
        at = min(position - low, high - position) <= AT_LIMIT
        color = BAD if at else BAR
        bounded = np.isfinite(low) and np.isfinite(high) and high > low
        share = 100.0 * min(1.0, max(0.0, (position - low) / (high - low))) if bounded else 50.0
        track = "#dee2e6" if bounded else "transparent"
        ends = f"{low:.2f} .. {high:.2f}" if bounded else "no limit"
        look = f"color:{BAD};font-weight:bold" if at else "color:inherit"
        rows.append(
            f"<div style='display:flex;gap:6px;align-items:center;{look}'>"
            f"<span style='width:34%;overflow:hidden;white-space:nowrap;text-overflow:ellipsis'>{escape(name)}</span>"
            f"<span style='flex:1;height:8px;background:{track};border-radius:4px;position:relative'>"
            f"<span style='position:absolute;left:calc({share:.1f}% - 3px);width:6px;height:12px;top:-2px;"
            f"background:{color};border-radius:3px'></span></span>"
            f"<span style='width:3.6em;text-align:right'>{position:.2f}</span>"
            f"<span style='width:7em;color:{QUIET};font-weight:normal'>{ends}</span></div>"
        )
    return _page("".join(rows) or "no joint has a single position")


def _described(robot: Robot, q: Array) -> list[tuple[str, float, float, float]]:
    if on_pinocchio(robot):
        return robot.describe(q)
    if robot.nq != robot.nv:
        return []
    limits = limit_of(robot, "position")
    low, high = np.array([[-np.inf], [np.inf]]).repeat(robot.nv, axis=1) if limits is None else limits
    ends = zip(joint_names(robot), q.tolist(), low.tolist(), high.tolist(), strict=True)
    return [(name, position, least, most) for name, position, least, most in ends]


def units(robot: Robot) -> str:
    """The units of the joint velocities, in words."""
    return " or ".join(f"{unit}/s" for unit in dict.fromkeys(joint_units(robot)))


def _page(text: str) -> str:
    return f"<div style='font-size:12px;line-height:1.35;padding:2px 10px 4px'>{text}</div>"
