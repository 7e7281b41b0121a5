"""What an analysis found in a session, for the command line."""

from __future__ import annotations

from typing import Any

import numpy as np

from labrig.report.data.selection import conditions_of, configurations, mean_force, place
from labrig.report.parts.table import Table, fixed, volts
from model import Condition, Measurements
from protocols.reasons import alike, in_short


def measurements_tables(measurements: Measurements) -> list[Table]:
    """Rows for the conditions, a summary of each configuration, and why readings are invalid."""
    names = configurations(measurements)
    rows = [_row(c) for name in names for c in conditions_of(measurements, name)]
    columns = ("condition", "F mN", "scatter mN", "readings", "invalid", "curve")
    summary = [_summary(measurements, name) for name in names]
    tables = [
        Table(title="Conditions", columns=columns, rows=tuple(rows)),
        Table(
            title="Found",
            columns=("sheet", "conditions", "with force", "with curve"),
            rows=tuple(summary),
        ),
    ]
    invalid = _reasons(measurements)
    if invalid:
        tables.append(
            Table(title="Invalid readings", columns=("readings", "why"), rows=tuple(invalid))
        )
    return tables


def _reasons(measurements: Measurements) -> list[tuple[str, str]]:
    """Return how many readings are invalid for each reason, the commonest first.

    Reasons that differ in their numbers alone are one, with their range.
    """
    readings = [reading for condition in measurements.conditions for reading in condition.readings]
    whys = [reading.why or "not stated" for reading in readings if not reading.valid]
    groups = sorted(alike(whys), key=len, reverse=True)
    return [(f"{len(group)} of {len(readings)}", in_short(group)) for group in groups]


def _row(condition: Condition) -> tuple[str, ...]:
    force = mean_force(condition)
    where = f"{place(condition.position_m)}, {volts(condition.voltage_V)}"
    return (
        f"{condition.configuration}, {where}" + _again(condition),
        "-" if force is None else fixed(1e3 * force.mean_N, 3),
        "-" if force is None else fixed(1e3 * force.deviation_N, 3),
        str(len(condition.used())),
        str(sum(not reading.valid for reading in condition.readings)),
        "ok" if condition.curve is not None else "none",
    )


def _again(condition: Condition) -> str:
    """Return what tells apart a condition that was measured more than once."""
    details = [f"mounting {condition.mounting}"] if condition.mounting else []
    details += [f"again {condition.run}"] if condition.run else []
    details += [condition.approach] if condition.approach == "down" else []
    details += [f"rig at {np.degrees(condition.tilt_rad):.4g}°"] if condition.tilt_rad else []
    return f" ({', '.join(details)})" if details else ""


def _summary(measurements: Measurements, name: str) -> tuple[str, ...]:
    own = conditions_of(measurements, name)
    forces = sum(mean_force(c) is not None for c in own)
    curves = sum(c.curve is not None for c in own)
    return (name, str(len(own)), str(forces), str(curves))


def measurements_as_dict(measurements: Measurements) -> dict[str, Any]:
    """Return the same for `--json`."""
    return {
        "source": measurements.source,
        "checksum": measurements.checksum,
        "conditions": [
            _as_dict(c)
            for name in configurations(measurements)
            for c in conditions_of(measurements, name)
        ],
        "warnings": list(measurements.warnings),
    }


def _as_dict(condition: Condition) -> dict[str, Any]:
    force = mean_force(condition)
    curve = condition.curve
    return {
        "configuration": condition.configuration,
        "position_mm": None if condition.position_m is None else 1e3 * condition.position_m,
        "voltage_V": condition.voltage_V,
        "mounting": condition.mounting,
        "run": condition.run,
        "force_mN": None if force is None else 1e3 * force.mean_N,
        "scatter_mN": None if force is None else 1e3 * force.deviation_N,
        "readings": len(condition.used()),
        "invalid": [
            {"reading": reading.index, "why": reading.why}
            for reading in condition.readings
            if not reading.valid
        ],
        "curve": None
        if curve is None
        else {
            "points": len(curve.s_m),
            "length_mm": 1e3 * float(curve.s_m[-1]),
            "sigma_mm": None if curve.sigma_m is None else 1e3 * float(np.median(curve.sigma_m)),
        },
    }
