"""A page for each configuration file, from the models that read it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from labrig.config.schema import schemas
from labrig.vision import Optics

_FILES = {
    "rig": ("rig.toml", "What is wired, how fast it is sampled, and what must never be exceeded."),
    "sheet": (
        "sheet.toml",
        "The arc and the sheet. Its tables other than `[arc]` are configurations; you name them.",
    ),
    "protocol": (
        "protocol.toml",
        (
            "What is done at each position, and what is kept. It has one table of a kind of "
            "protocol, such as `[pulse_train]`. [What a protocol can determine](../protocol.md)"
        ),
    ),
    "load_cell": (
        "load_cell.toml",
        "The load cell's calibration. `labrig calibrate load-cell` writes it.",
    ),
    "about": ("about.toml", "People, sample and project. [More](../../howto/about.md)"),
}
_OPTICS = (
    "optics.json",
    (
        "Where the sheet's plane is in the image. `labrig calibrate camera` writes it. Required "
        "are `px_per_mm` and `clamp_px`."
    ),
)


def pages() -> dict[str, str]:
    """Return the pages by their names."""
    every = {name: (*_FILES[name], schema) for name, schema in schemas().items()}
    every["optics"] = (*_OPTICS, Optics.model_json_schema())
    return {f"{name}_file": "\n".join(_page(*parts)) for name, parts in every.items()}


def _page(file: str, about: str, schema: dict[str, Any]) -> Iterator[str]:
    yield f"# {file}\n"
    yield f"{about}\n"
    if file.endswith(".toml"):
        yield 'An unknown key is an error. Write a text as `"text"`, a date as `2026-03-04`.\n'
    yield from _table(schema, schema, "", level=2)
    further = schema.get("additionalProperties")
    if isinstance(further, dict):
        yield from _section(further, schema, "NAME", level=2)


def _table(part: dict[str, Any], schema: dict[str, Any], path: str, level: int) -> Iterator[str]:
    """Yield the keys of a table, then a section for each table in it."""
    required = part.get("required", [])
    keys, inner = [], []
    for name, value in part.get("properties", {}).items():
        table = _object(value, schema)
        named = _named_tables(value, schema)
        if named is not None:
            inner.append((f"{name}.NAME", value, named))
        elif table is None or not table.get("properties"):
            keys.append(_row(name, value, schema, needed=name in required))
        else:
            inner.append((name, value, table))
    if keys:
        yield "| key | value | default | meaning |"
        yield "|---|---|---|---|"
        yield from keys
        yield ""
    for name, value, table in inner:
        repeated = "array" in str(value.get("type", "")) or "items" in value
        below = f"{path}.{name}" if path else name
        said = value.get("description") or ""
        yield from _section(table, schema, below, level, said=said, repeated=repeated)


def _section(
    table: dict[str, Any],
    schema: dict[str, Any],
    path: str,
    level: int,
    *,
    said: str = "",
    repeated: bool = False,
) -> Iterator[str]:
    table = _resolved(table, schema)
    yield (
        f"{'#' * min(level, 4)} `[[{path}]]`\n"
        if repeated
        else f"{'#' * min(level, 4)} `[{path}]`\n"
    )
    about = table.get("description", "")
    yield f"{_sentence(about)} {_sentence(said) if said != about else ''}\n"
    yield from _table(table, schema, path, level + 1)


def _row(name: str, value: dict[str, Any], schema: dict[str, Any], *, needed: bool) -> str:
    default = "required" if needed else _shown(value.get("default"))
    meaning = _cell(value.get("description", ""))
    return f"| `{name}` | {_cell(_kind(value, schema))} | {default} | {meaning} |"


def _kind(value: dict[str, Any], schema: dict[str, Any]) -> str:
    value = _resolved(value, schema)
    if "const" in value:
        return f"`{_shown(value['const'])}`".replace("``", "`")
    if "enum" in value:
        return " or ".join(_shown(one) for one in value["enum"])
    for several in ("anyOf", "oneOf"):
        if several in value:
            kinds = [_kind(one, schema) for one in value[several] if one.get("type") != "null"]
            return " or ".join(dict.fromkeys(kinds))
    if value.get("type") == "array":
        return f"list of {_kind(value.get('items', {}), schema) or 'values'}"
    words = {"string": "text", "boolean": "true or false", "integer": "whole number"}
    if value.get("format") == "date":
        return "date"
    if value.get("type") == "object":
        return "table"
    kind = words.get(value.get("type", ""), value.get("type", ""))
    return f"{kind}{_bounds(value)}"


def _bounds(value: dict[str, Any]) -> str:
    signs = {
        "minimum": "at least",
        "exclusiveMinimum": "above",
        "maximum": "at most",
        "exclusiveMaximum": "below",
    }
    said = [f"{words} {value[key]:g}" for key, words in signs.items() if key in value]
    return f", {', '.join(said)}" if said else ""


def _object(value: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any] | None:
    """Return the table that a value is, or that a list holds; None for a plain value."""
    value = _resolved(value, schema)
    if "anyOf" in value:
        tables = [_object(one, schema) for one in value["anyOf"]]
        return next((one for one in tables if one is not None), None)
    if value.get("type") == "array":
        return _object(value.get("items", {}), schema)
    return value if value.get("type") == "object" else None


def _named_tables(value: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any] | None:
    """Return the table that each entry of a table is whose keys the user names; None for others."""
    value = _resolved(value, schema)
    tables = [_named_tables(one, schema) for one in value.get("anyOf", ())]
    if any(tables):
        return next(table for table in tables if table)
    named = value.get("patternProperties", {})  # where the names themselves are restricted
    further = next(iter(named.values()), value.get("additionalProperties"))
    if not isinstance(further, dict):
        return None
    table = _object(further, schema)
    return table if table and table.get("properties") else None


def _resolved(value: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any]:
    if "$ref" in value:
        found: dict[str, Any] = schema["$defs"][value["$ref"].rsplit("/", 1)[-1]]
        return found
    return value


def _shown(value: object) -> str:
    if value is None or value == "":
        return ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, str):
        return f'`"{value}"`'
    if isinstance(value, dict):
        return "a table"
    return f"`{value}`"


def _sentence(text: str) -> str:
    text = " ".join(text.split())
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') or not text else '.'}"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "\\<")
