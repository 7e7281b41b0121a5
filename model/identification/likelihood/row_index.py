"""Where each number stands: the rows of all runs, padded to equal length for the noise model."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from model.effects.interface import AcquisitionTimes
from model.identification.data.data_vector import (
    ConditionData,
    DataVector,
    Index,
    PulseSeries,
    Which,
    shares,
    trends,
)
from model.identification.data.pulses import WINDOW_S
from model.identification.data.run_key import RunKey
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.measurements import FloatArray
from model.measurements.pulse_train import SAMPLE_S

if TYPE_CHECKING:
    from scipy.sparse import csr_array

WITHIN = np.array([-0.35, 0.0, 0.35])  # of a part of a pulse: for the mean over it
MOST_SWAYS = 3  # trends over the readings of how far out a curve is


def _sparse(rows: FloatArray) -> csr_array:
    from scipy.sparse import csr_array  # slow to import

    return csr_array(rows)


@dataclass(frozen=True, kw_only=True)
class RowBlock:
    """Rows of one configuration, indices into the vector of all data."""

    reading_of: Index  # (n,) condition of each reading
    clock: AcquisitionTimes  # (n,) of the readings
    measured_N: FloatArray  # (n,)
    in_time: Index  # (n,) the readings in the order in which they were taken
    share: FloatArray  # (n,) of each reading in the mean of its condition
    trend: FloatArray  # (rows, n) from readings to mean, trends and first pulses
    trend_rows: Index  # (rows,)
    trend_of: Index  # (rows,) condition
    is_mean: Which  # (rows,)
    is_early: Which  # (rows,) a first pulse less the mean
    mode_rows: Index  # (K, M); -1: no curve
    sway: FloatArray  # (rows, n) likewise, to trends and first pulses of how far out the curve is
    sway_rows: Index
    sway_of: Index
    bin_clock: AcquisitionTimes  # (m,) each part in each of the pulses
    bin_sample: AcquisitionTimes  # (m,) the sampling points of these pulses
    bin_at: Index  # (m,) which part
    bin_of: Index  # (b,) condition
    bin_rows: Index
    bin_set: Index  # (b,) which of the pulses
    bin_N: FloatArray  # (b,) measured
    bin_variance: FloatArray  # (b,)
    edge_s: float  # how well the pulses' edges are known in time

    @cached_property
    def trends_by(self) -> csr_array:
        """The same as `trend`, of whose numbers nearly all are 0."""
        return _sparse(self.trend)

    @cached_property
    def sways_by(self) -> csr_array:
        """The same as `sway`."""
        return _sparse(self.sway)

    @cached_property
    def _means_by(self) -> csr_array:
        by = np.zeros((len(self.mode_rows), len(self.reading_of)))
        by[self.reading_of, np.arange(len(self.reading_of))] = self.share
        return _sparse(by)

    def means(self, values: FloatArray) -> FloatArray:
        """Return `mean` of several: (m, n) to (m, K)."""
        return np.asarray((self._means_by @ values.T).T)

    def mean(self, values: FloatArray) -> FloatArray:
        """Mean over the readings that count: (n,) to (K,)."""
        return np.asarray(
            np.bincount(self.reading_of, self.share * values, len(self.mode_rows)), dtype=float
        )

    def of_condition(self, k: int, size: int) -> Which:
        """Return which of all rows are those of a condition, (size,)."""
        result = np.zeros(size, dtype=bool)
        for rows, of in (
            (self.trend_rows, self.trend_of), (self.sway_rows, self.sway_of),
            (self.bin_rows, self.bin_of),
        ):  # fmt: skip
            result[rows[of == k]] = True
        modes = self.mode_rows[k]
        result[modes[modes >= 0]] = True
        return result

    def bin_mean(self, values: FloatArray) -> FloatArray:
        """Mean over the pulses: (m,) to (b,)."""
        total = np.bincount(self.bin_at, values, len(self.bin_of))
        mean: FloatArray = total / self._bin_counts
        return mean

    @cached_property
    def _bin_counts(self) -> FloatArray:
        return np.maximum(np.bincount(self.bin_at, minlength=len(self.bin_of)), 1).astype(float)


class RowIndex:
    """Rows of all configurations, run by run."""

    def __init__(
        self, data_vectors: list[DataVector], configuration_models: list[ConfigurationModel]
    ) -> None:
        self.runs: list[RunKey] = []
        self._run_of: list[int] = []
        self.size = 0
        self.blocks = [
            self._block(data_vector, configuration_model)
            for data_vector, configuration_model in zip(
                data_vectors, configuration_models, strict=True
            )
        ]
        self.run_of = np.array(self._run_of, dtype=np.int64)
        self.row_of = np.zeros(self.size, dtype=np.int64)
        counts = np.zeros(len(self.runs), dtype=np.int64)
        for i, r in enumerate(self._run_of):
            self.row_of[i] = counts[r]
            counts[r] += 1
        self.height = int(counts.max(initial=1))

    @property
    def setups(self) -> int:
        """How often the load cell was set."""
        return sum(bool(np.isfinite(position)) for _, position, *_ in self.runs)

    def pad(self, flat: FloatArray) -> FloatArray:
        """(N, ...) to (R, n, ...); rows that a run does not have are 0."""
        result = np.zeros((len(self.runs), self.height, *flat.shape[1:]))
        result[self.run_of, self.row_of] = flat
        return result

    def _new(self, run: RunKey, count: int) -> Index:
        if run not in self.runs:
            self.runs.append(run)
        self._run_of += [self.runs.index(run)] * count
        self.size += count
        return np.arange(self.size - count, self.size)

    def _block(self, data_vector: DataVector, configuration_model: ConfigurationModel) -> RowBlock:
        seen = data_vector.seen
        n = sum(len(o.force_N) for o in seen)
        trend, sway = _Rows(n), _Rows(n)
        is_mean, is_early = list[bool](), list[bool]()
        modes = np.full((len(seen), configuration_model.modes), -1)
        start = 0
        for k, o in enumerate(seen):
            own = slice(start, start + len(o.force_N))
            start = own.stop
            T = trends(o.kept_clock, data_vector.trends) if len(o.force_N) else np.zeros((0, 0))
            early = _firsts(o)
            trend.add(_spread(T, o.counts), own, self._new(o.run, len(T)), k)
            trend.add(early, own, self._new(o.run, len(early)), k)
            is_mean += [j == 0 for j in range(len(T) + len(early))]
            is_early += [j >= len(T) for j in range(len(T) + len(early))]
            if o.curve is not None:
                modes[k] = self._new(o.run, configuration_model.modes)
            if o.own_curves and o.voltage_V != 0.0:
                slopes = _spread(T[1 : 1 + MOST_SWAYS], o.counts)
                if len(o.own_curves) == len(o.counts):
                    slopes = np.concatenate([slopes, early])
                sway.add(slopes, own, self._new(o.run, len(slopes)), k)
        bins = [self._new(p.run, len(p.force_N)) for p in data_vector.pulses]
        reading_of, clock = configuration_model.reading_of, configuration_model.clock
        bin_clock, bin_sample, bin_at = _moments(seen, data_vector.pulses)
        return RowBlock(
            reading_of=reading_of, clock=clock,
            measured_N=np.concatenate([o.force_N for o in seen]),
            in_time=_in_time(clock, reading_of, data_vector), share=configuration_model.share,
            trend=trend.stacked(),
            trend_rows=_ints(trend.rows), trend_of=_ints(trend.of),
            is_mean=np.array(is_mean, dtype=bool), is_early=np.array(is_early, dtype=bool),
            mode_rows=modes, sway=sway.stacked(), sway_rows=_ints(sway.rows),
            sway_of=_ints(sway.of), bin_clock=bin_clock, bin_sample=bin_sample, bin_at=bin_at,
            bin_of=_ints([p.condition for p in data_vector.pulses for _ in p.force_N]),
            bin_rows=np.concatenate([_ints([]), *bins]),
            bin_set=_ints([i for i, p in enumerate(data_vector.pulses) for _ in p.force_N]),
            bin_N=np.concatenate([np.zeros(0), *(p.force_N for p in data_vector.pulses)]),
            bin_variance=np.concatenate(
                [np.zeros(0), *(p.variance_N2 for p in data_vector.pulses)]
            ),
            edge_s=max([0.0, *(p.edge_s for p in data_vector.pulses)]),
        )  # fmt: skip


@dataclass
class _Rows:
    """Weights of readings, row by row, with the places of these rows and their conditions."""

    n: int  # readings
    weights: list[FloatArray] = field(default_factory=list)
    rows: list[int] = field(default_factory=list)
    of: list[int] = field(default_factory=list)

    def add(self, weights: FloatArray, own: slice, places: Index, condition: int) -> None:
        """Weights (rows, readings of `own`)."""
        for row, place in zip(weights, places, strict=True):
            whole = np.zeros(self.n)
            whole[own] = row
            self.weights.append(whole)
            self.rows.append(int(place))
            self.of.append(condition)

    def stacked(self) -> FloatArray:
        """(rows, n)."""
        return np.array(self.weights) if self.weights else np.zeros((0, self.n))


def _spread(weights: FloatArray, counts: Which) -> FloatArray:
    """Weights of the readings that count, (rows, m), as weights of all: (rows, n)."""
    result = np.zeros((len(weights), len(counts)))
    result[:, counts] = weights
    return result


def _firsts(seen: ConditionData) -> FloatArray:
    """Weights that turn n readings into each of the first pulses', less the mean: (rows, n)."""
    every = np.eye(len(seen.counts)) - shares(seen)
    result: FloatArray = every[~seen.counts]
    return result


