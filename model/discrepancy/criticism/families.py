"""Group the rows of the data by quantity (force, curve, trend along a run, pulse) and voltage."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model_fit import MixedModelFit

MEANS = ("force", "neutral curve")


@dataclass(frozen=True)
class Family:
    """Rows of one quantity in one configuration at one voltage."""

    quantity: str  # "force", "neutral curve", "course of a run" or "course of a pulse"
    configuration: str
    voltage_V: float
    rows: Index


def families(fitted: MixedModelFit, without: Collection[int] = ()) -> list[Family]:
    """Return all families; conditions `without`, by number over all, are in none."""
    return [one for one in _each(fitted, without) if len(one.rows)]


def _each(fitted: MixedModelFit, without: Collection[int]) -> Iterator[Family]:
    forward, first = fitted.problem.forward, 0
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        name = configuration_model.sheet.configuration
        zero = np.array([one.zero for one in configuration_model.data_vector.seen], dtype=bool)
        used = ~zero & ~np.isin(first + np.arange(configuration_model.K), list(without))
        for voltage_V in np.unique(configuration_model.voltage_V).tolist():
            here = used & (configuration_model.voltage_V == voltage_V)
            trend, course = here[block.trend_of], here[block.trend_of] & ~block.is_mean
            force = block.trend_rows[block.is_mean & trend]
            yield Family("force", name, voltage_V, force)
            modes = block.mode_rows[here & configuration_model.has_curve].ravel()
            yield Family("neutral curve", name, voltage_V, modes)
            run = np.concatenate([block.trend_rows[course], block.sway_rows[here[block.sway_of]]])
            yield Family("course of a run", name, voltage_V, run)
            yield Family("course of a pulse", name, voltage_V, block.bin_rows[here[block.bin_of]])
        first += configuration_model.K


def joined(some: Collection[Family]) -> Index:
    """Return the rows of several families."""
    none = np.zeros(0, dtype=np.int64)
    return np.sort(np.concatenate([none, *(one.rows for one in some)]))
