"""A comparison of models in time, kept and shown."""

from __future__ import annotations

import math

from labrig.analysis.comparison.result import (
    ComparedModel,
    ComparedQuantity,
    DynamicComparison,
    KeptComparisons,
)
from labrig.config.base import parse_json
from labrig.report.tables.in_time.comparison import dynamic_comparison_table, not_fitted
from labrig.serialise import from_plain, to_json

NOTHING = float("nan")
FOUND = DynamicComparison(
    configuration="long", held_out="all at 15 mm", values={"force": 1750, "shape": 314},
    rate_hz=250.0,
    models=(
        ComparedModel(
            name="full", title="the moving sheet", ln_evidence=34446.2,
            quantities={
                "force": ComparedQuantity(
                    rmse=1.26e-4, share=1.0, ln_evidence=13274.0, misfit=1.0
                ),
                "shape": ComparedQuantity(rmse=8e-6, share=1.0, ln_evidence=2885.0, misfit=1.0),
            },
            parameters={"B": 1.27e-6}, undetermined=("eta",),
        ),
        ComparedModel(
            name="yagasaki", title="after Yagasaki", ln_evidence=15644.0,
            quantities={
                "shape": ComparedQuantity(rmse=2.14e-3, share=0.74, ln_evidence=1411.0, misfit=54.0)
            },
        ),
        ComparedModel(
            name="lee", title="after Lee", ln_evidence=15000.0,
            quantities={
                "force": ComparedQuantity(
                    rmse=NOTHING, share=NOTHING, ln_evidence=13121.0, misfit=1.1
                )
            },
        ),
        ComparedModel(name="none", title="after nobody", why_not="it predicts nothing"),
    ),
)  # fmt: skip


def test_what_is_kept_comes_back():
    text = to_json(KeptComparisons((FOUND,)))
    (again,) = from_plain(KeptComparisons, parse_json(text, "test"), lenient=True).comparisons
    assert again.models[:2] == FOUND.models[:2]
    assert math.isnan(again.models[2].quantities["force"].rmse)
    assert again.models[3].why_not == "it predicts nothing"
    assert again.values == FOUND.values


def test_the_table_says_what_is_predicted_and_how_much_less_evidence_there_is():
    table = dynamic_comparison_table(FOUND)
    assert table.columns[:2] == ("model", "force RMSE, mN")
    assert table.rows == (
        ("the moving sheet", "0.126", "-", "0.008", "0", "0", "-", "0"),
        ("after Yagasaki", "-", "-", "2.140 (74 %)", "-18802", "-", "-", "-1474"),
        ("after Lee", "-", "-", "-", "-19446", "-153", "-", "-"),
        ("after nobody", "-", "-", "-", "-", "-", "-", "-"),
    )
    assert "all at 15 mm" in table.note
    assert not_fitted(FOUND) == ["after nobody: it predicts nothing."]
