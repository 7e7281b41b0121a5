"""Discrepancy between simulation and measurement: where it is, and which effects explain it."""

from __future__ import annotations

from model.discrepancy.criticism import CheckResult, VerdictCheck
from model.discrepancy.data_checks import DataCheck, Suspicion
from model.discrepancy.data_checks.check import CheckedData, check_data
from model.discrepancy.diagnose import diagnose, next_measurement
from model.discrepancy.prepare import DiagnoseOptions
from model.discrepancy.verdict.result import Diagnosis, Named, Next, Unknown

__all__ = [
    "CheckResult",
    "CheckedData",
    "DataCheck",
    "DiagnoseOptions",
    "Diagnosis",
    "Named",
    "Next",
    "Suspicion",
    "Unknown",
    "VerdictCheck",
    "check_data",
    "diagnose",
    "next_measurement",
]
