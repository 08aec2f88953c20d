"""The libraries compared, with the settings that their users choose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from hqp import ErrorDamping

from ..ticks.apart import Apart
from ..ticks.driver import Driver
from ..ticks.ours import Ours
from ..ticks.scenes import Scene
from ..ticks.stream import Stream

#: The joint acceleration that those keep which brake [rad/s^2].
ACCELERATION = 15.0
#: At this gain a bound of 10 rad/s is, for the position, the lm_damping of the others.
BY_ERROR = {
    "position": ErrorDamping(10.0, 0.02),
    "orientation": ErrorDamping(3.0, 0.1),
    "posture": ErrorDamping(0.3),
}


@dataclass(frozen=True)
class Own:
    """This library.

    Attributes
    ----------
    name : str
    options : dict
        Of :class:`benchmarks.ticks.ours.Ours`.
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)

    def missing(self) -> str:
        """Why it cannot run here: always empty."""
        return ""

    def refuses(self, scene: Scene) -> str:
        """Why it cannot take this scene: always empty."""
        return ""

    def driver(self, stream: Stream) -> Driver:
        """At work on a stream."""
        return Ours(stream, name=self.name, **self.options)


@dataclass(frozen=True)
class Peer:
    """Another library, one of its solvers, and settings.

    Attributes
    ----------
    package, solver : str
    variant : str
        What the settings are called; empty for the default ones.
    lm : float
        Levenberg-Marquardt damping of frames: its share of the square of their whole error.
    first : float
        What the costs of the first level are multiplied by.
    options : dict
        Of the driver beside the ticks, and of the ``solve_ik`` of the library.
    """

    package: str
    solver: str
    variant: str = ""
    lm: float = 0.0
    first: float = 1.0
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Library, solver and variant."""
        return " ".join(filter(None, (self.package, self.solver, self.variant)))

    def missing(self) -> str:
        """Why it cannot run here; empty if it can."""
        for package in filter(None, (self.package, {"proxqp": "proxsuite"}.get(self.solver, self.solver))):
            if find_spec(package) is None:
                return f"{self.name}: left out, {package} is not installed: python -m pip install -e '.[peers,solvers]'"
        return ""

    def refuses(self, scene: Scene) -> str:
        """Why it cannot take this scene; empty if it can."""
        if self.package == "roboplan" and any(goal.what == "com" for goal in scene.goals):
            return f"{self.name}: left out of {scene.name}, as it has no task for the centre of mass"
        return ""

    def driver(self, stream: Stream) -> Driver:
        """At work on a stream. What the libraries damp by is the error times the gain, which is taken out here."""
        first, *others = stream.scene.levels
        levels = (tuple(replace(goal, cost=self.first * goal.cost) for goal in first), *others)
        weighed = replace(stream, scene=replace(stream.scene, levels=levels))
        kind = getattr(import_module(f"benchmarks.ticks.with_{self.package}"), self.package.capitalize())
        variant = f" {self.variant}" if self.variant else ""
        return kind(self.solver, weighed, lm_damping=self.lm / stream.scene.step**2, name=variant, **self.options)


@dataclass(frozen=True)
class Elsewhere:
    """Another library that has an interpreter of its own.

    Attributes
    ----------
    library : str
        One of :data:`benchmarks.ticks.apart.MODULES`.
    variant : str
        What the settings are called; empty for the default ones.
    options : dict
        Of its ``Library``, see :class:`benchmarks.ticks.apart.Apart`.
    python : str, optional
        The interpreter.
    """

    library: str
    variant: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    python: str | None = None

    @property
    def name(self) -> str:
        """Library and variant."""
        return " ".join(filter(None, (self.library, self.variant)))

    def missing(self) -> str:
        """Why it cannot run here; empty if it can."""
        return "" if self.python else f"{self.name}: left out, name a Python that has it: --{self.library} PYTHON"

    def driver(self, stream: Stream) -> Driver:
        """At work on a stream."""
        assert self.python is not None
        return Apart(self.library, self.python, stream, name=self.name, **self.options)


#: Costs and lm are 1 at a gain of 1 in the examples of both libraries with one arm; mink's also add a damping of 1e-3.
SETUPS: tuple[Own | Peer, ...] = (
    Own("hqp", {"strict": False}),
    Own("hqp strict"),
    Own("hqp damped", {"damping": {"position": 0.2, "orientation": 1.0}}),
    Own("hqp braked", {"acceleration": ACCELERATION}),
    Own("hqp both", {"acceleration": ACCELERATION, "damping": {"position": 0.1, "orientation": 0.3}}),
    Own("hqp error", {"damping": BY_ERROR}),
    Own("hqp error braked", {"acceleration": ACCELERATION, "damping": BY_ERROR}),
    Peer("pink", "daqp"),
    Peer("pink", "proxqp"),
    Peer("pink", "daqp", "lm", lm=1.0, options={"safety_break": False}),
    Peer("pink", "daqp", "lm 100", lm=1.0, first=100.0, options={"safety_break": False}),
    Peer("pink", "daqp", "braked", options={"acceleration": ACCELERATION}),
    Peer("mink", "daqp"),
    Peer("mink", "daqp", "lm", lm=1.0, options={"damping": 1e-3}),
    Peer("roboplan", ""),
    Peer("roboplan", "", "lm 100", lm=1.0, first=100.0),
    Peer("roboplan", "", "levels", options={"priorities": True}),
    Peer("roboplan", "", "levels lm", lm=1.0, options={"priorities": True}),
)
