"""`labrig run` and `labrig replay` on the simulated rig, as a user calls them."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from labrig.session import compare_sessions, open_session, verify
from protocols.execution.events import Outcome, OutputState
from tests.end_to_end.small_rig import ONE_POSITION, PROTOCOL, labrig, make_rig, run_rig

pytestmark = pytest.mark.slow


def test_a_session_is_complete_and_whole(session: Path) -> None:
    assert all(check.ok for check in verify(session))
    with open_session(session) as opened:
        assert opened.outcome is Outcome.COMPLETED
        assert opened.output_state is OutputState.SAFE
        assert [run.completed for run in opened.runs] == [True] * 4
        for run in opened.runs:
            assert run.counts.lost_samples == 0
            assert run.counts.frames_dropped == 0
            assert list(run.readings["kind"]) == ["zero"] * 3 + ["discarded"] * 2 + ["kept"] * 6
            assert run.readings["valid"].all()


def test_the_session_holds_no_trace_of_the_simulated_truth(session: Path) -> None:
    with open_session(session) as opened:
        words = "\n".join(opened.texts.values()) + str(opened.resolved)
    for secret in ("seed =", "youngs_modulus", "curvature_per_m = 100", "decay_mm"):
        assert secret not in words


def test_the_same_rig_gives_bit_identical_datasets_and_another_seed_others(tmp_path: Path) -> None:
    folder = make_rig(tmp_path, ONE_POSITION + 'mode = "paper"\n', world="seed = 1\n")
    one = run_rig(folder, "one.h5")
    assert compare_sessions(one, run_rig(folder, "again.h5")) == []
    (folder / "world.toml").write_text("seed = 2\n")
    other = run_rig(folder, "other.h5")
    assert any("signals" in difference for difference in compare_sessions(one, other))


@pytest.mark.thorough
def test_a_replayed_session_has_the_same_signals_readings_and_frames(
    session: Path, tmp_path: Path
) -> None:
    assert labrig("replay", session, "-o", tmp_path / "replayed.h5") == 0
    with open_session(session) as first, open_session(tmp_path / "replayed.h5") as second:
        for run, again in zip(first.runs, second.runs, strict=True):
            for channel in first.channels:
                np.testing.assert_array_equal(run.signal_V(channel), again.signal_V(channel))
            np.testing.assert_array_equal(run.readings["force_N"], again.readings["force_N"])
            for reading in (0, 10):
                np.testing.assert_array_equal(run.frame(reading), again.frame(reading))


@pytest.mark.thorough
def test_a_replay_that_nobody_keeps_names_the_session(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig("replay", session) == 0
    assert capsys.readouterr().out.startswith(f"{session}: completed")


@pytest.mark.thorough
def test_a_rig_that_is_a_recording_is_run_like_any_other(
    rig: Path, session: Path, tmp_path: Path
) -> None:
    shutil.copy(session, tmp_path / "old.h5")
    (tmp_path / "rig.toml").write_text('replay = "old.h5"\n')
    files = [rig / "protocol.toml", rig / "sheet.toml"]
    assert labrig("run", tmp_path / "rig.toml", *files, "-o", tmp_path / "new.h5") == 0
    with open_session(tmp_path / "new.h5") as opened:
        assert opened.outcome is Outcome.COMPLETED


def test_check_finds_the_simulated_rig_ready(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert labrig("check", rig / "rig.toml") == 0
    printed = capsys.readouterr().out
    for name in ("drive board", "output at 0 V", "load cell quiet", "camera rate", "disk space"):
        assert name in printed


@pytest.mark.parametrize(
    ("file", "old", "new", "code", "said"),
    [
        ("rig.toml", "gain", "gian", 2, "gian is not a known key; did you mean gain"),
        ("rig.toml", "PCI6703/ao0", "PCI6703/ao99", 3, "ao99"),
        ("rig.toml", "PCI6703/ao0", "Dev9/ao0", 3, "Dev9"),
        ("rig.toml", 'address = "simulated"', 'address = "127.0.0.1:9"', 2, "simulated"),
        ("rig.toml", "load_cell.toml", "lost.toml", 2, "there is no such file"),
        ("protocol.toml", "readings_per_voltage = 3", "readings_per_voltage = 99", 2, "under volt"),
        ("protocol.toml", "zero_readings = 3", "voltages_V = [3.0, -3.0]", 2, "2.5 V"),
        ("protocol.toml", '"short"', '"tall"', 2, "tall"),
        ("sheet.toml", "width_mm = 11.0", "width_mm = -11.0", 2, "greater than 0"),
        ("load_cell.toml", "0.15296", "0.0", 2, "must not be 0"),
        ("optics.json", "7.001", '"wide"', 2, "px_per_mm"),
    ],
)
def test_a_fault_in_a_file_is_one_sentence_and_leaves_no_session(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    file: str,
    old: str,
    new: str,
    code: int,
    said: str,
) -> None:
    folder = make_rig(tmp_path / "rig", PROTOCOL)
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new))
    files = [folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert labrig("run", *files, "-o", folder / "s.h5") == code
    printed = capsys.readouterr()
    assert said in printed.err
    assert "Traceback" not in printed.err
    assert list(folder.glob("s.h5*")) == []


def test_a_session_is_never_overwritten(
    rig: Path, session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = session.stat().st_mtime_ns
    files = [rig / file for file in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert labrig("run", *files, "-o", session) == 2
    assert "exists" in capsys.readouterr().err
    assert session.stat().st_mtime_ns == before
