"""Robots from names and files: read, verified, and with joints held or tied as asked for."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import truth

from .choices import Base, Mimic
from .library import ROBOTS, Entry, available_robots, named

if TYPE_CHECKING:
    import mujoco

    from .pinocchio import PinocchioRobot

#: A limit of all joints, or of those that are named.
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
        The body that a robot begins with, where an MJCF has several; those of a list become one robot.
    mimic : {"lock", "follow", "free"}
        What to do with joints that the file ties to others: hold them where the neutral place of the others puts them
        (told once, by logging), tie them, or let them move on their own.
    lock : names, or dict of name to position
        Joints to be held, where neutral or at a position [rad], [m].
    tip : str, optional
        The frame that tasks mean which name none.
    position_limit : pair of float or array, or dict of name to pair, optional
        Lowest and highest positions [rad], [m]; a dict changes the joints that it names and leaves the rest.
    velocity_limit, acceleration_limit, torque_limit : float, array or dict of name to float, optional
        Largest speeds [rad/s], [m/s], accelerations [rad/s^2], [m/s^2], torques [N m], forces [N].
        See :class:`~tasks.robots.pinocchio.PinocchioRobot`.
    floating_base : bool, optional
        The old name of ``base="floating"``; deprecated.

    Raises
    ------
    InvalidInput
        If there is no such robot or file, it cannot be read exactly, or there is no such joint, body or frame, or a
        joint is held or limited where it cannot be; tells the element, and what is near.
    MissingPackage
        If Pinocchio is not installed; for a name, example-robot-data; for MJCF, MuJoCo.
    """
    entry, file, what = _find(source)
    chosen = _base(base, floating_base, entry)
    for given, allowed, option in (mimic, get_args(Mimic), "mimic"), (chosen, (None, *get_args(Base)), "base"):
        if given not in allowed:
            raise InvalidInput(f"{option} = {given!r}; it must be one of {', '.join(map(repr, allowed))}")
    from .model_file import describe
    from .pinocchio import PinocchioRobot
    from .ranges import open_ranges, tell
    from .reduction import reduced
    from .ties import arrange, resolve
    from .verification import verify

    positions = _positions(lock)
    described = describe(file, chosen, _bodies(body), what)
    verify(described.model, what)
    open_ranges(described.model, what)
    if described.left_out:
        tell(f"{what}: left out of the robot: {', '.join(described.left_out)}")
    if mimic == "free":
        model, neutral = reduced(described.model, positions, described.neutral, what)
    else:
        ties = resolve(described.ties, described.model, described.fixed, positions, what)
        model, neutral = arrange(described.model, described.neutral, ties, mimic, positions, what)
        if ties and mimic == "lock":
            tell(f"{what}: joints that follow others are held: {', '.join(tie.follower for tie in ties)}")
    robot = PinocchioRobot(
        model,
        tip=entry.tip if tip is None else tip,
        name=str(source) if entry.file else None,
        position_limit=position_limit,
        velocity_limit=velocity_limit,
        acceleration_limit=acceleration_limit,
        torque_limit=torque_limit,
    )
    robot.start_from(neutral)
    if entry.home or entry.height:
        q = robot.configuration({joint: q for joint, q in entry.home.items() if joint in robot.joint_names})
        if robot.base == 6:
            q[2] += entry.height
        robot.home = q
        robot.home.flags.writeable = False
    robot.left_out = described.left_out
    robot.source = file.resolve() if isinstance(file, Path) else None
    return robot


def _find(source: Any) -> tuple[Entry, Any, str]:
    """What the library knows of it, its file or model, and how messages call it."""
    if not isinstance(source, (str, PathLike)):
        if type(source).__name__ == "MjModel":
            return Entry(""), source, "robot of an MjModel"
        raise InvalidInput(f"robot = {source!r} is a {type(source).__name__}; it must be a name, a file or an MjModel")
    from .model_file import check_file, looks_like_a_file

    what = f"robot {str(source)!r}"
    if isinstance(source, str) and not looks_like_a_file(source):
        if source not in ROBOTS and source and Path(source).is_dir() and source not in available_robots():
            check_file(source)  # which tells what is in the folder
        return *named(source), what
    return Entry(""), check_file(source), what


def _base(base: Any, floating_base: bool | None, entry: Entry) -> Any:
    """The base asked for; as the library knows it where none is; None where the file is to say."""
    if floating_base is not None:
        warnings.warn("floating_base is now base='floating' or base='fixed'", DeprecationWarning, stacklevel=3)
        old = "floating" if truth(floating_base, "floating_base") else "fixed"
        if base not in (None, old):
            raise InvalidInput(f"floating_base = {floating_base!r}, but base = {base!r}; give base alone")
        return old
    return entry.base if base is None and entry.file else base


def _bodies(body: Any) -> list[str] | None:
    if body is None:
        return None
    names = [body] if isinstance(body, str) else list(body) if isinstance(body, Iterable) else [body]
    if not names or not all(isinstance(name, str) for name in names):
        raise InvalidInput(f"body = {body!r} must be the name of a body, or a list of names")
    return names


def _positions(lock: Any) -> dict[str, float | None]:
    """Joint -> where to hold it; None for neutral."""
    if isinstance(lock, str) or not isinstance(lock, Iterable):
        raise InvalidInput(
            f"lock = {lock!r} is a {type(lock).__name__}; it must be a list of joints, or a dict of positions"
        )
    return dict(lock) if isinstance(lock, Mapping) else dict.fromkeys(lock)
