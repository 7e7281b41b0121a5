"""The generators in the folder `generators`, and the files that each consists of."""

from __future__ import annotations

import hashlib
from importlib import import_module
from pathlib import Path

from benchmarks.worlds.contract import World

FOLDER = Path(__file__).parent / "generators"


def names() -> tuple[str, ...]:
    """Return the generators' names: NAME.py; files that begin with `_NAME` are parts of it."""
    return tuple(sorted(p.stem for p in FOLDER.glob("*.py") if not p.stem.startswith("_")))


def world(name: str) -> World:
    """Return a generator; raise `ValueError` where there is none."""
    if name not in names():
        raise ValueError(f"there is no generator '{name}'; there are {', '.join(names())}")
    found: World = import_module(f"benchmarks.worlds.generators.{name}").WORLD
    return found


def files(name: str) -> tuple[Path, ...]:
    """Return the files of a generator: its own and its parts."""
    return FOLDER / f"{name}.py", *sorted(FOLDER.glob(f"_{name}_*.py"))


def digest(name: str) -> str:
    """Return the sha256 of a generator's files, in their order."""
    whole = hashlib.sha256()
    for path in files(name):
        whole.update(path.name.encode() + b"\0" + path.read_bytes())
    return whole.hexdigest()
