"""Limit: self-collision avoidance between the nearest pairs of a robot's bodies; see :mod:`.shapes_limit`."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from pathlib import Path

from hqp import InvalidInput
from hqp.checks import listed, of_type

from ..base.checks import pair
from ..base.live import structure
from ..robots.robot import Robot
from .body_shapes import Shapes, bodies_of, known, shapes_of
from .shapes_limit import ShapesLimit

#: Two bodies, by their frames.
Both = tuple[str, str]


class SelfCollisionLimit(ShapesLimit):
    """Keep the bodies of a robot at a distance from each other.

    Their shapes are those of the file, URDF or MJCF, or of ``robot.with_geometry(...)``.

    Parameters
    ----------
    pairs : iterable of (str, str), optional
        Frames of the bodies to be kept apart (default: the pairs given with the shapes, as in an MJCF, else all pairs;
        in both cases without pairs with at most one joint between them, and those nearer than the margin at home).
    without : iterable of (str, str), or path of an SRDF, optional
        Pairs to be left out: those named, or all that the file disables.
    margin : float
        The least distance [m]; not negative.
    gain : float
        K [1/s]: the rate at which the margin is neared; at most 1/dt.
    rows : int
        Number of rows, one for each of the nearest pairs.
    name : str

    Raises
    ------
    InvalidInput
        If the margin is negative, the gain not positive or more than 1/dt, the robot has no file of shapes, a frame is
        unknown, or no pair is left; or if a file is not an SRDF.

    Examples
    --------
    >>> from tasks import Controller, JointLimits, PositionTask, SelfCollisionLimit, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> stack = JointLimits() + SelfCollisionLimit(margin=0.02, gain=5.0) >> PositionTask([0.0, 0.1, 0.3], gain=2.0)
    >>> Controller(panda, stack, dt=0.01)(panda.home).solution.certify().ok
    True
    """

    asked: tuple[Both, ...] | None = structure()
    without: tuple[Both, ...] = structure()

    def __init__(
        self,
        pairs: Iterable[Both] | None = None,
        *,
        without: Iterable[Both] | str | PathLike[str] = (),
        margin: float,
        gain: float,
        rows: int = 8,
        name: str = "self-collision",
    ) -> None:
        self.name = of_type(name, str, "name of a SelfCollisionLimit")
        self.asked = None if pairs is None else self._pairs(pairs, "pairs")
        if isinstance(without, str | PathLike):
            self.without = disabled(Path(without), f"{self.full_name()}: without = {str(without)!r}")
            self._strict = False  # files name bodies that have no shape
        else:
            self.without, self._strict = self._pairs(without, "without"), True
        super().__init__(margin=margin, gain=gain, rows=rows, name=name)

    def _pairs(self, pairs: Iterable[Both], option: str) -> tuple[Both, ...]:
        what, found = f"{self.full_name()}: {option}", list[Both]()
        for given in listed(pairs, what, "pairs of bodies"):
            first, second = pair(given, what, "two bodies")
            found.append((of_type(first, str, f"{what}: body"), of_type(second, str, f"{what}: body")))
        return tuple(found)

    def found(self, robot: Robot) -> Shapes:
        from ..robots.geometry import neighbours

        geometry, model = shapes_of(robot, self.full_name()), robot.model  # type: ignore[attr-defined]
        bodies, carriers = bodies_of(robot, geometry), [shape.parentJoint for shape in geometry.geometryObjects]
        for named in (*(self.asked or ()), *(self.without if self._strict else ())):
            known(named, bodies, self.full_name())
        pairs = [(own.first, own.second) for own in geometry.collisionPairs] if self.asked is None else []
        pairs = pairs or [(i, j) for i in range(len(bodies)) for j in range(i + 1, len(bodies))]
        if self.asked is None:
            pairs = [(i, j) for i, j in pairs if not neighbours(model, carriers[i], carriers[j])]
        else:
            wanted = {frozenset(both) for both in self.asked}
            pairs = [(i, j) for i, j in pairs if frozenset((bodies[i], bodies[j])) in wanted]
        left_out = {frozenset(both) for both in self.without}
        pairs = [(i, j) for i, j in pairs if frozenset((bodies[i], bodies[j])) not in left_out]
        shapes = Shapes(robot, geometry, pairs)
        if self.asked is None and len(shapes):
            shapes.leave_out(self.margin)
        if not len(shapes):
            raise InvalidInput(f"{self.full_name()}: no pair of {robot!r} is left to be kept apart; name some in pairs")
        return shapes


def disabled(path: Path, what: str) -> tuple[Both, ...]:
    """The pairs of bodies that an SRDF disables.

    Raises
    ------
    InvalidInput
        If the file cannot be read, or names no pair.
    """
    from ..robots.files.xml import parsed

    found = parsed(path, what).iter("disable_collisions")
    pairs = tuple((str(own.get("link1")), str(own.get("link2"))) for own in found)
    if not pairs:
        raise InvalidInput(f"{what} disables no collisions; it must be an SRDF with disable_collisions")
    return pairs
