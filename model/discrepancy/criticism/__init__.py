"""Checks that a verdict must pass after the effects are named."""

from __future__ import annotations

from model.discrepancy.criticism.check_result import CheckResult, Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck

__all__ = ["CheckResult", "Consequence", "Failure", "VerdictCheck"]
