"""Every fault: one sentence for the operator, the truth in the file, and 0 V or code 6."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import pytest

from protocols.execution.events import Outcome, OutputState
from sim_hardware.world.settings import FaultKind
from tests.cases import few
from tests.end_to_end.faulty_rig import FaultyRig, spied_writes

pytestmark = pytest.mark.slow
BEFORE, FAILED, UNKNOWN, DONE = 3, 5, 6, 0
LIMIT_V = 0.25
FOR_GOOD, FOR_A_MOMENT = "from_s = 0.5", "from_s = 0.5\nuntil_s = 0.8"
FOR_A_WHILE = "from_s = 0.5\nuntil_s = 6.0"  # longer than a call may take
OVER_A_PULSE = "from_s = 0.5\nuntil_s = 1.5"
FROM_THE_BEGINNING = 'from_s = 0.0\nsince = "beginning"'
ZABER = (('kind = "manual"', 'kind = "zaber"\nport = "simulated"'),)


@dataclass(frozen=True)
class Case:
    what: str
    when: str  # since the first voltage
    code: int
    said: str  # by the operator's screen, and as the reason in the file when the run failed
    invalid: str = ""  # why readings do not count, in a run that goes on
    rig: tuple[tuple[str, str], ...] = ()

    @property
    def name(self) -> str:
        until = "for a moment" if "until" in self.when else "for good"
        return f"{self.what} {'from the beginning' if 'beginning' in self.when else until}"


CASES = [
    # ---- the boards
    Case("daq_refused", FROM_THE_BEGINNING, BEFORE, "no connection to the NI gRPC Device Server"),
    Case("daq_refused", FOR_GOOD, UNKNOWN, "switch the amplifier off by hand"),
    Case("daq_refused", FOR_A_MOMENT, FAILED, "no connection to the NI gRPC Device Server"),
    Case("daq_hung", FROM_THE_BEGINNING, BEFORE, "did not answer in the time this can take"),
    Case("daq_hung", FOR_A_WHILE, FAILED, "did not answer in the time this can take"),
    Case("daq_hung", FOR_GOOD, UNKNOWN, "switch the amplifier off by hand"),
    Case("daq_read_hung", FOR_A_WHILE, FAILED, "did not answer in the time this can take"),
    Case("daq_slow", FOR_GOOD, DONE, "ms late (limit 5 ms)", "its edge came"),
    Case("daq_write_refused", FOR_A_MOMENT, FAILED, "is there by name but does not answer"),
    Case("daq_write_refused", FOR_GOOD, UNKNOWN, "switch the amplifier off by hand"),
    Case("daq_reserved", FROM_THE_BEGINNING, BEFORE, "in use by another task or program"),
    Case("daq_buffer_overflow", FOR_A_MOMENT, FAILED, "samples were overwritten"),
    Case("output_stuck", FOR_GOOD, UNKNOWN, "the drive voltage reads"),
    # ---- what they measure
    Case("force_nan", FOR_GOOD, FAILED, "the force input delivers no numbers"),
    Case("drive_nan", FOR_GOOD, UNKNOWN, "nobody sees which voltage", "samples were lost"),
    Case("drive_nan", FOR_A_MOMENT, DONE, "samples were lost", "samples were lost"),
    Case("current_saturated", FOR_GOOD, DONE, "the current input is at", "end of its range"),
    Case("cell_unplugged", FROM_THE_BEGINNING, BEFORE, "broken wire"),
    Case("cell_unplugged", FOR_GOOD, FAILED, "broken wire or missing excitation"),
    Case("cell_overloaded", FOR_GOOD, FAILED, "unload it at once"),
    # ---- the camera
    Case("camera_late", OVER_A_PULSE, DONE, "its frame came 200 ms late", "came 200 ms late"),
    Case("camera_dropped", OVER_A_PULSE, DONE, "no frame within", "no frame within 60 ms"),
    Case("camera_dropped", FOR_GOOD, FAILED, "has stopped delivering"),
    Case("camera_frozen", FOR_GOOD, DONE, "the camera is frozen", "bit by bit"),
    Case("camera_black", FOR_GOOD, DONE, "its frame is blank", "its frame is blank"),
    Case("camera_black", FROM_THE_BEGINNING, BEFORE, "neither black nor blank"),
    Case("camera_wrong_size", FOR_GOOD, FAILED, "sent a frame of 320 x 240"),
    Case("camera_gone", FROM_THE_BEGINNING, BEFORE, "sends no frame"),
    Case("camera_gone", FOR_GOOD, FAILED, "has stopped delivering"),
    # ---- the stage on its serial line
    Case("serial_garbage", FROM_THE_BEGINNING, BEFORE, "Zaber stage", rig=ZABER),
    Case("serial_half_line", FROM_THE_BEGINNING, BEFORE, "did not answer", rig=ZABER),
    Case("serial_silent", FROM_THE_BEGINNING, BEFORE, "did not answer", rig=ZABER),
    Case("serial_unplugged", FROM_THE_BEGINNING, BEFORE, "is gone", rig=ZABER),
    # ---- time
    Case("clock_jump", FOR_GOOD + "\namount_s = 3.0", DONE, "ms late", "its edge came"),
    Case("clock_jump", FOR_GOOD + "\namount_s = 30.0", FAILED, "samples were overwritten"),
]


@pytest.fixture
def rig(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> FaultyRig:
    return FaultyRig(tmp_path, capsys, spied_writes(monkeypatch))


# What ends before a voltage, or goes on without a reading or two, is tried once each.
KEPT = [case for case in CASES if case.code in {FAILED, UNKNOWN}]
KEPT += [next(case for case in CASES if case.code == code) for code in (BEFORE, DONE)]


@pytest.mark.parametrize("case", few(CASES, *KEPT), ids=lambda case: case.name)
def test_a_fault_is_told_in_the_file_too_and_the_output_is_at_0_V_or_said_not_to_be(
    rig: FaultyRig, case: Case
) -> None:
    since = "" if "since" in case.when else '\nsince = "first_voltage"'
    left = rig.run(f'[[faults]]\nwhat = "{case.what}"\n{case.when}{since}\n', case.rig)
    assert left.code == case.code, left.said
    assert case.said in left.said
    assert "Traceback" not in left.said
    assert "should not have happened" not in left.said
    assert left.highest_V <= LIMIT_V
    if case.code == BEFORE:
        assert left.highest_V == 0.0
        assert left.outcome is None or left.outcome is Outcome.FAILED
        return
    last = left.said.splitlines()[-1]  # words and code say the same
    assert ("NOT KNOWN TO BE SAFE" in last) is (case.code == UNKNOWN)
    assert ("the output is at 0 V, read back" in last) is (case.code != UNKNOWN)
    assert left.output is (OutputState.UNKNOWN if case.code == UNKNOWN else OutputState.SAFE)
    if case.code != UNKNOWN:
        assert left.board_V == 0.0
    if case.code == FAILED:
        assert left.outcome is Outcome.FAILED
        assert case.said in left.reason
    if case.code == DONE:
        assert left.outcome is Outcome.COMPLETED
        assert left.readings == 5
        assert ("all runs are done;" in last) is bool(left.invalid)
    if case.code == DONE and case.invalid:
        assert f"{len(left.invalid)} of {left.readings} readings do not count" in last
    if case.invalid:
        assert left.invalid
        assert all(case.invalid in why for why in left.invalid)
        assert len(left.invalid) < left.readings  # what came before the fault counts


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("PCI6703/ao0", "PCI6034E/ao0", "the device has no such channel"),
        ("PCI6703/ao0", "Dev1/ao0", "devices found: PCI6703, PCI6034E"),
        ("PCI6034E/ai1", "PCI6703/ai1", "rig.toml"),
    ],
)
def test_a_wrong_device_is_named_with_those_that_are_there(
    rig: FaultyRig, old: str, new: str, said: str
) -> None:
    left = rig.run(rig=[(old, new)])
    assert left.code == BEFORE
    assert said in left.said
    assert left.outcome is None
    assert left.highest_V == 0.0


def test_a_run_is_refused_with_code_6_while_the_read_back_is_not_0_V(rig: FaultyRig) -> None:
    """Of the board's output it knows that 0 V was written; the sheet is another matter."""
    left = rig.run("[amplifier]\noffset_mV = 50.0\n")  # half a volt at the sheet
    assert left.code == UNKNOWN
    assert "output at 0 V: +5" in left.said
    assert "switch the amplifier off by hand" in left.said
    assert left.outcome is None
    assert left.highest_V == 0.0


def test_faults_of_a_world_are_read_as_strictly_as_the_rest(rig: FaultyRig) -> None:
    left = rig.run('[[faults]]\nwhat = "camera_asleep"\nfrom_s = 1.0\n')
    assert left.code == 2
    assert "faults.0.what = 'camera_asleep'" in left.said


def test_every_fault_that_a_world_can_have_is_tried_and_described() -> None:
    known = set(get_args(FaultKind))
    timed = {"output_underflow"}  # in test_timed_output.py
    assert {case.what for case in CASES} | timed == known
    text = (Path(__file__).parents[2] / "docs" / "howto" / "world.md").read_text(encoding="utf-8")
    assert [what for what in sorted(known) if f"`{what}`" not in text] == []
