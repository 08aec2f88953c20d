"""Chapter 4 as data: one :class:`Scenario` a figure, in SI units.

The text counts time in minutes and each motion takes one; here T = 60 s, and everything is converted
once: the feedback of Eq. 4.5, 20 /min and 100 /min^2 for the position, 100 /min and 2500 /min^2 for
the orientation, is that of critically damped gains K = 10 /min and K = 50 /min.

Of each pair the even figure is *without* task priority (the tip alone) and the odd one *with* it (the
tip, then phi). Motion without priority does not depend on phi: 4.2 = 4.4, 4.26 = 4.28 = 4.30, and so
on. Equal scenarios compare equal and are simulated once, so the 36 figures are 26 motions.

Assumptions, where the text leaves things open: :data:`ASSUMPTIONS`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hqp import InvalidInput

from ..robots.planar import PlanarArm
from ..targets.paths import Circle, Line, Polygon
from ..targets.trajectories import Trajectory
from .claims import BOTH, FOLLOWS, MOSTLY, NO_LONGER_SINGULAR, NOT_THROUGHOUT, OVERCOMES, SINGULAR, Claim

MINUTE = 60.0
#: Between two solves [s].
TICK = 2e-4 * MINUTE
#: The same without joint limits, where joints turn so fast, near a kinematic singularity, that holding a command
#: for so long takes the tip off its path by more than 1 mm (in proportion: 1.1 mm in 4.11, 5.2 mm in 4.26).
FREE_TICKS = {"4.11": 1e-4 * MINUTE} | dict.fromkeys(("4.26", "4.28", "4.30"), 2.5e-5 * MINUTE)

ASSUMPTIONS = (
    "The arm starts at rest and follows each commanded acceleration exactly. A command holds for 2e-4 min; without"
    " joint limits for 1e-4 min in 4.11 and for 2.5e-5 min in 4.26 (= 4.28 = 4.30), because joints turn fast there.",
    "Links have a mass of 1 kg per metre, spread evenly. The plane is horizontal: no gravity (Eq. 4.1).",
    "Rectangle: (1, 0), (1, 1), (0.5, 1), (0.5, 0). Each side of a polygon is a cubic of its own, from rest to"
    " rest, all in equal times, one minute in all.",
    "Circle: counter-clockwise from angle 0, cubic in time. The tip starts on it at -10 degrees, 0.1 m away.",
    "Inclined line: from (1, 0.7) to (0.3, 0), at 45 degrees. The tips start within 0.07 m of it. The text gives"
    " neither end, and with three links the verdicts turn with the end: they are left undecided.",
    "Joint limits, where a law has them: 40 rad/min and 4000 rad/min^2 in every joint.",
    "Freedom that the tip alone leaves goes to its manipulability, at 50 /min, where there are joint limits.",
    "Damping, where a law has it: weight 0.1 in every joint, on the level of the orientation, towards the acceleration"
    " that brakes the joint as the orientation is braked, -100 /min times its speed.",
)


@dataclass(frozen=True)
class Course:
    """The path of the tip, as data.

    Attributes
    ----------
    kind : {"line", "polygon", "circle"}
    points : tuple of (x, y)
        Ends, corners, or the centre [m].
    radius : float
        Of a circle [m].
    """

    kind: str
    points: tuple[tuple[float, float], ...]
    radius: float = 0.0

    def trajectory(self, duration: float) -> Trajectory:
        """The motion along it in so many seconds, every piece from rest to rest (Eq. 3.21-3.26).

        Raises
        ------
        InvalidInput
            If the kind is none of the three.
        """
        match self.kind:
            case "line":
                return Line(self.points[0], self.points[1], duration)
            case "polygon":
                return Polygon(self.points, duration)
            case "circle":
                return Circle(self.points[0], self.radius, duration)
        raise InvalidInput(f"course of kind {self.kind!r}; it must be 'line', 'polygon' or 'circle'")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """One simulation of the thesis. Two figures of the same motion compare equal.

    Attributes
    ----------
    figure : str
        Its number in the text (not compared).
    claims : tuple of Claim
        What the text says of it (not compared).
    undecided : str
        What the thesis does not give although every verdict depends on it, or "" (not compared).
    lengths : tuple of float
        Link lengths [m].
    q0 : tuple of float
        Joint angles at the start [rad]; the arm is at rest.
    course : Course
        The path of the tip.
    phi : float or None
        Desired orientation [rad]; None without task priority.
    duration : float
        Of the motion [s].
    tick, free_tick : float
        Between two solves [s], with and without joint limits.
    position_gain, orientation_gain : float
        K [1/s] of Eq. 4.7: c1 = 2 K, c2 = K^2.
    velocity_limit, acceleration_limit : float
        Of every joint [rad/s], [rad/s^2].
    damping : float
        Weight of the joint accelerations on the level of the orientation.
    """

    figure: str = field(compare=False)
    claims: tuple[Claim, ...] = field(compare=False)
    undecided: str = field(default="", compare=False)
    lengths: tuple[float, ...]
    q0: tuple[float, ...]
    course: Course
    phi: float | None
    duration: float = MINUTE
    tick: float = TICK
    free_tick: float = TICK
    position_gain: float = 10 / MINUTE
    orientation_gain: float = 50 / MINUTE
    velocity_limit: float = 40 / MINUTE
    acceleration_limit: float = 4000 / MINUTE**2
    damping: float = 0.1

    @property
    def arm(self) -> PlanarArm:
        """The robot, with its limits."""
        return PlanarArm(self.lengths, velocity_limit=self.velocity_limit, acceleration_limit=self.acceleration_limit)

    @property
    def path(self) -> Trajectory:
        """The desired motion of the tip."""
        return self.course.trajectory(self.duration)

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
        If there is no such figure; lists those that there are.
    """
    found = SCENARIOS.get(figure.strip()) if isinstance(figure, str) else None
    if found is None:
        raise InvalidInput(f"figure {figure!r} is unknown; available: {', '.join(SCENARIOS)}")
    return found


