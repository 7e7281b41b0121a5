"""Effects that can act in one sense alone: no step of a fit leads beyond where they are gone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model.effects.interface import EffectParameter
from model.identification.likelihood.linearisation import Linearisation
from model.identification.likelihood.mixed_model import Solution
from model.identification.likelihood.model_state import Found

HELD = 1e12  # times what the data say of a parameter: its step is given


def within_range(
    linear: Linearisation,
    found: Sequence[Found],
    spans: Sequence[slice],
    solution: Solution,
    share: float = 1.0,
) -> Linearisation:
    """Return the linearisation with such steps cut short; the same where there are none.

    An effect that is asked for in the other sense ends at nothing, the other parameters with it;
    what a further step promises is no merit of its. `share` of the way to nothing is gone: none at
    the end of a fit, which is judged where it stands. `spans` are the columns of each effect.
    """
    steps = {
        place: step
        for one, span in zip(found, spans, strict=True)
        for place, (parameter, names) in enumerate(one.parameters(), span.start)
        if (step := _to_nothing(parameter, one.values[names[0]][parameter.name])) is not None
        and (solution.beta[place] - step) * _outward(parameter) > 0.0
    }
    if not steps:
        return linear
    held = list(steps)
    precision, away = linear.data.precision.copy(), linear.data.away.copy()
    precision[held] = HELD / np.diag(solution.covariance)[held]
    away[held] = [-share * step for step in steps.values()]
    return replace(linear, data=replace(linear.data, precision=precision, away=away))


def _to_nothing(parameter: EffectParameter, value: float) -> float | None:
    """Return the step to where an effect is gone, if that is an end of its range.

    A length or time at whose infinity nothing is left stands in the denominator there: as far as a
    straight line in its logarithm goes, a step of one takes all of it away.
    """
    if parameter.log:
        return 1.0 if parameter.neutral == np.inf else None
    if parameter.neutral not in (parameter.low, parameter.high):
        return None
    return parameter.neutral - value


def _outward(parameter: EffectParameter) -> float:
    """Return the sense of steps out of the range there."""
    return -1.0 if parameter.neutral == parameter.low else 1.0
