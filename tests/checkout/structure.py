"""Counts of the structure: files and folders, import circles, upward imports, long functions, long files.

``python tests/checkout/structure.py hqp tasks benchmarks`` prints a line a package.

Files and folders are those directly inside a package. A circle is a largest set of modules that all reach each other by
imports, those inside functions and for type checkers included. An import is upward where it leads to a file or folder
of a higher layer, or of the same one, in the package's import contract of pyproject.toml.
"""

from __future__ import annotations

import ast
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LONGEST_FUNCTION, LONGEST_FILE = 80, 350


@dataclass(frozen=True)
class Structure:
    """What was found in one package; `upward` is None where no contract names its layers."""

    entries: list[str]  # files and folders
    circles: list[list[str]]
    upward: list[tuple[str, str]] | None
    long_functions: list[tuple[str, int]]
    long_files: list[tuple[str, int]]

    def __str__(self) -> str:
        upward = "no contract" if self.upward is None else len(self.upward)
        return (
            f"{len(self.entries)} files and folders, {len(self.circles)} circles of {sum(map(len, self.circles))}"
            f" modules, upward imports: {upward}, {len(self.long_functions)} functions over {LONGEST_FUNCTION} lines,"
            f" {len(self.long_files)} files over {LONGEST_FILE}"
        )


def structure(package: str, root: Path = ROOT) -> Structure:
    """Count one package."""
    sources = {_module(path, root): path for path in sorted((root / package).rglob("*.py"))}
    trees = {module: ast.parse(path.read_text()) for module, path in sources.items()}
    graph = {module: set(_imports(module, sources[module], tree, sources)) for module, tree in trees.items()}
    lengths = {module: len(path.read_text().splitlines()) for module, path in sources.items()}
    layer = layers(package, root)
    upward = [(a, b) for a in graph for b in sorted(graph[a]) if _is_upward(a, b, layer)] if layer else None
    return Structure(
        sorted({module.split(".")[1] for module in sources if "." in module}),
        _circles(graph),
        upward,
        [each for module, tree in trees.items() for each in _long_functions(module, tree)],
        [(module, length) for module, length in lengths.items() if length > LONGEST_FILE],
    )


def _module(path: Path, root: Path) -> str:
    return ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def _imports(module: str, path: Path, tree: ast.Module, known: dict[str, Path]) -> Iterator[str]:
    """The modules of the same package that a module imports, wherever in it."""
    parts = module.split(".")
    folder = parts if path.name == "__init__.py" else parts[:-1]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name in known)
        elif isinstance(node, ast.ImportFrom):
            start = folder[: len(folder) - node.level + 1] if node.level else []
            origin = ".".join([*start, *(node.module.split(".") if node.module else [])])
            for name in node.names:
                found = f"{origin}.{name.name}" if f"{origin}.{name.name}" in known else origin
                if found in known and found != module:
                    yield found


def layers(package: str, root: Path) -> dict[str, int]:
    """The layer of every file and folder in the import contract of the package, 0 the highest; empty without one."""
    settings = tomllib.loads((root / "pyproject.toml").read_text())
    for contract in settings["tool"]["importlinter"]["contracts"]:
        if contract.get("containers") == [package]:
            return {entry.strip(): k for k, layer in enumerate(contract["layers"]) for entry in layer.split("|")}
    return {}


def _is_upward(importer: str, imported: str, layer: dict[str, int]) -> bool:
    if "." not in importer or "." not in imported:  # the package itself
        return "." not in imported
    a, b = importer.split(".")[1], imported.split(".")[1]
    return a != b and layer[a] >= layer[b]


def _circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """The strongly connected components of more than one module."""
    reach = {module: _reached(graph, module) for module in graph}
    circles = {tuple(sorted(other for other in reach[module] if module in reach[other])) for module in graph}
    return sorted(list(circle) for circle in circles if len(circle) > 1)


def _reached(graph: dict[str, set[str]], start: str) -> set[str]:
    reached, rest = set[str](), [start]
    while rest:
        new = graph[rest.pop()] - reached
        reached |= new
        rest.extend(new)
    return reached


def _long_functions(module: str, tree: ast.Module) -> Iterator[tuple[str, int]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            length = (node.end_lineno or node.lineno) - node.lineno + 1
            if length > LONGEST_FUNCTION:
                yield f"{module}.{node.name}", length


if __name__ == "__main__":
    for name in sys.argv[1:] or ["hqp", "tasks", "benchmarks"]:
        print(f"{name}: {structure(name)}")
