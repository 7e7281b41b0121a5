"""Configuration files: what is accepted, and the sentence for what is not."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig.config import (
    ReplayConfig,
    RigConfig,
    load_rig,
    load_sheet,
    parse_load_cell,
    parse_protocol,
    parse_rig,
    parse_sheet,
)
from labrig.config.base import parse_toml
from labrig.config.derived import model_of
from labrig.config.schema import schemas
from labrig.config.templates import template_text, write_templates
from labrig.errors import BadInputError
from labrig.session.tables.drive_table import load_protocol
from protocols import Purpose, ReadingKind
from tests.cases import few

RIG = '[load_cell]\ncalibration = "load_cell.toml"\n'
PLACES = '[[places]]\nconfiguration = "long"\npositions_mm = [0.0, 5.0]\n'
SHEET = "free_length_mm = 50.0\nwidth_mm = 11.0\nthickness_mm = 0.21\n"


@pytest.mark.parametrize("simulated", [True, False])
def test_the_files_that_init_writes_are_read_without_a_complaint(
    tmp_path: Path, simulated: bool
) -> None:
    write_templates(tmp_path / "rig", simulated=simulated)
    rig = load_rig(tmp_path / "rig" / "rig.toml")
    assert isinstance(rig, RigConfig)
    assert rig.is_simulated is simulated
    assert rig.load_cell.calibration.exists()
    assert rig.camera is not None
    assert rig.camera.optics.exists()
    assert set(load_sheet(tmp_path / "rig" / "sheet.toml")) == {"long", "short"}
    assert len(load_protocol(tmp_path / "rig" / "protocol.toml").schedule("p").runs) == 14


def test_init_never_overwrites_a_file(tmp_path: Path) -> None:
    (tmp_path / "sheet.toml").write_text("mine")
    with pytest.raises(BadInputError, match=r"sheet\.toml: is already there"):
        write_templates(tmp_path, simulated=True)
    assert [path.name for path in tmp_path.iterdir()] == ["sheet.toml"]


def test_the_default_protocol_is_the_papers() -> None:
    config = parse_protocol(template_text("protocol.toml"), "protocol.toml")
    run = config.schedule("protocol.toml").runs[0]
    kinds = [reading.kind for reading in run.readings]
    assert kinds == [ReadingKind.ZERO] * 10 + [ReadingKind.DISCARDED] * 2 + [ReadingKind.KEPT] * 20
    assert run.duration_s == pytest.approx(19.2)


def test_paths_are_taken_from_the_folder_of_rig_toml(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG)
    rig = load_rig(tmp_path / "rig.toml")
    assert isinstance(rig, RigConfig)
    assert rig.load_cell.calibration == tmp_path / "load_cell.toml"


@pytest.mark.parametrize("source", ["v.avi", "films/%03d.png"])
def test_a_recording_for_the_camera_is_taken_from_the_folder_of_rig_toml(
    tmp_path: Path, source: str
) -> None:
    assert source_read(tmp_path, json.dumps(source)) == str(tmp_path / source)


@pytest.mark.parametrize(
    "source",
    ["/dev/video0", "rtsp://192.0.2.1/a", "iidc:1", "unknown:cam", "a ! appsink", "0", "simulated"],
)
def test_a_camera_that_is_no_file_of_that_folder_stays_as_it_is_written(
    tmp_path: Path, source: str
) -> None:
    assert source_read(tmp_path, json.dumps(source)) == source
    assert source_read(tmp_path, "0") == 0


def source_read(folder: Path, source: str) -> int | str:
    text = f'{RIG}[camera]\nsource = {source}\noptics = "optics.json"\n'
    (folder / "rig.toml").write_text(text)
    rig = load_rig(folder / "rig.toml")
    assert isinstance(rig, RigConfig)
    assert rig.camera is not None
    return rig.camera.source


@dataclass(frozen=True, kw_only=True)
class Images:
    """Files of a device of one's own."""

    folder: str = field(default="", metadata={"path": True})
    other: Path | None = field(default=None, metadata={"path": True})
    named: str = field(default="x", metadata={"path": lambda value: value.endswith(".png")})


def test_settings_of_a_device_that_are_paths_are_taken_from_the_folder_of_rig_toml() -> None:
    def read(**keys: object) -> object:
        return model_of(Images)(**keys).with_paths_from(Path("rig")).settings()

    assert read() == Images()
    assert read(folder="../pngs", other="a", named="b.png") == Images(
        folder=str(Path("rig/../pngs")), other=Path("rig/a"), named=str(Path("rig/b.png"))
    )
    absolute = str(Path("/tmp").absolute())
    assert read(folder=absolute) == Images(folder=absolute)


