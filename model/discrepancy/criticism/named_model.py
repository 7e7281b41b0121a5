"""A model with its named effects: the input of the verdict checks, computed when needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.discrepancy.criticism.cell_noise import CellNoise, unusual_cell_noise
from model.discrepancy.criticism.predictive import Predictive
from model.discrepancy.search.cross_validation import position_groups
from model.discrepancy.search.evidence import Candidate, candidates
from model.discrepancy.search.forward_selection import SearchResult
from model.discrepancy.search.one_name import SingleName, single_names
from model.discrepancy.thresholds import CROSS_VALIDATED_NAMES, TOLERATED_SCATTER_RATIO
from model.discrepancy.verdict.posterior import Choice
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.model_state import Found
from model.measurements import FloatArray

# random effects of a set-up, by name; the others are of the load cell's electronics and of edges
MOUNTING = {
    "stiffness": "the stiffness", "eibm": "the EIBM", "position": "the place on the arc",
    "clamp_tilt": "the direction of the clamp", "registration": "the registration of the image",
    "force_zero": "the load cell's zero",
}  # fmt: skip


@dataclass(frozen=True)
class NamedModel:
    """The search, the names it ended with, and the model that has them."""

    outcome: SearchResult
    named: Sequence[Choice]
    fitted: MixedModelFit  # with the named effects, and a term that the load cell's noise hid
    plain: MixedModelFit | None = None  # without that term; None: there is none

    @cached_property
    def predictive(self) -> Predictive:
        """Residuals of left-out positions, with scatter limited to what set-ups usually have."""
        return Predictive(self.fitted, limited_scatter(self.fitted), position_groups(self.fitted))

    @property
    def cell_noise(self) -> CellNoise | None:
        """The load cell's noise beside the names; None: it is as usual."""
        return unusual_cell_noise(self.plain or self.fitted)

    @property
    def log_sigma(self) -> FloatArray:
        """Ln of all standard deviations beside the names, for models without the term."""
        return (self.plain or self.fitted).solution.log_sigma

    @property
    def found(self) -> tuple[Found, ...]:
        """The named effects with their values."""
        names = {one.effect.name for one in self.named}
        return tuple(one for one in self.fitted.found if one.effect.name in names)

    @cached_property
    def rivals(self) -> list[Candidate]:
        """Return the best names of the first step and those that were named, as candidates."""
        ranked = [c for c in self.outcome.steps[0].ranking if c.known][:CROSS_VALIDATED_NAMES]
        effects = {c.name: c.score.candidate.effect for c in ranked}
        effects |= {one.effect.name: one.effect for one in self.named}
        return candidates(self.outcome.base, [e for e in effects.values() if e is not None])

    @cached_property
    def single_names(self) -> list[SingleName]:
        """Return single names that explain a good part of what all names together do."""
        return single_names(self.outcome, [one.effect.name for one in self.named], self.fitted)

    @cached_property
    def scatter_ratio(self) -> dict[str, float]:
        """Standard deviation of each random effect between set-ups over its usual one."""
        names, guess = self.fitted.problem.noise.random_effects, self.fitted.problem.guess
        ratio = np.exp(self.fitted.solution.log_sigma - guess)
        return dict(zip(names, ratio.tolist(), strict=False))


def limited_scatter(fitted: MixedModelFit) -> FloatArray:
    """Return ln of all standard deviations, those of mountings not far above the usual ones."""
    log_sigma, guess = fitted.solution.log_sigma.copy(), fitted.problem.guess
    for k, name in enumerate(fitted.problem.noise.random_effects):
        if name in MOUNTING:
            log_sigma[k] = min(log_sigma[k], guess[k] + np.log(TOLERATED_SCATTER_RATIO))
    return log_sigma
