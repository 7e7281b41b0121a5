"""`labrig run --diagnose --yes` on worlds whose sessions are really ambiguous: load cell alone.

Without pictures a little weight, a wrong rest curvature, a wrong direction of the clamp and a wrong
zero bend the forces alike. Everything is the program's own: boards, drives, volts, analysis,
search, choice from the menu, protocol, the simulated person who turns the rig over.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import tomlkit

from benchmarks.hidden_effects.cases import Case
from benchmarks.hidden_effects.recipe import base_recipe, geometry
from labrig.cli.follow import FOLLOWS
from labrig.report.data.kept_diagnosis import kept_diagnosis
from labrig.session import load_measurements, open_session
from tests.end_to_end.small_rig import labrig, make_rig

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(300)]

WEIGHT = 0.005  # N/m; of 0.008 the forces of one session are enough to name it
REST_ERROR = 2.0  # 1/m; of 3.5 one session is enough
PROTOCOL = """
[pulse_train]
zero_readings = 4
readings_per_voltage = 4

[[places]]
configuration = "long"
positions_mm = [0, 5, 10, 15, 20, 25, 30]

[extras]
mode = "paper"
"""


def rig_without_camera(folder: Path, weight_N_per_m: float, rest_error_per_m: float) -> list[Path]:
    """A world that is the base model but for a weight, or a rest curvature that is misstated."""
    recipe = base_recipe(Case(seed=1, rest="constant"))
    recipe.set("gravity_N_per_m", weight_N_per_m)
    make_rig(folder, PROTOCOL, tomlkit.dumps(_without_none(recipe.world)))
    rig, sheet = folder / "rig.toml", folder / "sheet.toml"
    tables = tomlkit.parse(rig.read_text(encoding="utf-8"))
    del tables["camera"]
    rig.write_text(tomlkit.dumps(tables), encoding="utf-8")
    stated = tomlkit.parse(sheet.read_text(encoding="utf-8"))
    for name, one in geometry(recipe).items():
        assert one.initial_curvature is not None
        stated[name]["initial_curvature_per_m"] = float(one.initial_curvature[1][0])
    stated["long"]["initial_curvature_per_m"] += rest_error_per_m
    sheet.write_text(tomlkit.dumps(stated), encoding="utf-8")
    return [rig, folder / "protocol.toml", sheet]


def _without_none(tree: Any) -> Any:
    """TOML has no None; lists for tuples."""
    if isinstance(tree, dict):
        return {key: _without_none(value) for key, value in tree.items() if value is not None}
    return list(tree) if isinstance(tree, tuple) else tree


def looped(folder: Path, *, weight: float = 0.0, rest_error: float = 0.0) -> Path:
    """Run it, to the end of the loop."""
    files = rig_without_camera(folder, weight, rest_error)
    first = folder / "first.h5"
    assert labrig("run", *files, "-o", first, "--yes", "--diagnose") == 0
    return first


def test_a_weight_that_looks_like_a_bent_sheet_is_named_when_the_rig_was_turned_over(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = looped(tmp_path, weight=WEIGHT)
    last = tmp_path / "first-3.h5"  # the second one tells what the load cell's zero would explain
    out = capsys.readouterr().out
    *before, _ = [line for line in out.splitlines() if line.startswith("Verdict: ")]
    for verdict in before:  # one of a class
        assert "gravity or " in verdict or " or gravity" in verdict
        assert "which these data cannot tell apart" in verdict
    proposed = [line for line in out.splitlines() if line.startswith("Measure next: ")]
    assert "all positions again with the rig turned over" in proposed[-1]
    with open_session(first) as one, open_session(last) as two:
        assert two.texts[FOLLOWS] == one.identifier
        assert {run.planned.tilt_rad for run in two.runs} == {math.pi}
        assert sum("Turn the whole rig over" in event.text for event in two.events) == 1
    assert {c.tilt_rad for c in load_measurements(last).conditions} == {math.pi}
    assert "Ended with 3 sessions: the data allow a verdict." in out
    found = kept_diagnosis(first)
    assert found is not None
    assert found.verdict == "effect_named"
    (named,) = found.effects
    assert named.name == "gravity"
    assert named.confusable_with == ()
    low, high = named.parameters["load_N_per_m"].interval()
    assert low < WEIGHT < high


def test_where_the_sheet_is_bent_the_rig_turned_over_clears_the_weight(tmp_path: Path) -> None:
    first = looped(tmp_path, rest_error=REST_ERROR)
    over = load_measurements(tmp_path / "first-3.h5")
    assert {c.tilt_rad for c in over.conditions} == {math.pi}
    for a, b in zip(load_measurements(first).conditions, over.conditions, strict=True):
        assert a.readings[0].force_N != b.readings[0].force_N  # another day, other set-ups
    found = kept_diagnosis(first)
    assert found is not None
    reported = {name for e in found.effects for name in (e.name, *e.confusable_with)}
    assert "initial_curvature" in reported
    assert "gravity" not in reported
