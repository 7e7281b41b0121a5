"""`labrig demo`, as `make demo` runs it: what it prints, what it leaves, and its numbers."""

from __future__ import annotations

import itertools
import json
import re
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from labrig.analysis import analyze
from labrig.cli.commands import demo as demo_command
from labrig.model_file import load_model
from labrig.session import load_measurements, open_session
from model import Measurements, fit
from tests.end_to_end.small_rig import labrig, make_rig, run_rig
from tests.labrig.conftest import NOTHING
from tests.made_once import made_once

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(900),
    pytest.mark.skipif(sys.platform == "win32", reason="the simulated stage needs a pty"),
]
FREE_POSITION_M = {"long": 15e-3, "short": 5e-3}  # where the undriven sheet rests, in the paper
E_PA = {"long": 150e6, "short": 100e6}  # of the default world
THICKNESS_M, WIDTH_M = 0.21e-3, 11e-3
NUMBER = re.compile(r"(?<![\w.])\d[\d.]*(?![\w.])")
FEWER_POSITIONS = "[0, 10, 20, 25]"  # of each configuration, where the demo has seven
OTHER = f"""
[pulse_train]
zero_readings = 3
readings_per_voltage = 3

[[places]]
configuration = "long"
positions_mm = {FEWER_POSITIONS}

[[places]]
configuration = "short"
positions_mm = {FEWER_POSITIONS}

[extras]
mode = "paper"
"""


@dataclass(frozen=True)
class Demo:
    """What it left and said."""

    folder: Path
    printed: str
    code: int


def run_demo(folder: Path) -> Demo:
    with redirect_stdout(StringIO()) as printed:
        code = labrig("demo", folder)
    return Demo(folder, printed.getvalue(), code)


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory, data_unchecked: None) -> Demo:
    """All configurations, voltages and steps of it, with fewer positions and readings.

    Left out is what other tests look at: figures inside the pages (test_report_page.py), and the
    sheet that moves, which is found below and in test_dynamic_fit_command.py.
    """

    def make(folder: Path) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(demo_command, "READINGS", 3)
            fewer = with_fewer_positions(demo_command._state_readings)
            patch.setattr(demo_command, "_state_readings", fewer)
            patch.setattr("labrig.report.parts.figures.svg_text", lambda _fig: NOTHING)
            patch.setattr("labrig.report.parts.figures.save_all", only_svg)
            patch.setattr(demo_command, "_moving", lambda _folder: None)
            made = run_demo(folder)
        kept_beside(folder).write_text(json.dumps([made.printed, made.code]))

    folder = made_once(tmp_path_factory, "demo", make)
    return Demo(folder, *json.loads(kept_beside(folder).read_text()))


def only_svg(fig: Figure, folder: Path, name: str, _formats: object, svg: str) -> list[Path]:
    from labrig.report.parts.style import save_all  # with matplotlib: slow to import

    return save_all(fig, folder, name, ("svg",), svg)


def with_fewer_positions(state_readings: Callable[[Path], None]) -> Callable[[Path], None]:
    """What writes the demo's protocol, with fewer positions."""

    def write(protocol: Path) -> None:
        state_readings(protocol)
        text, count = re.subn(
            r"(?m)^positions_mm = \[.*\]", f"positions_mm = {FEWER_POSITIONS}", protocol.read_text()
        )
        assert count == 2
        protocol.write_text(text)

    return write


def kept_beside(folder: Path) -> Path:
    """Where its output and its exit code are kept for other workers."""
    return folder.with_name("demo-printed.json")


@pytest.mark.thorough
def test_as_shipped_it_prints_and_leaves_the_same(tmp_path: Path) -> None:
    shipped = run_demo(tmp_path / "demo")
    test_the_demo_prints_the_papers_tables_and_leaves_a_report(shipped)
    measurements = load_measurements(shipped.folder / "session.h5")
    assert all(len(forces(measurements, name)) == 7 for name in ("long", "short"))
    test_the_fit_finds_the_worlds_stiffness(measurements)


def test_the_demo_prints_the_papers_tables_and_leaves_a_report(demo: Demo) -> None:
    assert demo.code == 0
    for title in ("Table 4. Parameters", "Table 6. Root mean squared errors"):
        assert title in demo.printed
    assert "The world's own record of the last voltage: 0 V" in demo.printed
    assert "Largest residuals" in demo.printed
    assert "Verdict: " in demo.printed
    assert (demo.folder / "model+.toml").exists()
    assert (demo.folder / "diagnosis" / "index.html").exists()
    assert 'name = "nonuniform_eibm"' in (demo.folder / "model+.toml").read_text()
    report = demo.folder / "report"
    assert {p.stem for p in (report / "figures").glob("*.svg")} >= {
        f"figure-{number}" for number in range(5, 10)
    }
    page = (report / "index.html").read_text()
    assert all(f"Table {number}." in page for number in (3, 4, 6))
    assert "Model discrepancy" in page


def test_its_ten_seconds_on_the_real_clock_are_recorded_as_simulated(demo: Demo) -> None:
    with open_session(demo.folder / "real-clock" / "session.h5") as session:
        assert session.clock == "real"
        assert session.simulated
        assert session.boards == "simulated"


