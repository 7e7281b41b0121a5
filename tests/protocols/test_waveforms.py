"""Waveforms as protocols: their values, their readings, what they refuse, and a table from CSV."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from labrig.session import open_session
from labrig.session.tables.drive_table import load_protocol
from protocols import ReadingKind, ScheduleError
from protocols.kinds.multi_sine import MultiSine
from protocols.kinds.pseudo_random import PseudoRandom, sequence
from protocols.kinds.sine import Sine
from protocols.kinds.sweep import Sweep
from protocols.kinds.table import Table
from tests.cases import few
from tests.end_to_end.small_rig import labrig, make_rig, run_rig

KINDS = (Sine, Sweep, MultiSine, PseudoRandom, Table)
PLACES = """
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""


def written(protocol):
    """Times and voltages of the waveform itself, without the rest before it and 0 V after it."""
    steps = protocol.steps_and_readings()[0][1:-1]
    times_s = np.array([step.time_s for step in steps]) - protocol.rest_s
    return times_s, np.array([step.voltage_V for step in steps])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_waveform_begins_at_rest_ends_at_0_V_and_is_read_at_intervals(kind):
    protocol = kind()
    steps, readings, duration_s = protocol.steps_and_readings()
    assert (steps[0].voltage_V, steps[-1].voltage_V) == (0.0, 0.0)
    assert duration_s == pytest.approx(protocol.rest_s + protocol.length_s)
    assert readings[0].kind is ReadingKind.ZERO
    due_s = np.array([steps[each.step].time_s + each.delay_s for each in readings[1:]])
    assert np.allclose(np.diff(due_s), protocol.read_every_s)
    assert any(each.kind is ReadingKind.KEPT for each in readings)
    assert max(abs(step.voltage_V) for step in steps) <= 1.0
    assert set(protocol.pulses().voltages_V) == {
        max(step.voltage_V for step in steps),
        min(step.voltage_V for step in steps),
    }


def test_a_sine_is_the_sine_in_the_middle_of_each_write():
    sine = Sine(amplitude_V=1.5, offset_V=0.25, frequency_hz=0.4, periods=3)
    times_s, volts = written(sine)
    middle_s = times_s + 0.5 * sine.write_every_s
    assert np.allclose(volts, 0.25 + 1.5 * np.sin(2 * np.pi * 0.4 * middle_s))
    kinds = [each.kind for each in sine.steps_and_readings()[1][1:]]
    assert kinds.count(ReadingKind.DISCARDED) == pytest.approx(len(kinds) / 3, abs=1)


@pytest.mark.parametrize("protocol", [Sine(periods=7), MultiSine(periods=4)], ids=["sine", "multi"])
def test_each_period_is_read_at_the_same_voltages(protocol):
    readings = protocol.steps_and_readings()[1][1:]
    volts = [each.voltage_V for each in readings]
    assert len(set(volts)) <= len(readings) / protocol.periods
    assert not any(str(voltage_V) == "-0.0" for voltage_V in volts)


def test_a_sweep_goes_from_one_frequency_to_the_other():
    sweep = Sweep(start_hz=0.5, end_hz=4.0, sweep_s=10.0, write_every_s=0.005)
    _, volts = written(sweep)
    rising = np.flatnonzero((volts[:-1] < 0) & (volts[1:] >= 0)) * sweep.write_every_s
    per_s = math.log(8.0) / 10.0  # after n turns f0 (exp(t per_s) - 1) / per_s = n
    turns = np.arange(1, len(rising) + 1)
    assert np.allclose(rising, np.log1p(turns * per_s / 0.5) / per_s, atol=0.011)
    assert len(rising) == int(0.5 * (8.0 - 1.0) / per_s)


