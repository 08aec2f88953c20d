"""A page an example, and one that shows them all: their own first sentence, their code and their picture.

Nothing is run: the tests do that, and compare what is printed; the pictures are those of ``docs/images``.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

from pages import heading, write
from sphinx.application import Sphinx
from sphinx.config import Config

DOCS = Path(__file__).parents[1]
EXAMPLES = DOCS.parent / "examples"
FOLDER = DOCS / "examples"


def pictures(code: str) -> list[str]:
    """The pictures of an example: those that it names, and those named like the function that draws them."""
    drawn = re.findall(r'"(\w+)\.(?:png|gif)"|^ *from _\w*pictures import (\w+)', code, re.MULTILINE)
    names = dict.fromkeys(named or function for named, function in drawn)
    return [f"{name}.{kind}" for name in names for kind in ("png", "gif") if (DOCS / f"images/{name}.{kind}").exists()]


def page(path: Path) -> str:
    """One example: what it shows, its picture, its code."""
    code = path.read_text(encoding="utf-8")
    parts = [heading(title(path)), ast.get_docstring(ast.parse(code)) or ""]
    parts += [f".. image:: /images/{name}\n   :alt: {title(path)}" for name in pictures(code)]
    parts += [f"``python examples/{path.name}`` prints what it finds.", f".. literalinclude:: /../examples/{path.name}"]
    return "\n\n".join(parts)


def title(path: Path) -> str:
    """The name of the file, in words."""
    number, _, words = path.stem.partition("_")
    return f"{number} {words.replace('_', ' ')}"


def card(path: Path) -> str:
    """An example in the gallery: a picture, if it draws one, above its first sentence."""
    code = path.read_text(encoding="utf-8")
    about = (ast.get_docstring(ast.parse(code)) or "").splitlines()[0]
    shown = "".join(
        f"   .. image:: /images/{name}\n      :target: {path.stem}.html\n      :alt: {title(path)}\n\n"
        for name in pictures(code)[:1]
    )
    return f".. container:: card\n\n{shown}   :doc:`{title(path)} <{path.stem}>`\n\n   {about}"


def generate(app: Sphinx, config: Config) -> None:
    """Write the pages, before the sources are looked for."""
    paths = sorted(EXAMPLES.glob("[0-9]*.py"))
    names = "\n".join(f"   {path.stem}" for path in paths)
    cards = "\n\n".join("   " + card(path).replace("\n", "\n   ") for path in paths)
    gallery = [
        heading("Examples"),
        "Short scripts, each run by the tests. With a folder as argument they draw their picture into it.",
        f".. container:: cards\n\n{cards}",
        f".. toctree::\n   :hidden:\n\n{names}",
    ]
    write(FOLDER, {"index": "\n\n".join(gallery), **{path.stem: page(path) for path in paths}})


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("config-inited", generate)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