def _moments(
    seen: tuple[ConditionData, ...], pulses: tuple[PulseSeries, ...]
) -> tuple[AcquisitionTimes, AcquisitionTimes, Index]:
    """Moments of all parts in all pulses, those of the pulses' sampling points, and which part."""
    own = {k: seen[k].kept_clock for k in dict.fromkeys(p.condition for p in pulses)}
    counts = {k: len(clock.run_s) for k, clock in own.items()}
    first = dict(zip(own, np.cumsum([0, *counts.values()]).tolist(), strict=False))
    parts = [(p.condition, at, width) for p in pulses
             for at, width in zip(p.middle_s, p.width_s, strict=True)]  # fmt: skip
    # of each part `WITHIN` moments, and at each of these all pulses of its condition
    which = [first[k] + np.arange(counts[k]) for k, _, _ in parts for _ in WITHIN]
    sizes = [counts[k] for k, _, _ in parts for _ in WITHIN]
    inside = [at + w for _, at, width in parts for w in WITHIN * width]
    sample = [SAMPLE_S + w for _ in parts for w in WITHIN * 2.0 * WINDOW_S]
    pulses_of = AcquisitionTimes.joined(list(own.values())).at(np.concatenate([_ints([]), *which]))
    return (
        _in_pulse(pulses_of, np.repeat(inside, sizes)),
        _in_pulse(pulses_of, np.repeat(sample, sizes)),
        np.repeat(np.arange(len(parts)), [len(WITHIN) * counts[k] for k, _, _ in parts]),
    )


def _in_pulse(sample: AcquisitionTimes, at_s: FloatArray) -> AcquisitionTimes:
    """Other moments of the same pulses."""
    later = at_s - sample.pulse_s
    return replace(
        sample, pulse_s=sample.pulse_s + later, run_s=sample.run_s + later,
        wetted_s=sample.wetted_s + later, driven_s=sample.driven_s + later,
        worked_s=sample.worked_s + later,
    )  # fmt: skip


def _in_time(clock: AcquisitionTimes, of: Index, data_vector: DataVector) -> Index:
    keys = list(dict.fromkeys(o.run for o in data_vector.seen))
    run = np.array([keys.index(data_vector.seen[int(k)].run) for k in of])
    day = np.array([data_vector.seen[int(k)].session for k in of])
    return np.lexsort((clock.run_s, run, np.round(clock.session, 12), day))


def _ints(values: list[int]) -> Index:
    return np.array(values, dtype=np.int64)
