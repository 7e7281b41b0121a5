"""Distributions of other people, as an installer leaves them."""

from __future__ import annotations

from pathlib import Path


def install(folder: Path, name: str, entry_points: str, module: str) -> None:
    """Install version 1.0 of a distribution with one module of its name."""
    (folder / f"{name}.py").write_text(module, encoding="utf-8")
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8"
    )
    (info / "entry_points.txt").write_text(entry_points, encoding="utf-8")
