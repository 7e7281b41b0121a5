"""The result of `diagnose`: what is named, by which evidence, and with which errors."""

from __future__ import annotations

from model.discrepancy.verdict.result.candidates import DetectionLimit, Ranked, Signatures
from model.discrepancy.verdict.result.diagnosis import Diagnosis, Verdict
from model.discrepancy.verdict.result.effects import ChosenValue, FormCurve, Named, Unknown
from model.discrepancy.verdict.result.errors import BeforeAfter, ClosedGap, ErrorRow, Gap, Where
from model.discrepancy.verdict.result.proposals import Next, Promise

__all__ = [
    "BeforeAfter",
    "ChosenValue",
    "ClosedGap",
    "DetectionLimit",
    "Diagnosis",
    "ErrorRow",
    "FormCurve",
    "Gap",
    "Named",
    "Next",
    "Promise",
    "Ranked",
    "Signatures",
    "Unknown",
    "Verdict",
    "Where",
]
