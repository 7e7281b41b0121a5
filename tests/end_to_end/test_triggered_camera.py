"""The boards trigger the camera: its pictures themselves say what moment they show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from labrig.session import RecordedSession, open_session
from protocols.execution.events import Outcome
from sim_hardware import world
from sim_hardware.optics.marker import read_marker
from tests.end_to_end.small_rig import labrig, make_rig, run_rig

pytestmark = pytest.mark.slow
MOVING = Path(world.__file__).with_name("moving.toml").read_text()
MARKED = "\n[camera]\nmarker = true\n"  # each picture has its number and time written into it
SLOW_WIRE = '\n[[faults]]\nwhat = "daq_slow"\nfrom_s = 0.0\namount_s = 0.0008\n'
EXPOSURE_S = 0.005
ONE_POSITION = """
[pulse_train]
zero_readings = 1
pulses_discarded = 1
readings_per_voltage = 1

[[places]]
configuration = "long"
positions_mm = [5]

[extras]
random_order = false
no_touch_zero = false
reversed_approach = false
free_shapes = false
"""


def triggered_rig(folder: Path, world_text: str, keys: str, board: str = "ni") -> Path:
    make_rig(folder, ONE_POSITION, world_text, board)
    rig = folder / "rig.toml"
    exposure = "" if keys.startswith("exposure_s") else "exposure_s = 0.005\n"
    rig.write_text(rig.read_text().replace("exposure_s = 0.005", exposure + keys))
    return folder


def shown_off_s(session: RecordedSession) -> list[float]:
    """Of each reading: the middle of the exposure that its picture shows, less sampling point."""
    found = []
    for run in session.runs:
        for row in run.readings:
            image = run.frame(int(row["index"]))
            assert image is not None
            marker = read_marker(image)
            assert marker is not None
            ended_s = marker[1]
            assert ended_s is not None
            sample_s = run.time_zero_s + float(row["time_s"])
            found.append(ended_s - EXPOSURE_S / 2 - sample_s)
    return found


HARDWARE_NI = 'trigger = "hardware"\ntrigger_line = "PCI6703/port0/line1"'
HARDWARE_LABJACK = 'trigger = "hardware"\ntrigger_line = "EIO1"'


@pytest.mark.parametrize(
    ("keys", "board"),
    [
        (HARDWARE_NI, "ni"),
        pytest.param(HARDWARE_LABJACK, "labjack", marks=pytest.mark.thorough),
        ('trigger = "software"', "ni"),
    ],
    ids=["by NI boards", "by a LabJack", "by command"],
)
def test_each_picture_shows_the_sampling_point_to_better_than_1_ms(
    tmp_path: Path, keys: str, board: str
) -> None:
    folder = triggered_rig(tmp_path, MOVING + MARKED + SLOW_WIRE, keys, board)
    with open_session(run_rig(folder)) as session:
        assert session.outcome is Outcome.COMPLETED
        off_s = shown_off_s(session)
        assert len(off_s) == 4
        assert max(map(abs, off_s)) < 1e-3
        (run,) = session.runs
        assert run.readings["valid"].all()
        said_s = run.readings["frame_offset_s"]
        np.testing.assert_allclose(said_s, off_s, atol=0.5e-3)  # and labrig knows it
        assert (run.counts.frames_grabbed, run.counts.frames_missed) == (4, 0)
        assert np.isfinite(run.frame_column("trigger_time")).all()
        numbers = run.frame_column("device_number")
        assert list(numbers) == list(range(numbers[0], numbers[0] + 4))
        (camera,) = (device for device in session.devices if device.part == "camera")
        assert camera.acquisition is not None
        assert camera.acquisition.trigger == keys.split('"')[1]
        assert camera.acquisition.exposure_s == EXPOSURE_S


@pytest.mark.thorough
def test_pictures_of_a_free_camera_do_not(tmp_path: Path) -> None:
    folder = triggered_rig(tmp_path, MOVING + MARKED, "")
    with open_session(run_rig(folder)) as session:
        assert max(map(abs, shown_off_s(session))) > 1e-3


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ('trigger = "hardware"', 'trigger = "hardware" needs trigger_line'),
        ('trigger = "sometimes"', "must be one of free, software, hardware"),
        ('trigger = "hardware"\ntrigger_line = "line1"', "must be a digital line, such as"),
        (
            HARDWARE_NI + '\n[interlock]\nline = "PCI6703/port0/line1"',
            "trigger_line and [interlock] line are both PCI6703/port0/line1",
        ),
        ("gain = 3.0", "[camera] gain: the simulated camera sends 640 x 480 Mono8"),
        ('pixel_format = "RGB8"', "must be a format such as Mono8"),
        ("region = [0, 0, 0, 480]", "a width and a height above 0"),
        ("region = [0, 0, 320, 240]", "[camera] region: the simulated camera sends"),
        ("exposure_s = 0.2", "is longer than the time between two frames"),
    ],
)
def test_what_cannot_be_set_is_refused_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], keys: str, said: str
) -> None:
    folder = triggered_rig(tmp_path, "", keys)
    assert labrig("check", folder / "rig.toml") == 2
    assert said in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("board", "trigger", "interlock"),
    [
        ("ni", "pci6703/port0/line1", "PCI6703/port0/line1"),
        ("labjack", "DIO8", "EIO0"),
        ("labjack", "EIO3", "DIO11"),
    ],
)
def test_a_line_by_another_name_is_no_line_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], board: str, trigger: str, interlock: str
) -> None:
    """The trigger's pulses would keep the interlock's relay closed when the loop hangs."""
    keys = f'trigger = "hardware"\ntrigger_line = "{trigger}"'
    keys += f'\n[interlock]\nline = "{interlock}"'
    folder = triggered_rig(tmp_path, "", keys, board)
    assert labrig("check", folder / "rig.toml") == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "trigger_line and [interlock] line are both" in said


@pytest.mark.parametrize(
    "keys",
    [
        'trigger = "hardware"\ntrigger_line = "FIO1"',
        'trigger = "free"\n[interlock]\nline = "DIO0"',
    ],
)
def test_a_line_of_the_output_s_own_converter_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], keys: str
) -> None:
    folder = triggered_rig(tmp_path, "", keys, "labjack")
    assert labrig("check", folder / "rig.toml") == 3
    said = " ".join(capsys.readouterr().err.split())
    assert "belongs to the LJTick-DAC of [labjack] drive = TDAC0" in said
    assert "Traceback" not in said


@pytest.mark.parametrize("kind", ["opencv", "iidc"])
def test_a_kind_that_cannot_be_set_says_so_before_anything_is_opened(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    assert labrig("init", tmp_path / "rig") == 0
    rig = tmp_path / "rig" / "rig.toml"
    source = '"iidc:"' if kind == "iidc" else "0"
    rig.write_text(rig.read_text().replace("source = 0 ", f"gain = 3.0\nsource = {source} "))
    assert labrig("check", rig) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert f"a camera of kind {kind} has no setting gain; remove the key" in said
