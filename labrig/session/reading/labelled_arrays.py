"""A session as an xarray tree: arrays with named dimensions, coordinates and units.

/readings   dimension reading: the value of each channel at each reading of all runs
/signals    dimension sample: the raw samples of all runs, one after the other
/curves     dimensions curve and point: neutral curves of an analysed session, padded with NaN
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from labrig.session.format.layout import FROM_0
from labrig.session.reading.run_record import RunRecord
from labrig.session.recording.hdf5 import unit_of
from model.measurements import Condition, Curve, Measurements

_IN_RUN = "since time zero of the run"
_CURVE_UNITS = {
    "x_m": "m",
    "y_m": "m",
    "s_m": "m",
    "sigma_m": "m",
    "curvature_per_m": "1/m",
    "curvature_sigma_per_m": "1/m",
}


def labelled_session(
    runs: Sequence[RunRecord],
    attributes: Mapping[str, str],
    measurements: Measurements | None,
    began_s: float,
) -> Any:
    """Return the `xarray.DataTree` of an open session's runs; `measurements` of an analysed one.

    `began_s`: time of the session's first event.
    Raises ModuleNotFoundError where xarray is missing.
    """
    import xarray

    parts = {"readings": _readings(runs, began_s), "signals": _signals(runs)}
    if measurements is not None:
        parts["curves"] = _curves(measurements)
    whole = xarray.Dataset(attrs=dict(attributes))
    return xarray.DataTree.from_dict({"/": whole} | {k: v for k, v in parts.items() if v.sizes})


def _variable(dimensions: str | Sequence[str], values: Any, units: str) -> tuple[Any, Any, Any]:
    return (dimensions, values, {"units": units} if units else {})


def _place(run: RunRecord) -> tuple[str, float]:
    at = run.planned.position_m
    return run.planned.configuration, np.nan if at is None else at


def _readings(recorded: Sequence[RunRecord], began_s: float) -> Any:
    import xarray

    runs = [run for run in recorded if run.started and len(run.readings)]
    if not runs:
        return xarray.Dataset()
    rows = np.concatenate([run.readings for run in runs])
    counts = [len(run.readings) for run in runs]
    own = {"index": "reading_index", "kind": "kind", "voltage_V": "voltage_V", "time_s": "time_s"}
    coords = {new: _variable("reading", rows[old], unit_of(old)) for old, new in own.items()}
    coords["reading_index"][2]["comment"] = FROM_0
    coords["time_s"][2]["comment"] = _IN_RUN
    zeros_s = np.repeat([run.time_zero_s - began_s for run in runs], counts)
    coords["session_s"] = _variable("reading", zeros_s + rows["time_s"], "s")
    coords["session_s"][2]["comment"] = "since the session's first event"
    coords |= _places("reading", runs, counts)
    coords["valid"] = ("reading", rows["valid"], {"comment": "with the marks of until now"})
    values = {
        channel.column: _variable("reading", rows[channel.column], channel.unit)
        for channel in runs[0].signals
        if channel.column in (rows.dtype.names or ())
    }
    return xarray.Dataset(values, coords=coords)


def _places(dimension: str, runs: Sequence[RunRecord], counts: Sequence[int]) -> dict[str, Any]:
    names, positions = zip(*map(_place, runs), strict=True)
    return {
        "run": (
            dimension,
            np.repeat([run.planned.index for run in runs], counts),
            {"comment": FROM_0},
        ),
        "configuration": (dimension, np.repeat(np.array(names, dtype=str), counts), {}),
        "position_m": _variable(dimension, np.repeat(positions, counts), "m"),
    }


def _signals(recorded: Sequence[RunRecord]) -> Any:
    import xarray

    runs = [run for run in recorded if run.started and run.samples]
    if not runs:
        return xarray.Dataset()
    coords = _places("sample", runs, [run.samples for run in runs])
    coords["time_s"] = _variable("sample", np.concatenate([run.time_s for run in runs]), "s")
    coords["time_s"][2]["comment"] = _IN_RUN
    values = {
        channel.name: _variable(
            "sample", np.concatenate([run.signal_V(channel.name) for run in runs]), channel.raw_unit
        )
        for channel in runs[0].signals
    }
    return xarray.Dataset(values, coords=coords)


def _curves(measurements: Measurements) -> Any:
    import xarray

    found = list(_all_curves(measurements))
    if not found:
        return xarray.Dataset()
    points = max(len(curve.s_m) for _, _, curve in found)
    values = {
        name: _variable(("curve", "point"), _padded(found, name, points), unit)
        for name, unit in _CURVE_UNITS.items()
    }
    conditions = [condition for condition, _, _ in found]
    positions = [np.nan if c.position_m is None else c.position_m for c in conditions]
    coords = {
        "configuration": ("curve", np.array([c.configuration for c in conditions]), {}),
        "position_m": _variable("curve", positions, "m"),
        "voltage_V": _variable("curve", [c.voltage_V for c in conditions], "V"),
        "reading_index": ("curve", [reading for _, reading, _ in found], {}),
    }
    coords["reading_index"][2]["comment"] = f"{FROM_0}; -1: the curve of the mean image"
    for name, column in _of_conditions(conditions).items():
        coords[name] = ("curve", column, {})
    coords["again"][2]["comment"] = "how often the same place was measured before"
    return xarray.Dataset(values, coords=coords)


def _of_conditions(conditions: Sequence[Condition]) -> dict[str, Any]:
    """Return what tells apart conditions of the same place and voltage."""
    return {
        "again": [c.run for c in conditions],
        "mounting": [c.mounting for c in conditions],
        "approach": np.array([c.approach for c in conditions], dtype=str),
    }


def _all_curves(measurements: Measurements) -> Iterator[tuple[Condition, int, Curve]]:
    for condition in measurements.conditions:
        if condition.curve is not None:
            yield condition, -1, condition.curve
        for reading in condition.readings:
            if reading.curve is not None:
                yield condition, reading.index, reading.curve


def _padded(found: Sequence[tuple[Condition, int, Curve]], name: str, points: int) -> Any:
    rows = np.full((len(found), points), np.nan)
    for row, (_, _, curve) in zip(rows, found, strict=True):
        values = getattr(curve, name)
        if values is not None:
            row[: len(values)] = values
    return rows
