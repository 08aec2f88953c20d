"""Robots from names and files: read, verified, and with joints held or tied as asked for."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import listed, truth
from hqp.errors import brief

from ..base.checks import finite_scalar
from ..base.telling import tell
from .choices import Base, Mimic
from .library import ROBOTS, Entry, available_robots, named

if TYPE_CHECKING:
    import mujoco

    from .files.description import Description
    from .pinocchio import PinocchioRobot

#: A limit for all joints, or for the named ones.
Limit = ArrayLike | Mapping[str, float]
Range = tuple[ArrayLike, ArrayLike] | Mapping[str, tuple[float, float]]


def load_robot(
    source: str | PathLike[str] | mujoco.MjModel,
    *,
    base: Base | None = None,
    body: str | Iterable[str] | None = None,
    mimic: Mimic = "lock",
    lock: Iterable[str] | Mapping[str, float] = (),
    tip: str | None = None,
    position_limit: Range | None = None,
    velocity_limit: Limit | None = None,
    acceleration_limit: Limit | None = None,
    torque_limit: Limit | None = None,
    floating_base: bool | None = None,
) -> PinocchioRobot:
    """A spatial robot, by name or from a file.

    Parameters
    ----------
    source : str, path, or mujoco.MjModel
        A name, see :func:`available_robots`; a file, URDF or MJCF; or a model that MuJoCo has compiled.
    base : {"fixed", "planar", "floating"}, optional
        How the robot stands in the world: mounted; moving in the plane, with three velocities before those of the
        joints, along its own axes; or free, with six. Default: as the library knows the robot, as an MJCF says,
        mounted for a URDF.
    body : str or list of str, optional
        The root body of the robot, if an MJCF has several; the bodies of a list become one robot.
    mimic : {"lock", "follow", "free"}
        What to do with mimic joints: lock them at the neutral configuration (logged once), let them follow, or let
        them move independently.
    lock : names, or dict of name to position
        Joints to lock, at neutral or at the given position [rad], [m].
    tip : str, optional
        The frame used by tasks that name no frame.
    position_limit : pair of float or array, or dict of name to pair, optional
        Lowest and highest positions [rad], [m]; a dict changes the joints that it names and leaves the rest.
    velocity_limit, acceleration_limit, torque_limit : float, array or dict of name to float, optional
        Largest speeds [rad/s], [m/s], accelerations [rad/s^2], [m/s^2], torques [N m], forces [N].
        A speed of 0 holds a joint, and one with a torque of 0 has no motor. See
        :class:`~tasks.robots.pinocchio.PinocchioRobot`.
    floating_base : bool, optional
        The old name of ``base="floating"``; deprecated.

    Raises
    ------
    InvalidInput
        If there is no such robot or file, it cannot be read exactly, there is no such joint, body or frame, or a joint
        cannot be locked or limited as asked; the message names the element, and similar names.
    MissingPackage
        If Pinocchio is not installed; for a name, example-robot-data; for MJCF, MuJoCo.

    Examples
    --------
    >>> from tasks import load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> panda.nv, panda.tip
    (7, 'panda_hand_tcp')
    """
    entry, file, what = _find(source)
    chosen = _base(base, floating_base, entry)
    _check_option(mimic, get_args(Mimic), "mimic")
    from .files.language import describe
    from .pinocchio import PinocchioRobot
    from .verification import verify

    positions = _positions(lock)
    described = describe(file, chosen, _bodies(body), what)
    verify(described.model, what)
    _tell_left_out(described, what)
    given: dict[str, Any] = {"position": position_limit, "velocity": velocity_limit, "torque": torque_limit}
    named = {key: limit for key, limit in given.items() if isinstance(limit, Mapping)}
    model, neutral, followers, recipe = _arranged(_limited(described, named, what), mimic, positions, what)
    _check_named(model, named, what)
    given = {f"{key}_limit": None if key in named else limit for key, limit in given.items()}
    own: dict[str, Any] = {"tip": entry.tip if tip is None else tip, "name": str(source) if entry.file else None}
    robot = PinocchioRobot(model, **own, **given, acceleration_limit=acceleration_limit, follower_limits=followers)
    robot.start_from(neutral)
    _take_home(robot, entry)
    robot.recipe, robot.source = recipe, file.resolve() if isinstance(file, Path) else None
    _take_rest(robot, described)
    return robot


def _take_rest(robot: PinocchioRobot, described: Description) -> None:
    """Give the robot what its file has beside the model; springs of joints that follow others are none, and told."""
    robot.left_out, robot.closures, robot.scene = described.left_out, described.closures, described.scene
    robot.springs = {joint: spring for joint, spring in described.springs.items() if joint in robot.joint_names}
    followers = {robot.model.names[i] for i in robot.model.mimicking_joints}
    if followers.intersection(described.springs):
        names = ", ".join(joint for joint in described.springs if joint in followers)
        tell(f"{robot!r}: springs of joints that follow others are left out: {names}")


def _take_home(robot: PinocchioRobot, entry: Entry) -> None:
    """Give the robot the home configuration that the library knows, if any, at its height above the ground."""
    if entry.home or entry.height:
        q = robot.near({joint: angle for joint, angle in entry.home.items() if joint in robot.joint_names})
        if robot.base == 6:
            q[2] += entry.height
        robot.home = q


def _tell_left_out(described: Description, what: str) -> None:
    if described.closures:
        names = ", ".join(closure.name for closure in described.closures)
        tell(f"{what}: closed chains are closed in a stack by Loop.of(robot): {names}")
    if described.left_out:
        tell(f"{what}: left out of the robot: {', '.join(described.left_out)}")


def _check_option(given: Any, allowed: tuple[Any, ...], option: str) -> None:
    """Refuse a value that is none of those allowed."""
    if not isinstance(given, str | None) or given not in allowed:
        raise InvalidInput(f"{option} = {brief(given)}; it must be one of {', '.join(map(repr, allowed))}")


def _limited(described: Description, named: Mapping[str, Any], what: str) -> Description:
    """The description with these limits instead of the file's, before joints are tied or locked."""
    import pinocchio as pin

    from .joint_axes import NONE, joint_axes
    from .pinocchio import SPEED, TORQUE
    from .ranges import HELD, largest, position_limit

    if not named:
        return described
    model = pin.Model(described.model)
    ranges = position_limit(model, named.get("position"), what, zero_is_none=False)
    for i, axis in enumerate(joint_axes(model)):
        if axis.q_index != NONE and ranges is not None:
            model.lowerPositionLimit[axis.q_index], model.upperPositionLimit[axis.q_index] = ranges[:, i]
    for key, upper, lower, units in (
        ("velocity", model.upperVelocityLimit, model.lowerVelocityLimit, SPEED),
        ("torque", model.upperEffortLimit, model.lowerEffortLimit, TORQUE),
    ):
        if key in named:
            limits = largest(model, named[key], upper, f"{what}: {key} limit", units, zero_holds=True)
            if limits is not None:
                limits[limits == 0.0] = HELD
                upper[:], lower[:] = limits, -limits
    return replace(described, model=model)


