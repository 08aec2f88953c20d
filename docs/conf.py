"""How the pages of this folder become a site: ``python -m sphinx -W docs out/site``."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_site"), str(HERE.parent)]

import hqp  # noqa: E402

project = "hqp"
author = "The hqp developers"
version = release = hqp.__version__
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "formulas",
    "gallery",
    "navigation",
    "outside",
    "reference",
]
exclude_patterns = ["_site"]

# Pages: headings have the anchors that GitHub gives them, and formulas stand between dollars.
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
html_math_renderer = "mathml"

# Reference: signatures as they are written, parameters as NumPy's docstrings have them.
default_role = "literal"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
python_maximum_signature_line_length = 88
toc_object_entries_show_parents = "hide"

# No page asks anything of another machine.
html_theme = "furo"
html_title = f"hqp {release}"
html_static_path = ["_site/static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}
