"""A wrong value of a key: refused by its name, in plain words, before anything is begun."""

from __future__ import annotations

from pathlib import Path

import pytest

from labrig.config.templates import write_templates
from tests.labrig.wrong_inputs.files import refused

RUN = "run rig.toml protocol.toml sheet.toml -o out.h5"
NUMBER, WHOLE, TEXT = "should be a number", "should be a whole number", "should be a text in quotes"
TRUTH, LIST, DATE = "should be true or false", "should be a list", "should be a date such as"
NODES = "[0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50]"
ABOVE_0 = "should be greater than 0"

# as the file is shipped -> values of that key, and what is told of each
WRONG = {
    ("rig.toml", "[amplifier] gain", "gain = 10.0"): [
        ('"ten"', NUMBER),
        ("0", "or equal to 1"),
        ("true", "neither true nor false"),
        ("[1]", NUMBER),
        ("{ a = 1 }", NUMBER),
        ("nan", "finite number"),
    ],
    ("rig.toml", "[limits] sheet_voltage_V", "sheet_voltage_V = 2.5"): [
        ("-2.5", ABOVE_0),
        ("250", "equal to 30"),
        ('"2"', NUMBER),
    ],
    ("rig.toml", "[limits] time_under_voltage_s", "time_under_voltage_s = 30.0"): [
        ("0", ABOVE_0),
        ("false", "neither true"),
    ],
    ("rig.toml", "[limits] safe_below_V", "safe_below_V = 0.05"): [
        ("5", "equal to 0.5"),
        ("-1", ABOVE_0),
    ],
    ("rig.toml", "[ni] address", 'address = "simulated"'): [
        ("5", TEXT),
        ('"nowhere"', "host:port"),
    ],
    ("rig.toml", "[ni] drive", 'drive = "PCI6703/ao0"'): [
        ('"ao0"', "a device and a channel"),
        ("7", TEXT),
    ],
    ("rig.toml", "", 'force = "PCI6034E/ai0"'): [
        ('"PCI6034E/ai1"', "the input of both force and current"),
    ],
    ("rig.toml", "[ni] sample_rate_hz", "sample_rate_hz = 1000.0"): [
        ("0", "equal to 100"),
        ("1e9", "equal to 66000"),
        ('"fast"', NUMBER),
    ],
    ("rig.toml", "", 'calibration = "load_cell.toml"'): [
        ('"gone.toml"', "gone.toml: there is no such file"),
        ("5", "should be a path in quotes"),
    ],
    ("rig.toml", "", 'optics = "optics.json"'): [
        ('"gone.json"', "gone.json: there is no such file"),
        ('"sheet.toml"', "an optics.json is needed"),
    ],
    ("rig.toml", "[stage]", 'kind = "manual"'): [
        ('"robot"', "choose one of manual, zaber"),
        ('"zaber"', "port is missing"),
    ],
    ("protocol.toml", "[pulse_train] pulse_s", "pulse_s = 0.6"): [
        ('"long"', NUMBER),
        ("-1", ABOVE_0),
        ("true", "neither true"),
    ],
    ("protocol.toml", "", "pulse_s = 0.6"): [
        ("600", "longer than the limit of 30 s"),
        ("0.4", "must lie between 0 and pulse_s"),
    ],
    ("protocol.toml", "[pulse_train] voltages_V", "voltages_V = [2.0, -2.0]"): [
        ("2.0", LIST),
        ("[]", "at least 1 of them"),
        ('["2"]', NUMBER),
    ],
    ("protocol.toml", "", "voltages_V = [2.0, -2.0]"): [
        ("[20.0, -20.0]", "beyond the limit of ±2.5 V"),
        ("[2.0]", "without an edge"),
        ("[2,0, -2,0]", "write 2.0 if 2,0 is one number"),
        ("[2.0, -2.0, 2.0]", "has 2 V twice; state it once"),
    ],
    ("protocol.toml", "[pulse_train] readings_per_voltage", "readings_per_voltage = 10"): [
        ("1.5", WHOLE),
        ("-1", "equal to 1"),
        ("100000000", "equal to 1000"),
        ('"ten"', NUMBER),
    ],
    ("protocol.toml", "sample_at_s", "sample_at_s = 0.5"): [
        ("5", "must lie between"),
        ("-1", "0"),
    ],
    ("protocol.toml", "half_window_s", "half_window_s = 0.1"): [
        ("9", "must lie between"),
    ],
    ("protocol.toml", "configuration", 'configuration = "long"'): [
        ('"medium"', "is no table of sheet.toml"),
        ("5", TEXT),
    ],
    ("protocol.toml", "position", "positions_mm = [0, 5, 10, 15, 20, 25, 30]"): [
        ("5", LIST),
        ("[5, 5]", "is there twice"),
        ('["a"]', NUMBER),
        ("[0, 15000]", "the whole circle of the arc"),
        ("[0, 0.01]", "at least 0.5 mm"),
    ],
    ("protocol.toml", "[camera] frame_rate_hz", "frame_rate_hz = 25.0"): [
        ("0", ABOVE_0),
        ("1e6", "equal to 1000"),
    ],
    ("protocol.toml", "[extras] mode", 'mode = "paper"'): [
        ('"papers"', "should be 'default' or 'paper'"),
        ("5", "default"),
    ],
    ("protocol.toml", "moisten", "moisten = true"): [
        ('"yes"', TRUTH),
        ("1", TRUTH),
        ("[true]", TRUTH),
    ],
    ("protocol.toml", "keep_all_frames", "keep_all_frames = false"): [
        ("0", TRUTH),
        ('"no"', TRUTH),
    ],
    ("sheet.toml", "radius_mm", "radius_mm = 40.0"): [
        ("0", ABOVE_0),
        ('"40"', NUMBER),
        ("0.04", "3 to 400 mm"),
    ],
    ("sheet.toml", "[long]: free_length_mm", "free_length_mm = 50.0"): [
        ("-1", ABOVE_0),
        ('"50"', NUMBER),
        ("50000", "equal to 1000"),
    ],
    ("sheet.toml", "[long] free_length_mm", "free_length_mm = 50.0"): [
        ("0.05", "1 to 300 mm"),
    ],
    ("sheet.toml", "initial_curvature_per_m", "initial_curvature_per_m = 28.0"): [
        ('"straight"', "'measured'"),
        ("[1, 2]", "'measured'"),
        ("1e6", "0 to 360 deg"),
    ],
    (
        "sheet.toml",
        "initial_curvature_per_m",
        "s_mm = [0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50]",
    ): [
        ("[0, 0, 10, 15, 20, 25, 30, 35, 40, 45, 50]", "s_mm must rise"),
        ("[0, 50]", "s_mm has 2 values and per_m 11"),
    ],
    ("sheet.toml", "rise_time_s", "rise_time_s = 0.03"): [
        ("-1", "equal to 0"),
        ("30", "0 to 2 s"),
    ],
    ("load_cell.toml", "sensitivity_V_per_N", "sensitivity_V_per_N = 0.15296"): [
        ("0", "must not be 0"),
        ('"x"', NUMBER),
        ("152.96", "of the input's range"),
    ],
    ("load_cell.toml", "capacity", "capacity_mN = 98.07"): [
        ("-1", ABOVE_0),
        ("0.09807", "of the input's range"),
    ],
    ("load_cell.toml", "gain", "gain = 1.0"): [
        ('"x"', NUMBER),
    ],
    ("optics.json", "px_per_mm", '"px_per_mm": 7.001'): [
        ("0", ABOVE_0),
        ('"seven"', NUMBER),
        ("7001", "0 to 3 images"),
        ("0.007", "at least 40 pixels"),
    ],
    ("optics.json", "clamp_px", '"clamp_px": [60.4, 327.5]'): [
        ("[327.5, 6000.4]", "is outside of the image of 640 x 480 pixels"),
        ("[60.4]", "lacks value 2"),
        ("5", LIST),
    ],
    ("optics.json", "image_size", '"image_size": [640, 480]'): [
        ("[640.5, 480]", WHOLE),
        ("[0, 480]", ABOVE_0),
    ],
    ("optics.json", "polarity", '"polarity": "auto"'): [
        ('"grey"', "'bright'"),
    ],
    ("optics.json", "bits", '"bits": 8'): [
        ("4", "equal to 8"),
        ('"8"', NUMBER),
    ],
    ("about.toml", "title", 'title = ""'): [
        ("5", TEXT),
    ],
    ("about.toml", "licence", 'licence = ""'): [
        ('"mine"', "SPDX"),
        ("1", TEXT),
    ],
}
CASES = [
    pytest.param(*place, value, told, id=f"{place[2].split(' = ')[0]} {value}")
    for place, values in WRONG.items()
    for value, told in values
]
# a line of a file as shipped -> what stands in its place, and what is told
LINES = [
    ("rig.toml", "gain = 10.0", "gian = 10.0", "gian is not a known key; did you mean gain"),
    ("rig.toml", "[stage]", "[stages]", "stages is not a known key; did you mean stage"),
    ("rig.toml", 'optics = "optics.json"', "", "[camera] optics is missing"),
    ("rig.toml", 'source = "simulated"', "source = 0", "[camera] source = 0 is real"),
    ("rig.toml", 'world = "world.toml"', 'world = "gone.toml"', "gone.toml: no such file"),
    ("rig.toml", "[limits]", "[limits", "not valid TOML"),
    ("protocol.toml", "pulse_s = 0.6", "puls_s = 0.6", "did you mean pulse_s"),
    ("protocol.toml", "[pulse_train]", "[pulse_trains]", "did you mean pulse_train"),
    (
        "rig.toml",
        "gain = 10.0",
        "gain = 10.0\nduration_s = 4.0",
        "[amplifier] duration_s is not a known key; known are gain, ",
    ),
    ("protocol.toml", 'mode = "paper"', "tilt_deg = 90", "upright (0) or is turned over (180)"),
    ("protocol.toml", 'mode = "paper"', "release = 5", "release = 5: should be true or false"),
    ("protocol.toml", 'mode = "paper"', "remounts = 0.5", "remounts = 0.5: should be a whole"),
    ("protocol.toml", 'mode = "paper"', 'mode = "paper"\nremounts = 3', "remove remounts"),
    ("protocol.toml", 'mode = "paper"', "dead_weights_mN = [5000]", "at most the load cell's"),
    ("protocol.toml", "[[places]]", "[places]", "not valid TOML"),
    ("sheet.toml", "radius_mm = 40.0", "radius = 40", "did you mean radius_mm"),
    ("sheet.toml", "width_mm = 11.0", "", "[long]: width_mm is missing"),
    ("load_cell.toml", "date = ", "date = 5 #", "should be a date such as"),
    ("load_cell.toml", "date = ", 'date = "soon" #', "should be a date such as"),
    ("optics.json", '"bits": 8', '"bit": 8', "did you mean bits"),
    ("optics.json", '"bits": 8', '"bits": 8,', "not valid JSON"),
    ("about.toml", 'title = ""', 'titel = ""', "did you mean title"),
    ("about.toml", "# [[people]]", "[[people]]\nname = 5", "should be a text in quotes"),
    ("about.toml", "# [[people]]", '[[people]]\nname = "A"\norcid = "1"', "an ORCID iD such as"),
    ("about.toml", "# [[people]]", '[[people]]\nname = "A"\nemail = "a"', "an address such as"),
    ("about.toml", "# [[people]]", '[[people]]\nname = "A"\nrole = "boss"', "should be 'operator'"),
]


def told_of(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    file: str,
    change: tuple[str, str],
) -> str:
    """What `labrig run` says where a piece of a file is another."""
    text = (folder / file).read_text()
    assert change[0] in text
    (folder / file).write_text(text.replace(*change, 1))
    try:
        return refused(RUN, capsys)
    finally:
        (folder / file).write_text(text)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("values")
    write_templates(made, simulated=True)
    return made


@pytest.fixture(autouse=True)
def _there(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)


@pytest.mark.parametrize(("file", "key", "line", "value", "told"), CASES)
def test_a_wrong_value_is_told_with_its_key(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    file: str,
    key: str,
    line: str,
    value: str,
    told: str,
) -> None:
    mark = ": " if file.endswith(".json") else " = "
    said = told_of(folder, capsys, file, (line, f"{line.split(mark, maxsplit=1)[0]}{mark}{value}"))
    assert told in said
    assert key in said
    assert len(said.splitlines()) == 1 or line.startswith("rise_time_s")  # of both sheets


@pytest.mark.parametrize(("file", "line", "instead", "told"), LINES)
def test_a_wrong_line_is_told(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    file: str,
    line: str,
    instead: str,
    told: str,
) -> None:
    assert told in told_of(folder, capsys, file, (line, instead))
