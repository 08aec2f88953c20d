"""Robots from files, and by name from the package example-robot-data: nothing is fetched from a network."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from contextlib import redirect_stderr
from dataclasses import dataclass, field
from functools import cache
from io import StringIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, MissingPackage
from hqp.checks import truth

from .robot import nearest

if TYPE_CHECKING:
    import pinocchio as pin

    from .pinocchio import PinocchioRobot

#: What to do with joints that a URDF ties to another one: hold them, tie them, or let them move on their own.
Mimic = Literal["lock", "follow", "free"]

LOG = logging.getLogger("hqp")
_TOLD: set[tuple[str, tuple[str, ...]]] = set()  # each list of locked joints is told once


@dataclass(frozen=True)
class Entry:
    """A robot of the library.

    Attributes
    ----------
    file : str
        Its URDF, among the robots of example-robot-data.
    tip : str or None
        The frame that tasks mean which name none.
    floating_base : bool
    home : dict
        Joint -> position [rad], [m], of a configuration to start from; the other joints are neutral.
    height : float
        Of a floating base there [m].
    """

    file: str
    tip: str | None = None
    floating_base: bool = False
    home: Mapping[str, float] = field(default_factory=dict)
    height: float = 0.0


def _both(left: str, right: str, **joints: float) -> dict[str, float]:
    """The same joints on both sides: ``SIDE`` in their names is one, and the other."""
    return {name.replace("SIDE", side): value for name, value in joints.items() for side in (left, right)}


ROBOTS: dict[str, Entry] = {
    "panda": Entry(
        "panda_description/urdf/panda.urdf",
        "panda_hand_tcp",
        home={f"panda_joint{i + 1}": q for i, q in enumerate((0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785))},
    ),
    "ur3": Entry("ur_description/urdf/ur3_robot.urdf", "tool0"),
    "ur5": Entry(
        "ur_description/urdf/ur5_robot.urdf",
        "tool0",
        home={"shoulder_lift_joint": -1.2, "elbow_joint": 1.6, "wrist_1_joint": -1.9, "wrist_2_joint": -1.57},
    ),
    "ur10": Entry("ur_description/urdf/ur10_robot.urdf", "tool0"),
    "xarm7": Entry("xarm_description/urdf/xarm7.urdf", "link_eef"),
    "kinova": Entry("kinova_description/robots/kinova.urdf"),
    "z1": Entry("z1_description/urdf/z1.urdf"),
    "tiago": Entry("tiago_description/robots/tiago.urdf", "arm_tool_link"),
    "baxter": Entry("baxter_description/urdf/baxter.urdf"),
    "g1": Entry(
        "g1_description/urdf/g1_29dof_rev_1_0.urdf",
        floating_base=True,
        height=0.755,
        home=_both(
            "left",
            "right",
            SIDE_hip_pitch_joint=-0.3,
            SIDE_knee_joint=0.6,
            SIDE_ankle_pitch_joint=-0.3,
            SIDE_elbow_joint=0.8,
        ),
    ),
    "talos": Entry(
        "talos_data/robots/talos_reduced.urdf",
        floating_base=True,
        height=1.02,
        home=_both("left", "right", leg_SIDE_3_joint=-0.41, leg_SIDE_4_joint=0.86, leg_SIDE_5_joint=-0.45)
        | _both("left", "right", arm_SIDE_4_joint=-1.57),
    ),
    "icub": Entry("icub_description/robots/icub.urdf", floating_base=True, height=0.6),
    "go2": Entry("go2_description/urdf/go2.urdf", floating_base=True, height=0.4),
    "solo12": Entry("solo_description/robots/solo12.urdf", floating_base=True, height=0.3),
}


@cache
def data_folder() -> Path:
    """Where example-robot-data keeps its robots.

    Raises
    ------
    MissingPackage
        If it is not installed.
    """
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        files = distribution("example-robot-data").files or []
    except PackageNotFoundError:
        raise MissingPackage("robots by name need example-robot-data: pip install 'hqp[robots]'") from None
    place = next(file for file in files if str(file).endswith("share/example-robot-data/package.xml"))
    return Path(str(place.locate())).resolve().parent / "robots"


def available_robots() -> tuple[str, ...]:
    """Names that :func:`load_robot` knows: the library's, and those of all other URDF files of example-robot-data."""
    return (*ROBOTS, *sorted(_others()))


@cache
def _others() -> dict[str, str]:
    folder = data_folder()
    known = {entry.file for entry in ROBOTS.values()}
    found = {path.stem: str(path.relative_to(folder)) for path in sorted(folder.rglob("*.urdf"))}
    return {name: file for name, file in found.items() if file not in known and name not in ROBOTS}


