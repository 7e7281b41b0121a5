"""The short form of the soak: twelve runs, two for each fault, which comes at a random moment."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from benchmarks.soak import figures, soak, summary

MEDIAN_S = 0.3  # from a kill to 0 V


@pytest.mark.thorough
@pytest.mark.alone
@pytest.mark.timeout(900)
@pytest.mark.skipif(sys.platform != "linux", reason="stray processes are looked for in /proc")
def test_after_any_fault_the_output_is_at_0_V_and_nothing_is_lost(tmp_path: Path) -> None:
    verdicts = soak(12, seed=7, folder=tmp_path, tell=lambda verdict: None, jobs=4)
    faults = [f"{v.number} ({v.fault.value}): {fault}" for v in verdicts for fault in v.faults]
    assert faults == [], "\n".join(summary(verdicts))
    killed = figures("killed", [v for v in verdicts if v.fault.is_deadly])
    assert killed.energised > 0
    assert killed.median_s < MEDIAN_S
