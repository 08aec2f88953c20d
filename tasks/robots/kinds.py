"""Whether a robot is a Pinocchio robot, for algorithms that need its model."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, TypeGuard

if TYPE_CHECKING:
    from .pinocchio import PinocchioRobot


def on_pinocchio(robot: object) -> TypeGuard[PinocchioRobot]:
    """Whether this is a :class:`~tasks.robots.pinocchio.PinocchioRobot`, not a user's class with a `model`."""
    module = sys.modules.get(f"{__package__}.pinocchio")  # not imported: no such robot exists
    return module is not None and isinstance(robot, module.PinocchioRobot)
