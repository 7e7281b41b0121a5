"""What a notebook of the documentation starts with: the files of tutorials/data in its folder."""

import os
import shutil
from pathlib import Path

from IPython import get_ipython

# The kernel is a fork of a process that has imported matplotlib, so it does not ask for this.
get_ipython().run_line_magic("matplotlib", "inline")
for _path in Path(os.environ["LABRIG_DOCS_DATA"]).iterdir():
    if _path.is_file():
        shutil.copy(_path, ".")
