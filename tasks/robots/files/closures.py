"""Equality constraints of a MuJoCo model that close chains: connected points and welded bodies.

A *connect* holds a point of one body at a point of another; a *weld* also holds their relative rotation. If they name
sites, the sites themselves are held. MuJoCo keeps the points in the coordinates of the bodies: a connect has the point
of the first body first, a weld that of the second. The rotation of the second body is that of the first times a
quaternion.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import pinocchio as pin

from hqp import InvalidInput

from ..closure import Closure
from ..frame import WORLD
from .couplings import active
from .mujoco_numbers import pose
from .scene import Scene

KINDS = {mujoco.mjtEq.mjEQ_CONNECT: "connect", mujoco.mjtEq.mjEQ_WELD: "weld"}


def closed_chains(
    mj: mujoco.MjModel,
    world: Any,
    scene: Scene,
    placed: Mapping[int, tuple[int, Any]],
    names: list[str],
    what: str,
) -> tuple[list[Closure], list[str]]:
    """The closed chains of the robot, and the equalities that are left out, with reasons.

    Parameters
    ----------
    mj : mujoco.MjModel
    world : mujoco.MjData
        At qpos0: where what stands is.
    scene : Scene
    placed : dict of int to tuple
        Its bodies, and the world: which joint of the model carries each.
    names : list of str
        Of all bodies.
    what : str
        The file, for messages.

    Raises
    ------
    InvalidInput
        If a body that is held has no name.
    """
    found, left_out = list[Closure](), list[str]()
    for i in active(mj):
        kind = mujoco.mjtEq(mj.eq_type[i])
        if kind not in KINDS:
            continue
        name, ends = mj.eq(i).name, _ends(mj, i)
        other = next((body for body, _ in ends if body not in scene.bodies), None)
        if all(body not in scene.bodies for body, _ in ends):
            continue
        if other is not None and not _stands(mj, other):
            left_out.append(
                f"{KINDS[kind]} {name or f'number {i}'!r} (to {names[other]!r}, which is no part of the robot)"
            )
            continue
        if len({placed[body][0] if body in placed else 0 for body, _ in ends}) < 2:
            continue  # both are one body
        (a, at), (b, at_b) = (_frame(mj, world, body, own, placed, names, what) for body, own in ends)
        rotation = (at_b.rotation @ at.rotation.T) if KINDS[kind] == "weld" else None
        found.append(Closure(name or f"{a} to {b}", a, b, at.translation, at_b.translation, rotation))
    return found, left_out


def _ends(mj: mujoco.MjModel, i: int) -> list[tuple[int, pin.SE3]]:
    """Both bodies, and of each the frame that is held, in its own coordinates."""
    objects, data = (int(mj.eq_obj1id[i]), int(mj.eq_obj2id[i])), mj.eq_data[i]
    if mj.eq_objtype[i] == mujoco.mjtObj.mjOBJ_SITE:
        return [(int(mj.site_bodyid[site]), pose(mj.site_pos[site], mj.site_quat[site])) for site in objects]
    first, second = pin.SE3.Identity(), pin.SE3.Identity()
    if mujoco.mjtEq(mj.eq_type[i]) == mujoco.mjtEq.mjEQ_WELD:
        first, second.translation = pose(data[3:6], data[6:10]), data[:3]
    else:
        first.translation, second.translation = data[:3], data[3:6]
    return [(objects[0], first), (objects[1], second)]


def _stands(mj: mujoco.MjModel, body: int) -> bool:
    """Whether a body is fixed to the world, and is not a mocap body."""
    return bool(mj.body_weldid[body] == 0 and mj.body_mocapid[mj.body_rootid[body]] < 0)


def _frame(
    mj: mujoco.MjModel,
    world: Any,
    body: int,
    own: pin.SE3,
    placed: Mapping[int, tuple[int, Any]],
    names: list[str],
    what: str,
) -> tuple[str, pin.SE3]:
    """The name of a body as a frame of the model, and the held frame in its coordinates; the world for fixed bodies."""
    if body == 0 or body not in placed:
        return WORLD, pose(world.xpos[body], world.xquat[body]) * own
    if not mj.body(body).name:
        raise InvalidInput(f"{what}: {names[body]} is held in a closed chain; give it a name")
    return names[body], own
