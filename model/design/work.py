"""Quasi-static work of a sheet that moves an object along the arc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.design.force_map import force_map, known_voltages, reached, section
from model.design.propagation import propagate
from model.measurements import FloatArray
from model.parameter import Parameter
from model.sheet.sheet_model import SheetModel

POINTS = 61  # an odd number, for Simpson's rule


@dataclass(frozen=True)
class WorkAlongArc:
    """Work on the object over a section, in J; the object moves slowly."""

    outward_J: dict[float, Parameter]  # by voltage: the integral of F dp from low to high
    cycle_J: Parameter  # there at the highest voltage, and back at the lowest
    voltages_V: tuple[float, float]  # lowest and highest


def work_along_arc(
    model: SheetModel, configuration: str, low_m: float, high_m: float
) -> WorkAlongArc:
    """Return the work at each voltage of the model, and that of a cycle.

    The object is held at each position by a force that balances the sheet's. In a cycle it moves
    from `low_m` to `high_m` at the highest voltage, and back at the lowest.
    """
    p, volts = section(low_m, high_m, POINTS), known_voltages(model, configuration)

    def question(changed: SheetModel) -> list[float]:
        force_N = reached(force_map(changed, configuration, p, volts)).tangential_N
        along = _integral(force_N, p)
        return [*map(float, along), float(along[-1] - along[0])]

    *along, cycle = propagate(model, configuration, question, ("J",) * (len(volts) + 1))
    outward = {float(v): one for v, one in zip(volts, along, strict=True)}
    return WorkAlongArc(outward, cycle, (float(volts[0]), float(volts[-1])))


def _integral(values: FloatArray, p: FloatArray) -> FloatArray:
    """Return the integral over p of values (positions, voltages), by Simpson's rule."""
    weights = np.full(len(p), 2.0)
    weights[1::2] = 4.0
    weights[[0, -1]] = 1.0
    result: FloatArray = weights @ values * (p[1] - p[0]) / 3.0
    return result
