"""What lies beside the folder of the pages: files that are pages of the site too, and links that lead there.

On GitHub ``[x](../examples/01_levels.py)`` opens the file; on the site it opens the page of that example. A link to any
other file, such as the source of a module or the licence, gives the file itself.
"""

from __future__ import annotations

import re
from pathlib import Path

from pages import write
from sphinx.application import Sphinx
from sphinx.config import Config

FOLDER = Path(__file__).parents[1] / "project"
#: A link -> the page of the site, both as seen from the folder of the pages.
PAGES = {
    r"\.\./README\.md": "index.md",
    r"\.\./CHANGELOG\.md": "project/changelog.md",
    r"\.\./CONTRIBUTING\.md": "project/contributing.md",
    r"\.\./examples/(\d\w+)\.py": r"examples/\1.rst",
    r"\.\./examples/?": "examples/index.rst",
}


def mend(app: Sphinx, docname: str, source: list[str]) -> None:
    """Links out of the folder lead to pages, where there are such."""
    if "/" not in docname:
        for link, page in PAGES.items():
            source[0] = re.sub(rf"\]\({link}(?P<anchor>#[^)\s]*)?\)", rf"]({page}\g<anchor>)", source[0])


def generate(app: Sphinx, config: Config) -> None:
    """Write a page for each file beside the folder that the site shows as it is."""
    include = "```{{include}} ../../{0}\n:relative-docs: docs/\n:relative-images:\n```"
    write(FOLDER, {name: include.format(f"{name.upper()}.md") for name in ("changelog", "contributing")}, "md")


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("config-inited", generate)
    app.connect("source-read", mend)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
