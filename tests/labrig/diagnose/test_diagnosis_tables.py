"""Tables about a diagnosis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from labrig.report.diagnosis.limits import limits_table, visibility
from labrig.report.diagnosis.tables import (
    MOST_RANKED,
    improvement_table,
    next_sentence,
    ranking_table,
)
from model.discrepancy import CheckResult
from model.discrepancy.verdict.result import DetectionLimit, Next
from model.effects import catalogue
from tests.labrig.diagnose.made import found, unknown


def test_what_is_named_is_among_the_candidates_however_many_explain_more_alone():
    diagnosis = found()
    best = diagnosis.ranking[0]
    others = tuple(replace(best, name=f"unknown_{i}", log_bayes=900.0) for i in range(20))
    rows = ranking_table(replace(diagnosis, ranking=(*others, best))).rows
    assert len(rows) == MOST_RANKED + 1
    assert (rows[-1][0], rows[-1][-1]) == ("EIBM along the sheet", "named")


def test_a_candidate_that_failed_a_check_is_not_said_to_explain_less():
    diagnosis = found()
    best = replace(diagnosis.ranking[0], name="gravity", log_bayes=900.0)
    failed = CheckResult(
        name="place_structure", passed=False, sentence="unequal", effects=("gravity",)
    )
    rows = ranking_table(replace(diagnosis, ranking=(best,), checks=(failed,))).rows
    assert (rows[0][0], rows[0][-1]) == ("gravity", "failed a check")
    passed = replace(failed, passed=True)
    rows = ranking_table(replace(diagnosis, ranking=(best,), checks=(passed,))).rows
    assert rows[0][-1] == "explains less"


def test_the_unknown_that_is_reported_is_marked_among_the_candidates():
    diagnosis = unknown()
    assert diagnosis.unknown is not None
    name = f"unknown:{diagnosis.unknown.location}"
    best = replace(found().ranking[0], name=name, log_bayes=900.0)
    rows = ranking_table(replace(diagnosis, ranking=(best,))).rows
    assert rows[0][-1] == "reported"


def test_detection_limits_are_listed_the_tightest_first_without_what_is_invisible():
    limits = {
        "gravity": DetectionLimit(parameter="load_N_per_m", value=0.01, unit="N/m", ratio=2.0),
        "roll_friction": DetectionLimit(parameter="coefficient", value=0.04, unit="", ratio=0.4),
        "charging_lag": DetectionLimit(parameter="time_constant_s", value=9.0, unit="s", ratio=90),
    }
    table = limits_table(replace(found(), limits=limits))
    assert table.rows == (
        ("roll friction", "coefficient", "0.04", "-", "0.4"),
        ("gravity", "load_N_per_m", "0.01", "N/m", "2"),
    )
    assert limits_table(found()) is None


def test_effects_of_other_distributions_that_were_tried_are_named_with_whose_they_are():
    diagnosis = found()
    names = (*diagnosis.signatures.names, "curvature_threshold")
    diagnosis = replace(
        diagnosis,
        signatures=replace(diagnosis.signatures, names=names),
        plugins={"curvature_threshold": "mylab 0.3", diagnosis.effects[0].name: "other 1"},
    )
    assert "Also tried: curvature threshold (mylab 0.3)." in visibility(diagnosis)
    assert not any("Also tried" in text for text in visibility(found()))


def test_effects_that_one_session_cannot_show_are_counted_apart():
    said = visibility(found())[0]
    several = [name for name, one in catalogue().items() if one.for_sessions(1) is None]
    assert said == (
        "5 of 5 effects would be seen in these data if large. "
        f"{len(several)} more need several sessions, given together."
    )


def test_the_reported_set_is_all_that_may_be_there():
    named = found()
    assert named.reported_set == {"nonuniform_eibm": 0.993}
    one = replace(
        named.effects[0], confusable_with=("gravity",), or_else=("unknown",),
        probabilities={"nonuniform_eibm": 0.7, "gravity": 0.2, "unknown": 0.1},
    )  # fmt: skip
    open_still = replace(
        named, effects=(one,), not_ruled_out={"clamp_angle": 0.15, "gravity": 0.05}
    )
    assert list(open_still.reported_set.items()) == [
        ("nonuniform_eibm", 0.7), ("gravity", 0.2), ("clamp_angle", 0.15), ("unknown", 0.1),
    ]  # fmt: skip
    assert open_still.to_json()["reported_set"] == open_still.reported_set


def test_the_reported_set_of_something_unknown_has_the_names_that_it_may_have():
    of_unknown = unknown()
    shares = {"unknown": 0.6, "gravity": 0.4}
    one = replace(of_unknown.unknown, confusable_with=("gravity",), probabilities=shares)
    assert replace(of_unknown, unknown=one).reported_set == shares
    assert replace(of_unknown, unknown=None).reported_set == {}


def test_of_one_position_nothing_is_predicted_without_it():
    diagnosis = found()
    assert any("left out" in row[0] for row in improvement_table(diagnosis).rows)
    alone = tuple(row for row in diagnosis.rows if row.position_m == diagnosis.rows[0].position_m)
    table = improvement_table(replace(diagnosis, rows=alone))
    assert not any("left out" in row[0] for row in table.rows)
    assert "Left out" not in table.note


def test_with_too_few_set_ups_nothing_is_below_a_threshold():
    diagnosis = replace(found(), threshold=np.inf, threshold_from="nothing is named")
    table = ranking_table(replace(diagnosis, effects=()))
    assert "Threshold for a name: none (nothing is named)" in table.note
    remarks = {row[-1] for row in table.rows}
    assert "not judged" in remarks
    assert "below the threshold" not in remarks


@pytest.mark.parametrize(("expected", "unlikely"), [(3.9, True), (4.1, False)])
def test_a_measurement_that_will_hardly_tell_two_effects_apart_says_so(expected, unlikely):
    one = Next(
        why="30 runs, to separate gravity from clamp angle", extra="long_runs",
        between=("gravity", "clamp_angle"), separation=1.7, expected=expected, minutes=2.0,
        protocol={},
    )  # fmt: skip
    assert ("unlikely to tell them apart: it takes 4 sigma" in next_sentence(one)) is unlikely
