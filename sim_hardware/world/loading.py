"""Reading a world.toml: laid over the shipped one, every fault named with file, key and value."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from sim_hardware.world.settings import WorldSettings

SHIPPED = ("world.toml", "paper_scatter.toml", "moving.toml")
_MOST_BYTES = 1 << 20
_MOST_SHOWN = 200  # characters of a key or value in a message
_REPLACED = ("boards",)  # a table of these replaces the shipped one whole
_LIMITS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}


class WorldError(ValueError):
    """A world that cannot be made; the text is one sentence: file, key, value, allowed range."""


def load_world(path: Path | None = None, seed: int | None = None) -> WorldSettings:
    """Return the world of a file; None: the shipped one. `seed` replaces the file's.

    A file needs to say only what differs from the shipped world.toml. Where a folder has no file
    of the name of a shipped world (`paper_scatter.toml`), the shipped one is meant. Raises
    WorldError.
    """
    content = _parsed(_shipped("world.toml"), "world.toml")
    name = "world.toml"
    if path is not None:
        name = str(path)
        content = _laid_over(content, _parsed(_text(Path(path)), name))
    if seed is not None:
        content["seed"] = seed
    try:
        return WorldSettings.model_validate(content)
    except ValidationError as fault:
        raise WorldError("; ".join(_sentence(name, error) for error in fault.errors())) from None


def _shipped(name: str) -> str:
    return files("sim_hardware.world").joinpath(name).read_text(encoding="utf-8")


def _text(path: Path) -> str:
    try:
        if path.exists() and not (path.is_file() and path.stat().st_size <= _MOST_BYTES):
            raise WorldError(f"{path}: this is no file that could hold a world")
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        if path.name in SHIPPED and path.parent.is_dir():
            return _shipped(path.name)
        raise WorldError(
            f"{path}: no such file; name a world.toml, or one of the shipped worlds "
            f"({', '.join(SHIPPED)})"
        ) from None
    except (OSError, UnicodeDecodeError) as fault:
        raise WorldError(f"{path}: cannot be read ({fault})") from None


def _parsed(text: str, name: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise WorldError(f"{name}: not valid TOML: too many brackets in one another") from None
    except ValueError as fault:  # also of a number with thousands of digits
        raise WorldError(f"{name}: not valid TOML: {fault}") from None


def _laid_over(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """`above` with what it does not say taken from `below`, table by table."""
    result = dict(below)
    for key, value in above.items():
        old = below.get(key)
        merge = isinstance(old, dict) and isinstance(value, dict) and key not in _REPLACED
        result[key] = _laid_over(old, value) if merge else value  # type: ignore[arg-type]
    return result


def _sentence(name: str, error: Any) -> str:
    key = _short(".".join(str(part) for part in error["loc"]))
    value = error["input"]
    shown = _short(repr(value))
    context = error.get("ctx", {})
    if error["type"] == "extra_forbidden":
        return f"{name}: {key} = {shown} is not a key of a world; remove it or correct its name"
    if error["type"] == "missing":
        return f"{name}: {key} is missing"
    limits = [f"{word} {context[k]:g}" for k, word in _LIMITS.items() if k in context]
    if limits:
        return f"{name}: {key} = {shown} must be {' and '.join(limits)}"
    reason = str(error["msg"]).removeprefix("Value error, ")
    reason = reason[:1].lower() + reason[1:]
    where = f"{key} = {shown}" if key and not isinstance(value, dict) else key or "the file"
    return f"{name}: {where}: {reason}"


def _short(text: str) -> str:
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}..."
