"""Which two effects a diagnosis asks a further measurement to tell apart."""

from __future__ import annotations

import importlib
from dataclasses import replace

import pytest

import labrig
from labrig.errors import BadInputError
from labrig.experiment.next_measurement.proposal import pair_of, proposal
from labrig.report.diagnosis.tables import verdict_title
from tests.labrig.diagnose import made
from tests.labrig.report_data import measure


def test_a_name_comes_with_what_it_may_be_instead():
    found = made.indistinguishable()
    assert pair_of(found) == (found.effects[0].name, found.effects[0].confusable_with[0])


def test_names_that_an_unknown_effect_may_be_are_told_apart():
    found = made.unknown()
    assert found.unknown is not None
    both = replace(found.unknown, confusable_with=("roll_friction", "roll_sticking"))
    assert pair_of(replace(found, unknown=both)) == ("roll_friction", "roll_sticking")
    one = replace(found.unknown, confusable_with=("roll_friction",))
    assert pair_of(replace(found, unknown=one)) is None


def test_the_only_name_of_something_unknown_is_told_with_what_shows_it():
    """No measurement tells it from what is in no catalogue, but one shows it by itself."""
    found = made.unknown()
    one = replace(found.unknown, confusable_with=("first_pulse_transient",))
    with pytest.raises(BadInputError) as refused:
        proposal(measure("long"), replace(found, unknown=one), None)
    assert str(refused.value) == (
        "the diagnosis names first pulse transient alone, or something that is not in the "
        "catalogue, and no measurement can be chosen to tell it from that. What shows it by "
        "itself: first pulse transient: The discarded pulses, or a run begun again without a rest. "
        "To tell it from another effect, name both with between, such as "
        "first_pulse_transient and gravity."
    )


def test_the_title_of_something_unknown_does_not_deny_the_names_that_it_may_have():
    found = made.unknown()
    assert verdict_title(found) == "something that is neither in the model nor in the catalogue"
    one = replace(found.unknown, confusable_with=("first_pulse_transient",))
    assert verdict_title(replace(found, unknown=one)) == (
        "something that is not in the model, and perhaps not in the catalogue"
    )


def test_names_that_are_not_ruled_out_are_told_apart():
    open_still = {"gravity": 0.3, "unknown": 0.2, "clamp_angle": 0.1}
    found = replace(made.cannot_tell(), not_ruled_out=open_still)
    assert pair_of(found) == ("gravity", "clamp_angle")
    assert pair_of(replace(found, not_ruled_out={"gravity": 0.3, "unknown": 0.2})) is None


def test_tables_are_diagnosed_where_nobody_names_two_effects(monkeypatch):
    """It told to run `labrig diagnose` first, which keeps nothing of tables."""
    found = made.indistinguishable()
    module = importlib.import_module("labrig.api.next_measurement")
    monkeypatch.setattr(module, "diagnosed", lambda *_: found)
    said = labrig.next_measurement(measure("long"))
    assert said.proposal == found.next_measurement
