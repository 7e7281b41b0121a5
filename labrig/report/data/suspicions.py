"""What is suspicious about measurements as they are stated, for fits and reports."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from model.discrepancy import Suspicion
    from model.measurements import Measurements


def suspicions(measurements: Measurements) -> tuple[Suspicion, ...]:
    """Return what `labrig diagnose` finds suspicious before it searches."""
    from model.discrepancy import check_data

    return check_data(measurements).suspicions
