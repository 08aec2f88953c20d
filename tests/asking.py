"""What a task asks for at one state."""

from __future__ import annotations

import numpy as np

from tasks import Stack
from tasks.robots.robot import RobotState
from tasks.rows.part import Order
from tasks.rows.task import Task


def asked(task: Task, state: RobotState, t: float, order: Order) -> tuple[np.ndarray, np.ndarray]:
    """Its rows J x = h, shapes (rows, nv) and (rows,), as a stack has them."""
    hierarchy = Stack(task).build(state.robot, order).fill(state, t)
    return hierarchy.dense().copy(), hierarchy.lower.copy()
