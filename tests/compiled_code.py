"""What numba compiled while the tests ran.

`make test` compiles first what the tests need: each worker that needs more compiles it for itself,
and some of it takes a minute. The end of a run names what was compiled after all.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("labrig", "model", "sim_hardware")


def compiled_since(time_s: float, root: Path = ROOT) -> list[str]:
    """Return the modules with compiled code that is newer than this, sorted."""
    found = set()
    for package in PACKAGES:
        for path in (root / package).rglob("__pycache__/*.nbi"):
            if path.stat().st_mtime > time_s:
                name = path.name.split(".")[0] + ".py"
                found.add((path.parents[1] / name).relative_to(root).as_posix())
    return sorted(found)


def summary(modules: Sequence[str]) -> list[str]:
    """Return a line for people; none where nothing was compiled."""
    if not modules:
        return []
    names = ", ".join(modules)
    return [f"compiled while the tests ran: {names} (`make test`: see COMPILE in the Makefile)"]
