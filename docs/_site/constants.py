"""The table of the numbers that are built in: tolerances, factors, limits of loops, with the comments above them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pages import heading
from sphinx.pycode import ModuleAnalyzer

ROOT = Path(__file__).parents[2]

#: Packages whose numbers decide how something looks, or what the thesis has done, not how a stack is solved.
LEFT_OUT = {"tasks/thesis", "tasks/view", "tasks/drawing"}


@dataclass(frozen=True)
class Constant:
    """A number of a module: its name, its value as it is written, and the comment ``#:`` above it, if there is one."""

    path: str
    name: str
    value: str
    about: str


def constants() -> Iterator[Constant]:
    """Every constant that is written as a number with a point or an exponent, or as a multiple of one."""
    for package in "hqp", "tasks":
        for path in sorted((ROOT / package).rglob("*.py")):
            place = path.relative_to(ROOT).as_posix()
            if not any(place.startswith(folder) for folder in LEFT_OUT):
                yield from _of(place, path.read_text(encoding="utf-8"))


def _of(place: str, code: str) -> Iterator[Constant]:
    assigned = [node for node in ast.parse(code).body if isinstance(node, ast.Assign)]
    pairs = [pair for node in assigned for pair in _pairs(node.targets[0], node.value)]
    found = {name: value for name, value in pairs if name.isupper() and name[0] != "_" and _is_number(value)}
    if found:
        analyzer = ModuleAnalyzer.for_string(code, place)
        analyzer.analyze()
        for name, value in found.items():
            about = _norms(" ".join(analyzer.attr_docs.get(("", name), [])).strip())
            yield Constant(place, name, ast.unparse(value), about)


def _norms(text: str) -> str:
    """Bars of norms, as in c |J|^2, are bars; between backticks they are already."""
    return re.sub(r"(`+.*?`+)|\|", lambda found: found[1] or r"\|", text)


def _pairs(target: ast.expr, value: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    """What is assigned to what, ``A, B = 1.0, 2.0`` included."""
    if isinstance(target, ast.Name):
        yield target.id, value
    elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        for name, part in zip(target.elts, value.elts, strict=True):
            yield from _pairs(name, part)


def _is_number(node: ast.expr) -> bool:
    allowed = ast.Constant | ast.Name | ast.Attribute | ast.BinOp | ast.UnaryOp | ast.operator | ast.unaryop | ast.Load
    parts = list(ast.walk(node))
    floats = [part for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, float)]
    return bool(floats) and all(isinstance(part, allowed) for part in parts)


def tables() -> str:
    """The page: a table a module."""
    found: dict[str, list[Constant]] = {}
    for constant in constants():
        found.setdefault(constant.path, []).append(constant)
    parts = [
        heading("Constants"),
        "What a solve may be told is in :class:`hqp.Settings`. These numbers are built in.",
    ]
    for place, rows in found.items():
        lines = "\n".join(f"   * - ``{row.name}``\n     - ``{row.value}``\n     - {row.about}" for row in rows)
        parts += [f"{place}\n{'-' * len(place)}", f".. list-table::\n   :width: 100%\n   :widths: 25 15 60\n\n{lines}"]
    return "\n\n".join(parts)
