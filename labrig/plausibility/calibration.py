"""The age of a calibration."""

from __future__ import annotations

import datetime as dt

from labrig.check import Check
from labrig.config.templates import NOT_CALIBRATED


def calibration_age(name: str, date: dt.date, warn_after_days: int, today: dt.date) -> Check:
    """Return a check of a calibration's age: older than that is a warning, the future a fault."""
    days = (today - date).days
    wanted = f"at most {warn_after_days} days"
    if days < -1:  # tomorrow is today in a time zone to the east
        found = f"dated in the future ({date}; this computer's clock says {today})"
        return Check(name=name, ok=False, found=found, wanted="a date in the past")
    if date == NOT_CALIBRATED:
        return Check(
            name=name, ok=True, found="never made: labrig init's", wanted=wanted, warning=True
        )
    late = days > warn_after_days
    return Check(name=name, ok=True, found=f"{max(days, 0)} days old", wanted=wanted, warning=late)
