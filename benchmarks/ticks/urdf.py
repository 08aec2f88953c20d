"""A URDF without what a controller has no use for: no geometry, and joints that are held are fixed."""

from __future__ import annotations

from collections.abc import Collection
from xml.etree import ElementTree as ET

from tasks.robots.library import ROBOTS, data_folder


def bare(robot: str, held: Collection[str]) -> ET.Element:
    """The URDF of a robot of the library, parsed and stripped."""
    root = ET.parse(data_folder() / ROBOTS[robot].file).getroot()
    for link in root.findall("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            link.remove(shape)
    for joint in root.findall("joint"):
        if joint.get("name") in held:
            joint.set("type", "fixed")
            for mimic in joint.findall("mimic"):
                joint.remove(mimic)
    for other in root.findall("mujoco") + root.findall("transmission") + root.findall("gazebo"):
        root.remove(other)
    return root


def root_link(urdf: ET.Element) -> str:
    """The link that is no other one's child."""
    children = {child.get("link") for child in urdf.iterfind("joint/child")}
    return next(name for link in urdf.findall("link") if (name := link.get("name", "")) not in children)


def for_mujoco(urdf: ET.Element, floating: bool) -> str:
    """As text that MuJoCo reads: every link a body, and a base that floats."""
    if floating:
        base = root_link(urdf)
        ET.SubElement(urdf, "link", name="world")
        joint = ET.SubElement(urdf, "joint", name="floating base", type="floating")
        ET.SubElement(joint, "parent", link="world")
        ET.SubElement(joint, "child", link=base)
    # MuJoCo merges links that cannot move against each other, and their names, unless it is told not to.
    compiler = ET.SubElement(urdf, "mujoco")
    ET.SubElement(compiler, "compiler", fusestatic="false", balanceinertia="true")
    return ET.tostring(urdf, encoding="unicode")
