"""Answers with the uncertainty of the parameters of the model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from model.design.deviated import deviated
from model.measurements import FloatArray, ModelError
from model.parameter import Parameter
from model.sheet.configured_sheet import Along, ConfiguredSheet
from model.sheet.deviations import USUAL_FREEDOM
from model.sheet.sheet_model import SheetModel

Pair = tuple[SheetModel, SheetModel]  # a standard uncertainty away, to both sides


def propagate(
    model: SheetModel,
    configuration: str,
    question: Callable[[SheetModel], Sequence[float]],
    units: Sequence[str],
) -> list[Parameter]:
    """Answers with the uncertainty of B, the EIBMs, k0 and the effects.

    Where the model says how these are uncertain together, all of them change at once, independent
    deviations one by one. Otherwise each parameter is varied by itself.
    """
    values = np.array(question(model))
    steps, freedom = [], list[float]()
    for pair, degrees in _pairs(model, configuration):
        moved = [np.array(question(changed)) for changed in pair]
        if not np.all(np.isfinite(moved)):
            raise ModelError(
                "within the uncertainty of the model's parameters this question has no answer; make"
                " the working section smaller or the demand lower"
            )
        steps.append(0.5 * (moved[0] - moved[1]))
        freedom.append(degrees)
    parts = np.array(steps).reshape(-1, len(values)) ** 2
    variance = parts.sum(axis=0)
    together = _freedom(variance, parts, np.array(freedom))
    return [
        Parameter(value=float(v), sigma=float(np.sqrt(s)), unit=unit, freedom=float(f))
        for v, s, f, unit in zip(values, variance, together, units, strict=True)
    ]


def _freedom(variance: FloatArray, parts: FloatArray, freedom: FloatArray) -> FloatArray:
    """Return Satterthwaite's degrees of freedom of sums of independent variances."""
    doubt = np.sum(parts**2 / freedom[:, None], axis=0)
    return np.asarray(np.minimum(variance**2 / np.maximum(doubt, 1e-300), USUAL_FREEDOM))


def _pairs(model: SheetModel, configuration: str) -> Iterator[tuple[Pair, float]]:
    """Yield two models for each independent uncertainty, and its degrees of freedom."""
    together = model.deviations.get(configuration)
    if together is None:
        for pair in (*_of_sheet(model, configuration), *_of_effects(model, configuration)):
            yield pair, USUAL_FREEDOM
        return
    for place, degrees in enumerate(together.freedom.tolist()):
        change = together.column(place)
        plus, minus = (deviated(model, configuration, change, sign) for sign in (1.0, -1.0))
        yield (plus, minus), degrees


def varied(one: ConfiguredSheet, B: float, bending: dict[float, float]) -> ConfiguredSheet:
    """B and, for each voltage, Me/B multiplied by factors."""
    eibm = {
        v: Along(a.s_m, a.values * B * bending.get(v, 1.0), a.sigma, a.unit)
        for v, a in one.eibm.items()
    }
    return replace(one, B=replace(one.B, value=one.B.value * B), eibm=eibm)


def _of_sheet(model: SheetModel, configuration: str) -> Iterator[Pair]:
    """Yield models with B, an EIBM or k0 a standard uncertainty higher and lower.

    Forces fix B, shapes fix Me/B, so these two are varied independently.
    """
    one = model.sheet(configuration)
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
    for high, low in pairs:
        yield (
            replace(model, sheets={**model.sheets, configuration: high}),
            replace(model, sheets={**model.sheets, configuration: low}),
        )


def _of_effects(model: SheetModel, configuration: str) -> Iterator[Pair]:
    """Yield for each uncertain parameter of an effect two models, at both ends of its interval."""
    for place, effect in enumerate(model.effects):
        before, after = model.effects[:place], model.effects[place + 1 :]
        for high, low in effect.varied(configuration):
            yield (
                replace(model, effects=(*before, high, *after)),
                replace(model, effects=(*before, low, *after)),
            )


def _relative(along: Along) -> float:
    """Return uncertainty of a moment's mean, relative to it."""
    mean = float(np.mean(np.abs(along.values)))
    return float(np.sqrt(np.mean(along.sigma**2))) / mean if mean else 0.0
