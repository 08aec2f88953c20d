"""Which names are public, and where the reference has each: once."""

from __future__ import annotations

import ast
import inspect
from dataclasses import dataclass
from importlib import import_module
from importlib.util import resolve_name
from typing import Any

#: The names that users type: all that these export.
NAMESPACES = [
    "hqp",
    "hqp.solution",
    "hqp.certificate",
    "hqp.backends",
    "hqp.problems",
    "hqp.lexls",
    "tasks",
    "tasks.adapters",
]

#: What they meet beside: what a name above takes, gives or is made of, and what extensions are written against.
MET = {
    "hqp.backends.base": ["Answer", "Backend"],
    "hqp.qp": ["FlatQP", "FlatResult", "FlatSolver", "Sizes"],
    "hqp.validation": ["KnownAnswer", "Finding", "check", "Judgement", "judge"],
    "tasks.adapters.part": ["Adapted"],
    "tasks.frames.placement": ["PlacementTask"],
    "tasks.obstacles.shapes": ["Obstacle"],
    "tasks.robots.abilities": "all",
    "tasks.robots.chain": ["Branched", "Chained"],
    "tasks.robots.frame": ["planar_frame"],
    "tasks.robots.manipulability": ["Degrees", "VelocityEllipse"],
    "tasks.robots.planar": ["PlanarState"],
    "tasks.simulation.account": ["Account", "Shortfall", "Stretch"],
    "tasks.simulation.record": ["Stop"],
    "tasks.targets.paths": ["Path", "Piece"],
    "tasks.view.live": ["Window"],
    "tasks.view.session": ["Session"],
}

#: The parts of the library, in the order of the reference.
PARTS = [
    *("hqp.hierarchy", "hqp.solver", "hqp.settings", "hqp.solution", "hqp.certificate", "hqp.damping", "hqp.backends"),
    *("hqp.errors", "hqp.files", "hqp.lexls", "hqp.problems", "hqp.validation", "hqp.qp"),
    *("tasks.rows", "tasks.frames", "tasks.joints", "tasks.limits", "tasks.obstacles", "tasks.criteria"),
    *("tasks.contacts", "tasks.control", "tasks.simulation", "tasks.ik", "tasks.view", "tasks.adapters"),
    *("tasks.targets", "tasks.robots", "tasks.base"),
]

#: Modules whose docstring says more than those of their names: the law, as a formula.
LAWS = ["hqp.damping.staged", "tasks.obstacles.avoidance", "tasks.obstacles.distance", "tasks.obstacles.self_collision"]


@dataclass(frozen=True)
class Public:
    """A public name: where it is imported from, what it is, and the part of the library that it belongs to."""

    namespace: str
    name: str
    value: Any
    part: str

    @property
    def path(self) -> str:
        """What to write after ``import``."""
        return f"{self.namespace}.{self.name}"


def public() -> list[Public]:
    """Every public name once, where it is first exported; modules are none, their names are."""
    exported = {name: list(import_module(name).__all__) for name in NAMESPACES}
    exported |= {name: _defined(name) if names == "all" else list(names) for name, names in MET.items()}
    found: list[Public] = []
    for namespace, names in exported.items():
        module = import_module(namespace)
        for name in names:
            value = getattr(module, name)
            if not inspect.ismodule(value) and not any(value is other.value for other in found):
                found.append(Public(namespace, name, value, _part(namespace, name)))
    return found


def _defined(namespace: str) -> list[str]:
    """The classes that a module defines."""
    module = import_module(namespace)
    return [
        name
        for name, value in vars(module).items()
        if inspect.isclass(value) and value.__module__ == namespace and not name.startswith("_")
    ]


def _part(namespace: str, name: str) -> str:
    """The package inside `hqp` or `tasks` that defines it, or exports it under a name of its own."""
    where = namespace if namespace.count(".") else home(namespace, name)
    return ".".join(where.split(".")[:2])


def home(module: str, name: str) -> str:
    """The module that defines a name, found by following the imports."""
    source = import_module(f"{module}._all" if module in {"hqp", "tasks"} else module)
    for node in ast.walk(ast.parse(inspect.getsource(source))):
        if isinstance(node, ast.ImportFrom) and any(name == (alias.asname or alias.name) for alias in node.names):
            package = source.__spec__.parent or "" if source.__spec__ else ""
            return home(resolve_name("." * node.level + (node.module or ""), package), name)
    return source.__name__
