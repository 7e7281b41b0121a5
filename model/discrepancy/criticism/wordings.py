"""Wordings of an effect: forms that another laboratory may mean by its name.

The catalogue has one form of each effect, with a tolerance. Others may write it without any
deviation, alike on all sheets, or let a fault of the load cell act in contact alone, as a zero does
that was taken after the sheet was touched. Evidence and imitation are compared in the best wording
of each, so that no name is preferred for the one in which the catalogue has it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from model.discrepancy.search.evidence import Candidate, Projected, averaged, candidates, score
from model.effects import Effect
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray


def wordings(fitted: MixedModelFit, effect: Effect) -> Iterator[list[Candidate]]:
    """Yield the shapes of an effect in each wording, as columns at a model."""
    away = without_contact(fitted.problem.forward)[:, None]
    stated = candidates(fitted, [effect])
    every = [stated, *(_exact(stated, sizes) for sizes in (2, 1)[not effect.by_configuration :])]
    yield from every
    if any(np.any(one.columns * away) for one in stated):
        for some in every:
            touching = [replace(one, columns=np.where(away, 0.0, one.columns)) for one in some]
            yield [one for one in touching if np.any(one.columns[:, 0])]


def _exact(stated: Sequence[Candidate], sizes: int) -> list[Candidate]:
    """Return shapes without deviations: a size for each configuration, or one for all."""
    return [replace(one, columns=one.columns[:, :sizes]) for one in stated]


def without_contact(forward: ForwardModel) -> npt.NDArray[np.bool_]:
    """Return which rows are readings of the load cell that touches nothing, (N,)."""
    result = np.zeros(forward.row_index.size, dtype=bool)
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        free = np.isnan(configuration_model.stated_m) | np.array(
            [one.zero for one in configuration_model.data_vector.seen], dtype=bool
        )
        result[block.trend_rows[free[block.trend_of]]] = True
        result[block.bin_rows[free[block.bin_of]]] = True
    return result


def evidence(
    before: MixedModelFit, log_sigma: FloatArray, effects: Sequence[Effect]
) -> dict[str, float]:
    """Return ln of the Bayes factor of each effect in its best wording, averaged over its shapes.

    At the model `before` any of them, and the noise that is estimated beside the one that is named.
    """
    forward = before.problem.forward
    projected = Projected.of(forward, before.linear, weigh(before.linear.data, log_sigma))
    result = {}
    for effect in effects:
        each = [
            averaged([score(forward, projected, one).log_bayes for one in shapes])
            for shapes in wordings(before, effect) if shapes
        ]  # fmt: skip
        if each:
            result[effect.name] = max(each)
    return result
