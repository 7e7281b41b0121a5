"""The configuration files behind the page's forms: text to values and back, comments kept."""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Item

from labrig.config import (
    PROTOCOLS,
    About,
    RigConfig,
    load_rig,
    parse_about,
    parse_json,
    parse_load_cell,
    parse_protocol,
    parse_rig,
    parse_sheet,
    parse_toml,
    read_text,
)
from labrig.config.about import FILE as ABOUT
from labrig.config.parts import board_models
from labrig.errors import BadInputError, LabrigError
from labrig.vision import Optics
from model import ModelError, SheetModel

Values = dict[str, Any]
KINDS = ("rig", "sheet", "protocol", "load_cell", "about", "optics", "model", "world")
WRITABLE = ("sheet", "protocol")
_MOST_FILES = 500


@dataclass(frozen=True)
class ConfigFile:
    """A file as the page gets it."""

    kind: str
    text: str
    values: Values | None = None
    errors: list[str] = field(default_factory=list)

    def as_dict(self) -> Values:
        """For JSON."""
        return {
            "kind": self.kind,
            "text": self.text,
            "values": self.values,
            "errors": self.errors,
            "ok": not self.errors,
        }


def list_files(folder: Path) -> list[Values]:
    """Return the configuration files of a folder, by name."""
    names = sorted(p for p in folder.iterdir() if p.suffix in {".toml", ".json"} and p.is_file())
    found = ((path.name, _kind_of_file(path)) for path in names[:_MOST_FILES])
    return [{"name": name, "kind": kind} for name, kind in found if kind]


def read_file(path: Path) -> ConfigFile:
    """Return a file with its faults, if any. Raises BadInputError when it is no text."""
    text = read_text(path)
    return from_text(kind_of(text, path.suffix), text, path.name)


def from_text(kind: str, text: str, name: str) -> ConfigFile:
    """Return a text with its faults, if any."""
    try:
        values = _values(text, kind, name)
    except BadInputError as error:
        return ConfigFile(kind, text, None, [str(error)])
    return ConfigFile(kind, text, values, _faults(kind, text, values, name))


def from_values(kind: str, values: Values, name: str, before: str = "") -> ConfigFile:
    """Values as a text; with `before`, the comments of that text are kept."""
    if kind == "optics":
        return from_text(kind, json.dumps(values, indent=1) + "\n", name)
    try:
        document = tomlkit.parse(before)
    except (TOMLKitError, RecursionError):
        document = tomlkit.document()
    _merge(document, _dated(values) if kind == "load_cell" else values)
    return from_text(kind, tomlkit.dumps(document), name)


def about_file(folder: Path) -> ConfigFile:
    """Return the about.toml beside rig.toml; an empty one where there is none."""
    path = folder / ABOUT
    return from_text("about", read_text(path) if path.exists() else "", ABOUT)


def about_text(folder: Path, values: Values) -> str:
    """Return about.toml with other values. Raises BadInputError for a fault in them."""
    found = from_values("about", values, ABOUT, about_file(folder).text)
    if found.errors:
        raise BadInputError(" ".join(found.errors))
    return found.text


def kind_of(text: str, suffix: str) -> str:
    """Return what a file is for, by its content; empty when it is none of ours."""
    try:
        values = parse_json(text, "") if suffix == ".json" else parse_toml(text, "")
    except BadInputError:
        return ""
    if not isinstance(values, dict):
        return ""
    if suffix == ".json":
        return "optics" if "px_per_mm" in values else ""
    if "labrig_model" in values:
        return "model"
    if values.keys() & {*board_models(), "replay", "amplifier"}:
        return "rig"
    if values.keys() & {"places", *PROTOCOLS.parts()}:
        return "protocol"
    if "sensitivity_V_per_N" in values:
        return "load_cell"
    if values.keys() & {"people", "project", "licence"} or (
        values and values.keys() <= About.model_fields.keys()
    ):
        return "about"
    tables = [values, *(value for value in values.values() if isinstance(value, dict))]
    return "sheet" if any("free_length_mm" in table for table in tables) else "world"


def _kind_of_file(path: Path) -> str:
    try:
        text = read_text(path)
    except BadInputError:
        return ""
    # A file that cannot be parsed is shown under the kind that its name says, to be mended.
    return kind_of(text, path.suffix) or next((k for k in KINDS if path.stem == k), "")


def _values(text: str, kind: str, name: str) -> Values:
    values = parse_json(text, name) if kind == "optics" else parse_toml(text, name)
    if not isinstance(values, dict):
        raise BadInputError(f"{name}: must hold one JSON object.")
    return {key: _plain(value) for key, value in values.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value.isoformat() if isinstance(value, dt.date | dt.time) else value


def _faults(kind: str, text: str, values: Values, name: str) -> list[str]:
    def model(_text: str, name: str) -> None:
        try:
            SheetModel.from_dict(values)
        except ModelError as error:
            raise BadInputError(f"{name}: {error}.") from None

    def protocol(text: str, name: str) -> None:
        parse_protocol(text, name).schedule(name)

    readers: dict[str, Callable[[str, str], object]] = {
        "rig": parse_rig,
        "sheet": parse_sheet,
        "protocol": protocol,
        "load_cell": parse_load_cell,
        "about": parse_about,
        "optics": Optics.from_json,
        "model": model,
    }
    try:
        if kind in readers:
            readers[kind](text, name)
    except LabrigError as error:
        return str(error).splitlines()
    return []


def _merge(table: Any, values: Values) -> None:
    """Make a TOML table hold these values; what stays the same keeps its place and its words."""
    for key in [key for key in table if values.get(key) is None]:
        del table[key]
    for key, value in values.items():
        if value is None:
            continue
        there = table.get(key)
        if isinstance(value, dict) and isinstance(there, dict):
            _merge(there, value)
        elif there is None or _unwrapped(there) != value:
            table[key] = _without_nothing(value)


def _unwrapped(item: Any) -> Any:
    return _plain(item.unwrap()) if isinstance(item, Item) else item


def _without_nothing(value: Any) -> Any:
    """TOML has no word for null: such a key is left out."""
    if isinstance(value, dict):
        return {key: _without_nothing(item) for key, item in value.items() if item is not None}
    if isinstance(value, list):
        return [_without_nothing(item) for item in value]
    return value


def _dated(values: Values) -> Values:
    """JSON has no dates."""
    try:
        return {**values, "date": dt.date.fromisoformat(str(values.get("date")))}
    except ValueError:
        return values


def rig_config(path: Path) -> RigConfig:
    """Return a rig.toml's content. Raises BadInputError for that of a recorded session."""
    config = load_rig(path)
    if not isinstance(config, RigConfig):
        raise BadInputError(f"{path.name}: this rig is a recorded session.")
    return config
