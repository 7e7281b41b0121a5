"""`Measurements` as flat arrays of fixed-length types, and back, without loss."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate
from typing import Any

import numpy as np

from labrig.files import as_text
from labrig.serialise import from_json, to_json
from labrig.session.format import layout
from labrig.session.format.layout import Array
from labrig.session.reading.values import with_str
from model.measurements import (
    CameraUncertainty,
    Condition,
    Contact,
    Curve,
    Measurements,
    Reading,
    SheetGeometry,
    TimeSeries,
)

MEAN_IMAGE = -1  # in place of a reading's place: the curve of the condition's mean image
# Columns of `points` and `samples`; those a curve or series does not have are NaN.
_POINT = ("s_m", "x_m", "y_m", "curvature_per_m", "sigma_m", "curvature_sigma_per_m")
_SAMPLE = ("time_s", "drive_V", "force_N", "current_A")
# for readers without labrig: what the columns of the plain arrays are
COLUMNS = {"points": _POINT, "samples": _SAMPLE}
# of columns whose names do not end with their unit
UNITS = {"curvature_per_m": "1/m", "curvature_sigma_per_m": "1/m"}
_CHANNEL = "channel_"  # before the name of a further channel's values, among those of readings
_CONTACT = ("s_m", "x_m", "y_m", "angle_rad", "position_m", "position_sigma_m", "radius_m")


def tables_from_measurements(measurements: Measurements) -> dict[str, Array]:
    """All of it as arrays by name."""
    conditions = measurements.conditions
    readings = [(at, reading) for at, c in enumerate(conditions) for reading in c.readings]
    curves = [(at, place, curve) for at, c in enumerate(conditions) for place, curve in _curves(c)]
    return {
        "sheets": _text(to_json(list(measurements.sheets.values()))),
        "warnings": _text(to_json(measurements.warnings)),
        "source": _text(measurements.source),
        "checksum": _text(measurements.checksum),
        "conditions": _condition_table(conditions),
        "readings": _reading_table(readings),
        "curves": _part_table(curves, "reading", _POINT),
        "points": _stacked([curve for *_, curve in curves], _POINT),
        "contacts": _contact_table(conditions),
        "rolls": _roll_table(conditions),
        "series": _series_table(measurements.series),
        "samples": _stacked(measurements.series, _SAMPLE),
        "camera": _text(to_json(measurements.camera)),
    }


def measurements_from_tables(tables: Mapping[str, Array]) -> Measurements:
    """Return the reverse; raises KeyError, ValueError, TypeError or IndexError on other tables."""
    sheets = from_json(tuple[SheetGeometry, ...], _text_back(tables["sheets"]))
    curves: dict[tuple[int, int], Curve] = {}
    for row in tables["curves"]:
        curves[int(row["condition"]), int(row["reading"])] = Curve(
            **_columns(tables["points"], row, _POINT)
        )
    return Measurements(
        sheets={sheet.configuration: sheet for sheet in sheets},
        conditions=_conditions(tables, curves),
        series=tuple(
            TimeSeries(
                configuration=str(row["configuration"]),
                position_m=_known(row["position_m"]),
                mounting=int(row["mounting"]),
                # sessions of before hold one run of each place
                run=int(row["run"]) if "run" in row.dtype.names else 0,
                extra=str(row["extra"]) if "extra" in row.dtype.names else "",
                **_columns(tables["samples"], row, _SAMPLE),
            )
            for row in with_str(tables["series"])
        ),
        source=_text_back(tables["source"]),
        checksum=_text_back(tables["checksum"]),
        warnings=from_json(tuple[str, ...], _text_back(tables["warnings"])),
        # sessions of before do not have it
        camera=(
            from_json(CameraUncertainty, _text_back(tables["camera"]))
            if "camera" in tables
            else CameraUncertainty()
        ),
    )


# ------------------------------------------------------------------------------------------- there


def _text(text: str) -> Array:
    raw = as_text(text).encode("utf-8")
    return np.array(raw, dtype=layout.text_type(len(raw)))


def _curves(condition: Condition) -> list[tuple[int, Curve]]:
    """Return the condition's curves with the place of their reading among its readings."""
    whole = [] if condition.curve is None else [(MEAN_IMAGE, condition.curve)]
    by_reading = [(i, r.curve) for i, r in enumerate(condition.readings) if r.curve is not None]
    return whole + by_reading


