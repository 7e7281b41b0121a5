"""More voltage at the sheet than configured, or one that stays, ends the session at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from labrig.session import open_session
from protocols.execution.events import Outcome, OutputState
from tests.cases import few
from tests.end_to_end.small_rig import ONE_POSITION, TWO_POSITIONS, labrig, make_rig

LONGEST_S = 0.1


@pytest.mark.slow
@pytest.mark.parametrize("board", few(["ni", "labjack"]))
def test_an_amplifier_with_more_gain_than_stated_is_noticed_at_the_first_step(
    tmp_path: Path, board: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = make_rig(tmp_path / "rig", ONE_POSITION, board=board)
    rig = folder / "rig.toml"
    text = rig.read_text()
    assert "gain = 10.0" in text
    rig.write_text(text.replace("gain = 10.0", "gain = 5.0", 1))
    files = [folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert labrig("run", *files, "-o", tmp_path / "session.h5") == 5
    said = capsys.readouterr().err
    assert "beyond the limit of" in said
    assert "[amplifier] gain" in said
    with open_session(tmp_path / "session.h5") as session:
        assert (session.outcome, session.output_state) == (Outcome.FAILED, OutputState.SAFE)
        drive_V = np.concatenate([run.signal_V("drive") for run in session.runs if run.started])
        assert np.max(np.abs(drive_V)) > 3.5
        above = np.count_nonzero(np.abs(drive_V) > 2.7)
        assert above / session.rate_hz < LONGEST_S


@pytest.mark.slow
@pytest.mark.parametrize(
    ("board", "pulse_V"), few([("ni", 2.0), ("labjack", 2.0), ("ni", 0.15)], first=2)
)
def test_a_voltage_that_stays_after_0_v_was_written_ends_the_session_before_the_next_position(
    tmp_path: Path, board: str, pulse_V: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """The operator would be asked to move the load cell, at a sheet that is under voltage."""
    stuck = '[[faults]]\nwhat = "output_stuck"\nsince = "first_voltage"\nfrom_s = 0.3\n'
    pulses = f"[pulse_train]\nvoltages_V = [{pulse_V}, -{pulse_V}]\n"
    protocol = TWO_POSITIONS.replace("[pulse_train]\n", pulses)
    folder = make_rig(tmp_path / "rig", protocol, world=stuck, board=board)
    files = [folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert labrig("run", *files, "-o", tmp_path / "session.h5") == 6
    assert "switch the amplifier off by hand" in capsys.readouterr().err
    with open_session(tmp_path / "session.h5") as session:
        assert (session.outcome, session.output_state) == (Outcome.FAILED, OutputState.UNKNOWN)
        assert [run.started for run in session.runs if run.planned.repeats is None] == [True, False]
        assert "0 V was written" in session.reason
