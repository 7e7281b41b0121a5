"""The version of this program."""

from __future__ import annotations

import importlib.metadata

NOT_INSTALLED = "0+unknown"  # run from a folder of sources that nobody has installed


def version() -> str:
    """Return the version as it was installed; that of git, where it was installed from there."""
    try:
        return importlib.metadata.version("labrig")
    except importlib.metadata.PackageNotFoundError:
        return NOT_INSTALLED
