"""Pages that are written when the site is built, in folders that git ignores."""

from __future__ import annotations

from pathlib import Path


def heading(text: str) -> str:
    """The title of a page of reStructuredText."""
    return f"{text}\n{'=' * len(text)}"


def write(folder: Path, pages: dict[str, str], kind: str = "rst") -> None:
    """Write the pages of a folder, name -> text: none that is as it was, so that it is not read again; drop others."""
    folder.mkdir(exist_ok=True)
    for old in set(folder.iterdir()) - {folder / f"{name}.{kind}" for name in pages}:
        old.unlink()
    for name, text in pages.items():
        path = folder / f"{name}.{kind}"
        if not path.exists() or path.read_text(encoding="utf-8") != text + "\n":
            path.write_text(text + "\n", encoding="utf-8")
