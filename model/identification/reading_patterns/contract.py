"""The contract of a pattern in the readings: what they have in common and their means do not show.

`diagnose` looks at the readings of a condition by their mean and slow trends. What is left of them
says how noisy the load cell is. A pattern is what is in there and is no noise: a wave, readings
that lack the same share. It is looked for once, in all readings of a session, before the search.
What was found is taken out where the noise is estimated, and adds basis shapes to a location.
"""

# ruff: noqa: ARG002 - the method that a pattern overrides does nothing with what it is given

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from model.identification.data.data_vector import DataVector, Index, Which
from model.locations.contract import Basis, Linearised
from model.locations.quantities import AcquisitionTimes
from model.measurements import FloatArray, RigScale


@dataclass(frozen=True, kw_only=True)
class ReadingsOf:
    """The readings of one configuration, condition by condition in time order."""

    configuration: str
    force_N: FloatArray  # (n,)
    clock: AcquisitionTimes  # (n,)
    reading_of: Index  # (n,) condition of each reading


@dataclass(frozen=True, kw_only=True)
class ReadingsOfCondition:
    """The readings of one condition in time order."""

    force_N: FloatArray  # (n,)
    by_eibm_N: float  # mean less that at 0 V in the same run; 0: at 0 V; NaN: not known


class FoundPattern(Protocol):
    """A pattern that was found in the readings of a session."""

    @property
    def location(self) -> str:
        """Return the location of discrepancy whose nonparametric term has its basis shapes."""

    def without(self, readings: ReadingsOf) -> FloatArray:
        """Return the forces without the pattern, (n,) N: what the load cell's noise is seen in."""

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """Return its basis shapes in one configuration, as a location's own `bases` does."""

    def in_other_data(self, data_vectors: Sequence[DataVector]) -> FoundPattern:
        """Return the same pattern in data with more or other readings of the same session."""


@dataclass(frozen=True, kw_only=True)
class ReadingPattern:
    """A kind of pattern."""

    name: str  # also of its file
    meaning: str  # a noun phrase
    order: int  # in which they are looked for

    def found_in(self, data_vectors: Sequence[DataVector], scale: RigScale) -> FoundPattern | None:
        """Return what there is of it; None where there is nothing.

        `data_vectors` has the readings of each configuration. Lengths and forces in a pattern's
        own code are multiplied by `scale`. In noise alone nothing may be found.
        """
        return None

    def not_outliers(self, conditions: Sequence[ReadingsOfCondition]) -> list[Which]:
        """Return of each condition which readings (n,) may be far from the others: none.

        It is asked before readings that are far from the others are left out as outliers.
        """
        return [np.zeros(len(one.force_N), dtype=bool) for one in conditions]