def _table(columns: Mapping[str, Sequence[Any]]) -> Array:
    """Return a structured array; texts get just the length they need."""
    made: dict[str, Array] = {}
    for name, values in columns.items():
        if values and isinstance(values[0], str):
            raw = [value.encode("utf-8") for value in values]
            made[name] = np.array(raw, dtype=layout.text_type(max(map(len, raw))))
        else:
            made[name] = np.array(values)
    table = np.zeros(
        len(next(iter(made.values()))),
        dtype=[(name, column.dtype) for name, column in made.items()],
    )
    for name, column in made.items():
        table[name] = column
    return table


def _starts(lengths: Sequence[int]) -> list[int]:
    return list(accumulate(lengths, initial=0))[:-1]


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _condition_table(conditions: Sequence[Condition]) -> Array:
    return _table(
        {
            "configuration": [c.configuration for c in conditions],
            "position_m": [_or_nan(c.position_m) for c in conditions],
            "voltage_V": [float(c.voltage_V) for c in conditions],
            "mounting": [c.mounting for c in conditions],
            "approach": [c.approach for c in conditions],
            "tilt_rad": [float(c.tilt_rad) for c in conditions],
            "run": [c.run for c in conditions],
        }
    )


def _reading_table(readings: Sequence[tuple[int, Reading]]) -> Array:
    others = dict.fromkeys(name for _, reading in readings for name in reading.other_values)
    return _table(
        {
            "condition": [at for at, _ in readings],
            "index": [r.index for _, r in readings],
            "kind": [r.kind for _, r in readings],
            "force_N": [float(r.force_N) for _, r in readings],
            "time_s": [_or_nan(r.time_s) for _, r in readings],
            "session_s": [_or_nan(r.session_s) for _, r in readings],
            "wetted_s": [_or_nan(r.wetted_s) for _, r in readings],
            "frame_s": [_or_nan(r.frame_s) for _, r in readings],
            "valid": [bool(r.valid) for _, r in readings],
            "why": [r.why for _, r in readings],
            **_of_means([r for _, r in readings]),
            **{
                f"{_CHANNEL}{name}": [r.other_values.get(name, np.nan) for _, r in readings]
                for name in others
            },
        }
    )


def _of_means(readings: Sequence[Reading]) -> dict[str, Sequence[Any]]:
    """Return the columns of readings that are means of others, where there are any."""
    if all(r.mean_of == 1 and r.sd_N is None for r in readings):
        return {}
    return {"mean_of": [r.mean_of for r in readings], "sd_N": [_or_nan(r.sd_N) for r in readings]}


def _part_table(
    parts: Sequence[tuple[int, int, Curve]], place: str, columns: Sequence[str]
) -> Array:
    lengths = [len(curve.s_m) for *_, curve in parts]
    table: dict[str, Sequence[Any]] = {
        "condition": [at for at, _, _ in parts],
        place: [where for _, where, _ in parts],
        "first": _starts(lengths),
        "count": lengths,
    }
    for name in columns[3:]:
        table[f"has_{name}"] = [getattr(curve, name) is not None for *_, curve in parts]
    return _table(table)


def _contact_table(conditions: Sequence[Condition]) -> Array:
    found = [(at, c.contact) for at, c in enumerate(conditions) if c.contact is not None]
    table: dict[str, Sequence[Any]] = {"condition": [at for at, _ in found]}
    for name in _CONTACT:
        table[name] = [float(getattr(contact, name)) for _, contact in found]
    return _table(table)


def _roll_table(conditions: Sequence[Condition]) -> Array:
    rolls = [
        (at, *roll)
        for at, c in enumerate(conditions)
        if c.contact is not None
        for roll in c.contact.rolls_m
    ]
    names = ("condition", "x_m", "y_m", "radius_m")
    return _table({name: [roll[i] for roll in rolls] for i, name in enumerate(names)})


