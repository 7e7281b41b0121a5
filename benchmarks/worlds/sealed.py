"""Sealed generators: nobody looks at them while the procedure is changed, and they do not change.

`sealed.toml` holds the sha256 of each one's files, and the seeds whose figures are reported.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

from benchmarks.worlds.registry import digest, names

FILE = Path(__file__).with_name("sealed.toml")


def check(name: str, seed: int, file: Path = FILE) -> None:
    """Raise `ValueError` where a sealed world has changed, or its seed is not to be reported."""
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    sealed, seeds = table.get("sealed", {}), table["report"]["seeds"]
    if name not in sealed:
        return
    if digest(name) != sealed[name]:
        raise ValueError(
            f"the sealed world '{name}' is not the one that was sealed: its digest is"
            f" {digest(name)}, sealed.toml has {sealed[name]}"
        )
    if seed not in seeds:
        raise ValueError(
            f"the sealed world '{name}' is only measured with the seeds to be reported,"
            f" {', '.join(map(str, seeds))}, not {seed}"
        )


def is_sealed(name: str, file: Path = FILE) -> bool:
    """Return whether a generator is sealed."""
    return name in tomllib.loads(file.read_text(encoding="utf-8")).get("sealed", {})


def open_worlds() -> tuple[str, ...]:
    """Return the generators that anybody may look at and train on."""
    return tuple(name for name in names() if not is_sealed(name))
