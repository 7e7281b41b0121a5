"""Whether two sheets, and the arcs of their load cells, have the same measures."""

from __future__ import annotations

import math
from typing import NamedTuple

from model.measurements.data import SheetGeometry

_SAME = 1e-6  # m, rad
_LENGTHS = ("free_length_m", "width_m", "thickness_m", "elongation_m", "arc_radius_m")


class GeometryDifference(NamedTuple):
    """A measure that two sheets do not share, with both values as people read them."""

    measure: str
    first: str
    second: str


def geometry_difference(first: SheetGeometry, second: SheetGeometry) -> GeometryDifference | None:
    """Return the first measure in which they differ; None: in none. k0 is not compared."""
    for key in _LENGTHS:
        a, b = getattr(first, key), getattr(second, key)
        if abs(a - b) > _SAME:
            measure = key.removesuffix("_m").replace("_", " ")
            return GeometryDifference(measure, f"{1e3 * a:g} mm", f"{1e3 * b:g} mm")
    a, b = first.arc_origin_rad, second.arc_origin_rad
    if abs(a - b) > _SAME:
        return GeometryDifference(
            "begin of the arc", f"{math.degrees(a):g} degrees", f"{math.degrees(b):g} degrees"
        )
    return None
