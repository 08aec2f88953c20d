"""Robotics on top of :mod:`hqp`: declare tasks in order of priority, get the motion that honours it.

>>> from tasks import Controller, OrientationTask, PlanarArm, PositionTask
>>> arm = PlanarArm([0.5, 0.5, 0.5])
>>> stack = PositionTask([1.0, 0.2], gain=2.0) >> OrientationTask(0.0, gain=2.0)
>>> controller = Controller(arm, stack, order="velocity", backend="pseudoinverse")
>>> step = controller([1.1, -1.3, -0.7], [0.0, 0.0, 0.0])
>>> step.v.shape, step.ok
((3,), True)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

#: Former name -> present name; each warns, for one version.
_FORMER = {
    "Degrees": "robots.manipulability.Degrees",
    "PlanarState": "robots.planar.PlanarState",
    "Stop": "simulation.record.Stop",
    "VelocityEllipse": "robots.manipulability.VelocityEllipse",
}

if TYPE_CHECKING:
    from ._all import *  # noqa: F403
    from ._all import __all__ as __all__
else:

    def __getattr__(name: str) -> object:
        """Import everything at the first use of a name, so that the command can be interrupted meanwhile."""
        from importlib import import_module

        if name in _FORMER:
            import warnings

            now, _, own = _FORMER[name].rpartition(".")
            warnings.warn(f"tasks.{name} is tasks.{_FORMER[name]} now", DeprecationWarning, stacklevel=2)
            return getattr(import_module(f".{now}", __name__), own)
        if name == "__all__" or not name.startswith("_"):
            everything = import_module("._all", __name__)
            if name in everything.__dict__ or name in everything.__dict__.get("__all__", ()):
                return globals().setdefault(name, getattr(everything, name))
            if name in globals():  # a module that came with it
                return globals()[name]
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__getattr__("__all__")})
