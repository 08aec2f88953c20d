"""The methods of ``python -m benchmarks ik``, and which of them are installed."""

from __future__ import annotations

from importlib.util import find_spec

from .ik_ours import Method, Native, NativePosture, NativeStrict
from .ik_peers import Mink, MinkPosture, Oink, Peer, Pink, PinkPosture

METHODS: tuple[type[Method], ...] = (
    Native,
    NativeStrict,
    NativePosture,
    Pink,
    PinkPosture,
    Mink,
    MinkPosture,
    Oink,
)
#: What some need beside the package that they are of.
BESIDE = {"pink": ("daqp",), "mink": ("mujoco", "daqp")}


def missing(method: type[Method]) -> str:
    """Why a method cannot be measured here; empty if it can."""
    if not issubclass(method, Peer):
        return ""
    gone = [name for name in (method.package, *BESIDE.get(method.package, ())) if find_spec(name) is None]
    why = f"{method.name}: left out, {', '.join(gone)} is not installed: pip install 'hqp[peers,solvers]'"
    return why if gone else ""
