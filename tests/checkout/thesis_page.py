"""The tables of docs/thesis.md are those of claims.md: what stands under one heading in both, to compare and to copy.

From a checkout: ``hqp thesis && python tests/checkout/thesis_page.py out/thesis/claims.md``
"""

from __future__ import annotations

import sys
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "thesis.md"


def tables(text: str) -> dict[str, list[str]]:
    """Heading -> lines of the first table below it, of the headings that have one."""
    found: dict[str, list[str]] = {}
    heading, above = "", ""
    for line in text.splitlines():
        if line.startswith("#"):
            heading = line.lstrip("# ")
        elif line.startswith("|") and (heading not in found or above.startswith("|")):
            found.setdefault(heading, []).append(line)
        above = line
    return found


def refreshed(page: str, claims: str) -> str:
    """The page with the tables of `claims` in the place of its own of the same headings."""
    fresh = tables(claims)
    for heading, own in tables(page).items():
        if heading in fresh:
            page = page.replace("\n".join(own), "\n".join(fresh[heading]))
    return page


if __name__ == "__main__":
    PAGE.write_text(
        refreshed(PAGE.read_text(encoding="utf-8"), Path(sys.argv[1]).read_text(encoding="utf-8")), encoding="utf-8"
    )
