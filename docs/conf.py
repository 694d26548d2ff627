"""How the manual is built: `make docs`."""

import sys
from importlib.resources import files
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE / "_extensions")]

from fea.base.version import __version__  # noqa: E402

project = "fea"
author = "The authors of conrod-fea"
copyright = "GPL-3.0-or-later"  # noqa: A001
release = version = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "numpydoc",
    "program",
]
language = "en"
exclude_patterns = ["_build", "_extensions"]
nitpicky = True
default_role = "py:obj"  # of docstrings, whose names in small letters may be parameters, files and commands
nitpick_ignore_regex = [("py:obj", r"[a-z_ ]+(\.json)?")]

myst_enable_extensions = ["amsmath", "attrs_block", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
suppress_warnings = ["myst.strikethrough"]

numpydoc_show_class_members = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = f"fea {__version__}"
html_static_path = ["_static", str(files("sphinx-mathjax-offline") / "static/mathjax/tex-svg-full.js")]
html_css_files = ["manual.css"]
html_copy_source = False
html_show_search_summary = False  # a page that was opened from disk may not read others
html_theme_options = {"navigation_with_keys": True}
mathjax_path = "tex-svg-full.js"
