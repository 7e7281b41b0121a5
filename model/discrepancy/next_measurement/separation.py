"""How many standard deviations a design of measurements puts between two effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.search.evidence import Candidate, Projected, candidates
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit


def separation(fitted: MixedModelFit, which: Sequence[Candidate], size: float) -> float:
    """Sigmas from the first candidate, `size` times its own size, to all the others can imitate."""
    forward = fitted.problem.forward
    weighed = Projected.of(forward, fitted.linear, fitted.solution)
    A, _ = weighed.normal(forward, np.stack([c.columns[:, 0] for c in which], axis=1))
    own, others = A[0, 1:], A[1:, 1:]
    rest = A[0, 0] - own @ np.linalg.lstsq(others, own, rcond=1e-12)[0]
    return float(np.sqrt(max(rest, 0.0))) * size


@dataclass(frozen=True)
class Suspect:
    """One of two effects that are indistinguishable so far."""

    effect: Effect
    values: dict[str, float]  # its form
    size: float  # multiples of it that the data speak of

    def forms(self, fitted: MixedModelFit) -> list[Candidate]:
        """Return all its forms in a design, its own one first."""
        pool = candidates(fitted, [self.effect], tolerant=False)
        return sorted(pool, key=lambda c: dict(c.values) != self.values)


def separated(fitted: MixedModelFit, between: Sequence[Suspect]) -> float:
    """Return how many sigmas the first two of some effects are apart in these data."""
    return distance(fitted, equally_long(fitted, between[:2]))


def equally_long(fitted: MixedModelFit, pair: Sequence[Suspect]) -> tuple[Suspect, Suspect]:
    """Return both with the amplitudes at which they explain as much as the stronger one.

    The second one's own amplitude may be near zero, since it was fitted to the remainder of the
    first.
    """
    first, second = pair
    units = [separation(fitted, one.forms(fitted)[:1], 1.0) for one in pair]
    length = max(one.size * unit for one, unit in zip(pair, units, strict=True))
    sizes = [
        length / unit if unit > 0.0 else one.size for one, unit in zip(pair, units, strict=True)
    ]
    return replace(first, size=sizes[0]), replace(second, size=sizes[1])


def distance(fitted: MixedModelFit, pair: tuple[Suspect, Suspect]) -> float:
    """Sigmas from either of two to the nearest form of the other; the smaller of the two."""
    forms = [one.forms(fitted) for one in pair]
    return min(
        separation(fitted, (own[0], other), one.size)
        for one, own, others in zip(pair, forms, forms[::-1], strict=True)
        for other in others
    )
