"""The version of this program."""

from __future__ import annotations

import importlib.metadata
from functools import cache
from pathlib import Path

NOT_INSTALLED = "0+unknown"  # run from a folder of sources that nobody has installed
_SOURCES = Path(__file__).parents[1]
_LETTERS = 9  # of a commit, as in the versions that setuptools-scm makes


def version() -> str:
    """Return the version as it was installed; in a clone of git that of the present commit.

    What was installed from a clone (`pip install -e .`) has the commit of that day for ever.
    """
    try:
        installed = importlib.metadata.version("labrig")
    except importlib.metadata.PackageNotFoundError:
        return NOT_INSTALLED
    commit = commit_of(_SOURCES)
    if not commit or f"+g{commit[:_LETTERS]}" in installed:
        return installed
    return f"{installed.partition('+')[0]}+g{commit[:_LETTERS]}"


@cache
def commit_of(sources: Path) -> str:
    """Return the commit that a clone of labrig is at, hexadecimal; empty: it is none."""
    try:
        if 'name = "labrig"' not in (sources / "pyproject.toml").read_text(encoding="utf-8"):
            return ""
        git = sources / ".git"
        if git.is_file():  # of a work tree beside the clone
            git = sources / _text(git).removeprefix("gitdir: ")
        head = _text(git / "HEAD")
        return _commit(git, head.removeprefix("ref: ")) if head.startswith("ref: ") else head
    except OSError:
        return ""


def _commit(git: Path, branch: str) -> str:
    common = git / "commondir"
    shared = git / _text(common) if common.exists() else git
    if (shared / branch).exists():
        return _text(shared / branch)
    packed = (line.split() for line in _text(shared / "packed-refs").splitlines())
    return next((line[0] for line in packed if line[1:] == [branch]), "")


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8").strip()
