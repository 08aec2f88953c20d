"""What stands beside a robot in the scene of its MJCF, as solids to keep away from."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from hqp import InvalidInput
from hqp.checks import listed, of_type

from ..base.checks import suggestion
from ..base.live import structure
from ..robots.robot import Robot
from .solids import Box, Polyhedron, Solid


class SimpleSolid(Solid):
    """A sphere, capsule, cylinder, ellipsoid or half space of Coal, by its own sizes [m]."""

    kind: str = structure()
    sizes: tuple[Any, ...] = structure()

    def __init__(self, kind: str, sizes: tuple[Any, ...], at: Any, *, name: str) -> None:
        super().__init__(at, name)
        self.kind, self.sizes = kind, sizes

    def numbers(self) -> tuple[Any, ...]:
        return (self.at,)

    def shape(self) -> Any:
        from ..robots.convexity import shape_of

        return shape_of(self.kind, *self.sizes)

    def __repr__(self) -> str:
        return f"{self.kind} {self.name!r}"


def scene_solids(robot: Robot, names: Iterable[str] | None = None) -> list[Solid]:
    """The solids that stand beside a robot in the scene of its MJCF, for :class:`CollisionLimit`.

    These are the geoms that collide, of the world and of all bodies that are not the robot's and that nothing moves, no
    joint and no hand (mocap). Meshes become their convex hulls, planes half spaces. Each is where it stands in the
    scene; ``solid.at`` moves it.

    Parameters
    ----------
    robot : PinocchioRobot
        Loaded from an MJCF file or a ``mujoco.MjModel``.
    names : names, optional
        Bodies and geoms (default: all).

    Returns
    -------
    list of Solid
        In the order of the file, each with the name of its geom; without one, of its body and a number.

    Raises
    ------
    InvalidInput
        If the robot was not loaded from an MJCF, a name is none of these, or a geom has no convex shape, such as a
        height field.

    Examples
    --------
    >>> import mujoco
    >>> from tasks import CollisionLimit, load_robot, scene_solids
    >>> model = mujoco.MjModel.from_xml_string('''
    ... <mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
    ...   <body name="table" pos=".6 0 .2"><geom type="box" size=".3 .5 .2"/></body>
    ...   <body name="arm"><joint axis="0 1 0"/><geom type="capsule" size=".05" fromto="0 0 .5 .2 0 .5"/></body>
    ... </worldbody></mujoco>''')
    >>> robot = load_robot(model)
    >>> scene_solids(robot)
    [Halfspace 'floor', Box([0.6, 1.0, 0.4])]
    >>> away = CollisionLimit(scene_solids(robot, ["table"]), margin=0.02, gain=10.0)
    """
    scene = getattr(of_type(robot, Robot, "robot"), "scene", None)
    if scene is None:
        raise InvalidInput(f"scene_solids: {robot!r} was not loaded from an MJCF")
    from ..robots.files.mjcf_shapes import standing

    beside = standing(robot.model, scene)  # type: ignore[attr-defined]
    wanted = None
    if names is not None:
        wanted = [of_type(name, str, "scene_solids: name") for name in listed(names, "scene_solids: names", "names")]
        known = sorted({name for geom in beside for name in (geom.body, geom.name)})
        for name in wanted:
            if name not in known:
                raise InvalidInput(f"scene_solids: nothing that stands is called {name!r}{suggestion(name, known)}")
    return [_solid(geom) for geom in beside if wanted is None or geom.body in wanted or geom.name in wanted]


def _solid(geom: Any) -> Solid:
    kind, sizes = geom.kind, geom.sizes
    if kind == "Box":
        return Box(sizes, geom.at, name=geom.name)
    if kind == "hull":
        return Polyhedron(sizes, geom.at, name=geom.name)
    if kind == "":
        raise InvalidInput(f"scene_solids: geom {geom.name!r} has no convex shape; leave it out by names")
    return SimpleSolid(kind, sizes, geom.at, name=geom.name)
