"""The values of options of ``load_robot``."""

from __future__ import annotations

from typing import Literal

#: How a robot stands in the world: mounted, moving in the plane, or free.
Base = Literal["fixed", "planar", "floating"]
#: What to do with a joint that follows another one: hold it, tie it, or let it move on its own.
Mimic = Literal["lock", "follow", "free"]