def _series_table(series: Sequence[TimeSeries]) -> Array:
    lengths = [len(each.time_s) for each in series]
    return _table(
        {
            "configuration": [each.configuration for each in series],
            "position_m": [_or_nan(each.position_m) for each in series],
            "mounting": [each.mounting for each in series],
            "run": [each.run for each in series],
            "extra": [each.extra for each in series],
            "first": _starts(lengths),
            "count": lengths,
            "has_force_N": [each.force_N is not None for each in series],
            "has_current_A": [each.current_A is not None for each in series],
        }
    )


def _stacked(items: Sequence[Any], names: Sequence[str]) -> Array:
    """Return the named arrays of all items side by side, one item below the other."""
    parts = []
    for item in items:
        columns = [getattr(item, name) for name in names]
        missing = np.full(len(columns[0]), np.nan)
        parts.append(np.column_stack([missing if c is None else c for c in columns]))
    return np.vstack(parts) if parts else np.empty((0, len(names)))


# -------------------------------------------------------------------------------------------- back


def _text_back(table: Array) -> str:
    return bytes(table[()]).decode("utf-8")


def _known(value: Any) -> float | None:
    return None if np.isnan(value) else float(value)


def _columns(stacked: Array, row: Any, names: Sequence[str]) -> dict[str, Any]:
    first, count = int(row["first"]), int(row["count"])
    if first < 0 or count < 0 or first + count > len(stacked):
        raise ValueError("a part of a table lies outside of it")
    present = [name for name in names if f"has_{name}" not in row.dtype.names or row[f"has_{name}"]]
    return {name: stacked[first : first + count, names.index(name)].copy() for name in present}


def _conditions(
    tables: Mapping[str, Array], curves: Mapping[tuple[int, int], Curve]
) -> tuple[Condition, ...]:
    rows = with_str(tables["conditions"])
    contacts = _contacts(tables)
    readings: list[list[Reading]] = [[] for _ in rows]
    for row in with_str(tables["readings"]):
        at = int(row["condition"])
        readings[at].append(
            Reading(
                index=int(row["index"]),
                kind=str(row["kind"]),  # type: ignore[arg-type]
                force_N=float(row["force_N"]),
                time_s=_known(row["time_s"]),
                session_s=_known(row["session_s"]),
                wetted_s=_known(row["wetted_s"]),
                # measurements of before do not have it
                frame_s=_known(row["frame_s"]) if "frame_s" in (row.dtype.names or ()) else None,
                valid=bool(row["valid"]),
                why=str(row["why"]),
                curve=curves.get((at, len(readings[at]))),
                other_values=_other_values(row),
                mean_of=int(row["mean_of"]) if "mean_of" in (row.dtype.names or ()) else 1,
                sd_N=_known(row["sd_N"]) if "sd_N" in (row.dtype.names or ()) else None,
            )
        )
    return tuple(
        Condition(
            configuration=str(row["configuration"]),
            position_m=_known(row["position_m"]),
            voltage_V=float(row["voltage_V"]),
            readings=tuple(readings[at]),
            curve=curves.get((at, MEAN_IMAGE)),
            mounting=int(row["mounting"]),
            approach=str(row["approach"]),  # type: ignore[arg-type]
            tilt_rad=float(row["tilt_rad"]),
            run=int(row["run"]),
            contact=contacts.get(at),
        )
        for at, row in enumerate(rows)
    )


def _other_values(row: Any) -> dict[str, float]:
    """Return the values of further channels that a reading has."""
    names = [name for name in row.dtype.names if name.startswith(_CHANNEL)]
    return {
        name.removeprefix(_CHANNEL): float(row[name]) for name in names if not np.isnan(row[name])
    }


def _contacts(tables: Mapping[str, Array]) -> dict[int, Contact]:
    """By condition; none in sessions that were analysed before there were any."""
    if "contacts" not in tables:
        return {}
    rolls: dict[int, list[tuple[float, float, float]]] = {}
    for row in tables["rolls"]:
        circle = (float(row["x_m"]), float(row["y_m"]), float(row["radius_m"]))
        rolls.setdefault(int(row["condition"]), []).append(circle)
    return {
        int(row["condition"]): Contact(
            **{name: float(row[name]) for name in _CONTACT},
            rolls_m=tuple(rolls.get(int(row["condition"]), ())),
        )
        for row in tables["contacts"]
    }
