"""A rig whose output and inputs are on one USB-6211, with `address = "simulated"`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from labrig.session import open_session
from protocols.execution.events import Outcome, OutputState
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig, run_rig

pytestmark = pytest.mark.slow

WORLD = """
[boards]
USB6211 = "USB-6211"

[wiring]
drive = "USB6211/ao1"
force = "USB6211/ai4"
current = "USB6211/ai1"
readback = "USB6211/ai2"
"""
PLACES = {
    "PCI6703/ao0": "USB6211/ao1",
    "PCI6034E/ai0": "USB6211/ai4",
    "PCI6034E/ai1": "USB6211/ai1",
    "PCI6034E/ai2": "USB6211/ai2",
}


@pytest.fixture
def rig_6211(tmp_path: Path) -> Path:
    folder = make_rig(tmp_path / "rig", ONE_POSITION + 'mode = "paper"\n', world=WORLD)
    text = (folder / "rig.toml").read_text()
    for old, new in PLACES.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "rig.toml").write_text(text)
    return folder


def test_check_finds_it_ready(rig_6211: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert labrig("check", rig_6211 / "rig.toml") == 0
    printed = capsys.readouterr().out
    assert "USB6211 is a USB-6211" in printed
    assert "output at 0 V" in printed


def test_a_run_measures_and_ends_at_zero_volts(rig_6211: Path) -> None:
    with open_session(run_rig(rig_6211)) as session:
        assert session.outcome is Outcome.COMPLETED
        assert session.output_state is OutputState.SAFE
        (run,) = session.runs
        assert run.counts.lost_samples == 0
        assert run.readings["valid"].all()
        drive_V, force_V = run.signal_V("drive"), run.signal_V("force")
    assert drive_V.max() == pytest.approx(2.0, abs=0.05)
    assert drive_V.min() == pytest.approx(-2.0, abs=0.05)
    assert abs(drive_V[-20:]).max() < 0.05  # 0 V, read back
    step_V = 2 * 0.2 / 2**16  # of its smallest range
    assert np.allclose(force_V / step_V, np.rint(force_V / step_V), atol=1e-6)
    assert np.ptp(force_V) > 1e-4  # the load cell is what is wired there


@pytest.mark.thorough
def test_a_replay_of_it_has_the_same_signals(rig_6211: Path, tmp_path: Path) -> None:
    session = run_rig(rig_6211)
    assert labrig("replay", session, "-o", tmp_path / "again.h5") == 0
    with open_session(session) as first, open_session(tmp_path / "again.h5") as again:
        assert first.ranges_V == again.ranges_V
        for channel in first.channels:
            np.testing.assert_array_equal(
                first.runs[0].signal_V(channel), again.runs[0].signal_V(channel)
            )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"USB-6211"', '"USB-6212"', "there is no simulated board 'USB-6212'"),
        ("USB6211/ai4", "USB6211/ai99", "[wiring] force = 'USB6211/ai99'"),
    ],
)
def test_a_world_without_that_board_or_terminal_is_refused_in_a_sentence(
    rig_6211: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, said: str
) -> None:
    (rig_6211 / "world.toml").write_text(WORLD.replace(old, new))
    assert labrig("check", rig_6211 / "rig.toml") == 2
    printed = capsys.readouterr()
    assert said in printed.err
    assert "world.toml" in printed.err
    assert "Traceback" not in printed.err
