"""The order of the pages: Learn, Theory, Evidence, Reference.

The pages themselves say nothing of it, so that they read the same elsewhere: it is added to the landing page.
"""

from __future__ import annotations

from sphinx.application import Sphinx

LANDING = "index"
NAVIGATION = {
    "Learn": [
        "robots",
        "ik",
        "redundancy",
        "obstacles",
        "singularities",
        "teleoperation",
        "changing-stacks",
        "torques",
        "contacts",
        "live",
        "ros",
        "coming-from-pink-or-mink",
        "ported-programs",
        "examples/index",
    ],
    "Theory": ["theory", "backends"],
    "Evidence": ["validation", "benchmarks", "benchmark-results", "compare", "thesis", "survey"],
    "Reference": [
        "conventions",
        "reference/index",
        "reference/constants",
        "files",
        "extending",
        "architecture",
        "project/contributing",
        "project/changelog",
    ],
}


def add(app: Sphinx, docname: str, source: list[str]) -> None:
    """End the landing page with all others."""
    if docname == LANDING:
        for caption, names in NAVIGATION.items():
            source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n" + "\n".join(names) + "\n```\n"


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("source-read", add)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
