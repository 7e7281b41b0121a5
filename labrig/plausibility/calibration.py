"""The age of a calibration."""

from __future__ import annotations

import datetime as dt

from labrig.check import Check
from labrig.config.templates import NOT_CALIBRATED


def calibration_age(name: str, date: dt.date, warn_after_days: int, today: dt.date) -> Check:
    """Return a check of a calibration's age: older than that is a warning, the future a fault."""
    days = (today - date).days
    wanted = f"at most {warn_after_days} days"
    if days < 0:
        return Check(name=name, ok=False, found="dated in the future", wanted="a date in the past")
    if date == NOT_CALIBRATED:
        return Check(
            name=name, ok=True, found="never made: labrig init's", wanted=wanted, warning=True
        )
    late = days > warn_after_days
    return Check(name=name, ok=True, found=f"{days} days old", wanted=wanted, warning=late)
