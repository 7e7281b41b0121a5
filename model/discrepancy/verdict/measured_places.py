"""What a model says of the conditions that were measured: `predict` of many places at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.measurements import FloatArray, ModelError
from model.sheet.instruments import LoadCellReadings, as_imaged, camera_m
from model.sheet.prediction import Predictable
from model.sheet.solution import sampled_s, solved


@dataclass(frozen=True, kw_only=True)
class Seen:
    """Mean force and curve of a condition, as load cell and camera show them."""

    F_N: float
    s_m: FloatArray
    x_m: FloatArray
    y_m: FloatArray


def seen_at(
    model: Predictable, configuration: str, places: Sequence[tuple[float, float]]
) -> list[Seen]:
    """Return what is seen at positions and voltages; raise `ModelError` where one is not reachable.

    It is what `predict` says of each of them.
    """
    every = dict.fromkeys(
        (at_m, volts)
        for at_m, asked in places
        for volts in model.alternating_voltages_V(configuration, asked)
    )
    rows = {place: k for k, place in enumerate(every)}
    found = solved(model.setups(configuration, list(rows)))
    if not np.all(found.reachable):
        raise ModelError("with the model's effects a measured condition is not reachable")
    positions_m = [at_m for at_m, _ in rows]
    s_m = sampled_s(found.setups[0])
    shapes, result = found.shapes(s_m), list[Seen]()
    cell = LoadCellReadings.of(model.effects, found, positions_m)
    for at_m, volts in places:
        k = rows[at_m, volts]
        beside = model.alternating_voltages_V(configuration, volts)
        own = {v: rows[at_m, v] for v in beside}
        added_N = 0.0 if cell is None else cell.added_N(own, volts)
        then = as_imaged(found.setups[k], model.effects, at_m)
        late = then is not found.setups[k]
        seen, row = (solved([then]), 0) if late else (found, k)
        curve = seen.shapes(s_m) if late else shapes
        dx_m, dy_m = camera_m(model.effects, seen, curve, row)
        result.append(
            Seen(
                F_N=float(found.force_N[k]) + added_N, s_m=s_m, x_m=curve.x_m[row] + dx_m,
                y_m=curve.y_m[row] + dy_m,
            )
        )  # fmt: skip
    return result
