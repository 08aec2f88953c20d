"""The letters of a PDF: those of the pictures' font, without its thousands of others.

A PDF carries the glyphs that it shows, as TrueType, which journals ask for. Matplotlib looks them up for every file in
the whole font, which takes longer than to draw a small picture; in a font of few letters it takes a third of that.
Forms, kerning and ligatures are those of the whole font.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

#: The font of Matplotlib's default style.
FONT = "DejaVu Sans"
#: The name under which Matplotlib finds its letters.
LETTERS = "hqp letters"
#: Latin, Greek, and the signs of text and mathematics.
SIGNS = (*range(0x20, 0x250), *range(0x370, 0x400), *range(0x2000, 0x2300))
#: Which records of a font's table of names hold its family.
FAMILY = (1, 16)


def families(names: list[str]) -> list[str]:
    """The same font families in the same order, and before `FONT` its letters, which are looked for there first."""
    return [family for name in names for family in ((_made(), name) if name == FONT else (name,))]


@cache
def _made() -> str:
    """Make the letters known to Matplotlib, upright and bold, once a process; their name."""
    from fontTools import subset
    from matplotlib import get_data_path
    from matplotlib.font_manager import fontManager

    options = subset.Options(layout_features=["*"], legacy_kern=True, name_IDs=["*"], glyph_names=True)
    options.drop_tables += ["FFTM"]
    folder = Path(_folder().name)
    for file in "DejaVuSans.ttf", "DejaVuSans-Bold.ttf":
        with subset.load_font(Path(get_data_path(), "fonts", "ttf", file), options) as font:
            subsetter = subset.Subsetter(options)
            subsetter.populate(unicodes=SIGNS)
            subsetter.subset(font)
            for record in font["name"].names:
                if record.nameID in FAMILY:
                    record.string = LETTERS
            font.save(folder / file)
        fontManager.addfont(folder / file)
    return LETTERS


@cache
def _folder() -> TemporaryDirectory[str]:
    """For the files of the letters; it goes with the process."""
    return TemporaryDirectory(prefix="hqp-letters-")