def load_robot(
    source: str | PathLike[str],
    *,
    floating_base: bool | None = None,
    mimic: Mimic = "lock",
    lock: Iterable[str] | Mapping[str, float] = (),
    tip: str | None = None,
    position_limit: tuple[ArrayLike, ArrayLike] | None = None,
    velocity_limit: ArrayLike | None = None,
    acceleration_limit: ArrayLike | None = None,
    torque_limit: ArrayLike | None = None,
) -> PinocchioRobot:
    """A spatial robot, by name or from a file.

    Parameters
    ----------
    source : str or path
        A name, see :func:`available_robots`, or a file: ``.urdf``, or ``.xml`` for MuJoCo's MJCF.
    floating_base : bool, optional
        Whether the base moves freely, with six velocities before those of the joints (default: as the library knows the
        robot; False for a file). An MJCF file says itself.
    mimic : {"lock", "follow", "free"}
        What to do with joints that a URDF ties to another one: hold them at neutral (told once, by logging), tie them,
        or let them move on their own.
    lock : names, or dict of name to position
        Joints to be held, where neutral or at a position [rad], [m].
    tip : str, optional
        The frame that tasks mean which name none.
    position_limit, velocity_limit, acceleration_limit, torque_limit
        See :class:`~tasks.robots.pinocchio.PinocchioRobot`.

    Raises
    ------
    InvalidInput
        If there is no such robot or file, it cannot be read, or there is no such joint or frame; tells what is near.
    MissingPackage
        If Pinocchio is not installed, or for a name, example-robot-data.
    """
    if mimic not in get_args(Mimic):
        raise InvalidInput(f"mimic = {mimic!r}; it must be one of {', '.join(map(repr, get_args(Mimic)))}")
    from .pinocchio import PinocchioRobot, reduced

    entry, path = _find(source)
    floating = entry.floating_base if floating_base is None else truth(floating_base, "floating_base")
    what, positions = f"robot {str(source)!r}", _positions(lock)
    model = _parse(path, floating, mimic == "follow", what)
    if mimic == "lock":
        tied = _mimicking(path)
        unasked = tuple(name for name in tied if name not in positions)
        if unasked and (path.name, unasked) not in _TOLD:
            _TOLD.add((path.name, unasked))
            LOG.warning("%s: joints that mimic others are held at neutral: %s", path.name, ", ".join(unasked))
        positions = dict.fromkeys(tied) | positions
    model = reduced(model, positions, what)
    robot = PinocchioRobot(
        model,
        tip=entry.tip if tip is None else tip,
        name=str(source) if source in ROBOTS else None,
        position_limit=position_limit,
        velocity_limit=velocity_limit,
        acceleration_limit=acceleration_limit,
        torque_limit=torque_limit,
    )
    q = robot.configuration({joint: q for joint, q in entry.home.items() if joint in robot.joint_names})
    if floating:
        q[2] += entry.height
    robot.home = np.array(q)
    robot.home.flags.writeable = False
    robot.source = path.resolve()
    return robot


def _find(source: str | PathLike[str]) -> tuple[Entry, Path]:
    """What the library knows of it, and its file."""
    if not isinstance(source, (str, PathLike)):
        raise InvalidInput(f"robot = {source!r} is a {type(source).__name__}; it must be a name or a file")
    text = str(source)
    path = Path(source)
    if path.suffix in (".urdf", ".xml", ".mjcf"):
        if not path.is_file():
            raise InvalidInput(f"there is no file {text!r}")
        return Entry(text), path
    if text in ROBOTS:
        return ROBOTS[text], data_folder() / ROBOTS[text].file
    others = _others()
    if text not in others:
        hint = nearest(text, available_robots()) if text else ""
        hint = hint if "did you mean" in hint else ""
        raise InvalidInput(
            f"unknown robot {text!r}{hint}; give a .urdf or .xml file, or one of {', '.join(available_robots())}"
        )
    return Entry(others[text]), data_folder() / others[text]


def _positions(lock: Iterable[str] | Mapping[str, float]) -> dict[str, float | None]:
    """Joint -> where to hold it; None for neutral."""
    if isinstance(lock, str):
        raise InvalidInput(f"lock = {lock!r} is a str; it must be a list of joints, or a dict of positions")
    return dict(lock) if isinstance(lock, Mapping) else dict.fromkeys(lock)


def _parse(path: Path, floating: bool, follow: bool, what: str) -> pin.Model:
    import pinocchio as pin

    try:
        with redirect_stderr(StringIO()):
            if path.suffix != ".urdf":
                return pin.buildModelFromMJCF(str(path))
            if floating:
                return pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer(), follow)
            return pin.buildModelFromUrdf(str(path), follow)
    except (ValueError, RuntimeError) as error:
        raise InvalidInput(f"{what}: Pinocchio cannot read {str(path)!r}: {error}") from None


def _mimicking(path: Path) -> tuple[str, ...]:
    """The joints that a URDF ties to others, where Pinocchio keeps them."""
    if path.suffix != ".urdf":
        return ()
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(path), True)
    return tuple(model.names[index] for index in model.mimicking_joints)
