"""Write the tables of curves: curves.csv has a row for each point, summary.csv for each image."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from labrig.errors import BadInputError
from labrig.files import write_bytes
from labrig.vision.curve import NeutralCurve
from labrig.vision.image.names import PictureLabel

LabelledCurve = tuple[PictureLabel, NeutralCurve]
Cells = dict[str, str]
_FIRST_BYTES, _TELLING = 200, 2  # of a table, and the columns that tell whose it is

COLUMNS = ("image", "point", "s_mm", "x_mm", "y_mm", "curvature_per_m", "sigma_mm",
           "curvature_sigma_per_m", "state", "frame", "time_s", "reason", "strip")  # fmt: skip
SUMMARY_COLUMNS = ("image", "frame", "time_s", "state", "tip_x_mm", "tip_y_mm", "tip_sigma_mm",
                   "tip_angle_deg", "mean_curvature_per_m", "covered", "reason",
                   "warnings", "strip", "length_mm", "length_sigma_mm",
                   "thickness_mm")  # fmt: skip


def write_points(path: Path, curves: Iterable[LabelledCurve]) -> None:
    """Write a row for each point, and one for each picture without a curve (state `refused`)."""
    _write(path, COLUMNS, (row for label, curve in curves for row in _points(label, curve)))


def write_summary(path: Path, curves: Iterable[LabelledCurve]) -> None:
    """Write a line for each picture: tip, mean curvature, length, or why there is no curve."""
    _write(path, SUMMARY_COLUMNS, (_summary(label, curve) for label, curve in curves))


def refuse_other_tables(points: Path, summary: Path) -> None:
    """Raise BadInputError where one of these would be written over a table of something else."""
    for path, columns in ((points, COLUMNS), (summary, SUMMARY_COLUMNS)):
        if path.is_file():
            with path.open("rb") as file:
                first = file.read(_FIRST_BYTES)
            if not first.startswith(",".join(columns[:_TELLING]).encode()):
                raise BadInputError(
                    f"{path}: this is no table of an earlier batch, and would be overwritten; give "
                    "another folder."
                )


def tip_angle_rad(curve: NeutralCurve) -> float:
    """Return the direction of the tip against the x axis; turns are counted on from the clamp."""
    steps = np.unwrap(np.arctan2(np.diff(curve.y_m), np.diff(curve.x_m)))
    # a step has the direction of its middle
    return float(steps[-1] + 0.5 * curve.curvature_per_m[-1] * (curve.s_m[-1] - curve.s_m[-2]))


def mean_curvature_per_m(curve: NeutralCurve) -> float:
    """Return the mean along the free length: a rigid elongation does not count."""
    free_m = curve.free_length_m or curve.s_m[-1]
    s_m = np.append(curve.s_m[curve.s_m < free_m], min(free_m, curve.s_m[-1]))
    if len(s_m) < 2:
        return float(curve.curvature_per_m[0])
    k = np.interp(s_m, curve.s_m, curve.curvature_per_m)
    return float(np.trapezoid(k, s_m) / s_m[-1])


def _points(label: PictureLabel, curve: NeutralCurve) -> Iterator[Cells]:
    about = _about(label)
    if not curve.ok:
        yield about | {"state": "refused", "reason": curve.why}
    for point in range(len(curve.s_m)):
        yield about | {
            "point": str(point),
            "s_mm": f"{1e3 * curve.s_m[point]:.6f}",
            "x_mm": f"{1e3 * curve.x_m[point]:.6f}",
            "y_mm": f"{1e3 * curve.y_m[point]:.6f}",
            "curvature_per_m": f"{curve.curvature_per_m[point]:.5f}",
            "sigma_mm": f"{1e3 * curve.sigma_m[point]:.7f}",
            "curvature_sigma_per_m": f"{curve.curvature_sigma_per_m[point]:.5f}",
            "state": "seen" if curve.seen[point] else "bridged",
        }


def _summary(label: PictureLabel, curve: NeutralCurve) -> Cells:
    about = _about(label)
    if not curve.ok:
        return about | {"state": "refused", "reason": curve.why}
    return about | {
        "state": "found",
        "tip_x_mm": f"{1e3 * curve.x_m[-1]:.6f}",
        "tip_y_mm": f"{1e3 * curve.y_m[-1]:.6f}",
        "tip_sigma_mm": f"{1e3 * curve.sigma_m[-1]:.7f}",
        "tip_angle_deg": f"{math.degrees(tip_angle_rad(curve)):.4f}",
        "mean_curvature_per_m": f"{mean_curvature_per_m(curve):.5f}",
        "covered": f"{curve.covered:.4f}",
        "warnings": "; ".join(curve.warnings),
        "length_mm": f"{1e3 * curve.s_m[-1]:.6f}",
        "length_sigma_mm": f"{1e3 * curve.end_sigma_m:.6f}" if curve.end_sigma_m else "",  # stated
        "thickness_mm": f"{1e3 * curve.thickness_m:.6f}" if curve.thickness_m else "",
    }


def _about(label: PictureLabel) -> Cells:
    return {
        "image": label.name,
        "strip": label.strip,
        "frame": "" if label.frame is None else str(label.frame),
        "time_s": "" if label.time_s is None else f"{label.time_s:.6f}",
    }


def _write(path: Path, names: Sequence[str], rows: Iterable[Cells]) -> None:
    text = io.StringIO()
    writer = csv.DictWriter(text, names, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_bytes(path, text.getvalue().encode("utf-8"))
