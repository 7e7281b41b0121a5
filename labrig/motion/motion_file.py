"""A motion as a file: NXdata in HDF5, or a CSV table.

HDF5: `entry/motion` holds what goes with time alone, `entry/shape` curvature and place along the
sheet (times, points), `entry/simulation` what it was made from. The CSV table has the points of the
shape in columns x_m[i], y_m[i], curvature_per_m[i], evenly from the clamp to the end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from labrig.errors import BadInputError
from labrig.files import SESSION_ENDINGS
from labrig.motion.simulated import SimulatedRun
from labrig.session.format import layout
from labrig.session.recording.disk import written_beside
from labrig.session.recording.hdf5 import create_group, put_text, put_text_list, set_attributes
from model.dynamics import SheetMotion

HDF5_ENDINGS, CSV_ENDING = SESSION_ENDINGS, ".csv"
# column, unit, what it is
OVER_TIME = (
    ("drive_V", "V", "voltage of the source; at an edge that before it"),
    ("sheet_V", "V", "voltage between the electrodes at the clamp"),
    ("current_A", "A", "current"),
    ("force_N", "N", "force on the rolls along the arc"),
    ("normal_N", "N", "force on the rolls normal to the sheet"),
    ("s_hat_m", "m", "place of the rolls along the sheet"),
    ("phi_hat_rad", "rad", "direction of the sheet at the rolls"),
    ("reading_N", "N", "force as the load cell follows it"),
)
ALONG_SHEET = (
    ("x_m", "m", "x"),
    ("y_m", "m", "y"),
    ("curvature_per_m", "1/m", "curvature"),
)
_LAST = "reading_N"  # behind the shape, in a table


def require_ending(path: Path) -> None:
    """Raise BadInputError where a name says no kind of file."""
    if path.suffix.lower() not in (*HDF5_ENDINGS, CSV_ENDING):
        raise BadInputError(f"{path}: a motion's name must end in .h5 (HDF5) or .csv.")


def write_motion(run: SimulatedRun, made_from: Mapping[str, str], path: Path) -> None:
    """Write a motion beside its place and rename it; the ending chooses HDF5 or CSV.

    made_from: texts that say what the motion was computed from (HDF5). Raises LabrigError.
    """
    with written_beside(path) as beside:
        if path.suffix.lower() == CSV_ENDING:
            with beside.open("w", encoding="utf-8", newline="") as table:
                table.writelines(_lines(run.motion))
        else:
            with h5py.File(beside, "x", libver=layout.LIBVER) as file:
                _fill(file, run, made_from)


def _lines(motion: SheetMotion) -> Iterator[str]:
    """Yield the lines of a table."""
    names, columns = ["time_s"], [motion.time_s[:, None]]
    scalars = {name: getattr(motion, name)[:, None] for name, _, _ in OVER_TIME}
    reading = scalars.pop(_LAST)
    names += scalars
    columns += scalars.values()
    for name, _, _ in ALONG_SHEET:
        columns.append(getattr(motion, name))
        names += [f"{name}[{point}]" for point in range(len(motion.s_m))]
    yield ",".join([*names, _LAST]) + "\n"
    for row in np.hstack([*columns, reading]):
        yield ",".join("" if np.isnan(value) else f"{value:.9g}" for value in row) + "\n"


def _fill(file: Any, run: SimulatedRun, made_from: Mapping[str, str]) -> None:
    """Write it into a file that is open and empty."""
    set_attributes(file, NX_class="NXroot", default="entry")
    entry = create_group(file, "entry", "NXentry")
    set_attributes(entry, default="motion")
    put_text(entry, "title", f"simulated motion: {run.place}")
    made = create_group(entry, "simulation", "NXprocess")
    for name, text in {"configuration": run.configuration, **made_from}.items():
        put_text(made, name, text)
    if run.position_m is not None:
        _dataset(made, "position_m", np.float64(run.position_m), "m", "of the load cell")
    _over_time(entry, run)
    _shape(entry, run.motion)


def _over_time(entry: Any, run: SimulatedRun) -> None:
    group = create_group(entry, "motion", "NXdata")
    signal = "current_A" if run.position_m is None else "force_N"
    set_attributes(group, signal=signal)
    put_text_list(group, "axes", ["time_s"])
    others = [name for name, _, _ in OVER_TIME if name != signal]
    put_text_list(group, "auxiliary_signals", others)
    _dataset(group, "time_s", run.motion.time_s, "s", "time")
    for name, unit, text in OVER_TIME:
        _dataset(group, name, getattr(run.motion, name), unit, text)


def _shape(entry: Any, motion: SheetMotion) -> None:
    group = create_group(entry, "shape", "NXdata")
    set_attributes(group, signal="curvature_per_m")
    put_text_list(group, "axes", ["time_s", "s_m"])
    put_text_list(group, "auxiliary_signals", ["x_m", "y_m"])
    group["time_s"] = entry["motion/time_s"]
    _dataset(group, "s_m", motion.s_m, "m", "distance from the clamp along the sheet")
    for name, unit, text in ALONG_SHEET:
        _dataset(group, name, getattr(motion, name), unit, text)


def _dataset(group: Any, name: str, values: Any, unit: str, text: str) -> None:
    packed = {"compression": "gzip", "shuffle": True} if np.ndim(values) else {}
    dataset = group.create_dataset(name, data=values, dtype="<f8", **packed)
    set_attributes(dataset, units=unit, long_name=f"{text} ({unit})")
