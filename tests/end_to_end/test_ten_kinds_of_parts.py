"""Each kind of part is one file: in a copy of the tree, and in a distribution of its own.

The parts are the examples of the docs, as they stand there.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from labrig.extractors.examples import CLAMP_PX, PX_PER_MM, STRIP, examples
from tests.end_to_end.small_rig import ONE_POSITION, make_rig
from tests.end_to_end.test_parts_of_others import CODE as DEVICES
from tests.labrig.report_data import measure, session

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PACKAGES = ("labrig", "drivers", "protocols", "model", "sim_hardware")


@dataclass(frozen=True)
class Example:
    """A part: its module's name, and where it belongs."""

    name: str
    folder: str
    group: str
    constant: str
    code: str

    @property
    def distribution(self) -> str:
        return f"labrig_{self.name}"


def shown(page: str, heading: str) -> str:
    """The first block of Python below a heading of a page in docs/."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    section = text[re.search(rf"^#+ {heading}$", text, re.MULTILINE).end() :]
    return re.search(r"```python\n(.*?)```", section, re.DOTALL)[1]


def device(constant: str, part: str) -> str:
    return f"{DEVICES}\n{constant} = {part}\n"


PARTS = [
    Example("cable_pickup", "model/effects", "effects", "EFFECT",
            shown("howto/extending.md", "An effect")),
    Example("humidity_eibm", "model/effects", "effects", "EFFECT",
            shown("howto/extending.md", "An effect of a recorded channel")),
    Example("electrode_cracks", "model/effects", "effects", "EFFECT",
            shown("howto/extending.md", "An effect that depends on the solution")),
    Example("cell_scale", "model/locations", "locations", "LOCATION",
            shown("howto/extending.md", "A location of discrepancy")),
    Example("pump", "model/identification/reading_patterns/kinds", "reading_patterns", "PATTERN",
            shown("howto/extending.md", "A pattern in the readings")),
    Example("pico", "drivers/boards", "boards", "BOARDS", device("BOARDS", "PICO")),
    Example("usb_6001", "sim_hardware/ni/boards", "simulated_boards", "BOARD",
            shown("howto/extending.md", "A simulated board")),
    Example("bar", "drivers/cameras", "cameras", "CAMERA", shown("howto/devices.md", "A camera")),
    Example("stepper", "drivers/positioners", "positioners", "POSITIONER",
            shown("howto/devices.md", "A positioner")),
    Example("balance", "drivers/force_sensors", "force_sensors", "FORCE_SENSOR",
            shown("howto/devices.md", "A force sensor")),
    Example("triangle", "protocols/kinds", "protocols", "PROTOCOL",
            shown("howto/extending.md", "A protocol")),
    Example("slow_ramp", "protocols/extras", "extras", "EXTRA",
            shown("howto/extending.md", "An extra")),
    Example("column_means", "labrig/extractors", "extractors", "EXTRACTOR",
            shown("howto/curve_extractor.md", "Add a curve extractor")),
    Example("wall_px", "labrig/vision/facts/kinds", "strip_facts", "FACT",
            shown("howto/extending.md", "A strip fact")),
    Example("largest_force", "labrig/exports", "exports", "FORMAT",
            shown("howto/extending.md", "An export format")),
    Example("every_force", "labrig/report/sections", "report_sections", "SECTION",
            shown("howto/report.md", "Add a section")),
    Example("humidity", "labrig/panel/pages", "page_panels", "PAGE",
            shown("howto/panel.md", "Add a page")),
    Example("readings_of_each", "labrig/batch/tasks", "batch_tasks", "TASK",
            shown("howto/batch.md", "Add a task")),
    Example("count_readings", "labrig/cli/commands", "commands", "COMMAND",
            shown("howto/commands.md", "Add a command")),
]  # fmt: skip


def copied(place: Path) -> str:
    """A copy of the tree with one file more in each folder; the path that finds it."""
    for package in PACKAGES:
        shutil.copytree(ROOT / package, place / package)
    for part in PARTS:
        (place / part.folder / f"{part.name}.py").write_text(part.code, encoding="utf-8")
    return str(place)


def installed(place: Path) -> str:
    """Each part as a distribution of its own, beside the tree; the path that finds them."""
    for part in PARTS:
        name = part.name.replace("_", "-") if part.group == "commands" else part.name
        name = "USB-6001" if part.group == "simulated_boards" else name
        info = place / f"{part.distribution}-0.1.dist-info"
        info.mkdir(parents=True)
        (place / f"{part.distribution}.py").write_text(part.code, encoding="utf-8")
        (info / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {part.distribution}\nVersion: 0.1\n"
        )
        (info / "entry_points.txt").write_text(
            f"[labrig.{part.group}]\n{name} = {part.distribution}:{part.constant}\n"
        )
    return os.pathsep.join([str(place), str(ROOT)])


@pytest.fixture(scope="module", params=[copied, installed])
def path(request, tmp_path_factory) -> str:
    """What PYTHONPATH must be for labrig with the ten kinds of parts."""
    return request.param(tmp_path_factory.mktemp("tree"))


# One way is enough for what a part does: that it is found is tested both ways by an effect.
BY_EACH_WAY = pytest.mark.parametrize(
    "path",
    [installed, pytest.param(copied, marks=pytest.mark.thorough)],
    indirect=True,
    scope="module",
)


def python(path: str, folder: Path, *arguments: object) -> str:
    """Run Python as a process of its own with these parts; what it prints."""
    done = subprocess.run(
        [sys.executable, *map(str, arguments)], capture_output=True, text=True, timeout=240,
        check=False, cwd=folder, env={**os.environ, "PYTHONPATH": path, "COLUMNS": "200"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "left out" not in done.stderr
    return done.stdout


def labrig(path: str, folder: Path, *arguments: object) -> str:
    return python(path, folder, "-m", "labrig", *arguments)


# Several commands in one process: to start one takes longer than what most of them do.
COMMANDS = """
import json, sys
from labrig.cli.main import run
for arguments in json.loads(sys.argv[1]):
    assert run(arguments) == 0, arguments
    print("-- done", flush=True)
