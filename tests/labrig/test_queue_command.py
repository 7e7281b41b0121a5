"""`labrig queue`: checked before the first begins, stopped by anything but a completed session."""

from __future__ import annotations

import errno
import json
import os
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from labrig.experiment import preflight
from labrig.session import open_session
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig
from tests.labrig.test_hooks import KEEP, told


@pytest.fixture
def rig(tmp_path, monkeypatch):
    folder = make_rig(tmp_path / "rig", ONE_POSITION + 'mode = "paper"\n')
    for name in ("first", "second", "third"):
        shutil.copy(folder / "protocol.toml", folder / f"{name}.toml")
    monkeypatch.chdir(folder)
    return folder


def outcomes(folder):
    found = {}
    for path in sorted(folder.glob("*.h5")):
        with open_session(path) as session:
            found[path.name] = session.outcome.value
    return found


@pytest.mark.thorough
@pytest.mark.slow
def test_protocols_are_run_one_after_the_other_and_each_is_reported(rig, tmp_path):
    hook = json.dumps([sys.executable, "-c", KEEP, str(tmp_path / "told")])
    with (rig / "rig.toml").open("a") as text:
        text.write(f"\n[hooks]\ncommand = {hook}\n")
    assert labrig("queue", "first.toml", "second.toml", "-o", "night") == 0
    assert outcomes(rig / "night") == {"01-first.h5": "completed", "02-second.h5": "completed"}
    assert [(one["event"], one["session"]) for one in told(tmp_path / "told")] == [
        ("done", "01-first.h5"),
        ("done", "02-second.h5"),
    ]


def test_a_fault_in_the_last_protocol_is_found_before_the_first_begins(rig, capsys):
    text = (rig / "third.toml").read_text()
    (rig / "third.toml").write_text(
        text.replace("[pulse_train]", "[pulse_train]\nvoltages_V=[9, -9]")
    )
    assert labrig("queue", "first.toml", "second.toml", "third.toml", "-o", "night") == 2
    assert "nothing was begun" in capsys.readouterr().err
    assert not (rig / "night").exists()


@pytest.mark.parametrize(
    "asked",
    [
        ("queue", "first.toml", "-o", "night"),
        ("run", "rig.toml", "first.toml", "sheet.toml", "-o", "night/s.h5"),
    ],
)
def test_a_folder_that_takes_no_file_is_told_before_the_rig_is_started(
    rig, capsys, monkeypatch, asked
):
    (rig / "night").mkdir()

    def refused(*_: object, **__: object) -> None:  # root may do anything
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(Path, "touch", refused)
    assert labrig(*asked) == 2
    said = capsys.readouterr().err
    assert "cannot be written (Permission denied)" in said
    assert "starting" not in said


def test_the_disk_must_have_room_for_all_sessions_together(rig, capsys, monkeypatch):
    one = preflight._session_bytes(preflight.plan_of(rig / "rig.toml"))
    free = int(2 * 1.5 * one)
    monkeypatch.setattr(preflight.shutil, "disk_usage", lambda _path: SimpleNamespace(free=free))
    assert labrig("queue", "first.toml", "second.toml", "third.toml", "-o", "night") == 2
    assert "for these 3 sessions" in capsys.readouterr().err


def test_a_session_that_exists_is_refused_before_the_first_begins(rig, capsys):
    (rig / "night").mkdir()
    (rig / "night" / "02-second.h5").touch()
    assert labrig("queue", "first.toml", "second.toml", "-o", "night") == 2
    assert "exists already" in capsys.readouterr().err
    assert not (rig / "night" / "01-first.h5").exists()


@pytest.mark.slow
def test_the_queue_stops_at_a_session_that_is_not_completed(rig, capsys):
    world = '[[faults]]\nwhat = "daq_write_refused"\nsince = "first_voltage"\nfrom_s = 6.0\n'
    (rig / "world.toml").write_text(world)
    longer = (rig / "second.toml").read_text().replace("[10]", "[0, 10, 20]")
    (rig / "second.toml").write_text(longer)
    code = labrig("queue", "first.toml", "second.toml", "third.toml", "-o", "night")
    assert code in (5, 6)
    assert outcomes(rig / "night") == {"01-first.h5": "completed", "02-second.h5": "failed"}
    assert "not begun: 03-third.h5" in capsys.readouterr().err
