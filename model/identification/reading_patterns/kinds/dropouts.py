"""Readings under voltage in which the same share of the EIBM is missing: a contact opens at times.

By their means and slow trends such readings would only look noisy, and the noise would hide what
they have in common: they stand apart from their neighbours, towards the force at 0 V, each by the
same share of what the EIBM adds. Noise does not agree on that, and has no reason to spare 0 V.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.identification.data.data_vector import ConditionData, DataVector, Which
from model.identification.data.robust_line import off_line, robust_sd
from model.identification.reading_patterns.contract import (
    ReadingPattern,
    ReadingsOf,
    ReadingsOfCondition,
)
from model.locations.basis import cosine_wave
from model.locations.contract import Basis, Linearised
from model.measurements import FloatArray, RigScale

FEWEST = 6  # dropouts
LEAST_SHARE, MOST_SHARE = 0.03, 0.3  # of the readings under voltage, and of those of a condition
FEWEST_READINGS = 5  # of a condition, to know which of them stand apart
SIGMA = 4.5  # of a reading's noise, from which on it stands apart
HALF, SIGMA_OF_ALL = 0.5, 2.5  # of the missing share, and of the noise: from which on, beside such
ONE_SIDE = 0.9  # share of those that stand apart that lack EIBM
SPREAD = 0.4  # robust standard deviation of the missing share, over the share
LESS_AT_REST = 0.25  # readings that stand apart at 0 V, over those under voltage, at most
SAME_PLACE_SHARE = 0.5  # of the conditions: more at the same place of the order are a transient
AMPLITUDE = 0.1  # relative, of the basis shape


@dataclass(frozen=True, kw_only=True)
class FoundDropouts:
    """Dropouts of a session."""

    dropped: Mapping[str, Which]  # by configuration, its readings (n,)
    location: str = "time"

    def without(self, readings: ReadingsOf) -> FloatArray:
        """Return the forces with the dropouts of each condition moved onto its other readings."""
        values, dropped = readings.force_N, self.dropped[readings.configuration]
        result = values.copy()
        for k in np.unique(readings.reading_of[dropped]):
            own = readings.reading_of == k
            result[own & dropped] += values[own & ~dropped].mean() - values[own & dropped].mean()
        return result

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """Return one: how much of the EIBM they lack."""
        dropped = self.dropped[at.configuration]
        if not np.any(dropped):
            return
        constant = cosine_wave(0, AMPLITUDE)
        share = constant(np.zeros(len(dropped))) * dropped
        number, of = int(np.sum(dropped)), int(np.sum(at.clock.voltage_V != 0.0))
        yield Basis(
            part="EIBM, dropouts", along="time", function=constant, unit="relative",
            span=(0.0, 1.0, "of the session"), step=replace(at.nothing(), eibm=share), shared=True,
            shows=f": in {number} of {of} readings under voltage a part of the EIBM is missing",
        )  # fmt: skip

    def in_other_data(self, data_vectors: Sequence[DataVector]) -> FoundDropouts:
        """See `FoundPattern.in_other_data`."""
        return replace(self, dropped=dropped_readings(data_vectors))


@dataclass(frozen=True, kw_only=True)
class Dropouts(ReadingPattern):
    """Readings in which a part of the EIBM is missing at once."""

    def found_in(self, data_vectors: Sequence[DataVector], scale: RigScale) -> FoundDropouts | None:  # noqa: ARG002
        """See `ReadingPattern.found_in`."""
        dropped = dropped_readings(data_vectors)
        return FoundDropouts(dropped=dropped) if any(map(np.any, dropped.values())) else None

    def not_outliers(self, conditions: Sequence[ReadingsOfCondition]) -> list[Which]:
        """See `ReadingPattern.not_outliers`."""
        found = dropouts_in(conditions)
        return super().not_outliers(conditions) if found is None else found.which


@dataclass(frozen=True, kw_only=True)
class LackingReadings:
    """Readings that lack the same share of the EIBM."""

    which: list[Which]  # of each condition, its readings
    share: float  # of the EIBM
    noise_N: float  # standard deviation of a reading


def dropouts_in(conditions: Sequence[ReadingsOfCondition]) -> LackingReadings | None:
    """Return which readings of each condition are dropouts; None: there are none."""
    off = [off_line(one.force_N) for one in conditions]
    asked = [len(one.force_N) >= FEWEST_READINGS for one in conditions]
    own_N = [robust_sd(o) for o, a in zip(off, asked, strict=True) if a]
    noise_N = float(np.median(own_N)) if own_N else 0.0
    if not noise_N:
        return None
    apart = [
        _apart(o, noise_N) if a else np.zeros(len(o), dtype=bool)
        for o, a in zip(off, asked, strict=True)
    ]
    driven = [i for i, one in enumerate(conditions) if asked[i] and abs(one.by_eibm_N) > 0.0]
    rest = [i for i, one in enumerate(conditions) if asked[i] and one.by_eibm_N == 0.0]
    if not driven or _share(apart, rest) > LESS_AT_REST * _share(apart, driven):
        return None
    if not _is_random([apart[i] for i in driven]):
        return None
    missing = np.concatenate([-off[i][apart[i]] / conditions[i].by_eibm_N for i in driven])
    enough = len(missing) >= FEWEST and _share(apart, driven) >= LEAST_SHARE
    if not enough or np.mean(missing > 0.0) < ONE_SIDE:
        return None
    share = float(np.median(missing))
    if robust_sd(missing - share) > SPREAD * share:
        return None
    which = [
        _lacking(off[i], one.by_eibm_N, share, noise_N) if i in driven
        else np.zeros(len(off[i]), dtype=bool)
        for i, one in enumerate(conditions)
    ]  # fmt: skip
    return LackingReadings(which=which, share=share, noise_N=noise_N)


def dropped_readings(data_vectors: Sequence[DataVector]) -> dict[str, Which]:
    """Return for each configuration which of its readings (n,), in their order, are dropouts."""
    seen = [one for data_vector in data_vectors for one in data_vector.seen]
    rest_N = {
        one.run: float(np.mean(one.kept_N))
        for one in seen if one.voltage_V == 0.0 and not one.zero and len(one.kept_N)
    }  # fmt: skip
    kept = [
        ReadingsOfCondition(
            force_N=one.kept_N,
            by_eibm_N=(
                float(np.mean(one.kept_N)) - rest_N.get(one.run, np.nan)
                if one.voltage_V and len(one.kept_N) else 0.0
            ),
        )
        for one in seen
    ]  # fmt: skip
    found, flags = dropouts_in(kept), [np.zeros(len(one.force_N), dtype=bool) for one in seen]
    if found is not None:
        early = _in_first_pulses(seen, kept, found)
        for own, one, which, first in zip(flags, seen, found.which, early, strict=True):
            own[one.counts], own[~one.counts] = which, first
    every = iter(flags)
    return {
        some.sheet.configuration: np.concatenate(
            [np.zeros(0, dtype=bool), *(next(every) for _ in some.seen)]
        )
        for some in data_vectors
    }


def _in_first_pulses(
    seen: Sequence[ConditionData], kept: Sequence[ReadingsOfCondition], found: LackingReadings
) -> list[Which]:
    """Return which readings of the first pulses lack as much; none where most do: a transient."""
    flags = []
    for one, own, which in zip(seen, kept, found.which, strict=True):
        more = one.force_N[~one.counts]
        level_N = np.median(own.force_N[~which]) if len(which) else np.nan
        flags.append(_lacking(more - level_N, own.by_eibm_N, found.share, found.noise_N))
    return flags if _is_random(flags) else [np.zeros(len(one), dtype=bool) for one in flags]


def _lacking(off: FloatArray, by_eibm_N: float, share: float, noise_N: float) -> Which:
    """Return which readings lack about so large a share, and more than noise takes from most."""
    least_N = max(HALF * share * abs(by_eibm_N), SIGMA_OF_ALL * noise_N)
    return np.asarray((by_eibm_N != 0.0) & (-np.sign(by_eibm_N) * off > least_N))


def _apart(off: FloatArray, noise_N: float) -> Which:
    own_N = robust_sd(off)
    found = np.abs(off) > SIGMA * max(noise_N, own_N)
    return np.asarray(found if found.mean() <= MOST_SHARE else np.zeros(len(off), dtype=bool))


def _share(apart: Sequence[Which], which: Sequence[int]) -> float:
    """Return the share of the readings of some conditions that stand apart."""
    found = np.concatenate([apart[i] for i in which]) if which else np.zeros(1, dtype=bool)
    return float(np.mean(found))


def _is_random(apart: Sequence[Which]) -> bool:
    """Return whether they do not stand at one place of the order, as those of a transient do."""
    places = Counter(int(i) for one in apart for i in np.flatnonzero(one))
    return max(places.values(), default=0) <= SAME_PLACE_SHARE * len(apart)


PATTERN = Dropouts(
    name="dropouts", meaning="readings that lack the same share of the EIBM", order=20
)
