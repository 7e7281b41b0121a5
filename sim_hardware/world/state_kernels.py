"""The sheet's inner state in time, compiled. Import this where it is used.

The state: voltage across the sheet (V); moment relative to the settled one at +2 V, as the water
would allow; how unevenly the water lies (1: as after a rest, 0: as under voltage); time spent
under voltage since the last wetting, in s at 2 V; the moment's slow follower, which relaxes it, as
the mean of three; these three; time spent under voltage since the beginning, in s at 2 V.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import brief_jit

if TYPE_CHECKING:
    from sim_hardware.world.settings import WorldSettings

Floats = npt.NDArray[np.float64]

VOLTAGE, MOMENT, UNEVEN, DRY_S, RELAXED, QUICK, MIDDLE, SLOW, DRIVEN_S = range(9)
COLUMNS = 9

# Voltage at which half of what drives the water is there.
_HALF_V = 0.5


class StateRules(NamedTuple):
    """The parameters of the state's movement."""

    rise_s: float
    build_up_s: float
    saturation_V: float
    negative_ratio: float
    spread_s: float
    return_s: float
    relaxation_s: float
    relaxation_spread: float
    spread_order: int


def rules_of(settings: WorldSettings) -> StateRules:
    """Return a world's."""
    e, w = settings.eibm, settings.water
    return StateRules(
        rise_s=settings.electrical.rise_time_s,
        build_up_s=e.build_up_s,
        saturation_V=e.saturation_V,
        negative_ratio=e.negative_ratio,
        spread_s=w.spread_s,
        return_s=w.return_s,
        relaxation_s=e.relaxation_s,
        relaxation_spread=e.relaxation_spread,
        spread_order=w.spread_order,
    )


@brief_jit
def _step(now: Floats, drive: float, dt: float, r: StateRules, new: Floats) -> None:
    """Fill the state `new` after `dt`, the amplifier at `drive` on average: exponential steps."""
    voltage, moment, uneven = now[VOLTAGE], now[MOMENT], now[UNEVEN]
    voltage = drive + (voltage - drive) * math.exp(-dt / r.rise_s)
    aim = math.tanh(voltage / r.saturation_V) / math.tanh(2.0 / r.saturation_V)
    if aim < 0.0:
        aim *= r.negative_ratio
    moment = aim + (moment - aim) * math.exp(-dt / r.build_up_s)
    active = voltage * voltage / (voltage * voltage + _HALF_V * _HALF_V)
    back = (1.0 - active) / r.return_s
    away = active / r.spread_s
    if r.spread_order == 2:
        away *= uneven
    rate = back + away
    uneven = back / rate + (uneven - back / rate) * math.exp(-rate * dt)
    new[VOLTAGE], new[MOMENT], new[UNEVEN] = voltage, moment, uneven
    driven_s = abs(voltage) / 2.0 * dt
    new[DRY_S], new[DRIVEN_S] = now[DRY_S] + driven_s, now[DRIVEN_S] + driven_s
    tau = r.relaxation_s
    new[QUICK] = moment + (now[QUICK] - moment) * math.exp(-dt * r.relaxation_spread / tau)
    new[MIDDLE] = moment + (now[MIDDLE] - moment) * math.exp(-dt / tau)
    new[SLOW] = moment + (now[SLOW] - moment) * math.exp(-dt / (tau * r.relaxation_spread))
    new[RELAXED] = (new[QUICK] + new[MIDDLE] + new[SLOW]) / 3.0


@brief_jit
def advance(states: Floats, drive: Floats, dt: float, rules: StateRules) -> None:
    """Fill `states` (n + 1, COLUMNS) from its first row on: n steps with mean `drive` (n,)."""
    for k in range(drive.shape[0]):
        _step(states[k], drive[k], dt, rules, states[k + 1])


@brief_jit
def part_steps(states: Floats, drive: Floats, dt: Floats, rules: StateRules) -> Floats:
    """States (n, COLUMNS) after a step of its own from each of `states`, likewise."""
    result = np.empty_like(states)
    for k in range(drive.shape[0]):
        _step(states[k], drive[k], dt[k], rules, result[k])
    return result


@brief_jit
def follow(inputs: Floats, start: Floats, dt: float, times_s: Floats) -> Floats:
    """Means of lags, one for each of `times_s`, behind what moves: (n, m, lags).

    `inputs` (n, m): what moves, at the end of each step; `start` (m, lags): the lags before.
    """
    n, m = inputs.shape
    lags = times_s.shape[0]
    result = np.empty((n, m, lags))
    for j in range(lags):
        kept = math.exp(-dt / times_s[j])
        for i in range(m):
            at = start[i, j]
            for k in range(n):
                at = inputs[k, i] + (at - inputs[k, i]) * kept
                result[k, i, j] = at
    return result


@brief_jit
def turn_stops(moved: Floats, before: Floats, start: Floats, reach: Floats) -> Floats:
    """Elements that follow what they hang on until they are turned by their reach, then slip.

    `moved` (n, m): where the m things that they hang on are; `before` (m,), `start` (m,): these
    and the elements before that; `reach` (m,). Returns how far each is turned (n, m).
    """
    turned = np.empty_like(moved)
    for m in range(reach.shape[0]):
        at, last = start[m], before[m]
        for k in range(moved.shape[0]):
            at = min(reach[m], max(-reach[m], at + moved[k, m] - last))
            last = moved[k, m]
            turned[k, m] = at
    return turned
