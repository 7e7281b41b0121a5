"""The fitted parameters with their uncertainty, and the model with them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from model.discrepancy.prepare import DiagnoseOptions
from model.discrepancy.verdict.written_model.effect_uncertainty import uncertainties
from model.discrepancy.verdict.written_model.written_deviations import deviations
from model.discrepancy.verdict.written_model.written_form import with_bands
from model.effects.catalogue import origins
from model.effects.interface import EffectParameter
from model.identification.base_model import weighs
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray, Measurements
from model.parameter import Parameter
from model.sheet.beam_problem import UNKNOWN, ActiveEffect
from model.sheet.configured_sheet import Along, ConfiguredSheet, FittedPositions
from model.sheet.deviations import USUAL_FREEDOM
from model.sheet.free_effect import FreeEffect
from model.sheet.sheet_model import SheetModel


def sheet_model(
    final: MixedModelFit, measurements: Measurements, options: DiagnoseOptions
) -> SheetModel:
    """Return the model with the effects found and their forms."""
    forward = final.problem.forward
    sheets = {name: _sheet(final, c) for c, name in enumerate(forward.names)}
    together = {
        name: deviations(final, c)
        for c, name in enumerate(forward.names)
        if weighs(forward.data_vectors[c])
    }
    held = tuple(f"{name or 'all'}, {at * 1e3:g} mm" for name, at in options.hold_out)
    return SheetModel(
        sheets=sheets, effects=tuple(_active(final, i) for i in range(len(final.found))),
        source=measurements.source, checksum=measurements.checksum, held_out=held,
        deviations=together, fitted=dict(_fitted_positions(final)),
    )  # fmt: skip


def _fitted_positions(final: MixedModelFit) -> Iterator[tuple[str, FittedPositions]]:
    forward = final.problem.forward
    for name, one in zip(forward.names, forward.configuration_models, strict=True):
        fitted = FittedPositions.of(one.stated_m[one.touching].tolist())
        if fitted is not None:
            yield name, fitted


def _active(final: MixedModelFit, place: int) -> ActiveEffect:
    one = final.found[place]
    form = with_bands(one, final)
    if isinstance(one.effect, FreeEffect):
        return ActiveEffect(name=UNKNOWN, location=one.effect.location, form=form)
    own = {name: parameters_of(final, place, name) for name in one.values}
    shared = not one.effect.by_configuration
    return ActiveEffect(
        name=one.effect.name,
        parameters=next(iter(own.values())) if shared else {},
        by_configuration={} if shared else own,
        form=form,
        distribution=origins().get(one.effect.name, ""),
    )


def parameters_of(final: MixedModelFit, place: int, configuration: str) -> dict[str, Parameter]:
    """Return an effect's values with their uncertainty, derived ones included."""
    one = final.found[place]
    values = dict(one.values[configuration])
    unsure = uncertainties(final, place, configuration)
    result = {
        k.name: Parameter(
            value=values[k.name],
            sigma=unsure[k.name].sigma if k.name in unsure else _step(k),
            unit=k.unit,
            freedom=unsure[k.name].freedom if k.name in unsure else USUAL_FREEDOM,
            positive=k.log,
            low=k.low,
            high=k.high,
        )
        for k in one.effect.parameters
    }
    forward = final.problem.forward
    sheet = forward.configuration_models[forward.names.index(configuration)].sheet
    derived = one.effect.derived(values, sheet)
    amplitude = one.effect.amplitude
    size = amplitude.name
    h = 0.01 * abs(values[size]) or 1e-9
    moved = one.effect.derived({**values, size: values[size] + h}, sheet)
    ends = [
        one.effect.derived({**values, size: end}, sheet) if np.isfinite(end) else {}
        for end in (amplitude.low, amplitude.high)
    ]
    for name, value in derived.items():
        slope = (moved[name] - value) / h
        unit = one.effect.extra.get(name, "")
        low, high = _bounds(ends[0].get(name), ends[1].get(name), rising=slope > 0.0)
        result[name] = Parameter(
            value=value,
            sigma=abs(slope) * result[size].sigma,
            unit=unit,
            freedom=result[size].freedom,
            low=low,
            high=high,
        )
    return result


