"""The warning flags of Zaber's ASCII protocol in words. F stopped, W warning, N note."""

from __future__ import annotations

NO_REFERENCE = ("WR", "WH")
HARMLESS = frozenset({"--", "NC", "NR", "NT", "NU"})
_WARNINGS = {
    "FF": "critical system error",
    "FN": "peripheral not supported",
    "FZ": "peripheral inactive",
    "FH": "hardware emergency stop",
    "FV": "supply voltage too high or too low, driver disabled",
    "FO": "driver disabled on start-up or by command",
    "FC": "current inrush error",
    "FM": "motor temperature error",
    "FD": "driver disabled",
    "FQ": "encoder error",
    "FI": "index error",
    "FA": "analog encoder out of step",
    "FR": "overdrive limit exceeded",
    "FS": "stalled and stopped",
    "FB": "stream out of bounds",
    "FP": "deviation from an interpolated path",
    "FE": "limit error",
    "FT": "excessive twist",
    "WL": "a limit switch was met unexpectedly",
    "WV": "supply voltage out of range",
    "WT": "controller temperature high",
    "WS": "stalled and recovered",
    "WM": "displaced while stationary",
    "WP": "invalid calibration",
    "WR": "no reference position: it must be homed",
    "WH": "not homed: it must be homed",
    "NC": "moved by its knob",
    "NI": "a movement was interrupted by another command",
    "ND": "stream discontinuity",
    "NR": "a value was rounded",
    "NT": "a value was truncated",
    "NU": "a setting awaits its update",
    "NJ": "joystick calibration in progress",
}


def is_fault(flag: str) -> bool:
    """Whether the device has stopped and will not move until the cause is gone."""
    return flag.startswith("F")


def in_words(flag: str) -> str:
    """Return the meaning of a flag, with the flag."""
    return f"{_WARNINGS.get(flag, 'unknown warning')} ({flag})"
