"""Compute signatures and detectability of effects, and which effects are indistinguishable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model.discrepancy.search.evidence import SIZES, Candidate, Projected
from model.discrepancy.thresholds import (
    COMPARISON_SIGMA,
    DETECTION_SIGMA,
    LARGE_AMPLITUDE,
    SEPARATION_SIGMA,
)
from model.discrepancy.verdict.result import DetectionLimit, Signatures
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.locations import location
from model.measurements import FloatArray

TINY = 1e-9


def forms(pool: Sequence[Candidate], chosen: Mapping[str, Mapping[str, float]]) -> list[Candidate]:
    """Return one candidate for each effect: the shape that was found, or the middle one."""
    groups: dict[str, list[Candidate]] = {}
    for one in pool:
        groups.setdefault(one.name, []).append(one)
    result = []
    for name, own in groups.items():
        wanted = chosen.get(name)
        match = [c for c in own if wanted is not None and dict(c.values) == dict(wanted)]
        result.append(match[0] if match else own[len(own) // 2])
    return result


def signatures(
    fitted: MixedModelFit, pool: Sequence[Candidate], amplitude: Mapping[str, float]
) -> Signatures:
    """Lengths and distances in sigmas, the base refitted; forms given the tolerance they have.

    Two effects are compared at the size that was found, else at one that would just be found.
    """
    forward = fitted.problem.forward
    weighed = Projected.of(forward, fitted.linear, fitted.solution)
    main = np.stack([c.columns[:, 0] for c in pool], axis=1)
    A, _ = weighed.normal(forward, main)
    length = np.sqrt(np.maximum(np.diag(A), 0.0))
    safe = np.where(length > 1e-9, length, 1.0)
    cosine = A / safe[:, None] / safe[None, :]
    n = len(pool)
    distance = np.zeros((n, n))
    for i, one in enumerate(pool):
        largest = LARGE_AMPLITUDE if one.effect is None else largest_amplitude(one.effect)
        size = abs(amplitude.get(one.name, 0.0)) * length[i] or min(
            COMPARISON_SIGMA, largest * length[i]
        )
        for j in range(n):
            if i != j:
                share = max(0.0, 1.0 - min(cosine[i, j] ** 2, 1.0))
                distance[i, j] = size * np.sqrt(share)
    return Signatures(tuple(c.name for c in pool), length, distance, cosine)


def lengths_beside(
    known: MixedModelFit, pool: Sequence[Candidate], log_sigma: FloatArray
) -> FloatArray:
    """Return lengths in sigmas beside the effects of a model, their forms tolerated."""
    forward = known.problem.forward
    weighed = Projected.of(forward, known.linear, weigh(known.linear.data, log_sigma))
    A, _ = weighed.normal(forward, np.stack([c.columns[:, 0] for c in pool], axis=1))
    return np.sqrt(np.maximum(np.diag(A), 0.0))


def largest_amplitude(effect: Effect) -> float:
    """Return the largest amplitude that a laboratory may have, over the prior scale.

    A prior scale is a guess, and a laboratory may exceed it many times: bounds and instrument
    limits count, and what the search tries at most.
    """
    size = effect.amplitude
    if size.starting_values or size.log:
        return LARGE_AMPLITUDE
    reach = max(size.high - size.neutral, size.neutral - size.low)
    limit = np.inf if size.instrument_limit is None else size.instrument_limit
    return float(min(min(reach, limit) / abs(size.prior_scale), max(SIZES)))


def detection_limits(
    lengths: Mapping[str, float], effects: Mapping[str, Effect]
) -> dict[str, DetectionLimit]:
    """Return from which amplitude on each effect would be seen; none of those without a scale."""
    result = {}
    for name, length in lengths.items():
        size = effects[name].amplitude if name in effects else None
        if size is not None and not (size.starting_values or size.log) and length > TINY:
            away = size.prior_scale * DETECTION_SIGMA / length
            result[name] = DetectionLimit(
                parameter=size.name, value=size.neutral + away, unit=size.unit,
                ratio=DETECTION_SIGMA / length,
            )  # fmt: skip
    return result


def invisible(
    fitted: MixedModelFit, found: Signatures, effects: Mapping[str, Effect]
) -> dict[str, str]:
    """Return effects that these data cannot show at any size, with data that could."""
    result = {}
    streams = _streams(fitted)
    for name, length in zip(found.names, found.detectability, strict=True):
        effect = effects.get(name)
        if effect is None or length * largest_amplitude(effect) >= DETECTION_SIGMA:
            continue
        needs = effect.isolates
        if location(effect.location).in_time and not streams:
            needs = "the readings in their order, and the series within a pulse: " + needs
        result[name] = f"{needs} {_seen_from(effect, float(length))}".rstrip()
    for name, effect in effects.items():
        # not even its form can be worked out; one that failed was told of when it did
        if name not in found.names and effect.needs_session:
            result[name] = "when in the session each reading was taken: " + effect.isolates
    return result


def _seen_from(effect: Effect, length: float) -> str:
    """Return from which size on it would be seen, a sentence; empty where sizes are no scale."""
    size = effect.amplitude
    if size.starting_values or size.log:
        return ""
    away = size.prior_scale * DETECTION_SIGMA / max(length, TINY)
    if size.neutral + abs(away) > size.high and size.neutral - abs(away) < size.low:
        return "Here it is not seen at any size that it can have."
    return f"Here it is seen from {size.neutral + away:.2g}{f' {size.unit}'.rstrip()} on."


def _streams(fitted: MixedModelFit) -> bool:
    """Return whether there are repeats in order or series."""
    parts = fitted.problem.forward.row_index.blocks
    return any(len(p.bin_rows) or np.any(~p.is_mean) for p in parts)


def classes(found: Signatures, unseen: Mapping[str, str]) -> tuple[tuple[str, ...], ...]:
    """Return groups of effects closer than `SEPARATION_SIGMA` at the amplitudes compared."""
    names = [n for n in found.names if n not in unseen]
    place = {n: i for i, n in enumerate(found.names)}
    left, result = set(names), []
    for name in names:
        if name not in left:
            continue
        near = [
            other for other in names
            if other in left and other != name
            and min(found.distance[place[name], place[other]],
                    found.distance[place[other], place[name]]) < SEPARATION_SIGMA
        ]  # fmt: skip
        if near:
            group = (name, *near)
            left -= set(group)
            result.append(group)
    return tuple(result)
