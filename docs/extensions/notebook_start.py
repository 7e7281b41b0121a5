"""What a notebook of the documentation starts with: the files of tutorials/data in its folder.

Its kernel is a fork of a process that has imported matplotlib, so figures inline are asked for here.
"""

import os
import shutil
from pathlib import Path

import matplotlib as _matplotlib

_matplotlib.use(os.environ["MPLBACKEND"])
for _path in Path(os.environ["LABRIG_DOCS_DATA"]).iterdir():
    if _path.is_file():
        shutil.copy(_path, ".")
