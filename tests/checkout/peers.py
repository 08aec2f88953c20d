"""Names and sizes of what Pink and mink offer, for the page that translates them."""

from __future__ import annotations

import ast
import inspect
import warnings
from types import ModuleType

#: What a statement that only draws, or waits for the clock, says.
DRAWS = {"viz", "viewer", "visualizer", "meshcat_shapes", "rate", "argparse", "args", "wrist_frame"}


def lines(program: str) -> int:
    """How long a program is: its statements, one a line, without docstrings and without those that only draw."""
    return sum(_counts(node) for node in ast.walk(ast.parse(program)) if isinstance(node, ast.stmt))


def _counts(node: ast.stmt) -> bool:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return False
    compound = isinstance(node, ast.For | ast.While | ast.With | ast.If | ast.Try | ast.FunctionDef | ast.ClassDef)
    names = {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
    names |= {part.name for part in ast.walk(node) if isinstance(part, ast.alias)}
    return compound or not names & DRAWS


def public_of_pink() -> list[str]:
    """Every public class, function and method of Pink that a program may use."""
    with warnings.catch_warnings(action="ignore"):  # what they import in turn may call itself deprecated
        import pink
        import pink.barriers
        import pink.limits
        import pink.tasks
        import pink.utils
        import pink.visualization

    found = {*pink.__all__, *pink.tasks.__all__, *pink.barriers.__all__, *pink.limits.__all__}
    return sorted(found | _own(pink.utils) | _own(pink.visualization) | _methods(pink.Configuration))


def public_of_mink() -> list[str]:
    """The same of mink; tables of MuJoCo's names are none."""
    with warnings.catch_warnings(action="ignore"):
        import mink

    found = {
        name
        for name, value in vars(mink).items()
        if not name.startswith("_") and not name.isupper() and (inspect.isclass(value) or inspect.isroutine(value))
    }
    return sorted(found | _methods(mink.Configuration))


def _own(module: ModuleType) -> set[str]:
    """What a module defines itself."""
    return {name for name, value in vars(module).items() if getattr(value, "__module__", "") == module.__name__}


def _methods(kind: type) -> set[str]:
    return {name for name in vars(kind) if not name.startswith("_")}


if __name__ == "__main__":
    import sys
    from pathlib import Path

    for file in sys.argv[1:]:
        print(f"{lines(Path(file).read_text(encoding='utf-8')):4d} {file}")
