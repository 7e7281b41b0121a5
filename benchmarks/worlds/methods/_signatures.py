"""What methods share that begin with the base model and the catalogue's signatures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from benchmarks.hidden_effects.records import Name
from benchmarks.hidden_effects.visible import known
from benchmarks.worlds.methods._contract import Answer, Foretell
from model.discrepancy.prepare import DiagnoseOptions, Prepared, prepare
from model.discrepancy.search.evidence import Candidate, candidates
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.measurements import Measurements


@dataclass(frozen=True)
class Started:
    """The base model, fitted, and all effects that might be missing."""

    ready: Prepared
    base: MixedModelFit
    effects: list[Effect]

    @staticmethod
    def of(measurements: Measurements) -> Started:
        """Fit the base model."""
        ready = prepare(measurements, DiagnoseOptions())
        return Started(ready, fit_mixed_model(ready.problem, ready.theta), known(symmetric=False))

    @cached_property
    def pool(self) -> list[Candidate]:
        """Return every effect in each of its shapes."""
        return candidates(self.base, self.effects)


def taken_at_their_word(names: list[str], foretell: Foretell) -> Answer:
    """Return names without intervals, and without a probability other than 1."""
    return Answer(named=[Name(name, 1.0, [], 0.0, {}) for name in names], foretell=foretell)