def _group(
    first: int,
    lengths: tuple[float, ...],
    degrees: tuple[float, ...],
    course: Course,
    without: Claim,
    claims: dict[float, Claim | tuple[Claim, ...]],
    undecided: str = "",
) -> list[Scenario]:
    """The pairs of figures of one arm on one path: without priority, then with it at each phi [deg]."""
    q0 = tuple(float(angle) for angle in np.radians(degrees))
    scenarios: list[Scenario] = []
    for pair, (phi, claim) in enumerate(claims.items()):
        figures = {
            f"4.{first + 2 * pair}": (None, without),
            f"4.{first + 2 * pair + 1}": (float(np.radians(phi)), claim),
        }
        scenarios += [
            Scenario(
                figure=figure,
                claims=says if isinstance(says, tuple) else (says,),
                undecided=undecided,
                lengths=lengths,
                q0=q0,
                course=course,
                phi=target,
                free_tick=FREE_TICKS.get(figure, TICK),
            )
            for figure, (target, says) in figures.items()
        ]
    return scenarios


UPRIGHT = Course("line", ((1.0, 0.0), (1.0, 1.0)))
RECTANGLE = Course("polygon", ((1.0, 0.0), (1.0, 1.0), (0.5, 1.0), (0.5, 0.0)))
TRIANGLE = Course("polygon", ((1.0, 0.5), (0.5, 1.0), (0.25, 0.5)))
CIRCLE = Course("circle", ((0.0, 0.0),), radius=0.6)
INCLINED = Course("line", ((1.0, 0.7), (0.3, 0.0)))

SHORT, LONG = (0.5, 0.5, 0.5), (0.7, 0.7, 0.3)
THREE, FOUR = (0.6, 0.5, 0.4), (0.4, 0.4, 0.4, 0.3)

#: What the text says of three links on the inclined line.
NEARLY: dict[float, Claim | tuple[Claim, ...]] = {0: (MOSTLY, OVERCOMES), 90: MOSTLY, 45: MOSTLY}

#: Figure -> scenario, in the order of the text.
SCENARIOS: dict[str, Scenario] = {
    item.figure: item
    for item in [
        *_group(2, SHORT, (65, -73, -42), UPRIGHT, FOLLOWS, {0: MOSTLY, 90: NOT_THROUGHOUT}),
        *_group(6, LONG, (62, -90, -52), UPRIGHT, FOLLOWS, {0: BOTH, 90: BOTH}),
        *_group(10, SHORT, (65, -73, -42), RECTANGLE, FOLLOWS, {0: NOT_THROUGHOUT, 90: NOT_THROUGHOUT}),
        *_group(14, LONG, (62, -90, -52), RECTANGLE, FOLLOWS, {0: BOTH, 90: BOTH}),
        *_group(18, LONG, (75, -68, -70), TRIANGLE, FOLLOWS, {0: BOTH, 90: BOTH}),
        *_group(22, LONG, (80, -125, -50), CIRCLE, FOLLOWS, {0: BOTH, 90: BOTH}),
        *_group(26, THREE, (40, 30, -85), INCLINED, SINGULAR, NEARLY, "the text does not give the line"),
        *_group(32, FOUR, (45, 35, -70, -30), INCLINED, NO_LONGER_SINGULAR, {0: BOTH, 90: BOTH, 45: BOTH}),
    ]
}
