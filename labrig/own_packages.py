"""Other people's modules that hide labrig's own packages, which have general names."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

NAMES = ("model", "drivers", "protocols", "sim_hardware")


def hidden() -> str | None:
    """Return one sentence if something else has the name of one of our packages, else None."""
    root = Path(__file__).resolve().parents[1]
    for name in NAMES:
        found = _where(name)
        if found is not None and found != root / name:
            return (
                f"{found}: hides labrig's own package '{name}', {root / name}; rename it, or "
                "start labrig in another folder and without it on PYTHONPATH."
            )
    return None


def require_own_packages() -> None:
    """Raise ImportError of one sentence if one of our packages is hidden."""
    sentence = hidden()
    if sentence is not None:
        raise ImportError(sentence)


def _where(name: str) -> Path | None:
    """Return the folder of a package or the file of a module, as an import would find it."""
    spec = sys.modules[name].__spec__ if name in sys.modules else find_spec(name)
    if spec is None:
        return None
    if spec.submodule_search_locations:
        return Path(next(iter(spec.submodule_search_locations))).resolve()
    return None if spec.origin is None else Path(spec.origin).resolve()
