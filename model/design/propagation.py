"""Answers with the uncertainty of the parameters of the model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from model.design.deviated import deviated
from model.measurements import FloatArray, ModelError
from model.parameter import Parameter
from model.sheet.configured_sheet import Along, ConfiguredSheet
from model.sheet.deviations import STIFFNESS, USUAL_FREEDOM
from model.sheet.sheet_model import SheetModel

# two models to both sides, and how many standard uncertainties each is away
Pair = tuple[SheetModel, SheetModel, float]
FARTHEST = 0.3  # relative, that B is moved: without B there is no sheet


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
    together = model.deviations.get(configuration)
    pairs = _apart(model, configuration) if together is None else _joint(model, configuration)
    steps = np.array([_step(question, pair) for pair in pairs]).reshape(-1, len(values))
    sigma = np.sqrt(np.sum(steps**2, axis=0))
    freedom = np.full(len(values), USUAL_FREEDOM) if together is None else together.freedom(steps)
    return [
        Parameter(value=float(v), sigma=float(s), unit=unit, freedom=float(f))
        for v, s, f, unit in zip(values, sigma, freedom, units, strict=True)
    ]


def _step(question: Callable[[SheetModel], Sequence[float]], pair: Pair) -> FloatArray:
    """Return what one standard uncertainty changes of the answers."""
    *models, away = pair
    moved = [np.array(question(changed)) for changed in models]
    if not np.all(np.isfinite(moved)):
        raise ModelError(
            "within the uncertainty of the model's parameters this question has no answer; make"
            " the working section smaller or the demand lower"
        )
    return np.asarray(0.5 * (moved[0] - moved[1]) / away)


def _joint(model: SheetModel, configuration: str) -> Iterator[Pair]:
    """Yield two models for each column of the deviations."""
    together, B = model.deviations[configuration], model.sheet(configuration).B.value
    for place in range(len(together)):
        change = together.column(place)
        away = _near(change.get(STIFFNESS, 0.0) / B)
        plus, minus = (deviated(model, configuration, change, sign) for sign in (away, -away))
        yield plus, minus, away


def _near(relative: float) -> float:
    """Return how many times a relative change of B is taken, so that B stays positive."""
    return min(1.0, FARTHEST / abs(relative)) if relative else 1.0


def _apart(model: SheetModel, configuration: str) -> Iterator[Pair]:
    """Yield two models for each parameter, varied by itself."""
    yield from _of_sheet(model, configuration)
    yield from _of_effects(model, configuration)


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
    away = _near(stiff)
    pairs = [(varied(one, 1.0 + away * stiff, {}), varied(one, 1.0 - away * stiff, {}), away)]
    for voltage, along in one.eibm.items():
        share = _relative(along)
        own = np.sqrt(max(share**2 - stiff**2, 0.1 * share**2))
        pairs.append(
            (varied(one, 1.0, {voltage: 1.0 + own}), varied(one, 1.0, {voltage: 1.0 - own}), 1.0)
        )
    if np.any(one.rest.sigma > 0.0):
        off = float(np.sqrt(np.mean(one.rest.sigma**2)))
        rests = [replace(one.rest, values=one.rest.values + sign * off) for sign in (1.0, -1.0)]
        pairs.append((replace(one, rest=rests[0]), replace(one, rest=rests[1]), 1.0))
    for high, low, away in pairs:
        yield (
            replace(model, sheets={**model.sheets, configuration: high}),
            replace(model, sheets={**model.sheets, configuration: low}),
            away,
        )


def _of_effects(model: SheetModel, configuration: str) -> Iterator[Pair]:
    """Yield for each uncertain parameter of an effect two models, at both ends of its interval."""
    for place, effect in enumerate(model.effects):
        before, after = model.effects[:place], model.effects[place + 1 :]
        for high, low in effect.varied(configuration):
            yield (
                replace(model, effects=(*before, high, *after)),
                replace(model, effects=(*before, low, *after)),
                1.0,
            )


def _relative(along: Along) -> float:
    """Return uncertainty of a moment's mean, relative to it."""
    mean = float(np.mean(np.abs(along.values)))
    return float(np.sqrt(np.mean(along.sigma**2))) / mean if mean else 0.0
