"""Uncertainty of the rise common to all pulses: columns beside the base model.

The rise at the sheet is stated, but not to the last per cent; whoever stamped the samples may have
stamped all of them half an interval late; and while the voltage crosses 0 the EIBM may follow its
own polarity, or go straight from one settled value to the other. None of it is an effect.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.effects.interface import AcquisitionTimes
from model.effects.rise import rise_left, through_zero
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.model_state import ModelState
from model.measurements import FloatArray

LATE, LONGER, STRAIGHT = 2.0, 0.03, (0.5, 0.5)
# mean and width of each: edges late, in units of what is known of one of them; the rise's time
# constant longer, relative; how far the EIBM crosses 0 as the voltage does
RISE = ((0.0, LATE), (0.0, LONGER), STRAIGHT)


def rise_columns(forward: ForwardModel, c: int, state: ModelState) -> FloatArray:
    """Rows of one configuration by each of `RISE`, (N, 3)."""
    block, none = forward.row_block(c), forward.no_step(c)
    rise = max(forward.configuration_models[c].sheet.rise_time_s, 1e-3)
    # against the sampling point, at which the EIBM is what it is said to be
    there, sample = (_changes(k, rise, block.edge_s) for k in (block.bin_clock, block.bin_sample))
    rows = [
        forward.rows_of(c, state, replace(none, bin_eibm=-block.bin_mean(one - other)))
        for one, other in zip(there, sample, strict=True)
    ]
    return np.stack(rows, axis=1)


def _changes(clock: AcquisitionTimes, rise_s: float, late_s: float) -> list[FloatArray]:
    """Of what is missing of the settled EIBM."""
    left = rise_left(clock, rise_s, 0.0)
    return [
        rise_left(clock, rise_s, late_s) - left,
        (rise_left(clock, 1.01 * rise_s, 0.0) - left) / 0.01,
        rise_left(through_zero(clock), rise_s, 0.0) - left,
    ]
