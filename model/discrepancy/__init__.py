"""Disagreement between simulation and measurement: its location, the effects, the remainder."""

from __future__ import annotations

from model.discrepancy.diagnose import diagnose, next_measurement
from model.discrepancy.prepare import Options as DiagnoseOptions
from model.discrepancy.verdict.result import Diagnosis, Named, Next, Unknown

__all__ = [
    "DiagnoseOptions",
    "Diagnosis",
    "Named",
    "Next",
    "Unknown",
    "diagnose",
    "next_measurement",
]
