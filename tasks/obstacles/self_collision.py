r"""Limit: self-collision avoidance between the nearest pairs of a robot's bodies, with the shapes of its file.

With the witnesses p_1 and p_2 of a pair, n the unit normal from the second to the first,

.. math:: n^T (J_1 - J_2) x \ge -K (d - d_{min}),

and the same of the velocity at the end of the tick at acceleration order.
Shapes are convex, meshes by their hulls, and their distances come from Coal, by the method of E. G. Gilbert, D. W.
Johnson and S. S. Keerthi, "A fast procedure for computing the distance between complex objects in three-dimensional
space", IEEE Journal on Robotics and Automation 4(2), 1988. The witness of two flat faces may jump within a tick, and
no reserve is kept for that: the margin is passed by what one tick bends, of a Panda at 0.01 s by 0.01 mm at velocity
order and 0.4 mm at acceleration order. Where that matters, take a larger one.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hqp import InvalidInput, Label
from hqp.checks import listed, of_type, whole_number

from ..base.checks import Array, not_negative, pair, positive_scalar, scalar, suggestion
from ..base.live import number, structure
from ..robots.robot import Robot, RobotState, on_pinocchio
from ..rows.alone import write_alone
from ..rows.part import PER, Order, Part, Tick
from .distance import check_rate, told

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class SelfCollisionLimit(Part):
    """Keep the bodies of a robot at a distance from each other; see :mod:`tasks.obstacles.self_collision`.

    Parameters
    ----------
    pairs : iterable of (str, str), optional
        Frames of the bodies to be kept apart (default: all, but those with one joint between them or none, and those
        which are nearer than the margin at the robot's home).
    margin : float
        The least distance [m]; not negative.
    gain : float
        K [1/s]: the rate at which the margin is neared; at most 1/dt.
    rows : int
        For so many pairs, those which are nearest.
    name : str

    Raises
    ------
    InvalidInput
        If the margin is negative, the gain not positive or more than 1/dt, the robot has no file of shapes, a frame is
        none of its, or no pair is left.

    Examples
    --------
    >>> from tasks import Controller, JointLimits, PositionTask, SelfCollisionLimit, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> stack = JointLimits() + SelfCollisionLimit(margin=0.02, gain=5.0) >> PositionTask([0.0, 0.1, 0.3], gain=2.0)
    >>> Controller(panda, stack, dt=0.01)(panda.home).solution.certify().ok
    True
    """

    is_limit: ClassVar[bool] = True
    asked: tuple[tuple[str, str], ...] | None = structure()

    def __init__(
        self,
        pairs: Iterable[tuple[str, str]] | None = None,
        *,
        margin: float,
        gain: float,
        rows: int = 8,
        name: str = "self-collision",
    ) -> None:
        self.name = of_type(name, str, "name of a SelfCollisionLimit")
        self.asked = None if pairs is None else self._pairs(pairs)
        self.margin, self.gain = margin, gain
        self.rows = whole_number(rows, f"{self.label()}: rows", least=1)
        self.weight = 1.0
        self._bound: tuple[Robot, float, Shapes] | None = None

    @number
    def margin(self, value: float) -> float:
        """The least distance [m]; not negative."""
        return scalar(not_negative(value, f"{self.label()}: margin", unit="m"), f"{self.label()}: margin")

    @number
    def gain(self, value: float) -> float:
        """K [1/s]: the rate at which the margin is neared."""
        return positive_scalar(value, f"{self.label()}: gain", unit="1/s")

    def _pairs(self, pairs: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
        what, found = f"{self.label()}: pairs", list[tuple[str, str]]()
        for given in listed(pairs, what, "pairs of bodies"):
            first, second = pair(given, what, "two bodies")
            found.append((of_type(first, str, f"{what}: body"), of_type(second, str, f"{what}: body")))
        return tuple(found)

    def shapes(self, robot: Robot) -> Shapes:
        """The pairs of this robot."""
        bound = self._bound  # of this margin: what is nearer at home is left out
        if bound is None or bound[0] is not robot or bound[1] != self.margin:
            bound = self._bound = robot, self.margin, Shapes(robot, self.asked, self.margin, self.label())
        return bound[2]

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_bound": None}

    def size(self, robot: Robot) -> int:
        assert self.rows is not None
        return min(self.rows, len(self.shapes(robot)))

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        shapes = self.shapes(robot)
        whole = self.size(robot) == len(shapes)
        rows = shapes.names() if whole else [f"nearest {i + 1}" for i in range(self.size(robot))]
        return [Label(self.name, row, "m" + PER[order]) for row in rows]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        check_rate(self.label(), self.gain, order, dt)
        self.shapes(robot)

    def distances(self, robot: Robot, state: RobotState) -> Array:
        """The distances of the pairs [m], in the order of ``shapes(robot).names()``."""
        return self.shapes(robot).distances(state)

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        assert A is not None
        write_alone(self, tick, A, lower, upper)

    def plan(self, site: Site) -> Plan:
        """Coal finds the contacts, and a loop makes rows of them."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels import rows as loops

        site.bounds = True
        shapes, rows = self.shapes(site.shared.robot), site.rows
        contacts, bodies = np.zeros((rows, loops.CONTACT)), np.zeros((rows, 2), dtype=np.int64)
        blocks = {name: site.frame(name) for name in dict.fromkeys(name for pair in shapes.pairs for name in pair)}
        sides = [tuple(blocks[name].ctypes.data for name in pair) for pair in shapes.pairs]

        def measure(tick: Tick) -> None:
            for row, k in enumerate(sorted(shapes.closest(tick.state, rows))):
                bodies[row] = sides[k]
                shapes.contact(k, contacts[row])

        call = Call(loops.write_bodies, *told(site, [self.margin, self.gain]), contacts, bodies)
        return Plan((call,), python=measure, why="the distances of its shapes come from Coal")

    def __repr__(self) -> str:
        return f"SelfCollisionLimit(margin={self.margin:g}, gain={self.gain:g}, rows={self.rows})"


class Shapes:
    """The shapes of one robot, and which pairs of them are watched.

    Attributes
    ----------
    geometry : pinocchio.GeometryModel
    pairs : list of (str, str)
        The frames of the bodies of each pair.
    """

    def __init__(self, robot: Any, asked: tuple[tuple[str, str], ...] | None, margin: float, what: str) -> None:
        if not on_pinocchio(robot):
            raise InvalidInput(f"{what}: {robot!r} has no shapes; it needs a robot of load_robot")
        import pinocchio as pin

        from ..robots.geometry import neighbours, witnesses

        self._robot, self._pin, self._witnesses = robot, pin, witnesses
        self.geometry = pin.GeometryModel(robot.geometry())
        model, shapes = robot.model, self.geometry.geometryObjects
        bodies = [model.frames[shape.parentFrame].name for shape in shapes]
        wanted = None if asked is None else {frozenset(self._known(pair, bodies, what)) for pair in asked}
        for i in range(len(shapes)):
            for j in range(i + 1, len(shapes)):
                apart = not neighbours(model, shapes[i].parentJoint, shapes[j].parentJoint)
                if apart if wanted is None else frozenset((bodies[i], bodies[j])) in wanted:
                    self.geometry.addCollisionPair(pin.CollisionPair(i, j))
        self._data = pin.GeometryData(self.geometry)
        if wanted is None:
            home = self.distances(robot.at(robot.home, np.zeros(robot.nv)))
            for k in np.flatnonzero(home <= margin)[::-1]:
                self.geometry.removeCollisionPair(self.geometry.collisionPairs[int(k)])
            self._data = pin.GeometryData(self.geometry)
        if not len(self):
            raise InvalidInput(f"{what}: no pair of {robot!r} is left to be kept apart; name some in pairs")
        self.pairs = [(bodies[pair.first], bodies[pair.second]) for pair in self.geometry.collisionPairs]
        for shape in shapes:
            shape.geometry.computeLocalAABB()
        self._centres = [np.array(shape.geometry.aabb_center) for shape in shapes]
        self._radii = np.array([shape.geometry.aabb_radius for shape in shapes])
        self._sides = np.array([(pair.first, pair.second) for pair in self.geometry.collisionPairs]).T

    def __len__(self) -> int:
        return len(self.geometry.collisionPairs)

    def names(self) -> list[str]:
        """One a pair: ``"panda_hand - panda_link0"``."""
        return [" - ".join(pair) for pair in self.pairs]

    def distances(self, state: RobotState) -> Array:
        """The distances of all pairs [m]; negative where two shapes overlap."""
        self._place(state)
        self._pin.computeDistances(self.geometry, self._data)
        return np.array([result.min_distance for result in self._data.distanceResults])

    def closest(self, state: RobotState, count: int) -> list[int]:
        """So many pairs, none of the others nearer.

        A ball about each shape tells the least that a pair can be apart; those farther than the last one wanted are
        not measured.
        """
        self._place(state)
        centres = np.array([place.act(ball) for place, ball in zip(self._data.oMg, self._centres, strict=True)])
        first, second = self._sides
        least = np.linalg.norm(centres[first] - centres[second], axis=1) - self._radii[first] - self._radii[second]
        found: list[tuple[float, int]] = []
        for k in np.argsort(least, kind="stable").tolist():
            if len(found) == count and least[k] > found[-1][0]:
                break
            insort(found, (float(self._pin.computeDistance(self.geometry, self._data, k).min_distance), k))
            del found[count:]
        return [k for _, k in found]

    def contact(self, k: int, out: Array) -> None:
        """One of them, as the last look at the distances found it: the distance, the normal, and both witnesses."""
        out[0], out[4:7], out[7:], out[1:4] = self._witnesses(self._data.distanceResults[k])

    def _place(self, state: RobotState) -> None:
        """Put the shapes where the joints are, whose places come with the joint Jacobians of a state."""
        data = state.ready()  # type: ignore[attr-defined]
        self._pin.updateGeometryPlacements(self._robot.model, data, self.geometry, self._data)

    @staticmethod
    def _known(both: tuple[str, str], bodies: list[str], what: str) -> tuple[str, str]:
        for name in both:
            if name not in bodies:
                raise InvalidInput(
                    f"{what}: {name!r} is no body with a shape{suggestion(str(name), dict.fromkeys(bodies))}"
                )
        return both
