"""Forces of a sheet over positions and voltages, and the sheet cut to another size."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray, ModelError
from model.mechanics.equilibrium import SolverStatus
from model.parameter import Parameter
from model.sheet.beam_problem import ConditionProblem
from model.sheet.configured_sheet import Along, ConfiguredSheet
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
    key = json.dumps([model.to_dict(), configuration, p.tolist(), V.tolist()])
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
        reachable=(found.status == SolverStatus.SOLVED).reshape(shape), setups=setups, solved=found,
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
            f"the working section is not reachable everywhere: not {found.position_m[i] * 1e3:g} mm"
            f" at {found.voltage_V[j]:+g} V; make the section smaller or the sheet longer"
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
    )


def varied(one: ConfiguredSheet, B: float, bending: dict[float, float]) -> ConfiguredSheet:
    """B and, for each voltage, Me/B multiplied by factors."""
    eibm = {
        v: Along(a.s_m, a.values * B * bending.get(v, 1.0), a.sigma, a.unit)
        for v, a in one.eibm.items()
    }
    return replace(one, B=replace(one.B, value=one.B.value * B), eibm=eibm)


def propagate(
    model: SheetModel,
    configuration: str,
    question: Callable[[SheetModel], Sequence[float]],
    units: Sequence[str],
) -> list[Parameter]:
    """Answers with the uncertainty of B, the EIBMs, k0 and the effects' parameters.

    Forces fix B, shapes fix Me/B, so these two are varied independently, and each parameter of an
    effect by itself. Uncertainties of an effect's inferred form are not in it.
    """
    one = model.sheet(configuration)
    values = np.array(question(model))
    stiff = one.B.sigma / one.B.value
    pairs = [(varied(one, 1.0 + stiff, {}), varied(one, 1.0 - stiff, {}))]
    for voltage, along in one.eibm.items():
        share = _relative(along)
        own = np.sqrt(max(share**2 - stiff**2, 0.1 * share**2))
        pairs.append(
            (varied(one, 1.0, {voltage: 1.0 + own}), varied(one, 1.0, {voltage: 1.0 - own}))
        )
    if np.any(one.rest.sigma > 0.0):
        off = float(np.sqrt(np.mean(one.rest.sigma**2)))
        rests = [replace(one.rest, values=one.rest.values + sign * off) for sign in (1.0, -1.0)]
        pairs.append((replace(one, rest=rests[0]), replace(one, rest=rests[1])))
    variance = np.zeros(len(values))
    models = [
        [replace(model, sheets={**model.sheets, configuration: sheet}) for sheet in pair]
        for pair in pairs
    ]
    for both in [*models, *_of_effects(model, configuration)]:
        moved = [np.array(question(changed)) for changed in both]
        if not np.all(np.isfinite(moved)):
            raise ModelError(
                "within the uncertainty of the model's parameters this question has no answer; make"
                " the working section smaller or the demand lower"
            )
        variance += (0.5 * (moved[0] - moved[1])) ** 2
    return [
        Parameter(value=float(v), sigma=float(np.sqrt(s)), unit=unit)
        for v, s, unit in zip(values, variance, units, strict=True)
    ]


def _of_effects(model: SheetModel, configuration: str) -> Iterator[list[SheetModel]]:
    """Yield for each uncertain parameter of an effect two models, at both ends of its interval."""
    for place, effect in enumerate(model.effects):
        before, after = model.effects[:place], model.effects[place + 1 :]
        for ends in effect.varied(configuration):
            yield [replace(model, effects=(*before, one, *after)) for one in ends]


def _relative(along: Along) -> float:
    """Return uncertainty of a moment's mean, relative to it."""
    mean = float(np.mean(np.abs(along.values)))
    return float(np.sqrt(np.mean(along.sigma**2))) / mean if mean else 0.0
