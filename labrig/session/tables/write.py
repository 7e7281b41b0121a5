"""Measurements into CSV files."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from pathlib import Path

from labrig.errors import BadInputError
from labrig.files import make_folder
from labrig.session.recording.disk import written_beside
from labrig.session.tables import camera_uncertainty, columns
from labrig.session.tables.decimals import degrees, milli, plain
from model.measurements import Condition, Curve, Measurements, TimeSeries

TABLES = ("forces.csv", "curves.csv", "signals.csv", camera_uncertainty.FILE)
Cells = dict[str, str]


def write_tables(measurements: Measurements, folder: Path) -> list[Path]:
    """Write forces.csv, and each further table of `TABLES` where there is any of it; their paths.

    Optional columns are written where something is to be said in them. Raises BadInputError when a
    file is there already.
    """
    folder = Path(folder)
    tables = {
        "forces.csv": (
            columns.FORCES,
            (*columns.FORCES_OPTIONAL, *_other_columns(measurements)),
            _forces(measurements),
        ),
        "curves.csv": (columns.CURVES, columns.CURVES_OPTIONAL, _curves(measurements)),
        "signals.csv": (columns.SIGNALS, columns.SIGNALS_OPTIONAL, _signals(measurements.series)),
        camera_uncertainty.FILE: (
            (),
            columns.CAMERA,
            camera_uncertainty.cells_of(measurements.camera),
        ),
    }
    _make(folder)
    written: list[Path] = []
    for name, (required, optional, rows) in tables.items():
        cells = list(rows)
        if cells or name == "forces.csv":
            used = [column for column in optional if any(row.get(column) for row in cells)]
            _write(folder / name, [*required, *used], cells)
            written.append(folder / name)
    return written


def write_curves(measurements: Measurements, path: Path) -> None:
    """Write curves.csv alone, in place of one that is there."""
    cells = list(_curves(measurements))
    used = [column for column in columns.CURVES_OPTIONAL if any(row.get(column) for row in cells)]
    _write(path, [*columns.CURVES, *used], cells)


def _make(folder: Path) -> None:
    make_folder(folder)
    for name in TABLES:
        if (folder / name).exists():
            raise BadInputError(f"{folder / name} exists already; choose another folder.")


def _write(path: Path, names: Iterable[str], rows: Iterable[Cells]) -> None:
    with (
        written_beside(path) as beside,
        beside.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.DictWriter(
            file, list(names), restval="", extrasaction="ignore", lineterminator="\n"
        )
        writer.writeheader()
        writer.writerows(rows)


def _maybe(value: float | None) -> str:
    return "" if value is None else plain(value)


def _where(condition: Condition) -> Cells:
    return {
        "configuration": condition.configuration,
        "position_mm": "" if condition.position_m is None else milli(condition.position_m),
        "voltage_V": plain(condition.voltage_V),
        "mounting": str(condition.mounting) if condition.mounting else "",
        "approach": condition.approach,
        "run": str(condition.run) if condition.run else "",
        "tilt_deg": degrees(condition.tilt_rad) if condition.tilt_rad else "",
    }


def _other_columns(measurements: Measurements) -> list[str]:
    """Return the columns of further channels, in the order in which they come."""
    readings = (reading for c in measurements.conditions for reading in c.readings)
    names = dict.fromkeys(name for reading in readings for name in reading.other_values)
    return [f"{columns.CHANNEL}{name}" for name in names]


def _forces(measurements: Measurements) -> Iterator[Cells]:
    for condition in measurements.conditions:
        where = _where(condition)
        for reading in condition.readings:
            yield where | {
                "reading": str(reading.index),
                "force_mN": milli(reading.force_N),
                "kind": reading.kind,
                "time_s": _maybe(reading.time_s),
                "session_s": _maybe(reading.session_s),
                "wetted_s": _maybe(reading.wetted_s),
                "valid": "true" if reading.valid else "false",
                "why": reading.why,
                "sd_mN": "" if reading.sd_N is None else milli(reading.sd_N),
                "mean_of": str(reading.mean_of) if reading.mean_of > 1 else "",
                **{
                    f"{columns.CHANNEL}{name}": plain(value)
                    for name, value in reading.other_values.items()
                },
            }


def _curves(measurements: Measurements) -> Iterator[Cells]:
    for condition in measurements.conditions:
        where = _where(condition)
        if condition.curve is not None:
            yield from _points(condition.curve, where)
        for reading in condition.readings:
            if reading.curve is not None:
                yield from _points(reading.curve, where | {"reading": str(reading.index)})


def _points(curve: Curve, where: Cells) -> Iterator[Cells]:
    milli_columns = {
        "x_mm": curve.x_m,
        "y_mm": curve.y_m,
        "s_mm": curve.s_m,
        "sigma_mm": curve.sigma_m,
    }
    plain_columns = {
        "curvature_per_m": curve.curvature_per_m,
        "curvature_sigma_per_m": curve.curvature_sigma_per_m,
    }
    for point in range(len(curve.s_m)):
        cells = where | {"point": str(point)}
        cells |= {k: milli(v[point]) for k, v in milli_columns.items() if v is not None}
        cells |= {k: plain(v[point]) for k, v in plain_columns.items() if v is not None}
        yield cells


def _signals(series: Iterable[TimeSeries]) -> Iterator[Cells]:
    for each in series:
        where = {
            "configuration": each.configuration,
            "position_mm": "" if each.position_m is None else milli(each.position_m),
            "mounting": str(each.mounting) if each.mounting else "",
            "run": str(each.run) if each.run else "",
            "extra": each.extra,
        }
        for at in range(len(each.time_s)):
            cells = where | {"time_s": plain(each.time_s[at]), "drive_V": plain(each.drive_V[at])}
            if each.force_N is not None:
                cells["force_mN"] = milli(each.force_N[at])
            if each.current_A is not None:
                cells["current_mA"] = milli(each.current_A[at])
            yield cells
