"""Which two effects a diagnosis asks a further measurement to tell apart."""

from __future__ import annotations

from dataclasses import replace

from labrig.experiment.next_measurement.proposal import pair_of
from tests.labrig.diagnose import made


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


def test_names_that_are_not_ruled_out_are_told_apart():
    open_still = {"gravity": 0.3, "unknown": 0.2, "clamp_angle": 0.1}
    found = replace(made.cannot_tell(), not_ruled_out=open_still)
    assert pair_of(found) == ("gravity", "clamp_angle")
    assert pair_of(replace(found, not_ruled_out={"gravity": 0.3, "unknown": 0.2})) is None
