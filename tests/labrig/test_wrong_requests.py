"""What cannot be done as it was asked for: one sentence, the right code, and nothing half done."""

from __future__ import annotations

import io
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.cli.sentences.streams import show_what_can_be_shown
from tests.labrig.report_data import measure, session


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session, a file that is none, and a session that was never under voltage."""
    folder = tmp_path_factory.mktemp("asked")
    made = measure("long")
    session(folder / "good.h5", made)
    still = tuple(replace(c, voltage_V=0.0, run=k) for k, c in enumerate(made.conditions))
    session(folder / "still.h5", replace(made, conditions=still))
    (folder / "a_file").write_text("x")
    return folder


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (["fit", "good.h5", "--q", "nan"], "--q nan: a number is needed"),
        (["fit", "still.h5"], "was measured at 0 V alone"),
        (["curves", "good.h5", "--configuration", "medium"], "are for images"),
        (["curves", "good.h5", "--look", "silhouette"], "are for images"),
        (["diagnose", "good.h5", "--without", "gravty"], "no effect 'gravty'"),
        (["list", "a_file"], "this is a file, a folder is needed"),
        (["panel", "--host", "192.0.2.1", "--insecure", "--port", "0"], "; check --host."),
        (["config", "schema", "a_file/x"], "Not a directory"),
        pytest.param(
            ["calibrate", "board", "-o", "nowhere/board.pdf"],
            "No such file or directory",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_it_is_told_in_one_sentence(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    asked: list[str],
    told: str,
) -> None:
    monkeypatch.chdir(folder)
    before = sorted(folder.rglob("*"))
    assert run(asked) == 2
    said = capsys.readouterr()
    assert told in said.err
    assert len(said.err.strip().splitlines()) == 1
    assert said.out == ""
    assert sorted(folder.rglob("*")) == before


def test_letters_that_the_output_cannot_show_are_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(shown, encoding="ascii"))
    show_what_can_be_shown()
    assert run(["effects", "show", "surface_tension"]) == 0
    sys.stdout.flush()
    assert b"Qu?r?" in shown.getvalue()


def test_signs_that_an_old_code_page_lacks_become_plain_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shown = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(shown, encoding="ascii"))
    show_what_can_be_shown()
    sys.stdout.write("0.198 → 0.032 mN, −2 V, 36.5 ± 0.1 µN·m, 漢")
    sys.stdout.flush()
    assert shown.getvalue() == b"0.198 -> 0.032 mN, -2 V, 36.5 +/- 0.1 uN m, ?"
