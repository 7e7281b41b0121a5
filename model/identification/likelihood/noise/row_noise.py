"""How noisy the rows are by themselves, as assumed before the misfit has said how much it is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.identification.data.data_vector import DataVector, Index
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.random_effects import USUAL, NoisePriors, constant_groups
from model.identification.likelihood.row_index import RowBlock
from model.identification.reading_patterns.contract import FoundPattern, ReadingsOf
from model.measurements import FloatArray, RigScale

LEAST_MODE_M = 1e-7
LEAST_PULSE_N, LEAST_READING_N = 1e-8, 1e-7
CURVE_M = 2e-5  # of a curve's point where none is stated
READING_N = 3e-5  # of a reading where repeats do not say it
SWAY_M = 5e-6  # of how far out a reading's curve is


@dataclass(frozen=True, kw_only=True)
class RowNoise:
    """Fixed variances, further noises and their priors; the same for all states."""

    fixed: FloatArray  # (N,)
    masks: list[FloatArray]  # (N,)
    names: list[str]
    guess: FloatArray  # ln of the standard deviations
    width: FloatArray  # how unsure that is, of each by itself
    levels: list[tuple[Index, float]]  # noises that are unsure together as well, and how much
    random_effects: Mapping[str, tuple[float, float]]  # standard deviations, and of their ln
    constant: dict[str, FloatArray]  # groups (R, n, q) that are the same for all states


@dataclass(frozen=True, kw_only=True)
class _Kind:
    """Rows that are equally noisy, but for known weights of their variances."""

    name: str
    rows: Index
    weight: FloatArray | float
    size: float  # standard deviation, as assumed
    unsure: float  # standard deviation of its logarithm, by itself
    level: str = ""  # noises of one level are too large or too small together
    least: float = 0.0  # standard deviation that is there in any case


def noise_of(forward: ForwardModel, priors: NoisePriors = USUAL) -> RowNoise:
    """Return the noise of readings, modes, sways and pulses, each configuration on its own."""
    N, scale = forward.row_index.size, forward.scale
    priors = priors.at_scale(scale)
    fixed, kinds = np.zeros(N), list[_Kind]()
    for name, block, configuration_model, data_vector in zip(
        forward.names,
        forward.row_index.blocks,
        forward.configuration_models,
        forward.data_vectors,
        strict=True,
    ):
        reading_N = _without_patterns(forward.patterns, name, block)
        kinds += _kinds(name, block, configuration_model, data_vector, reading_N, priors, scale)
    masks = []
    for kind in kinds:
        mask = np.zeros(N)
        mask[kind.rows] = kind.weight
        masks.append(mask)
        fixed[kind.rows] = kind.least**2
    return RowNoise(
        fixed=fixed, masks=masks, names=[k.name for k in kinds],
        guess=np.log([k.size for k in kinds]), width=np.array([k.unsure for k in kinds]),
        levels=_levels(kinds, priors.curve_unsure),
        random_effects=priors.random_effects, constant=constant_groups(forward, priors),
    )  # fmt: skip


def _without_patterns(patterns: Sequence[FoundPattern], name: str, block: RowBlock) -> FloatArray:
    """Return the forces of a configuration's readings without what they have in common, (n,)."""
    readings = ReadingsOf(
        configuration=name,
        force_N=block.measured_N,
        clock=block.clock,
        reading_of=block.reading_of,
    )
    for pattern in patterns:
        readings = replace(readings, force_N=pattern.without(readings))
    return readings.force_N


def _levels(kinds: Sequence[_Kind], unsure: float) -> list[tuple[Index, float]]:
    names = np.array([kind.level for kind in kinds])
    return [(np.flatnonzero(names == name), unsure) for name in np.unique(names) if name]


def guess_of(noise: RowNoise) -> FloatArray:
    """Ln of all standard deviations, as assumed: scatters, then noises."""
    return np.concatenate([[np.log(v) for v, _ in noise.random_effects.values()], noise.guess])


