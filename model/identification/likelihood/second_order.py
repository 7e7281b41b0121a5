"""What a large change in time does to the rows beyond the first order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.effects.rise import rise_left
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.model_state import ModelState
from model.identification.likelihood.row_index import RowBlock
from model.identification.likelihood.time_courses import in_means, in_parts
from model.measurements import FloatArray
from model.sheet.effect_hooks import MOST_LOST, Acting, course

LEVELS = np.array([-1.2, -0.6, 0.0, 0.4, 0.7, 0.85, 1.0, 1.15])  # the last but one: as it is
# from the level as it is, down and up: numbers of the levels that are passed
WAYS_FROM_ONE = ((5, 4, 3, 2, 1, 0), (7,))


def beyond_first_order(
    configuration_model: ConfigurationModel,
    block: RowBlock,
    state: ModelState,
    inner: Sequence[Acting],
    size: int,
) -> FloatArray:
    """Return the difference (N,) from the first-order rows, which are linear in EIBM and stiffness.

    Only Me/B shapes a sheet, so with factors a of the EIBM and b of B the force is b F(a/b). There
    are `size` rows.
    """
    y = np.zeros(size)
    if state.response is None:
        return y
    of, (eibm, stiffness) = block.reading_of, in_means(configuration_model, inner)
    driven = block.clock.voltage_V != 0.0
    a, b = np.ones(len(of)), np.ones(len(of))
    for one in inner:
        found = course(one, block.clock)
        if found is not None:
            a, b = a + found[0], b + found[1]
    there = _Course.of(a, b, eibm[of] * driven, stiffness[of])
    force = np.nan_to_num(state.solved.force_N)
    first = force[of] + state.by_eibm[of] * there.eibm
    first = first + (force - state.by_eibm)[of] * there.stiffness
    powers = _powers(state.response)
    exact = there.force(powers[:, of])
    y[block.trend_rows] = block.trend @ np.nan_to_num(exact - first)
    bent = np.where(driven, there.ratio - 1.0 - there.eibm + there.stiffness, 0.0)
    y[block.sway_rows] = block.sway @ (bent * state.reach_m[of])
    mean = block.mean(bent)
    y[block.mode_rows[configuration_model.has_curve]] = (state.modes_by_eibm * mean[:, None])[
        configuration_model.has_curve
    ]
    y[block.bin_rows] = _in_pulses(configuration_model, block, state, inner, powers)
    return y


def _in_pulses(
    configuration_model: ConfigurationModel,
    block: RowBlock,
    state: ModelState,
    inner: Sequence[Acting],
    powers: FloatArray,
) -> FloatArray:
    """Return the same for the parts of the pulses, relative to their sampling points: (b,)."""
    of, rise = block.bin_of, max(configuration_model.sheet.rise_time_s, 1e-6)
    eibm, stiffness = in_means(configuration_model, inner)
    force, slope = np.nan_to_num(state.solved.force_N[of]), state.by_eibm[of]
    both = []
    at_sample = 1.0 - block.bin_mean(rise_left(block.bin_sample, rise, 0.0))
    for number, clock in enumerate((block.bin_clock, block.bin_sample)):
        a = (1.0 - block.bin_mean(rise_left(clock, rise, 0.0))) / at_sample
        b = np.ones_like(a)
        for one in inner:
            change = in_parts(block, one)[number]
            a, b = a + change[0], b + change[1]
        there = _Course.of(a, b, eibm[of], stiffness[of])
        first = slope * there.eibm + (force - slope) * there.stiffness
        both.append(there.force(powers[:, of]) - first)
    return np.nan_to_num(both[0] - both[1])


def _powers(response: FloatArray) -> FloatArray:
    """Coefficients (L, K) of the force as a polynomial of the EIBM's share, less one."""
    return np.asarray(np.linalg.solve(np.vander(LEVELS - 1.0), response.T))


@dataclass(frozen=True)
class _Course:
    """EIBM and stiffness against those with which the beam was solved."""

    eibm: FloatArray  # to first order
    stiffness: FloatArray
    ratio: FloatArray  # of Me/B
    b: FloatArray  # of B

    @staticmethod
    def of(a: FloatArray, b: FloatArray, eibm: FloatArray, stiffness: FloatArray) -> _Course:
        """Return the course of factors `a`, `b`; `eibm` and `stiffness` are solved already."""
        a, b = np.maximum(a, 1.0 - MOST_LOST), np.maximum(b, 1.0 - MOST_LOST)
        b_more = b / (1.0 + stiffness)
        return _Course(a - 1.0 - eibm, b - 1.0 - stiffness, a / (1.0 + eibm) / b_more, b_more)

    def force(self, powers: FloatArray) -> FloatArray:
        """Return the force b F(a/b), F a polynomial (L, n)."""
        share = np.vander(self.ratio - 1.0, len(LEVELS)).T
        result: FloatArray = self.b * np.sum(powers * share, axis=0)
        return result
