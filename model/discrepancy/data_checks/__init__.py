"""Check the stated values of a measurement against its data, before the search."""

from __future__ import annotations

from model.discrepancy.data_checks.contract import Change, DataCheck, Suspicion

__all__ = ["Change", "DataCheck", "Suspicion"]
