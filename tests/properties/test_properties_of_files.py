"""Every configuration that its schema forbids ends with code 2, a sentence, and no session.

The cases are drawn from the JSON Schemas themselves: a key of each table is given a value of
another type, beyond its bounds, or a name that is not known.
"""

from __future__ import annotations

import contextlib
import copy
import io
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import tomlkit
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from labrig.cli.main import run
from labrig.config.rig import NOT_THE_OUTPUT
from labrig.config.schema import schemas
from labrig.config.templates import template_text, write_templates

FILES = {"rig": "rig.toml", "sheet": "sheet.toml", "protocol": "protocol.toml",
         "load_cell": "load_cell.toml", "about": "about.toml"}  # fmt: skip
ODD = (-1, 0, 10**9, 1.5, float("nan"), float("inf"), True, "word", "", [], [[]], {}, {"x": 1})
KINDS = {
    "integer": (int,),
    "number": (int, float),
    "string": (str,),
    "boolean": (bool,),
    "array": (list,),
    "object": (dict,),
}


@dataclass(frozen=True)
class Spot:
    """A key of a file that exists in the template, and what its schema says of it."""

    file: str
    path: tuple[str | int, ...]
    schema: Any  # a dict; None: the place of a key that is not known


def _resolved(schema: dict[str, Any], root: dict[str, Any]) -> dict[str, Any]:
    while "$ref" in schema:
        schema = root["$defs"][schema["$ref"].rsplit("/", 1)[-1]]
    return schema


def _spots(
    file: str, data: Any, schema: dict[str, Any], root: Any, at: tuple[Any, ...]
) -> Iterator[Spot]:
    schema = _resolved(schema, root)
    if "anyOf" in schema:
        tables = [_resolved(each, root) for each in schema["anyOf"]]
        schema = next((each for each in tables if each.get("type") == "object"), schema)
    if isinstance(data, dict):
        yield Spot(file, at, None)
        known = schema.get("properties", {})
        for key, value in data.items():
            below = known.get(key) or schema.get("additionalProperties") or {}
            yield Spot(file, (*at, key), _resolved(below, root))
            yield from _spots(file, value, below, root, (*at, key))
    elif isinstance(data, list) and data and isinstance(data[0], dict):
        yield from _spots(file, data[0], schema.get("items", {}), root, (*at, 0))


def _fits(value: Any, schema: dict[str, Any]) -> bool:
    """Whether a value may be what the schema describes; in doubt it may."""
    if "anyOf" in schema or "type" not in schema:
        return True
    kind = schema["type"]
    if kind == "string" and isinstance(value, str):
        return schema.get("format") != "date"  # what else it must look like is not said
    if isinstance(value, bool):
        return bool(kind == "boolean")
    if kind == "boolean":
        return value in (0, 1)
    if not isinstance(value, KINDS[kind]):
        return False
    if kind in ("integer", "number"):
        return _within(value, schema)
    return True


def _within(value: float, schema: dict[str, Any]) -> bool:
    if value != value or value in (float("inf"), -float("inf")):
        return False
    return (
        value >= schema.get("minimum", value)
        and value <= schema.get("maximum", value)
        and value > schema.get("exclusiveMinimum", value - 1)
        and value < schema.get("exclusiveMaximum", value + 1)
    )


def _all_cases() -> list[tuple[Spot, Any]]:
    found: list[tuple[Spot, Any]] = []
    for name, schema in schemas().items():
        file = FILES[name]
        text = template_text("rig_simulated.toml" if name == "rig" else file)
        for spot in _spots(file, tomllib.loads(text), schema, schema, ()):
            if spot.schema is None:
                found.append((spot, "unknown"))
                continue
            found += [(spot, odd) for odd in ODD if not _fits(odd, spot.schema)]
    return found


CASES = _all_cases()


def test_there_are_cases_for_each_file_and_most_keys() -> None:
    assert {spot.file for spot, _ in CASES} == set(FILES.values())
    assert len({(spot.file, spot.path) for spot, _ in CASES}) > 40
    assert len(CASES) > 200


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rig") / "rig"
    write_templates(folder, simulated=True)
    return folder


@contextlib.contextmanager
def changed(rig: Path, spot: Spot, value: Any) -> Iterator[None]:
    """A file of the rig with one fault in it."""
    path = rig / spot.file
    sound = path.read_text(encoding="utf-8")
    data: Any = tomllib.loads(sound)
    inner = data
    for key in spot.path[:-1] if spot.schema is not None else spot.path:
        inner = inner[key]
    inner["no_such_key" if spot.schema is None else spot.path[-1]] = copy.deepcopy(value)
    path.write_text(tomlkit.dumps(data), encoding="utf-8")
    try:
        yield
    finally:
        path.write_text(sound, encoding="utf-8")


@pytest.mark.slow
@settings(
    max_examples=120,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(case=st.sampled_from(CASES), command=st.sampled_from(["run", "check", "safe"]))
def test_every_invalid_configuration_ends_with_code_2_and_one_sentence(
    rig: Path, case: tuple[Spot, Any], command: str
) -> None:
    spot, value = case
    if spot.file != "rig.toml":
        command = "run"  # the others do not need that file
    elif command == "safe" and spot.path[:1] and spot.path[0] in NOT_THE_OUTPUT:
        command = "check"  # 0 V is written whatever is wrong with these
    files = [rig / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    arguments = [*files, "-o", rig / "s.h5"] if command == "run" else files[:1]
    out, err = io.StringIO(), io.StringIO()
    with (
        changed(rig, spot, value),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        code = run([command, *map(str, arguments)])
    said = err.getvalue().strip()
    assert code == 2, (spot.file, spot.path, value, code, said)
    assert said.startswith("labrig: "), said
    assert spot.file in said
    assert said.endswith("."), said
    assert "Traceback" not in said
    for line in said.splitlines():
        assert line.endswith("."), said  # a sentence for each fault, and nothing else
    assert list(rig.glob("s.h5*")) == []
