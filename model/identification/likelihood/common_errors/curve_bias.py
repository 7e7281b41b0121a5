"""What all curves of a sheet are off alike: columns of the base model with narrow priors.

Images of one sheet in one light mislead alike, so that many of them say no more than one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.model_state import ModelState
from model.measurements import FloatArray


@dataclass(frozen=True, kw_only=True)
class CurveBias:
    """A bias of each mode of the curves of each configuration, as base parameters."""

    first: int  # place
    curve_m: float  # how well curves are known, however many images there are
    modes: tuple[int, ...]  # by configuration; 0 without curves

    @property
    def sigma(self) -> list[float]:
        """Return their standard uncertainties, m."""
        return [self.curve_m] * sum(self.modes) if self.curve_m > 0.0 else []

    def rows(self, forward: ForwardModel, c: int, state: ModelState) -> FloatArray:  # noqa: ARG002
        """Return the rows of one configuration by each of them, (N, q)."""
        columns = np.zeros((forward.row_index.size, sum(self.modes)))
        block, seen = forward.row_index.blocks[c], forward.configuration_models[c].has_curve
        for m, place in enumerate(range(sum(self.modes[:c]), sum(self.modes[: c + 1]))):
            columns[block.mode_rows[seen, m], place] = 1.0
        return columns