def test_a_multi_sine_has_its_lines_alone_and_its_peak():
    multi = MultiSine(peak_V=1.2, base_hz=0.5, harmonics=(1, 2, 5), periods=2, write_every_s=0.01)
    _, volts = written(multi)
    assert 0.9 * 1.2 < np.max(np.abs(volts)) <= 1.2
    lines = np.abs(np.fft.rfft(volts[: len(volts) // 2]))
    strong = set(np.flatnonzero(lines > 0.05 * lines.max()))
    assert strong == {1, 2, 5}
    assert np.allclose(volts[: len(volts) // 2], volts[len(volts) // 2 :])


@pytest.mark.parametrize("order", range(3, 12))
def test_a_pseudo_random_sequence_has_the_greatest_length_and_a_flat_spectrum(order):
    bits = np.where(sequence(order), 1.0, -1.0)
    count = 2**order - 1
    assert len(bits) == count
    assert bits.sum() == 1.0
    around = [float(np.dot(bits, np.roll(bits, shift))) for shift in range(1, count)]
    assert set(around) == {-1.0}  # of such a sequence alone


def test_a_table_is_joined_by_lines_or_held():
    rows = {"times_s": (0.0, 1.0, 2.0), "voltages_V": (0.0, 1.0, -1.0), "write_every_s": 0.1}
    times_s, volts = written(Table(**rows))
    assert np.allclose(volts, np.interp(times_s + 0.05, rows["times_s"], rows["voltages_V"]))
    assert set(written(Table(**rows, held=True))[1]) == {0.0, 1.0}


@pytest.mark.parametrize(
    ("kind", "values", "said"),
    [
        (Sine, {"frequency_hz": 10.0}, "less than 10 writes a period"),
        (Sweep, {"end_hz": 40.0, "write_every_s": 0.01}, "less than 10 writes a period"),
        (Sweep, {"sweep_s": 3600.0, "write_every_s": 0.01}, "more than 50000 writes"),
        (MultiSine, {"harmonics": (1.0, 2.5)}, "must be whole numbers"),
        (MultiSine, {"harmonics": (1.0, 1.0)}, "a number twice"),
        (PseudoRandom, {"bit_s": 0.05}, "must be a multiple of write_every_s"),
        (PseudoRandom, {"low_V": 1.0}, "are the same"),
        (Table, {"times_s": (0.0, 1.0)}, "each time needs a voltage"),
        (Table, {"times_s": (1.0, 2.0), "voltages_V": (0.0, 0.0)}, "must begin at 0"),
        (Table, {"times_s": (0.0, 1.0, 1.0), "voltages_V": (0.0,) * 3}, "does not come after"),
        (Sine, {"read_every_s": 100.0}, "nothing would be read"),
    ],
)
def test_what_makes_no_waveform_is_refused(kind, values, said):
    with pytest.raises(ScheduleError, match=said):
        kind(**values)


def folder_with(tmp_path: Path, protocol: str, rows: str | None = None) -> Path:
    folder = make_rig(tmp_path / "rig", protocol + PLACES)
    if rows is not None:
        (folder / "drive.csv").write_text(rows)
    return folder


FROM_CSV = '[table]\nfile = "drive.csv"\nwrite_every_s = 0.05\n'


@pytest.mark.thorough
@pytest.mark.slow
def test_a_table_from_csv_is_run_and_its_rows_are_kept_in_the_session(tmp_path: Path):
    rows = "time_s,voltage_V\n0,0\n1,1.5\n2,-1.5\n3,0\n"
    folder = folder_with(tmp_path, FROM_CSV, rows)
    session = run_rig(folder)
    (folder / "drive.csv").unlink()
    with open_session(session) as done:
        assert "times_s = [0.0, 1.0, 2.0, 3.0]" in done.texts["protocol.toml"]
        drive_V = done.runs[0].signal_V("drive")
        assert done.runs[0].readings["valid"].all()
    assert drive_V.max() == pytest.approx(1.5, abs=0.1)
    assert drive_V.min() == pytest.approx(-1.5, abs=0.1)
    assert labrig("replay", session, "-o", tmp_path / "again.h5") == 0


def test_a_table_from_csv_may_be_written_as_a_spreadsheet_does(tmp_path: Path):
    folder = folder_with(tmp_path, FROM_CSV, "time_s;voltage_V\n0;0\n0,5;1,5\n1;0\n")
    found = load_protocol(folder / "protocol.toml").schedule("p")
    (folder / "drive.csv").write_text("time_s,voltage_V\n0,0\n0.5,1.5\n1,0\n")
    assert found == load_protocol(folder / "protocol.toml").schedule("p")


@pytest.mark.parametrize(
    ("protocol", "rows", "said"),
    [
        (FROM_CSV, None, "drive.csv"),
        (FROM_CSV, "time,volt\n0,0\n", "column 'time' is not known"),
        (FROM_CSV, "time_s,voltage_V\n0,0\n1,x\n", "line 3: column voltage_V: 'x' is not a number"),
        (FROM_CSV, "time_s,voltage_V\n0,0\n1,nan\n", "line 3: column voltage_V: 'nan' is not"),
        (FROM_CSV, "time_s,voltage_V\n0,0\n1,9\n2,0\n", "beyond the limit of ±2.5 V"),
        (FROM_CSV + "times_s = [0.0, 1.0]\n", "", "keep one of them"),
        ("[table]\nfile = 3\n", None, "must be the path of a CSV file"),
        ("[sine]\namplitude_V = 2.4\noffset_V = 0.4\n", None, "beyond the limit of ±2.5 V"),
        ("[sweep]\nsweep_s = 40.0\n", None, "s under voltage is longer than the limit of 30 s"),
    ],
)
def test_what_cannot_be_driven_is_one_sentence_before_anything_is_touched(
    tmp_path: Path, protocol: str, rows: str | None, said: str, capsys: pytest.CaptureFixture[str]
):
    folder = folder_with(tmp_path, protocol, rows)
    files = [folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert labrig("run", *files, "-o", tmp_path / "s.h5") == 2
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
    assert not (tmp_path / "s.h5").exists()


@pytest.mark.slow
@pytest.mark.parametrize("kind", few(KINDS), ids=lambda kind: kind.name)
def test_plan_shows_its_schedule_as_a_picture(
    tmp_path: Path, kind, capsys: pytest.CaptureFixture[str]
):
    folder = folder_with(tmp_path, f"[{kind.name}]\n")
    picture = tmp_path / "plan.png"
    assert labrig("plan", folder / "protocol.toml", "--picture", picture) == 0
    assert f"One {kind.name} run" in capsys.readouterr().out
    assert picture.read_bytes().startswith(b"\x89PNG")
