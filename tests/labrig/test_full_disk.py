"""A disk that takes no more: code 5, a sentence, and no half of a file under its name."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import h5py
import pytest

from labrig.cli.main import run
from labrig.errors import BadInputError, LabrigError
from labrig.files import check_free, write_text
from labrig.session import load_measurements, verify
from labrig.session.derived.store import store_finding
from labrig.session.recording import disk
from tests.cases import few
from tests.labrig.report_data import measure, session

_SAYS = "file write failed: errno = 28, error message = 'No space left on device'"


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of each file reaches the disk."""
    whole = Path.write_bytes

    def half(path: Path, content: bytes) -> int:
        whole(path, content[: len(content) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    monkeypatch.setattr(Path, "write_bytes", half)


@pytest.fixture(autouse=True)
def the_library_is_well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk, "_failed_writes", 0)
    monkeypatch.setattr(disk, "_left_behind", False)


@pytest.mark.slow
@pytest.mark.usefixtures("full")
@pytest.mark.parametrize(
    "asked",
    few(
        [
            ["init", "rig"],
            ["config", "schema", "schemas"],
            ["calibrate", "board", "-o", "board.pdf"],
            pytest.param(["fit", "good.h5", "-o", "model.toml"], marks=pytest.mark.slow),
        ],
        first=2,
    ),
)
def test_no_half_of_a_file_is_left(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    asked: list[str],
) -> None:
    session(tmp_path / "good.h5", measure("long"))
    monkeypatch.chdir(tmp_path)
    assert run(asked) == 5
    said = capsys.readouterr().err
    assert "the disk is full" in said
    assert len(said.strip().splitlines()) == 1
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["good.h5"]


@pytest.mark.slow
def test_a_session_is_not_called_damaged_when_its_copy_finds_no_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = session(tmp_path / "good.h5", measure("long"))

    def no_room(*_: Any, **__: Any) -> None:
        raise RuntimeError(f"Unable to synchronously copy object ({_SAYS})")

    monkeypatch.setattr(h5py.Group, "copy", no_room)
    with pytest.raises(LabrigError, match=r"good\.h5 cannot be written: the disk is full") as told:
        store_finding(path, "diagnosis", "{}")
    assert told.value.code == 5
    assert all(check.ok for check in verify(path))
    assert load_measurements(path).conditions
    assert list(tmp_path.iterdir()) == [path]


def test_the_process_ends_before_the_library_crashes_at_its_own_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ended: list[int] = []
    monkeypatch.setattr(os, "_exit", ended.append)
    disk.end_before_the_library_does(5)
    assert ended == []  # nothing has failed
    disk.end_before_the_library_does(6)
    assert ended == [6]  # boards that do not answer would be waited for
    ended.clear()
    disk.note_a_failed_write()
    disk.end_before_the_library_does(5)
    assert ended == [5]


def test_a_folder_that_cannot_be_written_is_named_by_the_file_that_was_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not by the one beside it, which cannot be removed there either."""

    def read_only(path: Path, *_: Any, **__: Any) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))

    for name in ("write_text", "write_bytes", "unlink"):
        monkeypatch.setattr(Path, name, read_only)
    with pytest.raises(BadInputError, match=r"model\.toml: cannot be written \(Read-only"):
        write_text(tmp_path / "model.toml", "x")
    with (
        pytest.raises(BadInputError, match=r"a\.h5 cannot be written: Read-only"),
        disk.written_beside(tmp_path / "a.h5") as beside,
    ):
        beside.write_bytes(b"x")


def test_two_programs_that_write_one_file_at_once_do_not_mix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, path = Path.write_bytes, tmp_path / "model.toml"

    def meanwhile(part: Path, content: bytes) -> int:
        written = whole(part, content)
        if content == b"one":
            write_text(path, "the other")
            assert path.read_text("utf-8") == "the other"
        return written

    monkeypatch.setattr(Path, "write_bytes", meanwhile)
    write_text(path, "one")
    assert path.read_text("utf-8") == "one"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_cannot_be_written_is_told_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:

    def refused(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(Path, "touch", refused)
    with pytest.raises(BadInputError, match=r"model.toml: cannot be written .Permission denied"):
        check_free(tmp_path / "model.toml")
