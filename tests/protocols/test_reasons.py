"""Many reasons in few words."""

from __future__ import annotations

import pytest

from protocols.reasons import in_short


@pytest.mark.parametrize(
    ("reasons", "said"),
    [
        ([], ""),
        (["no frame came", "no frame came"], "no frame came"),
        (
            ["late by 15.5 ms (limit 5 ms)", "no frame came", "late by 9 ms (limit 5 ms)"],
            "late by 9 to 15.5 ms (limit 5 ms); no frame came",
        ),
        (["late by 7 ms; no frame", "no frame", "late by 8 ms"], "late by 7 to 8 ms; no frame"),
        (["-2 V at +3 mm", "10 V at +3 mm"], "-2 to 10 V at +3 mm"),
        (["PCI6703 is gone", "PCI6034E is gone"], "PCI6703 is gone; PCI6034E is gone"),
    ],
)
def test_reasons_that_differ_in_numbers_alone_are_one_with_a_range(
    reasons: list[str], said: str
) -> None:
    assert in_short(reasons) == said
