"""What is the same for every process that the panel starts."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import TypedDict

_ROOT = Path(__file__).resolve().parents[2]


class Detached(TypedDict):
    """Options of `subprocess.Popen`."""

    start_new_session: bool
    creationflags: int


def module_environment() -> dict[str, str]:
    """Return an environment in which a process finds our packages, wherever it is started."""
    path = os.pathsep.join(filter(None, [str(_ROOT), os.environ.get("PYTHONPATH")]))
    # PYTHONSAFEPATH: a module of that name in the folder it is started in hides none of ours.
    return {**os.environ, "PYTHONPATH": path, "PYTHONSAFEPATH": "1"}


def detached() -> Detached:
    """Return a process that neither Ctrl-C at the panel's terminal nor the panel's end reaches."""
    flags = 0
    if sys.platform == "win32":
        flags = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
    return {"start_new_session": sys.platform != "win32", "creationflags": flags}