def test_a_replay_rig_names_only_the_session(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text('replay = "old.h5"\n')
    rig = load_rig(tmp_path / "rig.toml")
    assert isinstance(rig, ReplayConfig)
    assert rig.replay == tmp_path / "old.h5"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[ni]\nadress = 'x'\n" + RIG, r"rig: \[ni\] adress is not a known key; did you mean addr"),
        ("[ni]\naddress = 'nowhere'\n" + RIG, r"\[ni\] address = 'nowhere': must be \"local\""),
        ("[ni]\ndrive = 'ao0'\n" + RIG, r"\[ni\] drive = 'ao0': must be a device and a channel"),
        ("[limits]\nsheet_voltage_V = 99\n" + RIG, r"sheet_voltage_V = 99: should be less than or"),
        ("[limits]\nsheet_voltage_V = nan\n" + RIG, r"sheet_voltage_V = nan: should be a finite"),
        ("[amplifier]\ngain = 'ten'\n" + RIG, r"\[amplifier\] gain = 'ten': should be a num"),
        ("[ni]\n", r"load_cell is missing; it is required"),
        ("load_cell = 3\n", r"load_cell = 3: should be a table"),
        ("[ni\n", r"rig: not valid TOML: .*line 1"),
        ("replay = 'a.h5'\n" + RIG, r"load_cell is not a known key"),
    ],
)
def test_a_fault_in_rig_toml_is_named_with_key_value_and_remedy(text: str, said: str) -> None:
    with pytest.raises(BadInputError, match=said):
        parse_rig(text, "rig")


def test_all_faults_of_a_file_are_told_together_a_line_each() -> None:
    text = "[ni]\nadress = 'x'\n[limits]\nsheet_voltage_V = -1\n"
    with pytest.raises(BadInputError) as caught:
        parse_rig(text, "rig.toml")
    lines = str(caught.value).splitlines()
    assert len(lines) == 3
    assert all(line.startswith("rig.toml: ") and line.endswith(".") for line in lines)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (PLACES, r"exactly one of .* is needed; there is none"),
        ("[hold]\n[staircase]\n" + PLACES, r"there is \[hold\] and \[staircase\]"),
        ("[pulse_train]\npulse_s = 0.4\n" + PLACES, r"sample_at_s .* must lie between"),
        ("[pulse_train]\nvoltages_V = []\n" + PLACES, r"voltages_V"),
        ("[pulse_train]\n", r"places is missing"),
        ("[hold]\n" + PLACES + PLACES, r"a configuration is there twice"),
        (
            "[hold]\n" + PLACES + "[[places]]\nconfiguration = 'short'\nposition_mm = [0]\n",
            r"entry 2 of \[\[places\]\]: positions_mm is missing",
        ),
        (
            "[hold]\n[[places]]\nconfiguration = 'long'\npositions_mm = [0, nan]\n",
            r"entry 1 of \[\[places\]\]: value 2 of positions_mm = nan: should be a finite number",
        ),
        ("places = ['long']\n[hold]\n", r": value 1 of places = 'long': should be a table"),
        (
            "[pulse_train]\nvoltages_V = [2, 99]\n" + PLACES,
            r": value 2 of \[pulse_train\] voltages_V = 99: should be less than",
        ),
        (
            "[hold]\n[extras]\nmode = 'paper'\nremounts = 1\n" + PLACES,
            r'mode "paper" has no extras',
        ),
        (
            "[hold]\n[extras]\nmode = 'paper'\ntilt_deg = 180\n" + PLACES,
            r'mode "paper" has no extras; remove tilt_deg',
        ),
        (
            "[hold]\n[extras]\ntilt_deg = 90\n" + PLACES,
            r"\[extras\] tilt_deg = 90: the rig stands upright \(0\) or is turned over",
        ),
    ],
)
def test_a_fault_in_protocol_toml_is_named(text: str, said: str) -> None:
    with pytest.raises(BadInputError, match=said):
        parse_protocol(text, "protocol.toml").schedule("protocol.toml")


def test_default_extras_are_those_that_cost_little() -> None:
    runs = parse_protocol("[pulse_train]\n" + PLACES, "p").schedule("p").runs
    purposes = {run.purpose for run in runs}
    assert purposes == {Purpose.MEASUREMENT, Purpose.NO_TOUCH_ZERO, Purpose.FREE_SHAPE}
    assert any(run.approach == "down" for run in runs)


def test_sheet_lengths_become_metres_and_the_arc_goes_to_each_configuration() -> None:
    text = f"[arc]\nradius_mm = 30.0\norigin_deg = 10.0\n[long]\n{SHEET}"
    sheet = parse_sheet(text, "sheet.toml")["long"]
    assert sheet.free_length_m == pytest.approx(0.05)
    assert sheet.arc_radius_m == pytest.approx(0.03)
    assert sheet.arc_origin_rad == pytest.approx(math.radians(10))


