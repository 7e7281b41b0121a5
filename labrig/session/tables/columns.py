"""The columns of the CSV files, with their units, signs and axes."""

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

# How well camera and curves are known, one line for all curves.
CAMERA: Final = ("scale_fraction", "roll_deg", "origin_mm", "curve_mm")

KINDS: Final = ("zero", "discarded", "kept", "no_contact")
APPROACHES: Final = ("up", "down")

AXES: Final = (
    "x runs along the sheet where it leaves the clamp, y to the left of x. The origin is the point "
    "where the sheet leaves the clamp. Positions count along the arc, in the direction of growing "
    "angles, from origin_deg of sheet.toml. A force is positive where the sheet pushes the load "
    "cell towards larger positions. Curvature is positive where the sheet bends to the side of "
    "growing y."
)

MEANINGS: Final = {
    "configuration": "name of the configuration, a table of sheet.toml",
    "position_mm": "place of the load cell along the arc; empty: the sheet is free",
    "voltage_V": "at the sheet, as written",
    "reading": (
        "number of the reading in its run, from 0 (labrig mark counts from 1); in curves.csv empty "
        "for the mean image"
    ),
    "sd_mN": "standard deviation of the single readings, where force_mN is their mean",
    "mean_of": "how many readings force_mN is the mean of",
    "force_mN": "on the load cell, along the arc's tangent, towards larger positions",
    "time_s": "since the run began",
    "session_s": "since the session began",
    "wetted_s": "since the sheet was last moistened",
    "kind": "purpose of the reading: zero, discarded, kept or no_contact; default kept",
    "valid": "true or false; default true",
    "why": "why a reading is not valid",
    "mounting": "number of the placement, where a position was set anew",
    "approach": "up or down: from which side the load cell came to the position",
    "run": "how often the same place was measured before; empty: 0",
    "tilt_deg": "0, or 180 where the rig is turned over, so that weight pulls the other way",
    "point": "number of the point along the curve, from 0 at the clamp",
    "x_mm": "along the sheet where it leaves the clamp",
    "y_mm": "across it, to the left",
    "sigma_mm": "standard uncertainty across the curve",
    "s_mm": "arc length from the clamp",
    "curvature_per_m": "of the fitted curve; positive: to the side of growing y",
    "curvature_sigma_per_m": "its standard uncertainty",
    "drive_V": "at the sheet, as read back",
    "current_mA": "through the sheet",
    "extra": "name of the extra that the run belongs to",
    "scale_fraction": "standard uncertainty of the camera's scale: 0.004 is 0.4 %",
    "roll_deg": "that of its direction",
    "origin_mm": "that of the place of the clamp in its images",
    "curve_mm": "that of the curve of a mean image, however many images it has",
}

# What each table has a row for, the columns that it needs, and those that it may have.
TABLES: Final = {
    "forces.csv": ("A row for each reading.", FORCES, FORCES_OPTIONAL),
    "curves.csv": (
        "A row for each point of a neutral curve, from the clamp to the end.",
        CURVES,
        CURVES_OPTIONAL,
    ),
    "signals.csv": ("A row for each sample.", SIGNALS, SIGNALS_OPTIONAL),
    "camera_uncertainty.csv": (
        "One row, beside curves.csv: what all curves have in common.",
        (),
        CAMERA,
    ),
}
