"""The sixth question of section 5: the sheet of least area, and the effect of an elongation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from model.design.force_map import force_map, known_voltages, resized, section
from model.design.propagation import propagate
from model.design.strength import (
    ELONGATION_R,
    Direction,
    elongated_lengths_m,
    lengths_alone_m,
    shortest_alone_m,
    strength,
)
from model.measurements import FloatArray, ModelError
from model.parameter import Parameter
from model.sheet.sheet_model import SheetModel

LENGTHS = 20


@dataclass(frozen=True, kw_only=True)
class Size:
    """6: the sheet of least area that gives a force everywhere in the section."""

    length_m: float
    width_m: Parameter
    area_m2: Parameter
    elongation_m: float  # 0: without
    # what was searched: free lengths, and the area that each needs (inf: not possible)
    lengths_m: FloatArray
    areas_m2: FloatArray


def least_area(
    model: SheetModel,
    configuration: str,
    low_m: float,
    high_m: float,
    force_N: float,
    elongated: bool,
    direction: Direction = "both",
) -> Size:
    """6: the best length first, for force over width does not depend on the width; then the width.

    `elongated`: with a rigid elongation that reaches the object wherever the sheet does not. The
    material keeps its properties along the sheet from the clamp on.
    """
    if not (np.isfinite(force_N) and force_N > 0.0):
        raise ModelError("the required force must be a positive number")
    R, p = model.sheet(configuration).sheet.arc_radius_m, section(low_m, high_m, 31)
    extra = ELONGATION_R * R if elongated else 0.0
    if elongated:
        lengths = elongated_lengths_m(model, configuration, LENGTHS)
    else:
        shortest_m = _shortest(model, configuration, p)
        lengths = lengths_alone_m(model, configuration, shortest_m, LENGTHS)

    def area(changed: SheetModel, length: float) -> float:
        weakest = float(np.min(strength(changed, configuration, length, extra, p, direction)))
        return length * force_N / weakest if weakest > 0.0 else np.inf

    areas = np.array([area(model, float(length)) for length in lengths])
    if not np.any(np.isfinite(areas)):
        raise ModelError(
            f"no sheet of this material gives a force of {force_N * 1e3:g} mN ({direction} ways)"
            f" over the whole section, {'with' if elongated else 'without'} elongation"
        )
    best = _refined(lambda length: area(model, length), lengths, areas)

    def question(changed: SheetModel) -> list[float]:
        need = area(changed, best)
        return [need / best, need]

    width, need = propagate(model, configuration, question, ("m", "m^2"))
    return Size(
        length_m=best,
        width_m=width,
        area_m2=need,
        elongation_m=_elongation(model, configuration, best, extra, p),
        lengths_m=lengths,
        areas_m2=areas,
    )


def _shortest(model: SheetModel, configuration: str, p: FloatArray) -> float:
    """Return the length that reaches the whole section; raise ModelError where none does."""
    needed = shortest_alone_m(model, configuration, p)
    i = int(np.argmax(needed))
    if not np.isfinite(needed[i]):
        raise ModelError(
            f"no length of this sheet reaches {p[i] * 1e3:g} mm at all voltages, the uncertainty of"
            " its parameters included; make the section smaller"
        )
    return float(needed[i])


def _elongation(
    model: SheetModel, configuration: str, length: float, extra: float, p: FloatArray
) -> float:
    """Return the part of the elongation that is needed."""
    if extra == 0.0:
        return 0.0
    found = force_map(
        resized(model, configuration, length, extra), configuration, p,
        known_voltages(model, configuration),
    )  # fmt: skip
    return max(0.0, float(np.max(found.s_hat_m)) - length)


def _refined(area: Callable[[float], float], lengths: FloatArray, areas: FloatArray) -> float:
    """Return the best length between its neighbours on the grid."""
    from scipy.optimize import minimize_scalar  # slow to import

    i = int(np.argmin(areas))
    low, high = lengths[max(i - 1, 0)], lengths[min(i + 1, len(lengths) - 1)]
    found = minimize_scalar(area, bounds=(low, high), method="bounded", options={"xatol": 1e-5})
    return float(found.x) if found.fun <= areas[i] else float(lengths[i])


@dataclass(frozen=True)
class Linearity:
    """Effect of an elongation: error of the best line through F(p) against the sheet's length."""

    lengths_m: FloatArray  # of the sheet; the rest up to the arc is elongation
    relative_error: FloatArray  # RMS error over the range of F; NaN: not reachable
    slope_N_per_m: FloatArray
    voltage_V: float


def linearity(
    model: SheetModel, configuration: str, low_m: float, high_m: float, voltage_V: float = 0.0
) -> Linearity:
    """Return the same material with ever less sheet and ever more elongation."""
    R, p = model.sheet(configuration).sheet.arc_radius_m, section(low_m, high_m, 41)
    lengths = np.append(np.linspace(0.1 * R, R, 10), 1.25 * R)
    errors, slopes = np.full(len(lengths), np.nan), np.full(len(lengths), np.nan)
    for i, length in enumerate(lengths):
        changed = resized(
            model, configuration, float(length), ELONGATION_R * R if length <= R else 0.0
        )
        found = force_map(changed, configuration, p, voltage_V)
        if found.all_reachable():
            force = found.tangential_N[:, 0]
            line = np.polyfit(p, force, 1)
            errors[i] = np.sqrt(np.mean((np.polyval(line, p) - force) ** 2)) / np.ptp(force)
            slopes[i] = line[0]
    return Linearity(lengths, errors, slopes, voltage_V)