@pytest.mark.thorough
def test_its_sheet_that_moves_is_found_as_the_world_holds_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("labrig.cli.moving_demo._compare", lambda _fit, _session: None)
    folder = tmp_path / "moving"
    demo_command._moving(folder)
    printed = capsys.readouterr().out
    table = printed[printed.index("The long sheet in time") :].splitlines()
    found = {
        line.split("  ")[0]: [float(x) for x in NUMBER.findall(line.partition("  ")[2])]
        for line in table[3:16]
    }
    assert len(found) == 13
    for name, allowed in (
        ("mass per length", 0.02),
        ("Prony share 2", 0.03),
        ("Prony time 2", 0.05),
        ("capacitance c", 0.01),
        ("electrodes r", 0.01),
    ):
        fitted, low, high, true = found[name]
        assert low < fitted < high
        assert fitted == pytest.approx(true, rel=allowed)
    B, true_B = found["relaxed bending stiffness B"][0], found["relaxed bending stiffness B"][-1]
    assert pytest.approx(true_B, rel=0.04) == B  # of set-ups that scatter by 1 %
    assert {p.name for p in folder.glob("motion.*")} == {"motion.png", "motion.svg"}
    assert load_model(folder / "model.toml").dynamic["long"].fluid == "air"


def test_each_effect_of_the_world_is_named_beside_the_others_with_its_own_values(
    demo: Demo,
) -> None:
    found = {e.name: e.parameters for e in load_model(demo.folder / "model+.toml").effects}
    assert set(found) == {"nonuniform_eibm", "charging_lag", "first_pulse_transient"}
    assert found["nonuniform_eibm"]["decay_length_mm"].value == pytest.approx(12.0, rel=0.04)
    assert found["charging_lag"]["time_constant_s"].value == pytest.approx(0.05, rel=0.25)
    assert found["first_pulse_transient"]["relative_deficit"].value > 0.0


def test_a_folder_that_is_there_already_is_left_alone(demo: Demo) -> None:
    assert labrig("demo", demo.folder) == 2


# ------------------------------------------------------------------- order, signs, B and EIBM


@pytest.fixture(
    scope="module", params=["demo", *(pytest.param(s, marks=pytest.mark.thorough) for s in (2, 3))]
)
def seed(request: pytest.FixtureRequest) -> int | str:
    return request.param  # type: ignore[no-any-return]


@pytest.fixture(scope="module")
def measurements(
    seed: int | str, request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Measurements:
    if seed == "demo":
        return load_measurements(request.getfixturevalue("demo").folder / "session.h5")
    world = f"seed = {seed}\n"
    folder = make_rig(tmp_path_factory.mktemp("seed") / "rig", OTHER, world)
    path = run_rig(folder)
    analyze(path)
    return load_measurements(path)


def forces(measurements: Measurements, configuration: str) -> dict[float, dict[float, float]]:
    """Mean force by position and voltage, N."""
    found: dict[float, dict[float, float]] = {}
    for c in measurements.conditions:
        if c.configuration == configuration and c.position_m is not None:
            mean = float(np.mean([reading.force_N for reading in c.used()]))
            found.setdefault(c.position_m, {})[c.voltage_V] = mean
    return found


@pytest.mark.parametrize("configuration", ["long", "short"])
def test_forces_have_the_papers_order_and_signs(
    measurements: Measurements, configuration: str
) -> None:
    by_position = forces(measurements, configuration)
    assert len(by_position) == 4
    for by_voltage in by_position.values():
        assert by_voltage[2.0] > by_voltage[0.0] > by_voltage[-2.0]
        assert all(abs(force) < 6e-3 for force in by_voltage.values())
    for voltage_V in (2.0, 0.0, -2.0):
        along = [by_position[position][voltage_V] for position in sorted(by_position)]
        assert all(b < a for a, b in itertools.pairwise(along))


@pytest.mark.parametrize("configuration", ["long", "short"])
def test_the_undriven_sheet_rests_where_the_paper_says(
    measurements: Measurements, configuration: str
) -> None:
    by_position = forces(measurements, configuration)
    positions = sorted(by_position)
    undriven = [by_position[position][0.0] for position in positions]
    free_m = np.interp(0.0, undriven[::-1], positions[::-1])
    assert free_m == pytest.approx(FREE_POSITION_M[configuration], abs=1e-3)


def test_every_condition_has_a_curve_that_bends_more_at_more_voltage(
    measurements: Measurements,
) -> None:
    by_place: dict[tuple[str, float], dict[float, float]] = {}
    for c in measurements.conditions:
        assert c.curve is not None
        assert c.position_m is not None
        near = c.curve.s_m < 4e-3
        assert c.curve.curvature_per_m is not None
        root = float(np.mean(c.curve.curvature_per_m[near]))
        by_place.setdefault((c.configuration, c.position_m), {})[c.voltage_V] = root
    # At a held tip a larger bending moment at the root bends the root more.
    assert all(k[2.0] > k[0.0] > k[-2.0] for (name, _), k in by_place.items() if name == "long")


def test_the_fit_finds_the_worlds_stiffness(measurements: Measurements) -> None:
    found = fit(measurements).to_json()["configurations"]
    for configuration, truth_Pa in E_PA.items():
        truth = truth_Pa * WIDTH_M * THICKNESS_M**3 / 12
        B = found[configuration]["B_Nm2"]
        low, high = B["interval90"]
        assert high - low < 0.15 * B["value"]
        # Positions whose stiffness scatters by 1 % each.
        assert B["value"] == pytest.approx(truth, rel=0.03)
