"""Accuracy settings of the methods, by name."""

from __future__ import annotations

from dataclasses import dataclass

from hqp import Settings


@dataclass(frozen=True)
class Setting:
    """A setting: its name, its description, and the settings of a backend."""

    name: str
    about: str
    settings: Settings


TIGHT = Setting("tight", "the library's own: QPs to 1e-9, every level polished; DAQP at 1e-9", Settings())
LOOSE = Setting(
    "loose",
    "QPs to 1e-5 and no polish; DAQP as it comes: what flat solvers are called with where nobody sets anything",
    Settings(tolerance=1e-6, qp_tolerance=1e-5, polish=False),
)
#: By name.
SETTINGS = {setting.name: setting for setting in (TIGHT, LOOSE)}
