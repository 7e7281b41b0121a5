"""Numbers of sheet, arc, protocol and calibrations that can hardly be meant, before a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from drivers.load_cell import LoadCellCalibration
from labrig.check import Check
from model.measurements import SheetGeometry
from protocols import Schedule

FAR = 10.0  # by this factor beyond what is usual is a slip: the next unit is 1000 away
_ANY = math.inf


@dataclass(frozen=True)
class Usual:
    """The usual range of a quantity, and its unit as the file's key states it."""

    low: float
    high: float
    unit: str

    def checks(self, name: str, value: float) -> Iterator[Check]:
        """Yield a warning for a value out of the range, a fault for one far out of it."""
        if self.low <= value <= self.high:
            return
        far = not self.low / FAR <= value <= self.high * FAR
        unit = f" {self.unit}" if self.unit else ""
        ends = f"at least {self.low:g}" if self.high == _ANY else f"{self.low:g} to {self.high:g}"
        yield Check(
            name=name,
            ok=not far,
            found=f"{value:.4g}{unit}",
            wanted=f"{ends}{unit}",
            warning=not far,
        )


# Sheets, arcs and rigs that load cells of millinewtons are built for, with room to spare.
RADIUS = Usual(3.0, 400.0, "mm")
FREE_LENGTH = Usual(1.0, 300.0, "mm")
WIDTH = Usual(0.3, 200.0, "mm")
THICKNESS = Usual(0.01, 3.0, "mm")
ELONGATION = Usual(1.0, 400.0, "mm")
CLAMPED = Usual(0.1, 100.0, "mm")
RISE_TIME = Usual(0.0, 2.0, "s")
BEND = Usual(0.0, 360.0, "deg")  # of the free sheet at rest, all along it
NODES = Usual(0.5, 2.0, "of the free length")
REACH = Usual(1.0, _ANY, "of the arc's radius")
SPREAD = Usual(0.5, _ANY, "mm")
VOLTAGE = Usual(0.02, _ANY, "V")
# The water in a sheet decomposes from 1.2 V on; beyond some volts it is not water that is driven.
LIMIT = Usual(0.02, 6.0, "V")
CELL_SHARE = Usual(0.01, 5.0, "of the input's range")
SHEET_PX = Usual(40.0, _ANY, "pixels")
SHEET_IMAGES = Usual(0.0, 3.0, "images")


@dataclass(frozen=True, kw_only=True)
class SetUp:
    """What a run is planned with; None: not known, or not asked about."""

    schedule: Schedule
    sheets: Mapping[str, SheetGeometry] | None = None
    calibration: LoadCellCalibration | None = None  # of a cell that the board reads
    force_range_V: float = _ANY
    sheet_voltage_limit_V: float | None = None
    px_per_mm: float | None = None
    image_size: tuple[int, int] | None = None


def set_up_checks(set_up: SetUp) -> Iterator[Check]:
    """Yield a warning or a fault for each number that can hardly be meant."""
    sheets = set_up.sheets or {}
    lengths = [check for sheet in sheets.values() for check in length_checks(sheet)]
    yield from {check.name: check for check in lengths}.values()  # the arc's radius once
    if not all(check.ok for check in lengths):
        sheets = {}  # what follows from a wrong length is no further fault
    for sheet in sheets.values():
        yield from initial_curvature_checks(sheet)
    yield from _positions(set_up.schedule, sheets)
    yield from _voltages(set_up.schedule)
    if set_up.sheet_voltage_limit_V is not None:
        yield from LIMIT.checks("rig.toml [limits] sheet_voltage_V", set_up.sheet_voltage_limit_V)
    if set_up.calibration is not None:
        yield from _load_cell(set_up.calibration, set_up.force_range_V)
        yield from _dead_weights(set_up.schedule, set_up.calibration)
    if set_up.px_per_mm is not None and sheets:
        yield from _images(set_up.px_per_mm, set_up.image_size, sheets)


def length_checks(sheet: SheetGeometry) -> Iterator[Check]:
    """Yield a warning or a fault for each length of a sheet that can hardly be meant."""
    at = f"sheet.toml [{sheet.configuration}]"
    yield from RADIUS.checks("sheet.toml [arc] radius_mm", 1e3 * sheet.arc_radius_m)
    yield from FREE_LENGTH.checks(f"{at} free_length_mm", 1e3 * sheet.free_length_m)
    yield from WIDTH.checks(f"{at} width_mm", 1e3 * sheet.width_m)
    yield from THICKNESS.checks(f"{at} thickness_mm", 1e3 * sheet.thickness_m)
    if sheet.elongation_m:
        yield from ELONGATION.checks(f"{at} elongation_mm", 1e3 * sheet.elongation_m)
    if sheet.clamped_length_m:
        yield from CLAMPED.checks(f"{at} clamped_length_mm", 1e3 * sheet.clamped_length_m)
    yield from RISE_TIME.checks(f"{at} rise_time_s", sheet.rise_time_s)


