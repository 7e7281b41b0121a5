"""The documentation's build: `make docs`.

Pages are MyST Markdown in four folders. A page whose head names a kernel is a notebook and is run.
`docs/made` has a module for each page that is made from the code, `docs/drawings` one for each
drawing; `docs/extensions` has what Sphinx is taught.
"""

from __future__ import annotations

import os
import shutil
import sys
from importlib.metadata import version as version_of
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS), str(DOCS / "extensions")]

from made import write_pages  # noqa: E402 - found by the line above
from prepared import install  # noqa: E402

write_pages(DOCS)

project = "labrig"
author = "the labrig developers"
version = release = version_of("labrig")
html_title = "labrig"
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["labrig.css"]
highlight_language = "text"  # of blocks without a language: commands and their output
html_show_copyright = False
html_show_sphinx = False

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "terminal",
    "mermaid_as_text",
    "navigation",
    "unbroken_units",
]
exclude_patterns = [
    "_build",
    "made",
    "drawings",
    "extensions",
    "static",
    "schemas",
    "tutorials/data",
    "images",
]
myst_enable_extensions = ["deflist", "fieldlist", "attrs_block"]
myst_heading_anchors = 4

# Notebooks run anew in each build, in a folder of their own that holds tutorials/data.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True

# Commands of pages and notebooks find the labrig that builds them, and print plain text.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
os.environ |= {"COLUMNS": "120", "MPLBACKEND": "agg", "PYDEVD_DISABLE_FILE_VALIDATION": "1"}
os.environ |= install(DOCS / "_build")
os.environ["LABRIG_DOCS_DATA"] = str(DOCS / "tutorials" / "data")

_ipython = DOCS / "_build" / "ipython"
(_ipython / "profile_default" / "startup").mkdir(parents=True, exist_ok=True)
shutil.copy(DOCS / "extensions" / "notebook_start.py", _ipython / "profile_default" / "startup")
os.environ["IPYTHONDIR"] = str(_ipython)
