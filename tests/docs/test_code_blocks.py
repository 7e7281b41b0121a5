"""Configuration that the pages show is read by the code that reads the real files."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from labrig.config.about import parse_about
from labrig.config.protocol import protocol_model
from labrig.config.rig import rig_model
from labrig.config.sheet import Sheet

DOCS = Path(__file__).parents[2] / "docs"
_TOML = re.compile(r"^( *)```toml\n(.*?)^ *```$", re.DOTALL | re.MULTILINE)
BLOCKS = [
    pytest.param(re.sub(rf"^{indent}", "", text, flags=re.MULTILINE), id=f"{page.stem}-{number}")
    for page in sorted(DOCS.rglob("*.md"))
    if "_build" not in page.parts and page.parent.name != "made"
    for number, (indent, text) in enumerate(_TOML.findall(page.read_text(encoding="utf-8")), 1)
]
# Keys of devices.md are those of the parts that it adds, which its own tests have.
OURS = [block for block in BLOCKS if not str(block.id).startswith("devices-")]
RIG, PROTOCOL = rig_model(), protocol_model()


@pytest.mark.parametrize("text", BLOCKS)
def test_toml_of_the_pages_is_toml(text):
    tomllib.loads(text)


@pytest.mark.parametrize("text", OURS)
def test_tables_of_rig_toml_have_keys_that_it_knows(text):
    known = RIG.model_fields
    tables = {name: table for name, table in tomllib.loads(text).items() if name in known}
    for name, table in tables.items():
        for fault in _faults(RIG, {name: table}):
            if fault["loc"][0] == name:
                assert fault["type"] != "extra_forbidden", fault


def _faults(model, data):
    from pydantic import ValidationError

    try:
        model.model_validate(data)
    except ValidationError as error:
        return error.errors()
    return []


def test_the_first_sessions_protocol_is_read():
    text = (DOCS / "tutorials" / "data" / "short.toml").read_text(encoding="utf-8")
    positions_mm = PROTOCOL.model_validate(tomllib.loads(text)).places[0].positions_mm
    assert list(positions_mm) == [0, 7, 14, 21]


def test_the_tutorials_sheets_are_read():
    for name, table in (("sheet.toml", "long"), ("strip.sheet.toml", "strip")):
        text = (DOCS / "tutorials" / "data" / name).read_text(encoding="utf-8")
        assert Sheet.model_validate(tomllib.loads(text)[table]).free_length_mm > 0


def test_the_about_toml_of_its_page_is_read():
    page = (DOCS / "howto" / "about.md").read_text(encoding="utf-8")
    assert parse_about(_TOML.findall(page)[0][1], "about.md").sample is not None
