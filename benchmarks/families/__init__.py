"""The problem families, by key. A module here that has a tuple `FAMILIES` adds its own: a new family is one file."""

from __future__ import annotations

import sys

from ..registry import registered
from .family import Family, Sample, moved

#: All of them, in the order of their files.
FAMILIES: dict[str, Family] = {family.key: family for family in registered(sys.modules[__name__], "FAMILIES")}

__all__ = ["FAMILIES", "Family", "Sample", "moved"]
