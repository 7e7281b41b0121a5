"""Where simulation and measurement disagree, which effect explains it, and what is left then."""

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
