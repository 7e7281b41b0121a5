"""Where this user's caches lie: on this computer, and safe to delete."""

from __future__ import annotations

import os
import sys
from pathlib import Path

OWN = "LABRIG_CACHE"  # an environment variable that names another folder


def cache_folder() -> Path:
    """Return labrig's folder in the user's cache folder, as each system has it; not made here."""
    if own := os.environ.get(OWN):
        return Path(own)
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        base = Path(local) if local else _home() / "AppData" / "Local"
        return base / "labrig" / "Cache"
    if sys.platform == "darwin":
        return _home() / "Library" / "Caches" / "labrig"
    told = os.environ.get("XDG_CACHE_HOME", "")
    base = Path(told) if told and Path(told).is_absolute() else _home() / ".cache"
    return base / "labrig"


def _home() -> Path:
    """Return the user's folder; a place where nothing can be kept, where there is none.

    A container may run as a number that it does not know, and a relative HOME would be another
    folder for each place in which labrig is started.
    """
    try:
        home = Path.home()
    except RuntimeError:
        return Path(os.devnull)
    return home if home.is_absolute() else Path(os.devnull)
