"""Measured curves and forces of conditions as plain data, in mm and mN."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from labrig.errors import BadInputError
from model.measurements import Condition, Curve, FloatArray, Measurements, SheetGeometry

MOST_POINTS = 120  # of a curve on a page
NORMAL_90 = 1.6449  # half width of the central 90 % of a normal distribution, in sigma
DECIMALS = 4  # of lengths in mm and forces in mN


def condition_of(number: int, condition: Condition) -> dict[str, Any]:
    """Return one condition: where it was measured, its curve and its readings."""
    contact = condition.contact
    return {
        "id": number,
        "position_mm": None if condition.position_m is None else in_mm(condition.position_m),
        "voltage_V": condition.voltage_V,
        "mounting": condition.mounting,
        "run": condition.run,
        "approach": condition.approach,
        "curve": curve_of(condition.curve),
        "contact": None
        if contact is None
        else {"x_mm": in_mm(contact.x_m), "y_mm": in_mm(contact.y_m)},
        "readings": [
            {
                "index": reading.index,
                "kind": reading.kind,
                "time_s": reading.time_s,
                "force_mN": known(1e3 * reading.force_N),
                "valid": reading.valid,
                "why": reading.why,
                "curve": reading.curve is not None,
            }
            for reading in condition.readings
        ],
    }


def mean_force_of(condition: Condition) -> dict[str, Any] | None:
    """Return the mean of the readings in use with its standard error; None where none counts."""
    if condition.position_m is None:
        return None
    force_mN = np.array([1e3 * r.force_N for r in condition.used() if math.isfinite(r.force_N)])
    if not len(force_mN):
        return None
    deviation = float(np.std(force_mN, ddof=1)) if len(force_mN) > 1 else math.nan
    return {
        "mean_mN": float(np.mean(force_mN)),
        "sigma_mN": known(deviation / math.sqrt(len(force_mN))),
        "deviation_mN": known(deviation),
        "readings": len(force_mN),
    }


def curve_of(curve: Curve | None) -> dict[str, Any] | None:
    """Return a curve with few enough points for a page: measured ones, none made up."""
    if curve is None:
        return None
    count = len(curve.s_m)
    keep = np.unique(np.linspace(0, count - 1, min(count, MOST_POINTS)).round().astype(int))
    sigma = curve.sigma_m
    return plain_curve(
        curve.x_m[keep], curve.y_m[keep], None if sigma is None else NORMAL_90 * sigma[keep]
    )


def plain_curve(x_m: FloatArray, y_m: FloatArray, half90_m: FloatArray | None) -> dict[str, Any]:
    """Return points and the half width of their 90 % band along the normal, in mm."""
    return {
        "x_mm": rounded(1e3 * x_m),
        "y_mm": rounded(1e3 * y_m),
        "half90_mm": None if half90_m is None else rounded(1e3 * half90_m),
    }


def reading_curve(measurements: Measurements, number: int, index: int) -> dict[str, Any] | None:
    """Return the curve of one reading of a condition, by the condition's `id`; None: it has none.

    Raises BadInputError where there is no such condition or reading.
    """
    if not 0 <= number < len(measurements.conditions):
        raise BadInputError(f"condition {number}: this session has no such condition.")
    for reading in measurements.conditions[number].readings:
        if reading.index == index:
            return curve_of(reading.curve)
    raise BadInputError(f"condition {number} has no reading {index}.")


def sheet_of(sheet: SheetGeometry) -> dict[str, float]:
    """Return what is drawn of the set-up."""
    return {
        "free_length_mm": in_mm(sheet.free_length_m),
        "elongation_mm": in_mm(sheet.elongation_m),
        "arc_radius_mm": in_mm(sheet.arc_radius_m),
        "arc_origin_deg": float(np.degrees(sheet.arc_origin_rad)),
    }


def in_mm(length_m: float) -> float:
    """Return a length in mm, without the noise of the factor."""
    return round(1e3 * length_m, 6)


def known(value: float) -> float | None:
    """Return a number; None where there is none."""
    return value if math.isfinite(value) else None


def rounded(values: FloatArray) -> list[float | None]:
    """Return numbers as short as a page needs them."""
    return [known(float(v)) for v in np.round(values, DECIMALS)]
