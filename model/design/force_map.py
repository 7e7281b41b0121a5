"""Forces of a sheet over positions and voltages, and the sheet cut to another size."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray, ModelError, in_volts
from model.sheet.beam_problem import ConditionProblem
from model.sheet.sheet_model import SheetModel
from model.sheet.solution import SolvedProblems, solved


@dataclass(frozen=True, kw_only=True)
class ForceMap:
    """Over positions (P,) and voltages (V,); NaN where the place is not reachable."""

    position_m: FloatArray
    voltage_V: FloatArray
    tangential_N: FloatArray  # (P, V) F
    normal_N: FloatArray  # (P, V) along the arc's normal, outward positive
    s_hat_m: FloatArray
    reachable: npt.NDArray[np.bool_]
    setups: list[ConditionProblem]  # position after position, each at all voltages
    solved: SolvedProblems

    def all_reachable(self) -> bool:
        """Return whether every place is reachable at every voltage."""
        return bool(np.all(self.reachable))


_kept: ContextVar[dict[str, ForceMap] | None] = ContextVar("_kept", default=None)


@contextmanager
def keeping_maps() -> Iterator[None]:
    """Keep each map until the end of the block: many questions ask for the same ones."""
    token = _kept.set({})
    try:
        yield
    finally:
        _kept.reset(token)


def force_map(
    model: SheetModel, configuration: str, position_m: npt.ArrayLike, voltage_V: npt.ArrayLike
) -> ForceMap:
    """Solve all combinations at once."""
    p, V = np.atleast_1d(np.asarray(position_m, float)), np.atleast_1d(np.asarray(voltage_V, float))
    kept = _kept.get()
    if kept is None:
        return _solved_map(model, configuration, p, V)
    # a model file states neither its session nor the length that its sheet was cut from
    beside_file = [model.session, dict(model.cut_from_m)]
    key = json.dumps([model.to_dict(), beside_file, configuration, p.tolist(), V.tolist()])
    if key not in kept:
        kept[key] = _solved_map(model, configuration, p, V)
    return kept[key]


def _solved_map(model: SheetModel, configuration: str, p: FloatArray, V: FloatArray) -> ForceMap:
    if model.effects:
        setups = model.setups(configuration, [(float(x), float(v)) for x in p for v in V])
    else:
        by_voltage = [model.setup(configuration, float(p[0]), float(v)) for v in V]
        R, origin = by_voltage[0].sheet.arc_radius_m, by_voltage[0].sheet.arc_origin_rad
        setups = [replace(one, angle_rad=origin + float(x) / R) for x in p for one in by_voltage]
    found = solved(setups)
    shape = (len(p), len(V))
    # along the sheet's normal N; the arc's outward normal is its tangent turned back by 90 degrees
    normal = -found.normal_N * np.sin(found.gamma_rad)
    return ForceMap(
        position_m=p, voltage_V=V, tangential_N=found.force_N.reshape(shape),
        normal_N=normal.reshape(shape), s_hat_m=found.s_hat_m.reshape(shape),
        reachable=found.reachable.reshape(shape), setups=setups, solved=found,
    )  # fmt: skip


def reached(found: ForceMap, column: int | None = None) -> ForceMap:
    """Return the map, or an error where part of it, or of one column, is not reachable."""
    asked = np.ones_like(found.reachable)
    if column is not None:
        asked[:, :column] = asked[:, column + 1 :] = False
    missed = np.argwhere(asked & ~found.reachable)
    if len(missed):
        i, j = missed[0]
        raise ModelError(
            f"the working section is not reachable everywhere: not {found.position_m[i] * 1e3:.3g}"
            f" mm at {in_volts(found.voltage_V[j])}; make the section smaller or the sheet longer"
        )
    return found


def section(low_m: float, high_m: float, count: int = 61) -> FloatArray:
    """Return positions of a working section."""
    if not (np.isfinite(low_m) and np.isfinite(high_m) and low_m < high_m):
        raise ModelError(
            f"a working section needs a beginning below its end, not {low_m * 1e3:g} to"
            f" {high_m * 1e3:g} mm"
        )
    return np.linspace(low_m, high_m, count)


def known_voltages(model: SheetModel, configuration: str) -> FloatArray:
    """Return the driving voltages of the model, and 0 V."""
    return np.array(sorted({0.0, *model.sheet(configuration).eibm}))


def resized(
    model: SheetModel, configuration: str, length_m: float, elongation_m: float
) -> SheetModel:
    """Return the same material with another free length and elongation.

    Each place along the sheet keeps its material, effects included. Beyond the measured length the
    material is assumed to be the same as at its end.
    """
    if not (np.isfinite(length_m) and length_m > 0.0 and elongation_m >= 0.0):
        raise ModelError("a sheet needs a positive length, and an elongation of zero or more")
    one = model.sheet(configuration)
    sheet = replace(one.sheet, free_length_m=length_m, elongation_m=elongation_m)
    measured_m = model.cut_from_m.get(configuration, one.sheet.free_length_m)
    return replace(
        model,
        sheets={configuration: replace(one, sheet=sheet)},
        cut_from_m={configuration: measured_m},
        fitted={},
    )
