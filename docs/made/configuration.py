"""A page for each configuration file, from the models that read it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from labrig.config.schema import schemas
from labrig.vision import Optics

_FILES = {
    "rig": ("rig.toml", "The wiring, the sample rate, and the limits that are never exceeded."),
    "sheet": (
        "sheet.toml",
        "The arc and the sheet. Its tables other than `[arc]` are configurations; you name them.",
    ),
    "protocol": (
        "protocol.toml",
        (
            "Voltages, positions and recordings of a session. It has one table of a kind of "
            "protocol, such as `[pulse_train]`. [The protocol file](../protocol.md)"
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
        "The relation of pixels to the sheet's plane. `labrig calibrate camera` writes it. Only "
        "`px_per_mm` and `clamp_px` are required."
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
        tables = _tables(value, schema)
        named = _named_tables(value, schema)
        if named is not None:
            inner.append((f"{name}.NAME", value, [named]))
        elif not any(table.get("properties") for table in tables):
            keys.append(_row(name, value, schema, needed=name in required))
        else:
            inner.append((name, value, tables))
            if _may_be_plain(value):
                keys.append(_row(name, value, schema, needed=name in required))
    yield from _rows(keys)
    for name, value, tables in inner:
        repeated = "array" in str(value.get("type", "")) or "items" in value
        below = f"{path}.{name}" if path else name
        said = value.get("description") or ""
        if len(tables) > 1:
            yield from _kinds(tables, schema, below, level, said)
        else:
            yield from _section(tables[0], schema, below, level, said=said, repeated=repeated)


def _rows(rows: list[str]) -> Iterator[str]:
    if rows:
        yield "| key | value | default | meaning |"
        yield "|---|---|---|---|"
        yield from rows
        yield ""


def _kinds(
    tables: list[dict[str, Any]], schema: dict[str, Any], path: str, level: int, said: str
) -> Iterator[str]:
    """Yield the keys that all kinds of a device share, then the further keys of each kind."""
    rows = [_rows_of(table, schema) for table in tables]
    shared = [row for row in rows[0] if all(row in others for others in rows)]
    names = [_shown(table["properties"]["kind"].get("const")) for table in tables]
    yield f"{'#' * level} `[{path}]`\n"
    if said:
        yield f"{_sentence(said)}\n"
    yield from _rows([f"| `kind` | {' or '.join(names)} | | |", *shared])
    for table, own, name in zip(tables, rows, names, strict=True):
        further = [row for row in own if row not in shared]
        if further:
            yield f"{'#' * (level + 1)} `[{path}]` with `kind = `{name}\n".replace("``", "")
            yield f"{_sentence(table.get('description', ''))}\n"
            yield from _rows(further)


def _rows_of(table: dict[str, Any], schema: dict[str, Any]) -> list[str]:
    required = table.get("required", [])
    return [
        _row(name, value, schema, needed=name in required)
        for name, value in table.get("properties", {}).items()
        if name != "kind"
    ]


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
    before = "" if about.startswith(said.rstrip(".")) else f"{_sentence(said)} "
    yield f"{before}{_sentence(about)}\n"
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


def _tables(value: dict[str, Any], schema: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the tables that a value may be, or that a list holds; none for a plain value."""
    value = _resolved(value, schema)
    if "anyOf" in value:
        return [table for one in value["anyOf"] for table in _tables(one, schema)]
    if value.get("type") == "array":
        return _tables(value.get("items", {}), schema)
    return [value] if value.get("type") == "object" else []


def _may_be_plain(value: dict[str, Any]) -> bool:
    """Return whether a value may be a number, a text or a truth value in place of a table."""
    plain = {"string", "number", "integer", "boolean"}
    return any(one.get("type") in plain or "const" in one for one in value.get("anyOf", ()))


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
    return next((one for one in _tables(further, schema) if one.get("properties")), None)


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