def scatter_precision(noise: RowNoise) -> FloatArray:
    """Precision of the prior on these: (k, k)."""
    width = np.concatenate([[w for _, w in noise.random_effects.values()], noise.width])
    covariance = np.diag(width**2)
    for members, unsure in noise.levels:
        at = members + len(noise.random_effects)
        covariance[np.ix_(at, at)] += unsure**2
    return np.asarray(np.linalg.inv(covariance))


def _kinds(
    name: str, block: RowBlock, configuration_model: ConfigurationModel, data_vector: DataVector,
    reading_N: FloatArray, priors: NoisePriors, scale: RigScale,
) -> Iterator[_Kind]:  # fmt: skip
    if len(block.trend_rows):
        # of independent readings: those of a mean are fewer times as noisy
        in_mean = np.array([one.mean_of for one in data_vector.seen])[block.trend_of]
        weight = np.sum(block.trend**2, axis=1) / in_mean
        size, unsure = _reading_noise(block, reading_N, data_vector, scale.force)
        yield _Kind(
            name=f"{name} reading", rows=block.trend_rows, weight=weight, size=size, unsure=unsure
        )
    if priors.misfit_N and block.is_mean.any():
        means = block.trend_rows[block.is_mean]
        yield _Kind(
            name=f"{name} force",
            rows=means,
            weight=1.0,
            size=priors.misfit_N,
            unsure=priors.misfit_unsure,
        )
    stated = [o.curve.sigma_m for o in data_vector.seen if o.curve is not None]
    known = [float(np.mean(s)) for s in stated if s is not None]
    least_m = LEAST_MODE_M * scale.length
    seen_m = data_vector.camera.curve_m
    typical = max(float(np.mean(known)) if known else CURVE_M * scale.length, 5.0 * least_m)
    for m in range(configuration_model.modes):
        rows = block.mode_rows[configuration_model.has_curve, m]
        if len(rows):
            yield _Kind(
                name=f"{name} mode {m}",
                rows=rows,
                weight=1.0,
                size=typical / (1.0 + m),
                unsure=priors.mode_unsure,
                level=name,
                least=max(least_m, seen_m),
            )
    if len(block.sway_rows):
        weight = np.sum(block.sway**2, axis=1)
        yield _Kind(
            name=f"{name} sway", rows=block.sway_rows, weight=weight,
            size=SWAY_M * scale.length, unsure=2.0,
        )  # fmt: skip
    if len(block.bin_rows):
        # the scatter of the pulses says how sure each part is, up to a factor near one
        least_N = LEAST_PULSE_N * scale.force
        pooled = _pooled(block.bin_variance, block.bin_set, least_N)
        yield _Kind(
            name=f"{name} pulse",
            rows=block.bin_rows,
            weight=pooled,
            size=1.0,
            unsure=1.5,
            least=least_N,
        )


def _reading_noise(
    block: RowBlock, reading_N: FloatArray, data_vector: DataVector, force_scale: float
) -> tuple[float, float]:
    """Return the standard deviation of a reading about its trend in time, and of its logarithm."""
    total, degrees = 0.0, 0
    for one in data_vector.seen:
        if one.spread_N is not None and one.spread_N > 0.0:
            known = max(one.mean_of - 1, 1)
            total += known * one.spread_N**2
            degrees += known
    for k in np.unique(block.reading_of):
        own = (block.reading_of == k) & (block.share > 0.0)
        rows = block.trend[(block.trend_of == k) & ~block.is_early][:, own]
        n = int(own.sum())
        if n <= len(rows):
            continue
        values = reading_N[own]
        smooth = n * values.mean() ** 2 + float(np.sum((rows[1:] @ values) ** 2))
        total += float(values @ values) - smooth
        degrees += n - len(rows)
    if not degrees:
        return READING_N * force_scale, 1.5
    size_N = max(float(np.sqrt(max(total, 0.0) / degrees)), LEAST_READING_N * force_scale)
    return size_N, max(0.05, (2.0 * degrees) ** -0.5)


def _pooled(variance: FloatArray, sets: Index, least_N: float) -> FloatArray:
    """Return the pooled variance: the same part of a pulse scatters equally in all runs."""
    count = int(np.bincount(sets)[0])
    table = variance.reshape(-1, count)
    return np.maximum(np.tile(np.median(table, axis=0), len(table)), least_N**2)
