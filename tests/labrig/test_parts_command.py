"""`labrig parts`: every kind of part, what is found of it, and groups that nobody looks into."""

from __future__ import annotations

import ast
import json
import re
import sys
from pathlib import Path

import pytest

from labrig import testing
from labrig.cli.main import run
from labrig.cli.part_folders import FOLDERS, PREFIX, folder_of

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "howto" / "extending.md"
NO_PART = object()


def groups_in_the_code() -> set[str]:
    """The entry-point group of each plug-in folder that our packages make."""
    found = set()
    for package in ("labrig", "drivers", "protocols", "model", "sim_hardware"):
        for path in (ROOT / package).rglob("*.py"):
            text = path.read_text("utf-8")
            if "PluginFolder(" not in text:
                continue
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "PluginFolder":
                    (group,) = [word.value for word in node.keywords if word.arg == "group"]
                    assert isinstance(group, ast.Constant)
                    found.add(group.value)
    return found


def test_every_plug_in_folder_is_listed() -> None:
    assert {PREFIX + kind for kind in FOLDERS} == groups_in_the_code()


def test_the_page_about_extending_has_every_kind() -> None:
    pattern = r"\| ([^|`]+) \| `([A-Z_]+)` \| `(\S+)` \| `(labrig\.\w+)` \| `(\w+)` \|"
    rows = re.findall(pattern, PAGE.read_text("utf-8"))
    assert {group for *_, group, _ in rows} == groups_in_the_code()
    for name, constant, place, group, function in rows:
        folder = folder_of(group.removeprefix(PREFIX))
        named = (name, constant, place.replace("/", "."))
        assert (folder.what, folder.constant, folder.package) == named
        found = getattr(testing, function)(NO_PART)
        assert found == folder.faults(NO_PART) != []


def test_a_part_of_another_distribution_is_listed_and_a_misspelt_group_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    info = tmp_path / "writer-1.2.dist-info"
    info.mkdir()
    (tmp_path / "writer.py").write_text(
        "class Format:\n    summary, extra = 'A format.', ''\n"
        "    def write(self, session, folder): return []\nFORMAT = Format()\n"
    )
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: writer\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(
        "[labrig.exports]\nfile = writer:FORMAT\n[labrig.export]\nfile = writer:FORMAT\n"
        "[labrig.sections]\nfile = writer:FORMAT\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    assert run(["parts", "exports", "--json"]) == 0
    printed = capsys.readouterr()
    assert {"name": "file", "distribution": "writer", "version": "1.2"} in json.loads(printed.out)[
        "exports"
    ]
    assert (
        "the entry-point group labrig.export of writer is no kind of part; "
        "did you mean labrig.exports" in printed.err
    )
    assert "did you mean labrig.report_sections" in " ".join(printed.err.split())
    monkeypatch.delitem(sys.modules, "writer")


def test_an_unknown_kind_is_answered_with_the_one_spelt_alike(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for asked, meant in {"camera": "cameras", "sections": "report_sections"}.items():
        assert run(["parts", asked]) == 2
        said = f"there is no kind of part '{asked}'; did you mean {meant}?"
        assert said in capsys.readouterr().err
