"""With --json, standard output holds JSON, whatever parts of other distributions print."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from labrig.cli.main import run
from tests.model.distributions import install

TALKATIVE = """
from dataclasses import replace

from model.effects.gravity import EFFECT as GRAVITY

print("hello from the part")
EFFECT = replace(GRAVITY, name="talkative", title="Talkative")
"""


def test_what_a_foreign_part_prints_is_not_in_the_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    name = "talkative_effect"
    install(tmp_path, name, f"[labrig.effects]\ntalkative = {name}:EFFECT\n", TALKATIVE)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert run(["effects", "--json"]) == 0
    said = capsys.readouterr()
    assert "talkative" in said.out
    json.loads(said.out)
    assert "hello from the part" in said.err


def test_standard_output_is_what_it_was_after_a_command(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["effects", "--json"]) == 0
    json.loads(capsys.readouterr().out)
    print("later")
    assert capsys.readouterr().out == "later\n"


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help_is_no_json_and_stays_on_standard_output(
    option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["effects", "--json", option]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("Usage: labrig effects")
    assert said.err == ""
