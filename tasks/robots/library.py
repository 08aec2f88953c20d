"""Robots by name, from the installed package example-robot-data, without network access."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from hqp import InvalidInput, MissingPackage

from ..base.checks import suggestion
from .choices import Base


@dataclass(frozen=True)
class Entry:
    """A robot of the library.

    Attributes
    ----------
    file : str
        Its URDF, among the robots of example-robot-data.
    tip : str or None
        The frame used by tasks that name no frame.
    base : {"fixed", "planar", "floating"}
        How it stands in the world.
    home : dict
        Start configuration: joint -> position [rad], [m]; other joints are neutral.
    height : float
        Height of a floating base in that configuration [m].
    """

    file: str
    tip: str | None = None
    base: Base = "fixed"
    home: Mapping[str, float] = field(default_factory=dict)
    height: float = 0.0


def _both(left: str, right: str, **joints: float) -> dict[str, float]:
    """Positions of joints on both sides: ``SIDE`` in their names becomes left and right."""
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
        base="floating",
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
        base="floating",
        height=1.02,
        home=_both("left", "right", leg_SIDE_3_joint=-0.41, leg_SIDE_4_joint=0.86, leg_SIDE_5_joint=-0.45)
        | _both("left", "right", arm_SIDE_4_joint=-1.57),
    ),
    "icub": Entry("icub_description/robots/icub.urdf", base="floating", height=0.6),
    "go2": Entry(
        "go2_description/urdf/go2.urdf",
        base="floating",
        height=0.287,
        home=_both("F", "R", SIDEL_thigh_joint=0.9, SIDER_thigh_joint=0.9)
        | _both("F", "R", SIDEL_calf_joint=-1.8, SIDER_calf_joint=-1.8),
    ),
    "solo12": Entry(
        "solo_description/robots/solo12.urdf",
        base="floating",
        height=0.24,
        home=_both("L", "R", FSIDE_HFE=0.8, FSIDE_KFE=-1.6, HSIDE_HFE=-0.8, HSIDE_KFE=1.6),
    ),
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


def named(name: str) -> tuple[Entry, Path]:
    """The library entry of a robot, and its file.

    Raises
    ------
    InvalidInput
        If there is no such robot; the message lists similar names.
    MissingPackage
        If example-robot-data is not installed.
    """
    if name in ROBOTS:
        return ROBOTS[name], data_folder() / ROBOTS[name].file
    others = _others()
    if name not in others:
        hint = suggestion(name, available_robots()) if name else ""
        hint = hint if "did you mean" in hint else ""
        raise InvalidInput(
            f"unknown robot {name!r}{hint}; give a URDF or MJCF file, or one of {', '.join(available_robots())}"
        )
    return Entry(others[name]), data_folder() / others[name]


def available_robots() -> tuple[str, ...]:
    """Names that :func:`load_robot` knows: the library's, and those of all other URDF files of example-robot-data.

    Examples
    --------
    >>> from tasks import available_robots
    >>> "panda" in available_robots()
    True
    """
    return (*ROBOTS, *sorted(_others()))


@cache
def _others() -> dict[str, str]:
    folder = data_folder()
    known = {entry.file for entry in ROBOTS.values()}
    found = {path.stem: str(path.relative_to(folder)) for path in sorted(folder.rglob("*.urdf"))}
    return {name: file for name, file in found.items() if file not in known and name not in ROBOTS}
