"""Requests that no command can fulfil, each with its whole answer: one sentence, code 2, no file.

requests.txt holds them as a person types and reads them. A line that begins with `$` is asked; what
follows is the answer.
"""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import pytest

from labrig.cli.app import all_commands
from labrig.cli.main import run
from tests.labrig.wrong_inputs.files import MOST_WORDS, make_files
from tests.labrig.wrong_inputs.tables import TABLES

TEXT = Path(__file__).with_name("requests.txt").read_text(encoding="utf-8")
CASES = [part.partition("\n")[::2] for part in TEXT.split("\n$ labrig ")[1:]]
FEWEST = 200


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_files(tmp_path_factory.mktemp("requests"))
    for name, text in TABLES.items():
        (folder / name).write_text(text)
    (folder / "binary.dat").write_bytes(bytes(range(256)))
    (folder / "loop.h5").symlink_to("loop.h5")
    return folder


@pytest.fixture(scope="module")
def before(files: Path) -> dict[str, int]:
    """The files as they are before the first request: none may change them."""
    return state(files)


def state(folder: Path) -> dict[str, int]:
    """When each file was written."""
    return {
        file.path: file.stat(follow_symlinks=False).st_mtime_ns
        for place, _, _ in os.walk(folder)
        for file in os.scandir(place)
        if file.is_file(follow_symlinks=False)
    }


def test_the_requests_are_of_all_commands_and_many() -> None:
    assert len(dict(CASES)) == len(CASES) >= FEWEST
    assert {command.name for command in all_commands()} <= {asked.split()[0] for asked, _ in CASES}


@pytest.mark.slow  # hundreds of them
@pytest.mark.parametrize(("asked", "told"), CASES, ids=[asked for asked, _ in CASES])
def test_a_request_is_answered_in_one_sentence(
    files: Path,
    before: dict[str, int],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    asked: str,
    told: str,
) -> None:
    monkeypatch.chdir(files)
    assert run(shlex.split(asked)) == 2
    assert capsys.readouterr().err.removeprefix("labrig: ").strip() == told.strip()
    for line in told.strip().splitlines():
        assert len(line.split()) <= MOST_WORDS, line
    assert state(files) == before