"""


def each_of(path: str, folder: Path, *commands: list[object]) -> list[str]:
    """What commands print that one process runs one after the other."""
    asked = json.dumps([[str(word) for word in one] for one in commands])
    return python(path, folder, "-c", COMMANDS, asked).split("-- done\n")[:-1]


def test_an_effect_is_in_the_catalogue(path, tmp_path):
    every, one = each_of(path, tmp_path, ["effects"], ["effects", "show", "cable_pickup"])
    assert "cable_pickup" in every
    assert "tanh" in one


@pytest.mark.thorough
def test_a_fact_of_a_strip_has_its_option(path, tmp_path):
    assert "--wall" in labrig(path, tmp_path, "curves", "--help")


@pytest.mark.thorough
@BY_EACH_WAY
def test_an_effect_of_a_recorded_channel_is_found_where_it_was_recorded(path, tmp_path):
    script = """
import json
from dataclasses import replace
import numpy as np
from model import Condition, Measurements, Parameter, Reading, predict
from model.discrepancy.diagnose import diagnose
from model.sheet.configured_sheet import Along
from tests.labrig.report_data import truth

model, random = truth("long"), np.random.default_rng(1)
one = model.sheet("long")
eibm = {v: Along.constant(Parameter(value=10.0 * v * one.B.value, sigma=0.0, unit="N m"))
        for v in (2.0, -2.0)}
model = replace(model, sheets={"long": replace(one, eibm=eibm)})

def measured(position_m, volts, percent):
    rest_N, there_N = (predict(model, "long", position_m, v).F_N for v in (0.0, volts))
    force_N = rest_N + (1.0 + 0.1 * (percent - 50.0) / 10.0) * (there_N - rest_N)
    readings = [Reading(index=i, kind="kept" if volts else "zero", force_N=float(F),
                        other_values={"humidity_percent": percent})
                for i, F in enumerate(force_N + 2e-5 * random.standard_normal(10))]
    return Condition(configuration="long", position_m=position_m, voltage_V=volts,
                     readings=tuple(readings))