def initial_curvature_checks(sheet: SheetGeometry) -> Iterator[Check]:
    """Yield a warning or a fault for an initial curvature that can hardly be meant."""
    at, length_m = f"sheet.toml [{sheet.configuration}]", sheet.free_length_m
    if sheet.initial_curvature is not None:
        nodes_m, per_m = sheet.initial_curvature
        bend_deg = math.degrees(float(np.max(np.abs(per_m))) * length_m)
        yield from BEND.checks(f"{at} initial_curvature_per_m", bend_deg)
        yield from NODES.checks(f"{at} initial_curvature_per_m s_mm", float(nodes_m[-1]) / length_m)


def _positions(schedule: Schedule, sheets: Mapping[str, SheetGeometry]) -> Iterator[Check]:
    for name in dict.fromkeys(run.configuration for run in schedule.runs):
        at = f"protocol.toml [[places]] {name}"
        found_m = [
            where_m
            for run in schedule.runs
            if run.configuration == name
            for where_m in (run.position_m, run.via_m, run.move.position_m if run.move else None)
            if where_m is not None
        ]
        if len(set(found_m)) > 1:
            spread_mm = 1e3 * (max(found_m) - min(found_m))
            yield from SPREAD.checks(f"{at}, from the first position to the last", spread_mm)
        if found_m and name in sheets:
            yield from _on_the_arc(at, found_m, sheets[name])


def _on_the_arc(at: str, found_m: list[float], sheet: SheetGeometry) -> Iterator[Check]:
    """Yield a fault where a position is more than half the circle away from the sheet."""
    farthest_m = max(found_m, key=lambda p: abs(sheet.arc_origin_rad + p / sheet.arc_radius_m))
    low_m = (-math.pi - sheet.arc_origin_rad) * sheet.arc_radius_m
    high_m = (math.pi - sheet.arc_origin_rad) * sheet.arc_radius_m
    if not low_m <= farthest_m <= high_m:
        yield Check(
            name=f"{at} positions_mm",
            ok=False,
            found=f"{1e3 * farthest_m:g} mm",
            wanted=f"{1e3 * low_m:.0f} to {1e3 * high_m:.0f} mm, the whole circle of the arc",
        )
    reach = (sheet.free_length_m + sheet.elongation_m) / sheet.arc_radius_m
    yield from REACH.checks(f"sheet.toml [{sheet.configuration}] sheet and elongation", reach)


def _voltages(schedule: Schedule) -> Iterator[Check]:
    largest_V = max((abs(s.voltage_V) for run in schedule.runs for s in run.steps), default=0.0)
    if largest_V:
        yield from VOLTAGE.checks("protocol.toml, the largest voltage", largest_V)


def _load_cell(calibration: LoadCellCalibration, range_V: float) -> Iterator[Check]:
    """Yield whether the cell's capacity and sensitivity fit the input that reads it."""
    full_V = abs(calibration.sensitivity_V_per_N) * calibration.capacity_N
    name = "load_cell.toml sensitivity_V_per_N times capacity"
    yield from CELL_SHARE.checks(name, full_V / range_V)


def _dead_weights(schedule: Schedule, calibration: LoadCellCalibration) -> Iterator[Check]:
    largest_N = max((abs(run.load_N or 0.0) for run in schedule.runs), default=0.0)
    if largest_N > calibration.capacity_N:
        yield Check(
            name="protocol.toml [extras] dead_weights_mN",
            ok=False,
            found=f"{1e3 * largest_N:g} mN",
            wanted=f"at most the load cell's {1e3 * calibration.capacity_N:g} mN",
        )


def _images(
    px_per_mm: float, image_size: tuple[int, int] | None, sheets: Mapping[str, SheetGeometry]
) -> Iterator[Check]:
    longest_mm = 1e3 * max(sheet.free_length_m + sheet.elongation_m for sheet in sheets.values())
    name = "optics.json px_per_mm, the sheet in the image"
    yield from SHEET_PX.checks(name, px_per_mm * longest_mm)
    if image_size is not None:
        yield from SHEET_IMAGES.checks(name, px_per_mm * longest_mm / math.hypot(*image_size))
