"""`labrig run --controller` on the simulated rig: at the wire, with every fault, and killed."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig.control.controller_file import parse_controller
from labrig.report.figures.controlled import ControlledRun
from labrig.session import open_session, recover, verify
from labrig.session.format import layout
from labrig.session.recording.journal import journal_path
from protocols.execution.events import Outcome, OutputState
from tests.end_to_end.faulty_rig import FaultyRig, spied_writes
from tests.end_to_end.real_rig import ServedRig, serving
from tests.end_to_end.small_rig import labrig
from tests.labrig.simple_controller import write_control

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("data_unchecked")]
BEFORE, FAILED, UNKNOWN, DONE = 3, 5, 6, 0
AMPLIFIER = 10.0
LIMIT_V = 2.0
BOARD_STEP_V = 20 / 2**16  # of the PCI-6703
FOR_GOOD, FOR_A_MOMENT = "from_s = 0.5", "from_s = 0.5\nuntil_s = 0.8"
FOR_A_WHILE = "from_s = 0.5\nuntil_s = 3.0"  # longer than a call may take
POSITION_MM = 10.0


@dataclass(frozen=True)
class Case:
    what: str
    when: str  # since the first voltage
    code: int
    said: str  # by the operator's screen

    @property
    def name(self) -> str:
        return f"{self.what} {'for a moment' if 'until' in self.when else 'for good'}"


CASES = [
    Case("daq_refused", FOR_GOOD, UNKNOWN, "switch the amplifier off by hand"),
    Case("daq_refused", FOR_A_MOMENT, FAILED, "no connection to the NI gRPC Device Server"),
    Case("daq_hung", FOR_A_WHILE, FAILED, "did not answer in the time this can take"),
    Case("daq_read_hung", FOR_A_WHILE, FAILED, "did not answer in the time this can take"),
    Case("daq_slow", FOR_GOOD, FAILED, "within 3 periods (30 ms)"),
    Case("daq_write_refused", FOR_A_MOMENT, FAILED, "is there by name but does not answer"),
    Case("daq_write_refused", FOR_GOOD, UNKNOWN, "switch the amplifier off by hand"),
    Case("daq_buffer_overflow", FOR_A_MOMENT, FAILED, "samples were overwritten"),
    Case("output_stuck", FOR_GOOD, UNKNOWN, "the drive voltage reads"),
    Case("force_nan", FOR_GOOD, FAILED, "the force"),
    Case("force_nan", FOR_A_MOMENT, FAILED, "the force"),
    Case("drive_nan", FOR_GOOD, UNKNOWN, "read back as nan V"),
    Case("cell_unplugged", FOR_GOOD, FAILED, "broken wire or missing excitation"),
    Case("cell_overloaded", FOR_GOOD, FAILED, "unload it at once"),
    Case("camera_gone", FOR_GOOD, FAILED, "has stopped delivering"),
    Case("clock_jump", FOR_GOOD + "\namount_s = 3.0", FAILED, "ms late (limit 10 ms)"),
]

# What differs in kind runs always; the same faults happen to other runs in test_faults.py.
MORE = {
    "daq_refused for a moment", "daq_hung for a moment", "daq_write_refused for a moment",
    "daq_buffer_overflow for a moment", "force_nan for good",
    "cell_unplugged for good", "camera_gone for good", "cell_overloaded for good",
    "daq_refused for good", "daq_write_refused for good",
}  # fmt: skip


def marked(case: Case) -> Any:
    """The case, in the thorough run alone where it is one of MORE."""
    marks = [pytest.mark.thorough] if case.name in MORE else []
    return pytest.param(case, marks=marks, id=case.name)


@pytest.fixture
def rig(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> FaultyRig:
    return FaultyRig(tmp_path, capsys, spied_writes(monkeypatch))


def control(folder: Path) -> list[object]:
    return write_control(folder, position_mm=POSITION_MM)


@pytest.mark.parametrize("case", [marked(case) for case in CASES])
def test_a_fault_in_the_loop_ends_at_0_V_or_is_said_not_to(rig: FaultyRig, case: Case) -> None:
    world = f'[[faults]]\nwhat = "{case.what}"\n{case.when}\nsince = "first_voltage"\n'
    left = rig.run(world, options=control)
    assert left.code == case.code, left.said
    assert case.said in left.said
    assert "Traceback" not in left.said
    assert "should not have happened" not in left.said
    assert left.highest_V <= LIMIT_V / AMPLIFIER * (1 + 1e-9)
    last = left.said.splitlines()[-1]
    assert ("NOT KNOWN TO BE SAFE" in last) is (case.code == UNKNOWN)
    assert left.output is (OutputState.UNKNOWN if case.code == UNKNOWN else OutputState.SAFE)
    if case.code != UNKNOWN:
        assert left.board_V == 0.0
        assert "the output is at 0 V, read back" in last


def test_a_controlled_session_follows_its_reference_and_records_every_period(
    rig: FaultyRig,
) -> None:
    left = rig.run(options=control)
    assert (left.code, left.outcome, left.output) == (DONE, Outcome.COMPLETED, OutputState.SAFE)
    assert all(check.ok for check in verify(left.path))
    with open_session(left.path) as session:
        run = session.runs[0]
        rows, force_N = run.control, run.signal_V("force")
        assert session.version == layout.FORMAT
        assert len(rows) == 399
        assert session.texts["reference.csv"].startswith("time_s,force_mN")
        assert len(force_N) > 4000
    settled = (rows["planned_s"] > 1.4) & (rows["planned_s"] < 1.99)
    assert np.unique(rows["reference_N"][settled]) == pytest.approx([0.5e-3])
    assert rows["force_N"][settled].mean() == pytest.approx(0.5e-3, abs=2e-5)
    written = np.array(rig.writes)[-1 - len(rows) - left_zeros(rig) : -1 - left_zeros(rig)]
    np.testing.assert_allclose(written, rows["board_V"], atol=BOARD_STEP_V)
    assert left.board_V == 0.0


@pytest.mark.thorough
def test_a_controlled_session_is_exported_but_neither_replayed_nor_resumed(rig: FaultyRig) -> None:
    left = rig.run(options=control)
    folder = left.path.parent / "tables"
    assert labrig("analyze", left.path) == 0
    assert "no readings to analyze" in "".join(rig.capsys.readouterr())
    assert labrig("export", left.path, "-o", folder) == 0
    table = np.genfromtxt(folder / "control.csv", delimiter=",", names=True)
    with open_session(left.path) as session:
        rows = session.runs[0].control
    np.testing.assert_allclose(table["force_mN"], 1e3 * rows["force_N"], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(table["sheet_V"], rows["sheet_V"], rtol=1e-6, atol=1e-12)
    assert labrig("export", left.path, "-o", folder) == 2
    assert labrig("replay", left.path) == 2
    assert "not replayed" in rig.capsys.readouterr().err
    assert labrig("run", "--resume", left.path) == 2
    assert "a controlled session is not resumed" in rig.capsys.readouterr().err


@pytest.mark.thorough
def test_a_controlled_session_is_reported_beside_the_linear_model(rig: FaultyRig) -> None:
    left = rig.run(options=control)
    folder = left.path.parent / "report"
    assert labrig("report", left.path, "-o", folder, "--format", "svg") == 0
    page = (folder / "index.html").read_text()
    assert "Force under control" in page
    assert "is left out" not in "".join(rig.capsys.readouterr())
    assert (folder / "figures" / "controlled-1.svg").exists()
    with open_session(left.path) as session:
        law = parse_controller(session.texts["controller.toml"], "controller.toml")
        found = ControlledRun.of(session.runs[0], law, limit_V=2.5)
    settled = (found.time_s > 1.4) & (found.time_s < 1.99)
    for force_N in (found.force_N, found.linear_N):
        assert force_N[settled].mean() == pytest.approx(0.5e-3, abs=2e-5)
    assert found.limit_V == LIMIT_V
    assert found.limited(found.voltage_V) < 0.1


def left_zeros(rig: FaultyRig) -> int:
    """How often 0 V was written again at the end, after the planned return to it."""
    return next(i for i, volts in enumerate(reversed(rig.writes)) if volts) - 1


def test_a_reference_out_of_reach_ends_the_run_at_0_V(rig: FaultyRig) -> None:
    left = rig.run(
        options=lambda folder: write_control(
            folder, "time_s,force_mN\n0,0\n0.5,30\n4,0\n", position_mm=POSITION_MM
        )
    )
    assert (left.code, left.board_V, left.outcome) == (FAILED, 0.0, Outcome.FAILED)
    assert "was at its limit of ±2 V for 0.5 s" in left.said
    assert left.highest_V == pytest.approx(LIMIT_V / AMPLIFIER, abs=BOARD_STEP_V)


def test_the_rigs_limit_holds_whatever_the_controller_asks_for(rig: FaultyRig) -> None:
    left = rig.run(
        rig=[("sheet_voltage_V = 2.5", "sheet_voltage_V = 0.8")],
        options=lambda folder: write_control(
            folder, "time_s,force_mN\n0,0\n0.5,0.6\n0.9,0\n2,0\n", position_mm=POSITION_MM
        ),
    )
    assert left.code == DONE, left.said
    assert left.highest_V == pytest.approx(0.08, abs=BOARD_STEP_V)


def test_a_reference_longer_than_the_time_under_voltage_is_refused(rig: FaultyRig) -> None:
    left = rig.run(
        options=lambda folder: write_control(
            folder, "time_s,force_mN\n0,0\n31,0\n", position_mm=POSITION_MM
        )
    )
    assert left.code == 2
    assert "31 s under voltage is longer than the limit of 30 s" in left.said
    assert left.highest_V == 0.0


@pytest.mark.thorough
def test_a_controlled_session_that_was_cut_short_is_recovered(rig: FaultyRig) -> None:
    left = rig.run(options=control)
    with open_session(left.path) as session:
        before = session.runs[0].control.copy()
    made = recover_from_a_torn_copy(left.path)
    assert all(check.ok for check in verify(made))
    with open_session(made) as session:
        np.testing.assert_array_equal(session.runs[0].control, before)


def recover_from_a_torn_copy(path: Path) -> Path:
    """Recover what is left when a session was never closed."""
    import h5py

    torn = path.with_name("torn.h5")
    torn.write_bytes(path.read_bytes())
    with h5py.File(torn, "r+") as file:
        file["session/outcome"][()] = np.bytes_("running")
        file["session/checksums"][...] = np.zeros_like(file["session/checksums"][()])
    assert not journal_path(torn).exists()
    report = recover(torn)
    return report.output or torn


# ------------------------------------------------------------------ over TCP, on the real clock


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    with serving(tmp_path_factory.mktemp("served")) as found:
        options = write_control(
            found.folder / "rig",
            "time_s,force_mN\n0,0\n0.5,0.6\n20,0\n",
            position_mm=POSITION_MM,
            rate_hz=10.0,
        )
        found.options = [str(option) for option in options]
        yield found


def has_voltage(rig: ServedRig) -> bool:
    return bool(rig.rows()) and abs(float(rig.rows()[-1]["drive_V"])) > 0.2


@pytest.mark.alone
@pytest.mark.skipif(sys.platform != "linux", reason="needs ptys, signals and /proc")
@pytest.mark.parametrize(
    ("number", "limit_s"),
    [
        (signal.SIGKILL, 0.3),
        pytest.param(signal.SIGSTOP, 1.0, marks=pytest.mark.thorough),
        pytest.param(signal.SIGTERM, 0.3, marks=pytest.mark.thorough),
    ],
    ids=["killed", "hung", "told to stop"],
)
def test_a_controlled_run_that_dies_leaves_0_V_in_time(
    served: ServedRig, number: int, limit_s: float
) -> None:
    process = served.start()
    served.until(lambda: process.poll() is not None or has_voltage(served))
    assert process.poll() is None, served.said()
    os.kill(process.pid, number)
    sent_s = float(served.rows()[-1]["time_s"])
    served.until(lambda: not has_voltage(served), 5.0)
    zero_s = float(served.rows()[-1]["time_s"])
    if number == signal.SIGTERM:
        assert process.wait(30) == 4, served.said()
    process.kill()
    process.wait(5)
    assert zero_s - sent_s < limit_s + 0.02
