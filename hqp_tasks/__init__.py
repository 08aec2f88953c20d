"""Another name for the package `tasks`: for programs with a `tasks.py` of their own, or another package of that name.

``hqp_tasks.PositionTask is tasks.PositionTask`` wherever ``tasks`` is this library's. Where it is something else, the
library is imported under this name alone.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_file_location, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

HERE = Path(__file__).resolve().parent.parent / "tasks" / "__init__.py"


def _is_ours(spec: ModuleSpec | None) -> bool:
    return spec is not None and spec.origin is not None and Path(spec.origin).resolve() == HERE


class _Alias(MetaPathFinder, Loader):
    """Gives ``hqp_tasks.x`` as ``tasks.x``, the very same module."""

    def find_spec(self, name: str, path: Any = None, target: ModuleType | None = None) -> ModuleSpec | None:
        return spec_from_loader(name, self) if name.startswith(f"{__name__}.") else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = import_module("tasks" + spec.name.removeprefix(__name__))
        self._kept = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Nothing: it is there already; and it stays what it is."""
        module.__spec__ = self._kept


if _is_ours(find_spec("tasks")):
    sys.meta_path.insert(0, _Alias())
    sys.modules[__name__] = import_module("tasks")
else:
    _spec = spec_from_file_location(__name__, HERE, submodule_search_locations=[str(HERE.parent)])
    assert _spec is not None
    assert _spec.loader is not None
    __spec__, __file__, __path__ = _spec, str(HERE), [str(HERE.parent)]
    _spec.loader.exec_module(sys.modules[__name__])
