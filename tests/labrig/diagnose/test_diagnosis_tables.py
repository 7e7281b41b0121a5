"""Tables about a diagnosis."""

from __future__ import annotations

from dataclasses import replace

from labrig.report.diagnosis.tables import MOST_RANKED, ranking_table
from tests.labrig.diagnose.made import found


def test_what_is_named_is_among_the_candidates_however_many_explain_more_alone():
    diagnosis = found()
    best = diagnosis.ranking[0]
    others = tuple(replace(best, name=f"unknown_{i}", log_bayes=900.0) for i in range(20))
    rows = ranking_table(replace(diagnosis, ranking=(*others, best))).rows
    assert len(rows) == MOST_RANKED + 1
    assert (rows[-1][0], rows[-1][-1]) == ("EIBM along the sheet", "named")
