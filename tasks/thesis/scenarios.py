"""Chapter 4 as data: one :class:`Scenario` a figure, in SI units.

The text counts time in minutes and each move takes one; here T = 60 s, and everything is converted
once: the feedback of Eq. 4.5, 20 /min and 100 /min^2 for the position, 100 /min and 2500 /min^2 for
the orientation, is that of critically damped gains K = 10 /min and K = 50 /min.

Of each pair the even figure is *without* task priority (the tip alone) and the odd one *with* it (the
tip, then phi). Motion without priority does not depend on phi, so that 4.2 = 4.4, 4.6 = 4.8,
4.26 = 4.28 = 4.30 and 4.32 = 4.34 = 4.36; equal scenarios compare equal and are simulated once.

Assumptions, where the text leaves things open:

* The inclined line of 4.26-4.37 runs from (1, 0.7) to (0.3, 0), at 45 degrees; the tips start within 0.07 m of it.
* The robot starts at rest and follows each commanded acceleration exactly, for a tick of 2e-4 min.
* Joint limits, where a law has them: 40 rad/min and 4000 rad/min^2 in every joint.

Figures 4.10-4.25 (rectangle, triangle, circle) are not available yet.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hqp import InvalidInput

from ..motion.paths import Line
from ..robots.planar import PlanarArm

MINUTE = 60.0


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """One simulation of the thesis. Two figures of the same motion compare equal.

    Attributes
    ----------
    figure : str
        Its number in the text (not compared).
    claim : str
        What the text says of it, in short (not compared).
    lengths : tuple of float
        Link lengths [m].
    q0 : tuple of float
        Joint angles at the start [rad]; the arm is at rest.
    start, end : tuple of float
        Ends of the straight path [m].
    phi : float or None
        Desired orientation [rad]; None without task priority.
    duration : float
        Of the move [s].
    tick : float
        Between two solves [s].
    position_gain, orientation_gain : float
        K [1/s] of Eq. 4.7: c1 = 2 K, c2 = K^2.
    velocity_limit, acceleration_limit : float
        Of every joint [rad/s], [rad/s^2].
    """

    figure: str = field(compare=False)
    claim: str = field(compare=False)
    lengths: tuple[float, ...]
    q0: tuple[float, ...]
    start: tuple[float, float]
    end: tuple[float, float]
    phi: float | None
    duration: float = MINUTE
    tick: float = 2e-4 * MINUTE
    position_gain: float = 10 / MINUTE
    orientation_gain: float = 50 / MINUTE
    velocity_limit: float = 40 / MINUTE
    acceleration_limit: float = 4000 / MINUTE**2

    @property
    def arm(self) -> PlanarArm:
        """The robot, with its limits."""
        return PlanarArm(self.lengths, velocity_limit=self.velocity_limit, acceleration_limit=self.acceleration_limit)

    @property
    def path(self) -> Line:
        """The desired motion of the tip: a straight line, cubic in time, from rest to rest (Eq. 3.21-3.26)."""
        return Line(self.start, self.end, self.duration)

    @property
    def title(self) -> str:
        """``Figure 4.7: links 0.7 0.7 0.3 m, phi = 0°``."""
        what = "without task priority" if self.phi is None else f"with task priority, φ = {np.degrees(self.phi):.0f}°"
        return f"Figure {self.figure}: links {' '.join(map(str, self.lengths))} m, {what}"


def scenario(figure: str) -> Scenario:
    """The scenario of a figure of chapter 4, such as ``"4.7"``.

    Raises
    ------
    InvalidInput
        If there is no such figure here; lists those that there are.
    """
    found = SCENARIOS.get(figure.strip()) if isinstance(figure, str) else None
    if found is None:
        later = figure in {f"4.{number}" for number in range(10, 26)}
        why = "is not available yet (its path is not a straight line)" if later else "is unknown"
        raise InvalidInput(f"figure {figure!r} {why}; available: {', '.join(SCENARIOS)}")
    return found


def _group(
    first: int,
    lengths: tuple[float, ...],
    degrees: tuple[float, ...],
    path: tuple[tuple[float, float], tuple[float, float]],
    without: str,
    claims: dict[float, str],
) -> list[Scenario]:
    """The pairs of figures of one arm on one path: without priority, then with it at each phi [deg]."""
    q0 = tuple(float(angle) for angle in np.radians(degrees))
    scenarios = []
    for number, (phi, claim) in enumerate(claims.items()):
        for figure, target, says in (first + 2 * number, None, without), (first + 2 * number + 1, phi, claim):
            scenarios.append(
                Scenario(
                    figure=f"4.{figure}",
                    claim=says,
                    lengths=lengths,
                    q0=q0,
                    start=path[0],
                    end=path[1],
                    phi=None if target is None else float(np.radians(target)),
                )
            )
    return scenarios


_UPRIGHT = ((1.0, 0.0), (1.0, 1.0))
_INCLINED = ((1.0, 0.7), (0.3, 0.0))
_FOLLOWS = "the tip follows the line, the orientation is left to itself"
_MAJOR_PART = "both tasks met for the major part, the orientation lost towards the end"

#: Figure -> scenario, in the order of the text.
SCENARIOS: dict[str, Scenario] = {
    item.figure: item
    for item in [
        *_group(
            2, (0.5, 0.5, 0.5), (65, -73, -42), _UPRIGHT, _FOLLOWS,
            {0: _MAJOR_PART, 90: "both tasks cannot be met together"},
        ),
        *_group(
            6, (0.7, 0.7, 0.3), (62, -90, -52), _UPRIGHT, _FOLLOWS,
            {0: "both tasks met with maximum accuracy", 90: "both tasks met with maximum accuracy"},
        ),
        *_group(
            26, (0.6, 0.5, 0.4), (40, 30, -85), _INCLINED,
            "unable to follow the path: singular, joint speeds extremely high",
            {0: _MAJOR_PART, 90: _MAJOR_PART, 45: _MAJOR_PART},
        ),
        *_group(
            32, (0.4, 0.4, 0.4, 0.3), (45, 35, -70, -30), _INCLINED,
            "a fourth joint avoids the singular configurations",
            {0: "both tasks met", 90: "both tasks met", 45: "both tasks met"},
        ),
    ]
}  # fmt: skip
