"""A rig whose boards are a LabJack: the paper's protocol, and every fault of the wire."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig.config import RigConfig, load_rig
from labrig.session import open_session
from protocols.execution.events import Outcome, OutputState
from tests.cases import few
from tests.end_to_end.faulty_rig import FaultyRig, spied_writes
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig, run_rig
from tests.end_to_end.test_faults import (
    BEFORE,
    DONE,
    FAILED,
    FOR_A_MOMENT,
    FOR_A_WHILE,
    FOR_GOOD,
    FROM_THE_BEGINNING,
    LIMIT_V,
    UNKNOWN,
    Case,
)

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("data_unchecked")]
PAPER = """
[pulse_train]
zero_readings = 2
readings_per_voltage = 2

[[places]]
configuration = "long"
positions_mm = [5, 15]

[[places]]
configuration = "short"
positions_mm = [5, 15]

[extras]
mode = "paper"
"""

CASES = [
    Case("daq_refused", FROM_THE_BEGINNING, BEFORE, "no connection to the LabJack"),
    Case("daq_refused", FOR_GOOD, UNKNOWN, "switch the amplifier off by hand"),
    Case("daq_refused", FOR_A_MOMENT, FAILED, "no connection to the LabJack"),
    Case("daq_hung", FROM_THE_BEGINNING, BEFORE, "did not answer in the time this can take"),
    Case("daq_hung", FOR_A_WHILE, FAILED, "did not answer in the time this can take"),
    Case("daq_hung", FOR_GOOD, UNKNOWN, "switch the amplifier off by hand"),
    Case("daq_read_hung", FOR_A_WHILE, FAILED, "did not answer in the time this can take"),
    Case("daq_slow", FOR_GOOD + "\namount_s = 0.02", DONE, "ms late (limit 5 ms)", "its edge came"),
    Case("daq_write_refused", FOR_A_MOMENT, FAILED, "refuses it"),
    Case("daq_write_refused", FOR_GOOD, UNKNOWN, "switch the amplifier off by hand"),
    Case("daq_reserved", FROM_THE_BEGINNING, BEFORE, "another labrig drives"),
    Case("daq_reserved", FOR_GOOD, UNKNOWN, "another labrig drives"),
    Case("daq_buffer_overflow", FOR_A_MOMENT, FAILED, "samples were overwritten"),
    Case("output_stuck", FOR_GOOD, UNKNOWN, "the drive voltage reads"),
    Case("force_nan", FOR_GOOD, FAILED, "unload it at once"),
    Case("drive_nan", FOR_GOOD, UNKNOWN, "the drive voltage reads"),
    Case("current_saturated", FOR_GOOD, DONE, "the current input is at", "end of its range"),
    Case("cell_unplugged", FROM_THE_BEGINNING, BEFORE, "broken wire"),
    Case("clock_jump", FOR_GOOD + "\namount_s = 30.0", FAILED, "samples were overwritten"),
]

# What the wire of these boards makes different runs always; the others are in test_faults.py, too.
MORE = {
    "daq_refused for a moment", "daq_hung from the beginning", "daq_read_hung for a moment",
    "daq_write_refused for a moment", "current_saturated for good", "force_nan for good",
    "cell_unplugged from the beginning", "clock_jump for good",
}  # fmt: skip


def marked(case: Case) -> Any:
    """The case, in the thorough run alone where it is one of MORE."""
    marks = [pytest.mark.thorough] if case.name in MORE else []
    return pytest.param(case, marks=marks, id=case.name)


@pytest.fixture
def rig(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> FaultyRig:
    return FaultyRig(tmp_path, capsys, spied_writes(monkeypatch), "labjack")


@pytest.mark.parametrize("case", [marked(case) for case in CASES])
def test_a_fault_ends_as_with_other_boards(rig: FaultyRig, case: Case) -> None:
    since = "" if "since" in case.when else '\nsince = "first_voltage"'
    left = rig.run(f'[[faults]]\nwhat = "{case.what}"\n{case.when}{since}\n', case.rig)
    assert left.code == case.code, left.said
    assert case.said in left.said
    assert "Traceback" not in left.said
    assert "should not have happened" not in left.said
    assert left.highest_V <= LIMIT_V
    if case.code == BEFORE:
        assert left.highest_V == 0.0
        return
    assert left.output is (OutputState.UNKNOWN if case.code == UNKNOWN else OutputState.SAFE)
    assert ("NOT KNOWN TO BE SAFE" in left.said.splitlines()[-1]) is (case.code == UNKNOWN)
    if case.code != UNKNOWN:
        assert left.board_V == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('model = "T7"', 'model = "T7"\nserial = 470000009', "has the serial number 470012345"),
        ('model = "T7"', 'model = "T8"', "is a T7, rig.toml says T8"),
        ('drive = "TDAC0"', 'drive = "TDAC6"', "the LJTick-DAC does not answer"),
        ('current = "AIN2"', 'current = "AIN3"', "take an even one, AIN0 to AIN12"),
    ],
)
def test_what_does_not_fit_the_device_is_said_before_the_first_voltage(
    rig: FaultyRig, old: str, new: str, said: str
) -> None:
    left = rig.run(rig=[(old, new)])
    assert left.code == BEFORE
    assert said in left.said
    assert left.highest_V == 0.0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('drive = "TDAC0"', 'drive = "DAC0"', "gives no negative voltage"),
        ('drive = "TDAC0"', 'drive = "TDAC99"', "must be an output: TDAC0 to TDAC21"),
        ('force = "AIN0"', 'force = "ai0"', "must be an analog input, AIN0 to AIN13"),
        ('model = "T7"', 'model = "U3"', "must be one of T4, T7, T8"),
        ('address = "simulated"', 'address = "a:b:c"', "must be the device's address"),
        ("[load_cell]", '[interlock]\nline = "EIO9"\n[load_cell]', "must be a digital line"),
    ],
)
def test_what_no_device_has_is_said_with_its_key(
    rig: FaultyRig, old: str, new: str, said: str
) -> None:
    left = rig.run(rig=[(old, new)])
    assert left.code == 2
    assert said in left.said
    assert "rig.toml" in left.said


def test_init_writes_a_rig_that_passes_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig("init", tmp_path / "real", "--board", "labjack") == 0
    real = load_rig(tmp_path / "real" / "rig.toml")
    assert isinstance(real, RigConfig)
    assert real.boards_kind == "labjack"
    assert not real.is_simulated
    assert labrig("init", tmp_path / "rig", "--board", "labjack", "--simulated") == 0
    assert labrig("check", tmp_path / "rig" / "rig.toml") == 0
    assert "T7, serial 470012345" in capsys.readouterr().out
    assert labrig("init", tmp_path / "no", "--board", "labjak") == 2
    assert "did you mean 'labjack'?" in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The paper's protocol with fewer readings, on a LabJack."""
    return run_rig(make_rig(tmp_path_factory.mktemp("labjack"), PAPER, board="labjack"))


