"""The boards of a simulated rig whose world.toml names none."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files


@cache
def default_boards() -> dict[str, str]:
    """Return the shipped world's `[boards]`: a device's name and its product type."""
    text = files("sim_hardware").joinpath("world", "world.toml").read_text(encoding="utf-8")
    boards: dict[str, str] = tomllib.loads(text)["boards"]
    return boards
