"""Find the patterns in readings: the files of `kinds`, and those of other distributions.

A file adds one by its constant `PATTERN`; another distribution by an entry point of the group
`labrig.reading_patterns`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import cast

import numpy as np

from model.identification.data.data_vector import DataVector, Which
from model.identification.foreign_parts import answers_of
from model.identification.reading_patterns.contract import (
    FoundPattern,
    ReadingPattern,
    ReadingsOf,
    ReadingsOfCondition,
)
from model.locations.contract import Basis, Linearised
from model.measurements import FloatArray, RigScale
from model.plugins import OWN, Part, PluginFolder


def _faults(part: object) -> list[str]:
    from model.identification.reading_patterns.conformance import faults

    return faults(part)


FOLDER: PluginFolder[ReadingPattern] = PluginFolder(
    what="pattern in the readings",
    package="model.identification.reading_patterns.kinds",
    constant="PATTERN",
    group="labrig.reading_patterns",
    faults=_faults,
)


_WITHOUT = "the search goes on"


def reading_patterns() -> dict[str, ReadingPattern]:
    """Return all of them by name, in their order."""
    found = FOLDER.parts()
    names = sorted(found, key=lambda n: found[n].part.order)
    return {
        name: found[name].part if found[name].distribution == OWN else _of_others(found[name])
        for name in names
    }


@dataclass(frozen=True, kw_only=True)
class _PatternOfOthers(ReadingPattern):
    """A pattern of another distribution: what its code raises on these data costs no verdict."""

    pattern: ReadingPattern
    whose: str

    def found_in(self, data_vectors: Sequence[DataVector], scale: RigScale) -> FoundPattern | None:
        """See `ReadingPattern.found_in`."""

        def ask() -> Iterator[object]:
            yield self.pattern.found_in(data_vectors, scale)

        (found,) = answers_of(self.whose, object, ask, _WITHOUT) or (None,)
        if found is None:
            return None
        return _FoundByOthers(found=cast("FoundPattern", found), whose=self.whose)

    def not_outliers(self, conditions: Sequence[ReadingsOfCondition]) -> list[Which]:
        """See `ReadingPattern.not_outliers`."""
        none = super().not_outliers(conditions)

        def ask() -> list[Which]:
            flags = self.pattern.not_outliers(conditions)
            if [np.shape(one) for one in flags] != [one.shape for one in none]:
                raise ValueError("`not_outliers` returned no truth value for each reading")
            return flags

        return answers_of(self.whose, np.ndarray, ask, _WITHOUT) or none


@dataclass(frozen=True, kw_only=True)
class _FoundByOthers:
    """What a pattern of another distribution found: the same holds of it."""

    found: FoundPattern
    whose: str

    @property
    def location(self) -> str:
        """See `FoundPattern.location`."""
        return str(getattr(self.found, "location", ""))

    def without(self, readings: ReadingsOf) -> FloatArray:
        """See `FoundPattern.without`."""

        def ask() -> Iterator[FloatArray]:
            left = np.asarray(self.found.without(readings), dtype=float)
            if left.shape != readings.force_N.shape or not np.all(np.isfinite(left)):
                raise ValueError("`without` returned no finite force for each reading")
            yield left

        (left,) = answers_of(self.whose, np.ndarray, ask, _WITHOUT) or (readings.force_N,)
        return left

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `FoundPattern.bases`."""
        yield from answers_of(self.whose, Basis, partial(self.found.bases, at), _WITHOUT) or ()

    def in_other_data(self, data_vectors: Sequence[DataVector]) -> FoundPattern:
        """See `FoundPattern.in_other_data`."""

        def ask() -> Iterator[object]:
            yield self.found.in_other_data(data_vectors)

        (other,) = answers_of(self.whose, object, ask, _WITHOUT) or (self.found,)
        return replace(self, found=cast("FoundPattern", other))


def _of_others(part: Part[ReadingPattern]) -> _PatternOfOthers:
    whose = f"the pattern '{part.name}' of {part.distribution} {part.version}"
    own = part.part
    return _PatternOfOthers(
        name=own.name, meaning=own.meaning, order=own.order, pattern=own, whose=whose
    )


def origins() -> dict[str, str]:
    """Return "distribution version" by name of the patterns of other distributions."""
    return FOLDER.origins()


def patterns_in(data_vectors: Sequence[DataVector], scale: RigScale) -> tuple[FoundPattern, ...]:
    """Return the patterns that are in the readings of a session."""
    found = (one.found_in(data_vectors, scale) for one in reading_patterns().values())
    return tuple(one for one in found if one is not None)


def not_outliers(conditions: Sequence[ReadingsOfCondition]) -> list[Which]:
    """Return of each condition which readings (n,) some pattern has far from the others."""
    result = [np.zeros(len(one.force_N), dtype=bool) for one in conditions]
    for pattern in reading_patterns().values():
        for own, more in zip(result, pattern.not_outliers(conditions), strict=True):
            own |= more
    return result