def _check_named(model: Any, named: Mapping[str, Any], what: str) -> None:
    """Refuse a limit of a joint that is locked, as it would have no effect."""
    from .joint_axes import joint_axes

    own = {name for axis in joint_axes(model) for name in (axis.name, axis.joint)}
    moving = own | set(model.names)
    for key, limits in named.items():
        for name in limits:
            if isinstance(name, str) and name not in moving:
                raise InvalidInput(f"{what}: {key} limit of joint {name!r}: it is held; lock=, or mimic=, says so")
            if key == "torque" and isinstance(name, str) and name not in own:
                raise InvalidInput(f"{what}: torque limit of joint {name!r}: it follows another, which bears it")


def _arranged(described: Description, mimic: Mimic, positions: dict[str, float | None], what: str) -> Any:
    """The model with joints held and tied as asked for; see :class:`tasks.robots.files.ties.Arrangement`."""
    from .files.reduction import reduced
    from .files.ties import arrange, resolve

    if mimic == "free":
        return *reduced(described.model, positions, described.neutral, what), {}, None
    ties = resolve(described.ties, described.model, described.fixed, positions, what)
    if ties and mimic == "lock":
        tell(f"{what}: joints that follow others are held: {', '.join(tie.follower for tie in ties)}")
    return arrange(described.model, described.neutral, ties, mimic, positions, what)


def _find(source: Any) -> tuple[Entry, Any, str]:
    """The library entry, the file or model, and the name in messages, of a source."""
    if not isinstance(source, (str, PathLike)):
        mujoco = sys.modules.get("mujoco")  # without this module no MjModel exists
        if mujoco is not None and isinstance(source, mujoco.MjModel):
            return Entry(""), source, "robot of an MjModel"
        raise InvalidInput(
            f"robot = {brief(source)} is a {type(source).__name__}; it must be a name, a file or an MjModel"
        )
    from .files.language import check_file, is_folder, looks_like_a_file

    what = f"robot {str(source)!r}"
    if isinstance(source, str) and not looks_like_a_file(source):
        if source and source not in ROBOTS and is_folder(source) and source not in available_robots():
            check_file(source)  # raises, and lists the files of the folder
        return *named(source), what
    return Entry(""), check_file(source), what


def _base(base: Any, floating_base: bool | None, entry: Entry) -> Any:
    """The base asked for, or else that of the library entry; None if the file decides."""
    if floating_base is not None:
        warnings.warn("floating_base is now base='floating' or base='fixed'", DeprecationWarning, stacklevel=3)
        old = "floating" if truth(floating_base, "floating_base") else "fixed"
        if base not in (None, old):
            raise InvalidInput(f"floating_base = {floating_base!r}, but base = {base!r}; give base alone")
        return old
    chosen = entry.base if base is None and entry.file else base
    _check_option(chosen, (None, *get_args(Base)), "base")
    return chosen


def _bodies(body: Any) -> list[str] | None:
    if body is None:
        return None
    what = f"body = {brief(body)} must be the name of a body, or a list of names"
    try:
        names = [body] if isinstance(body, str) else listed(body, "body", "names")
    except InvalidInput:
        raise InvalidInput(what) from None
    if not names or not all(isinstance(name, str) for name in names):
        raise InvalidInput(what)
    return names


def _positions(lock: Any) -> dict[str, float | None]:
    """Joint -> where to hold it; None for neutral."""
    names = listed(lock, "lock", "joints, or a dict of positions")
    wrong = next((name for name in names if not isinstance(name, str)), None)
    if wrong is not None:
        raise InvalidInput(f"lock: {brief(wrong)} is a {type(wrong).__name__}; it must be the name of a joint")
    if not isinstance(lock, Mapping):
        return dict.fromkeys(names)
    return {name: None if q is None else finite_scalar(q, f"lock of joint {name!r}") for name, q in lock.items()}
