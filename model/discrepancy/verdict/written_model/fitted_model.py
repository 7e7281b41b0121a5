"""The fitted parameters with their uncertainty, and the model with them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from model.discrepancy.prepare import Options
from model.discrepancy.thresholds import INTERVAL_FREEDOM
from model.discrepancy.verdict.written_model.written_deviations import deviations
from model.discrepancy.verdict.written_model.written_form import with_bands
from model.effects.catalogue import origins
from model.effects.interface import EffectParameter
from model.identification.base_model import weighs
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.model_state import Found
from model.measurements import Measurements
from model.parameter import Parameter
from model.sheet.beam_problem import UNKNOWN, ActiveEffect
from model.sheet.configured_sheet import Along, ConfiguredSheet, FittedPositions
from model.sheet.free_effect import FreeEffect
from model.sheet.sheet_model import SheetModel


def sheet_model(final: MixedModelFit, measurements: Measurements, options: Options) -> SheetModel:
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
        sheets=sheets, effects=tuple(_active(f, final) for f in final.found),
        source=measurements.source, checksum=measurements.checksum, held_out=held,
        deviations=together, fitted=dict(_fitted_positions(final)),
    )  # fmt: skip


def _fitted_positions(final: MixedModelFit) -> Iterator[tuple[str, FittedPositions]]:
    forward = final.problem.forward
    for name, one in zip(forward.names, forward.configuration_models, strict=True):
        fitted = FittedPositions.of(one.stated_m[one.touching].tolist())
        if fitted is not None:
            yield name, fitted


def _active(one: Found, final: MixedModelFit) -> ActiveEffect:
    form = with_bands(one, final)
    if isinstance(one.effect, FreeEffect):
        return ActiveEffect(name=UNKNOWN, location=one.effect.location, form=form)
    own = {name: parameters_of(one, name, final) for name in one.values}
    shared = not one.effect.by_configuration
    return ActiveEffect(
        name=one.effect.name,
        parameters=next(iter(own.values())) if shared else {},
        by_configuration={} if shared else own,
        form=form,
        distribution=origins().get(one.effect.name, ""),
    )


def parameters_of(one: Found, configuration: str, final: MixedModelFit) -> dict[str, Parameter]:
    """Return an effect's values with their uncertainty, derived ones included."""
    values = dict(one.values[configuration])
    sigma = one.sigma.get(configuration, {})
    result = {
        k.name: Parameter(
            value=values[k.name],
            sigma=sigma.get(k.name, _step(k)),
            unit=k.unit,
            freedom=INTERVAL_FREEDOM,
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
            sigma=abs(slope) * sigma.get(size, 0.0),
            unit=unit,
            freedom=INTERVAL_FREEDOM,
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
    forward, part = final.problem.forward, final.problem.bases.parts[c]
    configuration_model, theta = forward.configuration_models[c], final.theta
    sigma = np.sqrt(np.maximum(np.diag(final.solution.covariance), 0.0))
    B = float(np.exp(theta[part.stiffness]))
    share = (
        float(sigma[part.stiffness]) if weighs(configuration_model.data_vector) else 1.0
    )  # then nothing is known
    stiffness = Parameter(value=B, sigma=B * share, unit="N m^2", freedom=INTERVAL_FREEDOM)
    stated = configuration_model.sheet.initial_curvature
    if stated is not None:
        along = Along(stated[0], stated[1], np.zeros(len(stated[0])), "1/m")
    else:
        rest = configuration_model.rest(configuration_model.s_m)
        for i, row in part.rest.items():
            rest = rest + theta[i] * row
        along = Along(configuration_model.s_m, rest, np.zeros(len(rest)), "1/m")
    eibm = {}
    for volts, (i, sign) in part.eibm.items():
        level = B * float(theta[i])
        relative = np.hypot(sigma[part.stiffness], sigma[i] / max(abs(theta[i]), 1e-9))
        value = Parameter(
            value=sign * level,
            sigma=abs(level) * float(relative),
            unit="N m",
            freedom=INTERVAL_FREEDOM,
        )
        eibm[volts] = Along.constant(value)
    geometry = replace(configuration_model.sheet, initial_curvature=(along.s_m, along.values))
    return ConfiguredSheet(geometry, stiffness, along, eibm)


def base_parameters(final: MixedModelFit) -> dict[str, dict[str, Parameter]]:
    """B and EIBM of each configuration, by the names that people see; their ratio without forces.

    Where nothing was weighed shapes know no more.
    """
    result = {}
    for c, name in enumerate(final.problem.forward.names):
        sheet = _sheet(final, c)
        known = weighs(final.problem.forward.data_vectors[c])
        own = {"B_Nm2": sheet.B} if known else {}
        what, unit = ("EIBM", "N m") if known else ("EIBM/B", "1/m")
        scale = 1.0 if known else 1.0 / sheet.B.value
        for volts, along in sorted(sheet.eibm.items()):
            own[f"{what} {volts:+g} V"] = Parameter(
                value=scale * float(along.values[0]),
                sigma=scale * float(along.sigma[0]),
                unit=unit,
                freedom=INTERVAL_FREEDOM,
            )
        result[name] = own
    return result
