"""The columns of the CSV tables, with units, signs and axes."""

from __future__ import annotations

from collections.abc import Iterator

from labrig.session.tables import columns

HEAD = """\
# CSV tables

`labrig import`, `labrig diagnose --forces ...` and `labrig fit` read these tables; `labrig export`
writes them. The first line names the columns, in any order. Columns are separated by commas,
decimals have a point, and an empty field means that the value is not known. The end of a name is
the unit.

Axes and signs: x runs along the sheet where it leaves the clamp, y to the left of x. The origin is
the point where the sheet leaves the clamp. Positions count along the arc, in the direction of
growing angles, from `origin_deg` of [sheet.toml](sheet_file.md). A force is positive where the
sheet pushes the load cell towards larger positions. Curvature is positive where the sheet bends to
the side of growing y.

![The coordinates](../../images/made/coordinates.svg)

`labrig export session.h5 -o tables` writes all three.
"""

MEANINGS = {
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
}

TABLES = {
    "forces.csv": ("A row for each reading.", columns.FORCES, columns.FORCES_OPTIONAL),
    "curves.csv": (
        "A row for each point of a neutral curve, from the clamp to the end.",
        columns.CURVES,
        columns.CURVES_OPTIONAL,
    ),
    "signals.csv": ("A row for each sample.", columns.SIGNALS, columns.SIGNALS_OPTIONAL),
}


def page() -> str:
    """Return the page's text. Raises KeyError for a column that is not described here."""
    return "\n".join([HEAD, *(line for name in TABLES for line in _table(name))])


def _table(name: str) -> Iterator[str]:
    about, required, optional = TABLES[name]
    yield f"\n## {name}\n"
    yield f"{about}\n"
    yield "| column | required | meaning |"
    yield "|---|---|---|"
    for column in required:
        yield f"| `{column}` | yes | {MEANINGS[column]} |"
    for column in optional:
        yield f"| `{column}` | no | {MEANINGS[column]} |"
    if name == "forces.csv":
        yield (
            f"| `{columns.CHANNEL}NAME_UNIT` | no | a further input of the rig, such as "
            f"`{columns.CHANNEL}temperature_degC` |"
        )