def test_the_papers_protocol_runs_from_end_to_end(session: Path) -> None:
    with open_session(session) as done:
        assert done.outcome is Outcome.COMPLETED
        assert done.output_state is OutputState.SAFE
        assert done.simulated
        assert done.devices[0].identity.product == "T7"
        for run in done.runs:
            assert run.counts.lost_samples == 0
            assert run.readings["valid"].all()
            drive_V = run.signal_V("drive")
            assert drive_V.max() == pytest.approx(2.0, abs=0.05)
            assert drive_V.min() == pytest.approx(-2.0, abs=0.05)
            assert abs(drive_V[-20:]).max() < 0.05


@pytest.mark.thorough
def test_it_is_analysed_and_fitted_as_any_other(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig("analyze", session) == 0
    assert labrig("fit", session, "-o", session.with_name("model.toml")) == 0
    said = capsys.readouterr().out
    found = re.search(r"bending stiffness B, µN·m²\s+([\d.]+)", said)
    assert found is not None
    assert float(found[1]) == pytest.approx(1.273, rel=0.1)  # the world's


@pytest.mark.thorough
def test_a_replay_of_it_has_the_same_signals(session: Path, tmp_path: Path) -> None:
    assert labrig("replay", session, "-o", tmp_path / "again.h5") == 0
    with open_session(session) as first, open_session(tmp_path / "again.h5") as again:
        step_V = 20.0 / 65536
        for channel in first.channels:
            signals = [each.runs[0].signal_V(channel) for each in (first, again)]
            shared = min(map(len, signals))
            assert shared > 0.95 * len(signals[0])
            np.testing.assert_allclose(signals[0][:shared], signals[1][:shared], atol=step_V)


@pytest.mark.parametrize("product_type", few(["T7 DAC0", "T4", "T8 DAC0"]))
def test_other_models_and_an_offset_stage_run_too(tmp_path: Path, product_type: str) -> None:
    world = f'[boards]\nLJ = "{product_type}"\n[load_cell]\nsensitivity_V_per_N = 5.0\n'
    folder = make_rig(tmp_path / "rig", ONE_POSITION + 'mode = "paper"\n', world, "labjack")
    text = (folder / "rig.toml").read_text()
    model, _, own = product_type.partition(" ")
    text = text.replace('model = "T7"', f'model = "{model}"')
    if own:
        text = text.replace('drive = "TDAC0"', 'drive = "DAC0"\nzero_V = 2.5\nstage_gain = 4.0')
    if model != "T7":
        text = text.replace('"AIN2"', '"AIN1"').replace('"AIN4"', '"AIN2"')
    (folder / "rig.toml").write_text(text)
    cell = folder / "load_cell.toml"
    line = re.sub(r"(?m)^sensitivity_V_per_N = \S+", "sensitivity_V_per_N = 5.0", cell.read_text())
    cell.write_text(line)
    with open_session(run_rig(folder)) as session:
        assert session.outcome is Outcome.COMPLETED
        drive_V = session.runs[0].signal_V("drive")
    assert drive_V.max() == pytest.approx(2.0, abs=0.1)
    assert drive_V.min() == pytest.approx(-2.0, abs=0.1)
