"""Models of the sheet in time compared on a recorded session, and what is kept of it there."""

from labrig.analysis.comparison.compared import compare_fitted, compare_in_time, why_not_in_time
from labrig.analysis.comparison.result import (
    ComparedModel,
    DynamicComparison,
    keep_comparisons,
    kept_comparisons,
)

__all__ = [
    "ComparedModel",
    "DynamicComparison",
    "compare_fitted",
    "compare_in_time",
    "keep_comparisons",
    "kept_comparisons",
    "why_not_in_time",
]