places = zip(np.arange(7) * 0.004, (38.0, 62.0, 35.0, 59.0, 44.0, 66.0, 41.0))
conditions = [measured(float(p), v, h) for p, h in places for v in (0.0, 2.0, -2.0)]
data = Measurements(sheets={"long": one.sheet}, conditions=tuple(conditions))
(found,) = diagnose(data).model.effects
p = found.parameters["relative_change"]
print(json.dumps([found.name, p.value, p.sigma]))
"""
    (tmp_path / "script.py").write_text(script)
    tree = os.pathsep.join([path, str(ROOT)])  # for the tests' data
    name, value, sigma = json.loads(python(tree, tmp_path, "script.py"))
    assert name == "humidity_eibm"
    assert abs(value - 0.1) < 3.0 * sigma < 0.1


@pytest.mark.thorough
@BY_EACH_WAY
def test_an_effect_and_a_location_change_what_a_model_predicts(path, tmp_path):
    script = """
import json
from dataclasses import replace
from model import predict
from model.locations.catalogue import locations
from model.parameter import Parameter
from model.sheet.beam_problem import ActiveEffect, Profile
from tests.labrig.report_data import truth

def force(*effects):
    model = replace(truth(), effects=effects)
    return predict(model, "long", 0.010, 2.0).F_N

