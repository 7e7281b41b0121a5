"""A rig whose force is read by a DPM-3 meter, in virtual time and over a serial line."""

from __future__ import annotations

import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.report.data.quality import quality
from labrig.session import open_session
from protocols.execution.channels import drive_channel, force_channel
from protocols.execution.events import Outcome, OutputState
from protocols.execution.rules import Rules, bad_samples, force_across_edge
from tests.end_to_end.real_rig import serving
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig, run_rig

pytestmark = pytest.mark.slow
PROTOCOL = ONE_POSITION + 'mode = "paper"\n'
METER = '\n[force_sensor]\nkind = "dpm3"\nport = "simulated"\n'
FILES = ("rig.toml", "protocol.toml", "sheet.toml")


def make_metered(folder: Path, world: str = "") -> Path:
    make_rig(folder, PROTOCOL, world)
    with (folder / "rig.toml").open("a") as file:
        file.write(METER)
    return folder


def forces_mN(path: Path) -> list[float]:
    with open_session(path) as session:
        (run,) = session.runs
        assert run.readings["valid"].all()
        return [1e3 * float(force_N) for force_N in run.readings["force_N"]]


@pytest.fixture(scope="module")
def metered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_rig(make_metered(tmp_path_factory.mktemp("metered")))


def test_check_finds_it_ready(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert labrig("check", make_metered(tmp_path / "rig") / "rig.toml") == 0
    assert "load cell quiet" in capsys.readouterr().out


def test_it_reads_the_forces_that_the_load_cell_reads_by_the_board(
    metered: Path, tmp_path: Path
) -> None:
    by_board = forces_mN(run_rig(make_rig(tmp_path / "rig", PROTOCOL)))
    by_meter = forces_mN(metered)
    assert max(map(abs, by_board)) > 1.0
    assert by_meter == pytest.approx(by_board, abs=0.1)


def test_the_session_says_what_read_the_force(metered: Path) -> None:
    with open_session(metered) as session:
        assert session.outcome is Outcome.COMPLETED
        assert session.resolved["rig"]["force_sensor"]["kind"] == "dpm3"
        assert session.resolved["force_channel_unit"] == "N"
        assert session.runs[0].ranges_V["force"] == 0.98


@pytest.mark.thorough
def test_a_session_is_analyzed_and_replayed_with_the_same_forces(
    metered: Path, tmp_path: Path
) -> None:
    again = tmp_path / "again.h5"
    assert labrig("replay", metered, "-o", again) == 0
    assert forces_mN(again) == pytest.approx(forces_mN(metered), abs=0.02)
    assert labrig("analyze", metered) == 0
    assert labrig("export", metered, "-o", tmp_path / "tables") == 0
    rows = (tmp_path / "tables" / "forces.csv").read_text().splitlines()
    column = rows[0].split(",").index("force_mN")
    analyzed = [float(row.split(",")[column]) for row in rows[1:]]
    assert max(analyzed) == pytest.approx(max(forces_mN(metered)), abs=0.1)


def test_a_meter_that_falls_silent_ends_the_run_at_zero_volts(tmp_path: Path) -> None:
    fault = '[[faults]]\nwhat = "serial_silent"\nsince = "first_voltage"\nfrom_s = 0.3\n'
    folder = make_metered(tmp_path / "rig", fault)
    files = [folder / name for name in FILES]
    assert labrig("run", *files, "-o", folder / "s.h5") == 5
    with open_session(folder / "s.h5") as session:
        assert session.output_state is OutputState.SAFE
        assert "the force meter 'dpm3' has given no reading" in session.reason


def test_a_reading_whose_force_is_a_line_across_an_edge_is_not_valid(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fault = (
        '[[faults]]\nwhat = "serial_garbage"\nsince = "first_voltage"\n'
        "from_s = 0.75\nuntil_s = 1.1\n"
    )
    folder = make_metered(tmp_path / "rig", fault)
    files = [folder / name for name in FILES]
    assert labrig("run", *files, "-o", folder / "s.h5") == 0
    with open_session(folder / "s.h5") as session:
        (run,) = session.runs
        assert run.readings["valid"].tolist() == [True, True, True, False, True, True]
        why = str(run.readings["why"][3])
    assert "the force meter gave no value for 0.58 s, across an edge of the voltage" in why
    assert "run 1, reading 4 (-2 V) does not count: the force meter" in capsys.readouterr().err


def test_a_meter_that_is_not_there_is_found_before_the_first_voltage(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fault = '[[faults]]\nwhat = "serial_silent"\nfrom_s = 0.0\nsince = "beginning"\n'
    folder = make_metered(tmp_path / "rig", fault)
    assert labrig("check", folder / "rig.toml") == 3
    assert "did not answer" in capsys.readouterr().err


def test_dead_weights_calibrate_the_cell_on_the_board_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = make_metered(tmp_path / "rig")
    command = (
        "calibrate",
        "load-cell",
        folder / "rig.toml",
        "--yes",
        *(f"--weight-mN={load}" for load in (0, 9.8, 19.6)),
    )
    assert labrig(*command) == 2
    assert 'kind = "dpm3" reports newtons by itself' in capsys.readouterr().err


def test_a_simulated_meter_needs_simulated_boards(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = make_metered(tmp_path / "rig")
    text = (folder / "rig.toml").read_text()
    text = text.replace('address = "simulated"', 'address = "127.0.0.1:9"')
    (folder / "rig.toml").write_text(text.replace('source = "simulated"', "source = 0"))
    assert labrig("check", folder / "rig.toml") == 2
    assert '[force_sensor] port = "simulated" needs [ni] address' in capsys.readouterr().err


@pytest.mark.parametrize(
    ("written", "instead", "named"),
    [
        ('source = "simulated"', "source = 0", "[camera] source = 0"),
        ('source = "simulated"', 'source = "http://a/"', '[camera] source = "http://a/"'),
        ('port = "simulated"', 'port = "COM4"', '[force_sensor] port = "COM4"'),
        ('kind = "manual"', 'kind = "zaber"\nport = "COM3"', '[stage] port = "COM3"'),
    ],
)
def test_a_real_device_beside_simulated_boards_is_refused_and_not_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], written: str, instead: str, named: str
) -> None:
    folder = make_metered(tmp_path / "rig")
    text = (folder / "rig.toml").read_text()
    assert written in text
    (folder / "rig.toml").write_text(text.replace(written, instead))
    assert labrig("check", folder / "rig.toml") == 2
    assert f"rig.toml: {named} is real" in capsys.readouterr().err


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform == "win32", reason="the simulated meter needs a pty")
def test_it_is_read_over_a_serial_line_in_real_time(tmp_path: Path) -> None:
    with serving(tmp_path) as rig:
        with (rig.folder / "rig" / "rig.toml").open("a") as file:
            file.write(METER.replace("simulated", rig.addresses["meter"]))
        rig.be_short()
        assert rig.start().wait(60) == 0, rig.said()
        with open_session(rig.session) as session:
            assert session.outcome is Outcome.COMPLETED
            (run,) = session.runs
            assert run.counts.lost_samples == 0
            reasons = " ".join(map(str, run.readings["why"]))
            assert "lost" not in reasons  # a busy computer may write an edge late
            assert "force" not in reasons
            forces_N = run.readings["force_N"]
            assert forces_N.max() - forces_N.min() > 1e-3
        rig.end()


def test_whatever_a_meter_has_read_is_said_in_newtons_and_never_in_volts(
    metered: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with h5py.File(metered) as file:
        assert file["session/run_000/signals/force"].attrs["units"] == "N"
    capsys.readouterr()
    assert labrig("show", metered) == 0
    (row,) = (
        line
        for line in capsys.readouterr().out.splitlines()
        if line.startswith("force ") and "±" in line
    )
    assert "±0.98 N" in row
    with open_session(metered) as session:
        (losses,) = (t for t in quality(session, None).tables if t.title == "Saturation")
    ranges = {row[0]: row[1] for row in losses.rows}
    assert ranges == {"force": "± 0.98 N", "current": "± 0.5 V", "drive": "± 5 V"}


def test_a_reading_at_the_end_of_a_meters_range_is_said_to_be_so_in_newtons() -> None:
    raw = np.array([[0.2, 0.98], [1.0, 1.0]])
    force = force_channel(range_V=0.98, conversion=np.asarray, raw_unit="N")
    (why,) = bad_samples(raw, (force, drive_channel(range_V=5.0)))
    assert why == "the force input is at the end of its range (±0.98 N)"


@pytest.mark.parametrize(
    ("times_s", "wrong"),
    [
        ([1.4, 1.45, 1.5, 1.55, 1.65], False),
        ([1.35, 1.8], False),  # far apart, but both at the reading's voltage
        ([0.9, 1.4, 1.65], True),
        ([1.4, 1.55, 2.05], True),
        ([1.95, 2.05], False),  # as a meter in order has it at the end of each pulse
    ],
)
def test_a_long_line_counts_where_its_values_are_at_the_readings_voltage(
    times_s: list[float], wrong: bool
) -> None:
    assert bool([*force_across_edge(np.array(times_s), 1.2, 1.9, Rules())]) == wrong
