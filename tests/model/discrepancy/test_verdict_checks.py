"""After the naming a verdict must survive what the data say of each name."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from benchmarks.hidden_effects import case, hidden_session
from model.discrepancy import DiagnoseOptions, diagnose
from model.discrepancy.criticism.catalogue import verdict_checks
from model.discrepancy.criticism.conformance import faults
from tests.model.discrepancy.foreign_sessions import Foreign, foreign_session
from tests.model.discrepancy.sessions import FALLING, diagnosed

CERTAIN = 0.95
FOREIGN = {
    "a stiffness that depends on the voltage": Foreign(
        stiffness=lambda bent, volts, s: 1.0 - 0.25 * np.abs(volts) / 2.0
    ),
    "a torsion spring of the wires": Foreign(wire_Nm_per_rad=3e-4),
    "an EIBM that falls with the curvature": Foreign(
        eibm=lambda bent, volts, s: 1.0 / (1.0 + np.abs(bent) / 60.0)
    ),
}


@cache
def foreign(name):
    return diagnose(foreign_session(FOREIGN[name], 2))


@pytest.mark.parametrize("name", verdict_checks())
def test_each_verdict_check_conforms(name):
    assert faults(verdict_checks()[name]) == []


def test_the_check_on_the_page_about_extending_conforms():
    page = (Path(__file__).parents[3] / "docs" / "howto" / "extending.md").read_text(
        encoding="utf-8"
    )
    example = page.split("## A verdict check")[1].split("```python")[1].split("```")[0]
    there: dict[str, object] = {"__name__": "example"}
    exec(compile(example, "extending.md", "exec"), there)
    assert faults(there["CHECK"]) == []


def test_a_right_name_passes_every_check():
    found = diagnosed(FALLING)
    assert [n.name for n in found.effects] == ["nonuniform_eibm"]
    assert {one.name for one in found.checks} == set(verdict_checks())
    assert all(one.passed for one in found.checks)


def test_where_nothing_is_named_nothing_is_checked():
    assert diagnosed().checks == ()


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.thorough) if "curvature" in name else name
        for name in FOREIGN
    ],
)
def test_what_no_catalogue_has_gets_no_name_with_certainty(name):
    found = foreign(name)
    assert found.verdict == "unknown_effect"
    assert all(one.confidence < CERTAIN for one in found.effects)


def test_a_failed_check_is_named_in_the_sentence_and_in_the_json():
    found = foreign("a torsion spring of the wires")
    failed = [one for one in found.to_json()["checks"] if not one["passed"]]
    assert [one["name"] for one in failed] == ["quantity_structure"]
    assert failed[0]["effects"] == ["clamp_angle"]
    assert "Check 'quantity_structure' failed: the amplitude of clamp angle" in found.sentence


@pytest.mark.thorough
def test_an_amplitude_that_would_be_seen_is_no_name():
    turned = hidden_session(case("load_cell_misalignment", "turned", 0.75, seed=5)).measurements
    found = diagnose(turned)
    failed = {one.name: one.sentence for one in found.checks if not one.passed}
    assert re.fullmatch(r"a load cell turned by 4\d degrees would be seen", failed["amplitude"])
    assert found.verdict != "effect_named"


@pytest.mark.thorough
def test_a_large_amplitude_that_rigs_do_have_keeps_its_name():
    turned = hidden_session(case("load_cell_misalignment", "turned", 0.52, seed=5)).measurements
    found = diagnose(turned)
    assert [n.name for n in found.effects] == ["load_cell_misalignment"]
    assert found.verdict == "effect_named"


def test_offsets_of_opposite_sign_are_no_meniscus():
    apart = Foreign(
        force_N=lambda force, at, volts, gamma, name: (
            (1.5e-4 if name == "long" else -1e-4) + 0.0 * force
        )
    )
    found = diagnose(foreign_session(apart, 2))
    assert found.verdict == "unknown_effect"
    assert found.unknown is not None
    assert found.unknown.location == "load_cell"
    failed = [one.name for one in found.checks if not one.passed]
    assert "signs" in failed


def test_an_effect_that_another_name_stands_in_for_is_unknown():
    drift = hidden_session(case("force_drift", "line", seed=7)).measurements
    found = diagnose(drift, DiagnoseOptions(exclude=("force_drift",)))
    assert found.verdict == "unknown_effect"
    assert found.unknown is not None
    assert found.unknown.location in ("load_cell", "time")