def _bounds(first: float | None, last: float | None, *, rising: bool) -> tuple[float, float]:
    """Return the bounds of a derived quantity from its values at those of the amplitude."""
    low, high = (first, last) if rising else (last, first)
    return (-np.inf if low is None else low, np.inf if high is None else high)


def _step(parameter: EffectParameter) -> float:
    """Uncertainty of a place that was only tried here and there: it may be anywhere between."""
    if parameter.unit != "mm" or len(parameter.starting_values) < 2:
        return 0.0
    return float(np.max(np.diff(parameter.starting_values)) / np.sqrt(3.0))


def _sheet(final: MixedModelFit, c: int) -> ConfiguredSheet:
    """B, k0 and EIBM of one configuration."""
    part, theta = final.problem.bases.parts[c], final.theta
    configuration_model = final.problem.forward.configuration_models[c]
    stated = configuration_model.sheet.initial_curvature
    if stated is not None:
        along = Along(stated[0], stated[1], np.zeros(len(stated[0])), "1/m")
    else:
        rest = configuration_model.rest(configuration_model.s_m)
        for i, row in part.rest.items():
            rest = rest + theta[i] * row
        along = Along(configuration_model.s_m, rest, np.zeros(len(rest)), "1/m")
    geometry = replace(configuration_model.sheet, initial_curvature=(along.s_m, along.values))
    eibm = {volts: Along.constant(_eibm(final, c, volts)) for volts in part.eibm}
    return ConfiguredSheet(geometry, _stiffness(final, c), along, eibm)


def _stiffness(final: MixedModelFit, c: int) -> Parameter:
    """B; as uncertain as it is large where nothing was weighed."""
    i = final.problem.bases.parts[c].stiffness
    B = float(np.exp(final.theta[i]))
    found = final.parameter(B, _row(final, {i: B}), "N m^2")
    return found if _weighs(final, c) else replace(found, sigma=B)


def _eibm(final: MixedModelFit, c: int, volts: float) -> Parameter:
    """EIBM at a voltage; as uncertain as B where nothing was weighed."""
    part = final.problem.bases.parts[c]
    stiffness, (i, sign) = _stiffness(final, c), part.eibm[volts]
    by_ratio = sign * stiffness.value
    value = by_ratio * float(final.theta[i])
    if _weighs(final, c):
        return final.parameter(value, _row(final, {part.stiffness: value, i: by_ratio}), "N m")
    return final.parameter(value, _row(final, {i: by_ratio}), "N m", more=abs(value))


def _eibm_ratio(final: MixedModelFit, c: int, volts: float) -> Parameter:
    """EIBM/B at a voltage."""
    i, sign = final.problem.bases.parts[c].eibm[volts]
    return final.parameter(sign * float(final.theta[i]), _row(final, {i: float(sign)}), "1/m")


def _weighs(final: MixedModelFit, c: int) -> bool:
    return weighs(final.problem.forward.data_vectors[c])


def _row(final: MixedModelFit, derivatives: Mapping[int, float]) -> FloatArray:
    """Return a quantity's derivatives by all parameters."""
    row: FloatArray = np.zeros(len(final.solution.beta))
    for i, value in derivatives.items():
        row[i] = value
    return row


def base_parameters(final: MixedModelFit) -> dict[str, dict[str, Parameter]]:
    """B and EIBM of each configuration, by the names that people see; their ratio without forces.

    Where nothing was weighed shapes know no more.
    """
    result = {}
    for c, name in enumerate(final.problem.forward.names):
        voltages = sorted(final.problem.bases.parts[c].eibm)
        if _weighs(final, c):
            own = {f"EIBM {volts:+g} V": _eibm(final, c, volts) for volts in voltages}
            result[name] = {"B_Nm2": _stiffness(final, c), **own}
        else:
            result[name] = {f"EIBM/B {v:+g} V": _eibm_ratio(final, c, v) for v in voltages}
    return result
