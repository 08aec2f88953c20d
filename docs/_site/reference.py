"""The reference: a page a part of the library with all its public names, and a page of constants."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path
from typing import Any

from constants import tables
from docutils import nodes
from pages import heading, write
from public import LAWS, PARTS, Public, home, public
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.pycode import ModuleAnalyzer

FOLDER = Path(__file__).parents[1] / "reference"
ABOUT = """
Every public name, once, in the part of the library that it belongs to. ``hqp`` is mathematics and has never heard of a
robot; ``tasks`` is robotics. A name is imported from where its entry says: most from ``hqp`` or ``tasks`` themselves.
""".strip()


def generate(app: Sphinx, config: Config) -> None:
    """Write the pages, before the sources are looked for."""
    parts: dict[str, list[Public]] = {part: [] for part in PARTS}
    for name in public():
        parts[name.part].append(name)
    pages = {module: part(module, names) for module, names in parts.items()}
    write(FOLDER, {"index": index(list(parts)), "constants": tables(), **pages})


def index(parts: list[str]) -> str:
    """The table of the parts."""
    rows = [(f":doc:`{name} <{name}>`", first_paragraph(import_module(name))) for name in parts]
    names = "\n".join(f"   {name}" for name in parts)
    return "\n\n".join([heading("Names"), ABOUT, table(rows), f".. toctree::\n   :hidden:\n\n{names}"])


def part(module: str, names: list[Public]) -> str:
    """A part of the library: what it is for, a table of its names, all of each, and the laws behind them."""
    rows = [(f":py:obj:`{name.name} <{name.path}>`", summary(name)) for name in names]
    laws = [f"{law}\n{'-' * len(law)}\n\n.. automodule:: {law}" for law in LAWS if law.startswith(f"{module}.")]
    return "\n\n".join([heading(module), f".. automodule:: {module}", table(rows), *map(entry, names), *laws])


def table(rows: list[tuple[str, str]]) -> str:
    """Names, and what they are."""
    lines = "\n".join(f"   * - {name}\n     - {about}" for name, about in rows)
    return f".. list-table::\n   :width: 100%\n   :widths: 30 70\n\n{lines}"


def entry(name: Public) -> str:
    """All of one name: what it is, what it takes, what it can do."""
    if inspect.isroutine(name.value):
        return f".. autofunction:: {name.path}"
    if not inspect.isclass(name.value):
        return f".. py:data:: {name.path}\n\n   {summary(name)}"
    options = ":members:"
    if name.value.__bases__ != (object,):
        options += "\n   :show-inheritance:"
    if "__call__" in vars(name.value) and name.value.__call__.__doc__:
        options += "\n   :special-members: __call__"
    return f".. autoclass:: {name.path}\n   {options}"


def summary(name: Public) -> str:
    """The first paragraph on a name; on a number or a type, the comment above it."""
    if inspect.isclass(name.value) or inspect.isroutine(name.value):
        return first_paragraph(name.value)
    analyzer = ModuleAnalyzer.for_module(home(name.namespace, name.name))
    analyzer.analyze()
    return " ".join(analyzer.attr_docs[("", name.name)]).strip()


def first_paragraph(value: object) -> str:
    """The first paragraph of a docstring, in a line."""
    return (inspect.getdoc(value) or "").split("\n\n")[0].replace("\n", " ")


def as_written(app: Sphinx, what: str, name: str, value: Any, options: Any, signature: str, result: str) -> Any:
    """The signature with its types as they are written, ``ArrayLike`` and not what it stands for."""
    if what not in {"class", "exception", "function", "method"} or signature is None:
        return None
    try:
        written = inspect.signature(value)
    except (TypeError, ValueError):
        return None
    kept = [parameter.replace(annotation=_Text(parameter.annotation)) for parameter in written.parameters.values()]
    if what == "method" and kept and kept[0].name in {"self", "cls"}:
        del kept[0]
    gives = written.return_annotation if what in {"function", "method"} else None
    taken = str(written.replace(parameters=kept, return_annotation=written.empty))
    return taken, gives if isinstance(gives, str) else None


class _Text(str):
    """A type that is shown without quotes."""

    def __new__(cls, annotation: object) -> Any:
        return super().__new__(cls, annotation) if isinstance(annotation, str) else annotation

    def __repr__(self) -> str:
        return str(self)


def no_type(app: Sphinx, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Undo that napoleon takes what stands before a colon for the type: of an attribute it is half a sentence."""
    types = [line for line in lines if line.startswith(":type: ")]
    if what in {"attribute", "property"} and types:
        lines.remove(types[0])
        lines[0] = f"{types[0].removeprefix(':type: ')}: {lines[0]}"


def no_names(app: Sphinx, doctree: nodes.document) -> None:
    """Words in the type of a parameter, ``array, shape (rows,)``, are no names of ours unless they look like one."""
    for node in list(doctree.findall(pending_xref)):
        if node.get("refdomain") == "py" and node.get("refspecific") and node["reftarget"].islower():
            node.replace_self(node.children)


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("config-inited", generate)
    app.connect("autodoc-process-signature", as_written)
    app.connect("autodoc-process-docstring", no_type, priority=600)  # after napoleon
    app.connect("doctree-read", no_names)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
