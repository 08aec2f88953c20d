"""Links of a robot as capsules, each carried by a frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.checks import Array, finite, not_negative, numbers, scalar
from ..base.live import Live, number, structure
from ..robots.frame import Frame
from ..robots.planar import PlanarArm
from ..robots.robot import Robot, check_frame, integrate, neutral

#: What "carried by a frame" may differ by when the joints move [m].
RIGID = 1e-9


class LinkCapsule(Live):
    """All points within a radius of the segment from one frame to another, carried by the first.

    Parameters
    ----------
    frame : str
        The frame that carries it.
    end : str or array, shape (3,) or (2,)
        Where the segment ends: another frame whose origin the first carries too, as that of the next joint; or a point
        in the coordinates of `frame` [m].
    radius : float
        [m].
    name : str, optional
        For labels (default: the name of the frame).

    Raises
    ------
    InvalidInput
        If the radius is negative or the end neither a name nor a point.

    Examples
    --------
    >>> from tasks import LinkCapsule
    >>> LinkCapsule("panda_link5", "panda_link6", 0.06, name="forearm")
    LinkCapsule('panda_link5', 'panda_link6', 0.06)
    """

    frame: str = structure()
    end: str | Array = structure()
    name: str = structure()

    def __init__(self, frame: str, end: str | ArrayLike, radius: float, *, name: str | None = None) -> None:
        self.frame = of_type(frame, str, "LinkCapsule: frame")
        self.name = frame if name is None else of_type(name, str, "LinkCapsule: name")
        self.radius = radius
        if isinstance(end, str):
            self.end = end
        else:
            point = finite(end, f"LinkCapsule {frame!r}: end")
            if point.shape not in {(2,), (3,)}:
                raise InvalidInput(f"LinkCapsule {frame!r}: end has shape {point.shape}; it must be (3,), or a frame")
            self.end = numbers(np.append(point, np.zeros(3 - len(point))), "end")

    @number
    def radius(self, value: float) -> float:
        """About the segment [m]; not negative."""
        return scalar(not_negative(value, f"{self.full_name()}: radius", unit="m"), f"{self.full_name()}: radius")

    def bind(self, robot: Robot) -> Array:
        """Where the segment ends in the coordinates of the frame, shape (3,) [m].

        Raises
        ------
        InvalidInput
            If the robot has no such frame, or the end moves against it.
        """
        for name in (self.frame, self.end):
            if isinstance(name, str):
                check_frame(robot, name, "LinkCapsule:")
        if not isinstance(self.end, str):
            return self.end
        q, step = neutral(robot), 0.3 * np.cos(np.arange(robot.nv))
        local = []
        for there in (q, integrate(robot, q, step)):
            state = robot.at(there, np.zeros(robot.nv))
            frame = state.frame(self.frame)
            local.append(axes(frame).T @ (state.frame(self.end).position - frame.position))
        if np.abs(local[0] - local[1]).max() > RIGID:
            raise InvalidInput(
                f"LinkCapsule: {self.frame!r} does not carry {self.end!r}; name them the other way round"
            )
        return local[0]

    def __repr__(self) -> str:
        end = self.end if isinstance(self.end, str) else self.end.tolist()
        return f"LinkCapsule({self.frame!r}, {end!r}, {self.radius:g})"


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


def axes(frame: Frame) -> Array:
    """The axes of a frame in columns, shape (3, 3), of a planar arm too."""
    if frame.rotation.ndim == 2:
        return frame.rotation
    c, s = np.cos(frame.rotation[0]), np.sin(frame.rotation[0])
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