flat = Profile(along="position", at=(0.0, 0.03), values=(10.0, 10.0), sigma=(0.0, 0.0), unit="%")
scale = ActiveEffect(name="unknown", location="cell_scale", profile=flat)
one_mN = Parameter(value=1.0, sigma=0.0, unit="mN")
pickup = ActiveEffect(name="cable_pickup", parameters={"force_mN": one_mN})
print(json.dumps([list(locations()), force(), force(scale), force(pickup)]))
"""
    (tmp_path / "script.py").write_text(script)
    tree = os.pathsep.join([path, str(ROOT)])  # for the tests' model
    names, plain_N, scaled_N, picked_N = json.loads(python(tree, tmp_path, "script.py"))
    assert "cell_scale" in names
    assert scaled_N == pytest.approx(1.1 * plain_N, rel=1e-9)
    assert picked_N - plain_N == pytest.approx(-1e-3 * np.tanh(1.0), rel=1e-6)


@pytest.mark.thorough
@BY_EACH_WAY
def test_a_simulated_board_is_wired_by_world_toml_and_checked(path, tmp_path):
    names = {"drive": "ao0", "force": "ai0", "current": "ai1", "readback": "ai2"}
    wiring = "".join(f'{signal} = "Box/{name}"\n' for signal, name in names.items())
    world = f'[boards]\nBox = "USB-6001"\n[wiring]\n{wiring}'
    rig = make_rig(tmp_path / "rig", ONE_POSITION + 'mode = "paper"\n', world=world) / "rig.toml"
    text = rig.read_text()
    for old, new in (("PCI6703/ao", "Box/ao"), ("PCI6034E/ai", "Box/ai")):
        text = text.replace(old, new)
    rig.write_text(text)
    assert "Box is a USB-6001" in labrig(path, tmp_path, "check", rig)


@BY_EACH_WAY
def test_devices_are_kinds_of_rig_toml_with_keys_of_their_own(path, tmp_path):
    assert labrig(path, tmp_path, "config", "schema", tmp_path)
    schema = (tmp_path / "rig.schema.json").read_text()
    assert all(f'"{word}"' in schema for word in ("step_px", "stepper", "balance", "pico"))
    (tmp_path / "rig.toml").write_text(
        '[pico]\naddress = "here:1"\n[load_cell]\ncalibration = "c.toml"\n'
        '[camera]\nsource = "bar:"\nstep_px = 8\noptics = "o.json"\n'
        '[stage]\nkind = "stepper"\nport = "COM1"\nrange_mm = 40\n'
        '[force_sensor]\nkind = "balance"\nport = "COM2"\n'
    )
    script = (
        "from pathlib import Path; from labrig.config import load_rig\n"
        "rig = load_rig(Path('rig.toml'))\n"
        "print(rig.boards_kind, rig.camera.kind, rig.stage.kind, rig.force_sensor.kind)"
    )
    kinds = python(path, tmp_path, "-c", script).split()
    assert kinds == ["pico", "bar", "stepper", "balance"]


@pytest.mark.thorough
@BY_EACH_WAY
def test_a_protocol_and_an_extra_are_planned_and_run_and_recorded(path, tmp_path):
    protocol = ONE_POSITION.replace("[pulse_train]", "[triangle]\npeak_V = 1.5")
    protocol = re.sub(r"(zero_readings|readings_per_voltage) = \d+\n", "", protocol)
    extras = "free_shapes = false\nno_touch_zero = false\nslow_ramp = true\n"
    rig = make_rig(tmp_path / "rig", protocol + extras)
    files = [rig / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    planned, _, shown = each_of(
        path, tmp_path, ["plan", rig / "protocol.toml"],
        ["run", *files, "-o", "session.h5", "--yes"], ["show", "session.h5", "--json"],
    )  # fmt: skip
    assert "1.5" in planned
    found = json.loads(shown)
    assert found["session"]["outcome"] == "completed"
    assert "slow ramp" in [run["purpose"] for run in found["runs"]]


@BY_EACH_WAY
def test_an_extractor_finds_a_curve(path, tmp_path):
    cv2.imwrite(str(tmp_path / "strip.png"), examples()[0].image)
    optics = {"px_per_mm": PX_PER_MM, "clamp_px": CLAMP_PX}
    (tmp_path / "optics.json").write_text(json.dumps(optics))
    (tmp_path / "sheet.toml").write_text(
        f"free_length_mm = {1e3 * STRIP.free_length_m}\nthickness_mm = {1e3 * STRIP.thickness_m}\n"
    )
    said = labrig(path, tmp_path, "curves", "strip.png", "--extractor", "column_means")
    assert "strip: 30.0 mm" in said


# `labrig report`, without drawing its figures and the search for data stated wrongly, and others.
REPORT = """
import labrig.report.parts.figures as figures
from labrig.cli.main import run
from tests.fits_unchecked import fits_unchecked
figures.svg_text = lambda fig: "<?xml version='1.0'?><svg width='9pt' viewBox='0 0 9 9'></svg>"
figures.save_all = lambda *_: []
with fits_unchecked():
    assert run(["report", "made.h5", "-o", "report"]) == 0
print("--", flush=True)
assert run(["count-readings", "made.h5"]) == 0
print("--", flush=True)
assert run(["--help"]) == 0
"""


@pytest.mark.thorough
@BY_EACH_WAY
def test_a_section_a_command_and_a_batch_task_use_an_analysed_session(path, tmp_path):
    session(tmp_path / "made.h5", measure("long", curves=False))
    tree = os.pathsep.join([path, str(ROOT)])  # for the tests' own parts
    _, counted, helped = python(tree, tmp_path, "-c", REPORT).split("--\n")
    assert "Every force" in next((tmp_path / "report").glob("*.html")).read_text("utf-8")
    assert int(counted) > 0
    assert "count-readings" in helped
    assert "1 done" in labrig(path, tmp_path, "batch", "readings_of_each", "made.h5")


@pytest.mark.thorough
@BY_EACH_WAY
def test_a_page_is_listed_by_the_panel(path, tmp_path):
    script = """
from labrig.panel.pages.interface import listing
print(*(page["title"] for page in listing("rig")["pages"] if page["menu"]))
"""
    assert "Humidity" in python(path, tmp_path, "-c", script)
