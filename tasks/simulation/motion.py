"""How a robot follows a command that holds over a tick, exactly; see :mod:`tasks.simulation.simulation`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..base.checks import Array
from ..control.step import Step


def follow(
    integrate: Callable[[Array, Array], Array], step: Step[Any, Any, Any], q: Array, v: Array, dt: float
) -> tuple[Array, Array, Array]:
    """Configuration and velocities at the end of the tick, and the accelerations over it."""
    if step.a is not None:
        a: Array = step.a
        return integrate(q, dt * v + (0.5 * dt * dt) * a), v + dt * a, a
    assert step.v is not None
    after: Array = step.v.copy()
    return integrate(q, dt * after), after, (after - v) / dt
