"""The columns of the three CSV files."""

from __future__ import annotations

from typing import Final

_WHERE: Final = ("configuration", "position_mm", "voltage_V")
# What tells one condition from another at the same place and voltage.
_WHICH: Final = ("mounting", "approach", "run")

FORCES: Final = (*_WHERE, "reading", "force_mN")
FORCES_OPTIONAL: Final = (
    "time_s",
    "session_s",
    "wetted_s",
    "kind",
    "valid",
    "why",
    *_WHICH,
    "tilt_deg",
    "sd_mN",  # of the single readings, where force_mN is their mean
    "mean_of",  # how many readings force_mN is the mean of
)

# Before the name of a further channel's values: channel_temperature_degC.
CHANNEL: Final = "channel_"

CURVES: Final = (*_WHERE, "point", "x_mm", "y_mm")
CURVES_OPTIONAL: Final = (
    "reading",
    "sigma_mm",
    "s_mm",
    "curvature_per_m",
    "curvature_sigma_per_m",
    *_WHICH,
    "tilt_deg",
)

# Those of `labrig curves` that say where a curve is from.
CURVES_IGNORED: Final = ("image", "strip", "state", "frame", "time_s", "reason")

SIGNALS: Final = ("configuration", "position_mm", "time_s", "drive_V")
SIGNALS_OPTIONAL: Final = ("force_mN", "current_mA", "mounting", "run", "extra")

KINDS: Final = ("zero", "discarded", "kept", "no_contact")
APPROACHES: Final = ("up", "down")
