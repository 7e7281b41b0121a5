"""What a fit sees of `Measurements`: per condition one mean force with its noise, and one curve."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.identification.data.curve_smoothing import SmoothCurve, smooth
from model.identification.likelihood.configuration.stacked_curves import PAST_THE_END
from model.measurements import (
    Condition,
    Curve,
    FloatArray,
    Measurements,
    ModelError,
    SheetGeometry,
    in_volts,
)

MOST_POINTS = 120


@dataclass(frozen=True, kw_only=True)
class Observation:
    """One condition that counts."""

    configuration: str
    position_m: float | None
    voltage_V: float
    run: tuple[str, float, int, int]  # conditions of the same run share what a set-up does
    force_N: float  # NaN: not measured
    force_variance_N2: float  # of one reading about the mean of its condition; NaN: one reading
    readings: int
    curve: Curve | None

    @property
    def name(self) -> str:
        """As people call it."""
        where = "free" if self.position_m is None else f"{self.position_m * 1e3:g} mm"
        return f"{self.configuration}, {where}, {in_volts(self.voltage_V)}"


@dataclass(frozen=True)
class Observed:
    """The observations of one configuration."""

    sheet: SheetGeometry
    observations: tuple[Observation, ...]

    @property
    def voltages_V(self) -> list[float]:
        """Driving voltages, 0 left out, ascending."""
        return sorted({o.voltage_V for o in self.observations if o.voltage_V != 0.0})

    def smoothed(self, one: Observation) -> SmoothCurve:
        """Return the curve of one of the observations as a smooth one; it is made once."""
        if one.curve is None:
            raise ModelError(f"condition {one.name} has no curve")
        if id(one) not in self._smoothed:
            self._smoothed[id(one)] = smooth(one.curve, self.sheet, one.name)
        return self._smoothed[id(one)]

    @cached_property
    def _smoothed(self) -> dict[int, SmoothCurve]:
        return {}

    def touching(self) -> list[Observation]:
        """Those with the load cell."""
        return [o for o in self.observations if o.position_m is not None]


def observe(measurements: Measurements, configuration: str) -> Observed:
    """Return the usable conditions of a configuration; raise `ModelError` where there are none."""
    sheet = measurements.sheets.get(configuration)
    if sheet is None:
        known = ", ".join(sorted(measurements.sheets)) or "none"
        raise ModelError(f"there is no configuration '{configuration}' (known: {known})")
    check_sheet(sheet)
    conditions = [c for c in measurements.conditions if c.configuration == configuration]
    if not conditions:
        raise ModelError(f"configuration '{configuration}' has no conditions: nothing was measured")
    found = [_observation(c, sheet) for c in conditions]
    used = tuple(o for o in found if o is not None)
    if not used:
        reasons = sorted({r.why for c in conditions for r in c.readings if r.why})
        why = f" ({'; '.join(reasons)})" if reasons else ""
        raise ModelError(f"configuration '{configuration}' has no valid readings at all{why}")
    return Observed(sheet, used)


def check_sheet(sheet: SheetGeometry) -> None:
    """Refuse a geometry that means nothing."""
    name = sheet.configuration
    for what, value in (
        ("free length", sheet.free_length_m),
        ("width", sheet.width_m),
        ("thickness", sheet.thickness_m),
        ("arc radius", sheet.arc_radius_m),
    ):
        if not (np.isfinite(value) and value > 0.0):
            raise ModelError(
                f"the {what} of configuration '{name}' must be positive, not {value:g} m"
            )
    if not (np.isfinite(sheet.elongation_m) and sheet.elongation_m >= 0.0):
        raise ModelError(f"the elongation of configuration '{name}' must be zero or longer")
    if sheet.free_length_m + sheet.elongation_m <= sheet.arc_radius_m:
        raise ModelError(
            f"sheet and elongation of configuration '{name}' are"
            f" {(sheet.free_length_m + sheet.elongation_m) * 1e3:g} mm long and cannot reach"
            f" the arc of {sheet.arc_radius_m * 1e3:g} mm"
        )


def _observation(condition: Condition, sheet: SheetGeometry) -> Observation | None:
    readings = condition.used()
    where = f"{condition.configuration}, {_place(condition)}, {in_volts(condition.voltage_V)}"
    if condition.position_m is not None:
        _check_position(condition.position_m, sheet, where)
        if not readings and (condition.readings or condition.curve is None):
            return None  # marked invalid: the curve of a stuck sheet is no equilibrium either
    elif condition.curve is None:
        return None
    if not np.isfinite(condition.voltage_V):
        raise ModelError(f"the voltage of condition {where} is not a finite number")
    forces = np.array([r.force_N for r in readings])
    if not np.all(np.isfinite(forces)):
        raise ModelError(f"a force of condition {where} is not a finite number; mark it invalid")
    free = condition.position_m is None
    mean = float(np.mean(forces)) if len(forces) and not free else np.nan
    variance = float(np.var(forces, ddof=1)) if len(forces) > 1 and not free else np.nan
    count = len(forces)
    if count == 1 and not free and readings[0].sd_N is not None:  # a mean that says its scatter
        variance, count = readings[0].sd_N ** 2, readings[0].mean_of
    run = (
        condition.configuration,
        condition.position_m if not free else np.inf,
        condition.mounting,
        condition.run,
    )
    curve = None if condition.curve is None else checked_curve(condition.curve, where)
    if curve is not None:
        _check_on_sheet(curve, sheet, where)
    return Observation(
        configuration=condition.configuration,
        position_m=condition.position_m,
        voltage_V=condition.voltage_V,
        run=(run[0], float(run[1] or 0.0), run[2], run[3]),
        force_N=mean,
        force_variance_N2=variance,
        readings=count,
        curve=curve,
    )


def _place(condition: Condition) -> str:
    return "free" if condition.position_m is None else f"{condition.position_m * 1e3:g} mm"


def _check_position(position_m: float, sheet: SheetGeometry, where: str) -> None:
    angle = position_m / sheet.arc_radius_m + sheet.arc_origin_rad
    if not np.isfinite(position_m) or abs(angle) > np.pi:
        raise ModelError(
            f"condition {where}: the position is not on the arc (half a turn each way)"
        )


def checked_curve(curve: Curve, where: str) -> Curve:
    """Return the curve, thinned to a useful number of points; raise `ModelError` for a bad one."""
    s, x, y = (np.asarray(a, dtype=float) for a in (curve.s_m, curve.x_m, curve.y_m))
    if not len(s) == len(x) == len(y):
        raise ModelError(f"the curve of condition {where} has unequal numbers of s, x and y")
    if len(s) < 4:
        raise ModelError(
            f"the curve of condition {where} has {len(s)} points; at least 4 are needed"
        )
    if not (np.all(np.isfinite(s)) and np.all(np.isfinite(x)) and np.all(np.isfinite(y))):
        raise ModelError(f"the curve of condition {where} holds a number that is not finite")
    if np.any(np.diff(s) <= 0.0) or s[0] < -1e-9:
        raise ModelError(f"the curve of condition {where}: s must ascend from the clamp")
    keep = np.unique(np.linspace(0, len(s) - 1, min(len(s), MOST_POINTS)).round().astype(int))

    def thin(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else np.asarray(values, dtype=float)[keep]

    return Curve(
        s_m=s[keep],
        x_m=x[keep],
        y_m=y[keep],
        curvature_per_m=thin(curve.curvature_per_m),
        sigma_m=thin(curve.sigma_m),
        curvature_sigma_per_m=thin(curve.curvature_sigma_per_m),
    )


def _check_on_sheet(curve: Curve, sheet: SheetGeometry, where: str) -> None:
    """Refuse a curve none of which is on the sheet, beside the clamp: one in another unit."""
    end_m = sheet.free_length_m + sheet.elongation_m
    count = int(np.count_nonzero(curve.s_m <= end_m * PAST_THE_END))
    if count < 2:
        raise ModelError(
            f"the curve of condition {where} has {count} point{'' if count == 1 else 's'} on the"
            f" sheet, which is {end_m * 1e3:g} mm long with its elongation; its unit seems to be"
            " another"
        )


def not_driven(measurements: Measurements, name: str) -> str:
    """Return why nothing is known of the EIBM of a configuration, and what to measure."""
    driven = [
        reading
        for c in measurements.conditions
        if c.configuration == name and c.voltage_V != 0.0
        for reading in c.readings
    ]
    why = next((reading.why for reading in driven if reading.why), "")
    if why:
        return (
            f"none of the {len(driven)} readings of configuration '{name}' under voltage counts"
            f" (the first: {why}); measure it again"
        )
    return (
        f"configuration '{name}' was measured at 0 V alone: that fixes B, but says nothing of the"
        " EIBM; measure it under voltage, too"
    )
