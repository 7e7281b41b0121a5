"""The keys of a part's settings as lines of TOML to start from, for parts that bring none."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet

COMMENT_AT = 35  # column of the shipped files


def settings_text(
    settings: type,
    known: Mapping[str, object] | None = None,
    without: AbstractSet[str] = frozenset(),
) -> str:
    """Return a line for each field of a dataclass: key, default, and what it is.

    A key without a default is commented out and marked as needed. `known`: values of some;
    `without`: those that are left out.
    """
    fields = [
        field for field in dataclasses.fields(settings) if field.init and field.name not in without
    ]
    return "".join(_lines(fields, known or {}))


def _lines(fields: list[dataclasses.Field[object]], known: Mapping[str, object]) -> Iterator[str]:
    for field in fields:
        value = known.get(field.name, _default(field))
        needed = field.name not in known and _default(field) is dataclasses.MISSING
        text = "" if needed or value is None else _toml(value)
        key = f"{field.name} = {text}" if text else f"# {field.name} ="
        unit = field.metadata.get("unit", "")
        words = [field.metadata.get("description", ""), f"in {unit}" if unit else ""]
        said = ("needed: " if needed else "") + ", ".join(filter(None, words))
        yield f"{key.ljust(COMMENT_AT - 1)} # {said}\n" if said else f"{key}\n"


def _default(field: dataclasses.Field[object]) -> object:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def _toml(value: object) -> str:
    """Return a value as TOML has it; empty where it has none of that type."""
    if isinstance(value, str | bool | int | float):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, tuple | list):
        items = [_toml(one) for one in value]
        return f"[{', '.join(items)}]" if all(items) else ""
    if isinstance(value, Mapping):
        pairs = [f"{key} = {_toml(one)}" for key, one in value.items()]
        return f"{{ {', '.join(pairs)} }}" if pairs else ""
    return ""
