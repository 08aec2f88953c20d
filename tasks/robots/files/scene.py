"""Finds the bodies of the robot in a MuJoCo model, which may have tables, targets or a second robot.

The children of the world are roots of trees. A tree without joints is furniture, a mocap body is a target, and a tree
with only a free joint is an object to handle. If a tree with other joints exists, all of these are left out and logged.
If the only movable body is one with a free joint, it is the robot.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hqp import InvalidInput

from ...base.checks import suggestion

if TYPE_CHECKING:
    import mujoco

FREE = 0  # mjtJoint.mjJNT_FREE
WORLD = 0


@dataclass(frozen=True)
class Scene:
    """The bodies of a MuJoCo model that are the robot.

    Attributes
    ----------
    roots : tuple of int
        Its root bodies; one that floats comes first.
    bodies : tuple of int
        All its bodies, each after its parent.
    left_out : tuple of str
        All other bodies, with reasons.
    """

    roots: tuple[int, ...]
    bodies: tuple[int, ...]
    left_out: tuple[str, ...]


def scene(mj: mujoco.MjModel, asked: Iterable[str] | None, what: str) -> Scene:
    """The robot among the bodies of a model: those of the names asked for, or the only one there is.

    Raises
    ------
    InvalidInput
        If there is no robot or several, a name is not a body, or a body is moved by a joint outside the robot.
    """
    names = body_names(mj)
    trees = {root: _tree(mj, root) for root in range(1, mj.nbody) if mj.body_parentid[root] == WORLD}
    kinds = {root: _kind(mj, tree) for root, tree in trees.items()}
    if asked is None:
        robots = [root for root, kind in kinds.items() if kind == "robot"]
        robots = robots or [root for root, kind in kinds.items() if kind == "free"]
        if len(robots) > 1:
            told = ", ".join(repr(names[root]) for root in robots)
            raise InvalidInput(
                f"{what} has several robots; choose by body={names[robots[0]]!r}, or all that are to be one by"
                f" body=[{told}]"
            )
        roots = robots
    else:
        roots = [_named(mj, name, names, what) for name in asked]
        if len(set(roots)) < len(roots):
            raise InvalidInput(f"{what}: body = {[names[root] for root in roots]} names one twice")
    if not roots:
        raise InvalidInput(f"{what} has 0 degrees of freedom: no body has a joint")
    roots.sort(key=lambda root: not _floats(mj, root))
    if sum(_floats(mj, root) for root in roots) > 1:
        raise InvalidInput(f"{what}: {' and '.join(repr(names[r]) for r in roots)} float, each by itself; choose one")
    bodies = tuple(body for root in roots for body in _tree(mj, root))
    if len(set(bodies)) < len(bodies):
        raise InvalidInput(f"{what}: of the bodies {[names[r] for r in roots]} one carries another; name one of them")
    carriers = {WORLD, *(ancestor for root in roots for ancestor in _ancestors(mj, root))}
    beside = [
        body
        for body in range(1, mj.nbody)
        if body not in bodies and mj.body_parentid[body] in carriers and body not in carriers
    ]
    left_out = [f"{names[body]!r} ({KINDS[_kind(mj, _tree(mj, body))]})" for body in beside]
    left_out += [f"{names[body]!r} (carries the robot, and stands)" for body in sorted(carriers - {WORLD})]
    return Scene(tuple(roots), bodies, tuple(left_out))


KINDS = {"mocap": "mocap", "furniture": "no joints", "free": "floats by itself", "robot": "another robot"}


def body_names(mj: mujoco.MjModel) -> list[str]:
    """One name per body; its number if it has no name."""
    return [mj.body(i).name or f"body {i}" for i in range(mj.nbody)]


def body_name(mj: mujoco.MjModel, body: int) -> str:
    """The name of a body; one of its own where it has none, such as ``"body3"``."""
    name = str(mj.body(body).name)
    if not name:
        taken, name = {mj.body(i).name for i in range(mj.nbody)}, f"body{body}"
        while name in taken:
            name += "_"
    return name


def _tree(mj: mujoco.MjModel, root: int) -> list[int]:
    """A body and all that it carries."""
    own = {root}
    for body in range(root + 1, mj.nbody):  # parents come first
        if mj.body_parentid[body] in own:
            own.add(body)
    return sorted(own)


def _kind(mj: mujoco.MjModel, tree: list[int]) -> str:
    joints = [int(mj.jnt_type[j]) for body in tree for j in _joints(mj, body)]
    if any(kind != FREE for kind in joints):
        return "robot"
    if joints:
        return "free"
    return "mocap" if mj.body_mocapid[tree[0]] >= 0 else "furniture"


def _joints(mj: mujoco.MjModel, body: int) -> range:
    first = int(mj.body_jntadr[body])
    return range(first, first + int(mj.body_jntnum[body]))


def _floats(mj: mujoco.MjModel, body: int) -> bool:
    return any(mj.jnt_type[j] == FREE for j in _joints(mj, body))


def _ancestors(mj: mujoco.MjModel, body: int) -> list[int]:
    found = []
    while (body := int(mj.body_parentid[body])) != WORLD:
        found.append(body)
    return found


def _named(mj: mujoco.MjModel, name: str, names: list[str], what: str) -> int:
    if name not in names[1:]:
        raise InvalidInput(f"{what}: {name!r} is no body{suggestion(str(name), names[1:])}")
    body = names.index(name, 1)
    carried = [names[b] for b in _ancestors(mj, body) if mj.body_jntnum[b]]
    if carried:
        raise InvalidInput(f"{what}: body {name!r} is carried by the joints of {carried[-1]!r}; name that one")
    if mj.body_mocapid[body] >= 0 and len(_tree(mj, body)) == 1:
        raise InvalidInput(f"{what}: body {name!r} is mocap, moved by hand and not by joints")
    return body
