"""What a notebook of the documentation starts with: the files of tutorials/data in its folder."""

import os
import shutil
from pathlib import Path

for _path in Path(os.environ["LABRIG_DOCS_DATA"]).iterdir():
    if _path.is_file():
        shutil.copy(_path, ".")
