"""Tables about a diagnosis."""

from __future__ import annotations

from dataclasses import replace

from labrig.report.diagnosis.limits import limits_table
from labrig.report.diagnosis.tables import MOST_RANKED, ranking_table
from model.discrepancy.verdict.result import DetectionLimit
from tests.labrig.diagnose.made import found


def test_what_is_named_is_among_the_candidates_however_many_explain_more_alone():
    diagnosis = found()
    best = diagnosis.ranking[0]
    others = tuple(replace(best, name=f"unknown_{i}", log_bayes=900.0) for i in range(20))
    rows = ranking_table(replace(diagnosis, ranking=(*others, best))).rows
    assert len(rows) == MOST_RANKED + 1
    assert (rows[-1][0], rows[-1][-1]) == ("EIBM along the sheet", "named")


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
