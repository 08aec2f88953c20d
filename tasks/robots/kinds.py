"""Whether a robot is a Pinocchio robot, for algorithms that need its model."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, TypeGuard

if TYPE_CHECKING:
    from .pinocchio import PinocchioRobot


def on_pinocchio(robot: object) -> TypeGuard[PinocchioRobot]:
    """Whether this is a robot of Pinocchio, and not one of somebody's own that happens to have a model."""
    module = sys.modules.get(f"{__package__}.pinocchio")  # there is none without it
    return module is not None and isinstance(robot, module.PinocchioRobot)
