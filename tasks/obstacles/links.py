"""Links of a robot as capsules, each carried by a frame."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.checks import Array, finite, not_negative, numbers, scalar
from ..base.live import Live, number, structure
from ..robots.frame import Frame
from ..robots.planar import PlanarArm
from ..robots.robot import Robot, check_frame, integrate, neutral
from .body_shapes import bodies_of, shapes_of

#: Tolerance for a point that a frame carries, when the joints move [m].
RIGID = 1e-9


class LinkCapsule(Live):
    """All points within a radius of the segment from one frame to another, carried by the first.

    :func:`link_capsules` makes them from the shapes of a robot.

    Parameters
    ----------
    frame : str
        The frame that carries it.
    end : str or array, shape (3,) or (2,)
        Where the segment ends: another frame whose origin is fixed in `frame`, as that of the next joint; or a point in
        the coordinates of `frame` [m].
    radius : float
        [m].
    start : array, shape (3,) or (2,), optional
        Where the segment begins, in the coordinates of `frame` [m] (default: its origin).
    name : str, optional
        For labels (default: the name of the frame).

    Raises
    ------
    InvalidInput
        If the radius is negative, the end neither a name nor a point, or the start no point.

    Examples
    --------
    >>> from tasks import LinkCapsule
    >>> LinkCapsule("panda_link5", "panda_link6", 0.06, name="forearm")
    LinkCapsule('panda_link5', 'panda_link6', 0.06)
    """

    frame: str = structure()
    end: str | Array = structure()
    start: Array = structure()
    name: str = structure()

    def __init__(
        self,
        frame: str,
        end: str | ArrayLike,
        radius: float,
        *,
        start: ArrayLike = (0.0, 0.0, 0.0),
        name: str | None = None,
    ) -> None:
        self.frame = of_type(frame, str, "LinkCapsule: frame")
        self.name = frame if name is None else of_type(name, str, "LinkCapsule: name")
        self.radius = radius
        self.end = end if isinstance(end, str) else _point(end, f"LinkCapsule {frame!r}: end", ", or a frame")
        self.start = _point(start, f"LinkCapsule {frame!r}: start", ", a point")

    @number
    def radius(self, value: float) -> float:
        """Radius about the segment [m]; not negative."""
        return scalar(not_negative(value, f"{self.full_name()}: radius", unit="m"), f"{self.full_name()}: radius")

    def bind(self, robot: Robot) -> Array:
        """Where the segment begins and ends in the coordinates of the frame, shape (2, 3) [m].

        Raises
        ------
        InvalidInput
            If the robot has no such frame, or the end moves relative to it.
        """
        for name in (self.frame, self.end):
            if isinstance(name, str):
                check_frame(robot, name, "LinkCapsule:")
        if not isinstance(self.end, str):
            return np.stack([self.start, self.end])
        q, step = neutral(robot), 0.3 * np.cos(np.arange(robot.nv))
        states = [robot.at(there, np.zeros(robot.nv)) for there in (q, integrate(robot, q, step))]

        def seen(end: str, frame: str) -> list[Array]:
            both = [(state.frame(end), state.frame(frame)) for state in states]
            return [axes(carrier).T @ (there.position - carrier.position) for there, carrier in both]

        def fixed(local: list[Array]) -> bool:
            return bool(np.abs(local[0] - local[1]).max() <= RIGID)

        local = seen(self.end, self.frame)
        if not fixed(local):
            other = fixed(seen(self.frame, self.end))
            instead = "name them the other way round" if other else "end at a joint or a point that it carries"
            raise InvalidInput(f"LinkCapsule: {self.frame!r} does not carry {self.end!r}; {instead}")
        return np.stack([self.start, local[0]])

    def __repr__(self) -> str:
        end = self.end if isinstance(self.end, str) else self.end.tolist()
        start = f", start={self.start.tolist()}" if self.start.any() else ""
        return f"LinkCapsule({self.frame!r}, {end!r}, {self.radius:g}{start})"


def planar_links(arm: PlanarArm, radius: float) -> tuple[LinkCapsule, ...]:
    """Every link of a planar arm, from the base on, with a radius [m].

    Parameters
    ----------
    arm : PlanarArm
    radius : float
        Of every link [m].

    Examples
    --------
    >>> from tasks import PlanarArm, planar_links
    >>> [link.name for link in planar_links(PlanarArm([0.5, 0.5, 0.5]), 0.05)]
    ['link 1', 'link 2', 'link 3']
    """
    lengths = of_type(arm, PlanarArm, "arm").lengths
    return tuple(
        LinkCapsule(f"link{i + 1}", [-length, 0.0], radius, name=f"link {i + 1}") for i, length in enumerate(lengths)
    )


def link_capsules(robot: Robot, bodies: Iterable[str] | None = None) -> tuple[LinkCapsule, ...]:
    """The bodies of a robot as capsules, each the smallest that contains all collision shapes of its body.

    Parameters
    ----------
    robot : PinocchioRobot
        With shapes: of its file, URDF or MJCF, or of ``robot.with_geometry(...)``.
    bodies : iterable of str, optional
        Frames of the bodies (default: all that have shapes, and that a joint moves).

    Raises
    ------
    InvalidInput
        If the robot has no shapes, or a frame carries none.

    Examples
    --------
    >>> from tasks import link_capsules, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> [hand] = link_capsules(panda, ["panda_hand"])
    >>> hand.name, round(hand.radius, 2)
    ('panda_hand', 0.05)
    """
    what = "link_capsules"
    geometry = shapes_of(robot, what)
    from ..robots.capsules import enclosing_capsule
    from ..robots.geometry import bodies_with_shapes

    model, found = robot.model, list[LinkCapsule]()  # type: ignore[attr-defined]
    for body in bodies_with_shapes(robot, bodies, what):
        number = bodies_of(robot, geometry).index(body)
        number = geometry.geometryObjects[number].parentFrame
        frame = model.frames[number]
        if bodies is None and frame.parentJoint == 0:
            continue
        start, end, radius = enclosing_capsule(geometry, number)
        there, same = frame.placement.inverse(), robot.frame_index(body) == number  # type: ignore[attr-defined]
        carrier = body if same else f"joint:{body}"
        found.append(LinkCapsule(carrier, there.act(end), radius, start=there.act(start), name=body))
    return tuple(found)


def _point(given: ArrayLike, what: str, allowed: str) -> Array:
    """A point in space or in the plane as an array, shape (3,)."""
    point = finite(given, what)
    if point.shape not in {(2,), (3,)}:
        raise InvalidInput(f"{what} has shape {point.shape}; it must be (3,){allowed}")
    return numbers(np.append(point, np.zeros(3 - len(point))), what)


def axes(frame: Frame) -> Array:
    """The axes of a frame in columns, shape (3, 3), also for a planar arm."""
    if frame.rotation.ndim == 2:
        return frame.rotation
    c, s = np.cos(frame.rotation[0]), np.sin(frame.rotation[0])
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
