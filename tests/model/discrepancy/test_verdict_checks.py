"""After the naming a verdict must survive what the data say of each name."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.hidden_effects import case, hidden_session
from model.discrepancy import DiagnoseOptions, diagnose
from model.discrepancy.criticism import Consequence, Failure, VerdictCheck, catalogue
from model.discrepancy.criticism.catalogue import verdict_checks
from model.discrepancy.criticism.conformance import faults
from model.discrepancy.criticism.criticise import criticise
from model.effects import effect
from model.identification.likelihood.model_state import Found
from model.plugins import Part, PluginWarning
from tests.fits_unchecked import fits_unchecked
from tests.model.discrepancy.foreign_sessions import Foreign, foreign_session
from tests.model.discrepancy.sessions import FALLING, diagnosed
from tests.model.discrepancy.test_diagnose import KEYS, UNKNOWN_KEYS

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
    with fits_unchecked():
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


class Broken(VerdictCheck):
    """A check of another distribution that fails."""

    def failures(self, named):
        """See `VerdictCheck.failures`."""
        if named.named == ("raises",):
            raise KeyError("no such thing")
        if named.named == ("misspelt",):
            yield Failure(consequence="rejekt", sentence="it is seen")
        yield named.named[0]


class Sound(VerdictCheck):
    """One that does not."""

    def failures(self, named):
        """See `VerdictCheck.failures`."""
        yield Failure(
            consequence=Consequence.IMPROBABLE_AMPLITUDE, sentence="it is seen", effects=named.named
        )


@pytest.mark.parametrize(
    ("named", "said"),
    [
        ("raises", "KeyError: 'no such thing'"),
        ("word", "TypeError: it yielded str, not a Failure"),
        (
            "misspelt",
            "ValueError: there is no consequence 'rejekt'; there are reject, reject_",
        ),
    ],
)
def test_a_check_of_another_distribution_that_fails_costs_no_verdict(monkeypatch, named, said):
    checks = [kind(name=name, meaning="a mark", order=1) for name, kind in KINDS.items()]
    parts = {one.name: Part(one.name, one, "labrig-extra", "0.1") for one in checks}
    there = SimpleNamespace(
        parts=lambda: parts, origins=lambda: dict.fromkeys(parts, "labrig-extra 0.1")
    )
    monkeypatch.setattr(catalogue, "FOLDER", there)
    with pytest.warns(PluginWarning, match=r"'broken' of labrig-extra 0\.1 failed") as told:
        found = criticise(SimpleNamespace(named=(named,)))
    assert said in str(told[0].message)
    assert [one.name for one in found.results] == ["sound"]


KINDS = {"broken": Broken, "sound": Sound}


@pytest.mark.slow
def test_a_right_name_passes_every_check():
    found = diagnosed(FALLING)
    assert [n.name for n in found.effects] == ["nonuniform_eibm"]
    assert {one.name for one in found.checks} == set(verdict_checks())
    assert all(one.passed for one in found.checks)


@pytest.mark.slow
def test_where_nothing_is_named_nothing_is_checked():
    assert diagnosed().checks == ()


@pytest.mark.thorough
@pytest.mark.parametrize("name", FOREIGN)
def test_what_no_catalogue_has_gets_no_name_with_certainty(name):
    found = foreign(name)
    assert found.verdict == "unknown_effect"
    assert all(one.confidence < CERTAIN for one in found.effects)


@pytest.mark.thorough
def test_a_failed_check_is_named_in_the_sentence_and_in_the_json():
    found = foreign("a torsion spring of the wires")
    told = json.loads(json.dumps(found.to_json(), allow_nan=False))
    assert (set(told), set(told["unknown"])) == (KEYS, UNKNOWN_KEYS)
    failed = [one for one in told["checks"] if not one["passed"]]
    assert [one["name"] for one in failed] == ["quantity_structure"]
    assert failed[0]["effects"] == ["clamp_angle"]
    assert "Check 'quantity_structure' failed: amplitude of clamp angle" in found.sentence


@pytest.mark.thorough
def test_an_amplitude_that_people_notice_keeps_its_name_without_certainty():
    hidden = case("load_cell_misalignment", "turned", 0.7, seed=5)
    found = diagnose(hidden_session(hidden).measurements)
    (one,) = found.effects
    assert one.name == "load_cell_misalignment"
    assert one.confidence < 0.8
    assert "unknown" in one.or_else
    failed = {check.name: check.sentence for check in found.checks if not check.passed}
    said = r"a load cell turned by \d\d degrees would be seen \(\d+ % overlook that\)"
    assert re.fullmatch(said, failed["amplitude"])


def test_the_probability_that_nobody_noticed_falls_without_an_edge():
    angle = effect("load_cell_misalignment").amplitude
    chances = np.array([angle.overlooked(v) for v in np.linspace(0.0, 3.0, 301)])
    assert chances[0] == 1.0
    assert angle.overlooked(-angle.instrument_limit) == 0.5
    assert np.all(np.diff(chances) <= 0.0)
    assert np.min(np.diff(chances)) > -0.03
    assert effect("force_offset").amplitude.overlooked(1e3) == 1.0


@pytest.mark.parametrize(
    ("name", "size", "consequence"),
    [
        ("load_cell_misalignment", 0.3, []),
        ("load_cell_misalignment", 0.55, [Consequence.IMPROBABLE_AMPLITUDE]),
        ("load_cell_misalignment", 0.8, [Consequence.IMPROBABLE_AMPLITUDE]),
        ("load_cell_misalignment", 2.0, [Consequence.REJECT]),
        # positions are measured in order: what goes with them may look like a drift as large
        *((f"{what}_drift", -0.35, []) for what in ("eibm", "stiffness")),
        *((f"{what}_drift", -0.9, [Consequence.IMPROBABLE_AMPLITUDE])
          for what in ("eibm", "stiffness")),
    ],
)  # fmt: skip
def test_only_an_amplitude_that_nobody_can_overlook_rejects_a_name(name, size, consequence):
    parameters = effect(name).parameters
    values = {one.name: one.neutral for one in parameters} | {parameters[0].name: size}
    one = Found(effect=effect(name), values={"long": values})
    check = verdict_checks()["amplitude"]
    failures = check.failures(SimpleNamespace(found=[one]))
    assert [failure.consequence for failure in failures] == consequence


@pytest.mark.thorough
def test_offsets_of_opposite_sign_are_no_meniscus():
    """Nor a drift: what is constant with each sheet does not go with the time."""
    apart = Foreign(
        force_N=lambda force, at, volts, gamma, name: (
            (1.5e-4 if name == "long" else -1e-4) + 0.0 * force
        )
    )
    found = diagnose(foreign_session(apart, 2))
    assert found.verdict == "unknown_effect"
    assert found.unknown is not None
    assert found.unknown.location == "load_cell"
    # a drift that imitates it is not named either
    assert {"neighbours", "signs"} <= {one.name for one in found.checks if not one.passed}
    assert "it can only act one way" in found.sentence


@pytest.mark.parametrize(("short_mN", "failures"), [(-0.1, 1), (0.1, 0), (-0.01, 0)])
def test_a_meniscus_that_pulls_both_ways_fails_the_check_of_signs(short_mN, failures):
    one = Found(
        effect=effect("surface_tension"),
        values={"long": {"force_mN": 0.15}, "short": {"force_mN": short_mN}},
        sigma={"long": {"force_mN": 0.01}, "short": {"force_mN": 0.01}},
    )
    found = list(verdict_checks()["signs"].failures(SimpleNamespace(found=[one])))
    assert len(found) == failures


@pytest.mark.thorough
def test_an_effect_that_another_name_stands_in_for_is_unknown():
    drift = hidden_session(case("force_drift", "line", seed=7)).measurements
    found = diagnose(drift, DiagnoseOptions(exclude=("force_drift",)))
    assert found.verdict == "unknown_effect"
    assert found.unknown is not None
    assert found.unknown.location in ("load_cell", "time")