def test_a_single_configuration_may_stand_at_top_level() -> None:
    sheet = parse_sheet(SHEET + "initial_curvature_per_m = 12.0\n", "sheet.toml")["sheet"]
    assert sheet.initial_curvature is not None
    np.testing.assert_allclose(sheet.initial_curvature[1], 12.0)


def test_measured_initial_curvature_is_left_to_the_fit() -> None:
    text = SHEET + 'initial_curvature_per_m = "measured"\n'
    assert parse_sheet(text, "s")["sheet"].initial_curvature is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "this is an empty file; a sheet.toml is needed"),
        ("x = 3\n", r"x is not a known key at top level"),
        ("[long]\nfree_length_mm = 50.0\n", r"\[long\]: width_mm is missing"),
        (SHEET.replace("50.0", "-1"), r"free_length_mm = -1: should be greater than 0"),
        (SHEET + "initial_curvature_per_m = 'guessed'\n", r"initial_curvature_per_m = 'guessed'"),
        (SHEET + "initial_curvature_per_m = { s_mm = [0, 1], per_m = [1, 2, 3] }\n", r"per_m 3"),
        (SHEET + "initial_curvature_per_m = { s_mm = [1, 0], per_m = [1, 2] }\n", r"must rise"),
        ("[arc]\nradius_mm = 0\n" + "[long]\n" + SHEET, r"\[arc\]: radius_mm = 0"),
        ("[ark]\nradius_mm = 40\n[long]\n" + SHEET, r"toml: \[ark\] is no sheet.* \[arc\]\.$"),
    ],
)
def test_a_fault_in_sheet_toml_is_named(text: str, said: str) -> None:
    with pytest.raises(BadInputError, match=said):
        parse_sheet(text, "sheet.toml")


def test_a_load_cell_without_sensitivity_is_refused() -> None:
    with pytest.raises(BadInputError, match="sensitivity_V_per_N must not be 0"):
        parse_load_cell("date = 2026-01-01\nsensitivity_V_per_N = 0.0\n", "load_cell.toml")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"rig\.toml: there is no such file"):
        load_rig(tmp_path / "rig.toml")


def test_the_schemas_kept_in_the_repository_are_those_of_the_code() -> None:
    folder = Path(__file__).parents[2] / "docs" / "schemas"
    for name, schema in schemas().items():
        kept = json.loads((folder / f"{name}.schema.json").read_text(encoding="utf-8"))
        assert kept == schema, f"run `labrig config schema docs/schemas` ({name} has changed)"


def keys_without_a_word(node: object, whole: dict[str, Any], path: str = "") -> Iterator[str]:
    """Yield the keys of a schema that neither they nor the table that they are describe."""
    if isinstance(node, list):
        for one in node:
            yield from keys_without_a_word(one, whole, path)
    if not isinstance(node, dict):
        return
    for name, key in node.get("properties", {}).items():
        tables = [key, *key.get("anyOf", [])]
        named = [whole["$defs"][t["$ref"].rsplit("/", 1)[1]] for t in tables if "$ref" in t]
        if not any(one.get("description", "").strip() for one in (key, *named)):
            yield f"{path}.{name}"
    for name, part in node.items():
        yield from keys_without_a_word(part, whole, f"{path}.{name}")


def test_every_key_of_a_configuration_file_is_described() -> None:
    undescribed = {"properties": {"mute": {"type": "string"}, "told": {"description": "what"}}}
    assert list(keys_without_a_word(undescribed, undescribed)) == [".mute"]
    every = {**schemas(), "replay": ReplayConfig.model_json_schema()}
    found = [f"{file}{key}" for file, one in every.items() for key in keys_without_a_word(one, one)]
    assert found == []


@pytest.mark.parametrize(
    ("line", "hint"),
    few(
        [
            (
                "x = [2.0, \N{MINUS SIGN}2.0]",
                "(at line 1, column 11), where '\N{MINUS SIGN}' stands",
            ),
            ("x = 0,6", "a number needs a point, not a comma, for its decimals"),
            ('x = "C:\\lab\\rig.toml"', "a path is written with /, or in 'single quotes'"),
            ('x = "C:\\users\\rig.toml"', "a path is written with /, or in 'single quotes'"),
            ("x\N{NO-BREAK SPACE}= 1", "where NO-BREAK SPACE stands"),
            ("x = 1\n\x1a", "where U+001A stands"),
            ("x = ", "not valid TOML: Invalid value (at end of document)."),
        ],
        first=3,
    ),
)
def test_what_a_line_of_toml_holds_that_it_may_not_is_named(line, hint):
    with pytest.raises(BadInputError) as said:
        parse_toml(line, "rig.toml")
    assert hint in str(said.value)
