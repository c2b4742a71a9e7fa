"""Sphinx builds the guide from here: `make guide`.

The repository is the source folder, so that the links between README, CONTRIBUTING, docs/ and protocol/ are the same
on the site as in the files.
"""

from __future__ import annotations

import gc
import sys
from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

gc.disable()  # a short run that keeps what it makes: looking for garbage takes a fifth of the time

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "host"), str(ROOT)]

import tfsat_host  # noqa: E402

project = "tfsat"
author = "tfsat contributors"
project_copyright = "tfsat contributors, MIT licence"
version = release = tfsat_host.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
root_doc = "docs/index"
include_patterns = ["docs/**", "protocol/reference.md", "README.md", "CONTRIBUTING.md", "CHANGELOG.md"]
# Sphinx would search them all.
exclude_patterns = [
    ".*",
    "build",
    "dist",
    "host",
    "tests",
    "tools",
    "firmware",
    "robots",
    "**/*.py",
    "docs/guide/site",
]

myst_heading_anchors = 4  # as on the web pages of a repository
smartquotes = False  # "--port" must not become a dash
myst_enable_extensions = ["tasklist"]

autodoc_typehints = "description"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_class_signature = "separated"
autodoc_default_options = {"members": True, "exclude-members": "__init__, __new__"}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
add_module_names = False

html_theme = "furo"
html_title = f"tfsat {release}"
html_copy_source = False
html_show_sphinx = False
html_extra_path = ["guide/site"]
html_static_path = ["guide/static"]
html_css_files = ["print.css"]


def setup(app: Sphinx) -> None:
    """Names of code blocks that mark what a page's own test runs: talk with the emulated robot, no language."""
    for name in ("control", "drop"):
        app.add_lexer(name, TextLexer)
