"""How far the EIBM changes along a run, which a fit of means does not know.

The first pulses of a run are weaker, and the sheet dries: each reading has an EIBM of its own, and
the fit has that of their mean. What it is at any one of them differs by this much.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from model.identification.data.data_vector import ConditionData
from model.identification.joint import Joint
from model.measurements import FloatArray

BY_CHANCE = 0.01  # probability of a change as large by noise alone, from which on there is none


def eibm_along_runs(joint: Joint, n: int) -> dict[float, float]:
    """Return the standard deviation of single readings' EIBM, relative, by voltage.

    It is of what all runs have in common, by the order of their readings, beyond the noise; 0
    where it may be noise alone, or there is one reading at a voltage, or one run: what its noise
    is cannot be told then.
    """
    data_vector, by_eibm_N = joint.forward.data_vectors[n], joint.fitted.linear.states[n].by_eibm
    result = {}
    for voltage in data_vector.voltages_V:
        pairs = zip(data_vector.seen, by_eibm_N.tolist(), strict=True)
        own = [(one, by) for one, by in pairs if one.voltage_V == voltage and _repeated(one)]
        result[voltage] = _scatter(list(_same_length(own)))
    return result


def _repeated(one: ConditionData) -> bool:
    return not (one.free or one.zero or one.identical) and len(one.kept_N) > 1


def _same_length(own: list[tuple[ConditionData, float]]) -> Iterator[tuple[FloatArray, float]]:
    """Yield the deviations from the mean of as many readings of each condition as all have."""
    count = min((len(one.kept_N) for one, _ in own), default=0)
    for one, by in own:
        first = one.kept_N[:count]
        yield first - first.mean(), by


def _scatter(own: list[tuple[FloatArray, float]]) -> float:
    """Return the scatter over the readings of their EIBM, relative, beyond the noise."""
    from scipy.special import fdtrc  # slow to import

    weight = sum(by**2 for _, by in own)
    if weight <= 0.0 or len(own) < 2:
        return 0.0
    away = np.array([row for row, _ in own])
    by = np.array([one for _, one in own])[:, None]
    change = (by * away).sum(axis=0) / weight  # by the order of the readings, least squares
    count = len(change)
    left = away - by * change
    degrees = max((len(own) - 1) * (count - 1), 1)
    noise = float(np.sum(left**2)) / degrees / weight
    scatter = float(np.sum(change**2)) / (count - 1)
    if noise > 0.0 and fdtrc(count - 1, degrees, scatter / noise) > BY_CHANCE:
        return 0.0
    return float(np.sqrt(max(scatter - noise, 0.0)))
