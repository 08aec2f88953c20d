"""URDF files for tests, written joint by joint."""

from __future__ import annotations

from pathlib import Path

INERTIA = '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'


def link(name: str, mass: float = 1.0) -> str:
    return f'<link name="{name}"><inertial><origin xyz="0.1 0 0.05"/><mass value="{mass}"/>{INERTIA}</inertial></link>'


def joint(
    name: str,
    parent: str,
    child: str,
    *,
    kind: str = "revolute",
    axis: str = "0 0 1",
    at: str = "0.3 0.1 0.2",
    rpy: str = "0.1 0.2 0.3",
    lower: float = -1.0,
    upper: float = 1.0,
    speed: float = 3.0,
    mimic: tuple[str, float, float] | None = None,
) -> str:
    """A joint; `mimic` is its leader, factor and offset."""
    limit = f'<limit lower="{lower}" upper="{upper}" velocity="{speed}" effort="9"/>'
    tie = "" if mimic is None else '<mimic joint="{}" multiplier="{}" offset="{}"/>'.format(*mimic)
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}" rpy="{rpy}"/><axis xyz="{axis}"/>{limit if kind != "fixed" else ""}{tie}</joint>'
    )


def write(folder: Path, *joints: str, links: int | tuple[str, ...], name: str = "arm.urdf", head: str = "") -> Path:
    """The file of these joints between ``link0``, ``link1``, ..., or between links of these names."""
    names = tuple(f"link{i}" for i in range(links)) if isinstance(links, int) else links
    path = folder / name
    path.write_text(f'{head}<robot name="arm">{"".join(map(link, names))}{"".join(joints)}</robot>')
    return path


def chain(*options: dict, prefix: str = "joint") -> list[str]:
    """Joints one on the other: ``joint0`` from ``link0`` to ``link1``, and so on."""
    return [joint(f"{prefix}{i}", f"link{i}", f"link{i + 1}", **own) for i, own in enumerate(options)]
