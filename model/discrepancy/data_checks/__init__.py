"""Checks of what is stated of a measurement, before anything is searched for."""

from __future__ import annotations

from model.discrepancy.data_checks.contract import Change, DataCheck, Suspicion

__all__ = ["Change", "DataCheck", "Suspicion"]
