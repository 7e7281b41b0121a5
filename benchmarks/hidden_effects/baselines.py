"""Four simpler methods on the same sessions, each with the same base model, rows and signatures.

`repeats_bic`  noise from the ten repeats alone, effects added while BIC falls
`fixed_forms`  the procedure of `diagnose` with the catalogue's forms taken at their word
`gp`           a Gaussian process for what the base model leaves, along the arc: it names nothing
`stlsq`        sparse regression (Brunton et al. 2016): all signatures at once, small ones dropped
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.hidden_effects.baseline_gp import gaussian_process
from benchmarks.hidden_effects.run import Made, options_of
from benchmarks.hidden_effects.visible import known
from model.discrepancy.prepare import Prepared, prepare
from model.discrepancy.search.evidence import Candidate, Projected, candidates
from model.discrepancy.search.forward_selection import search
from model.discrepancy.search.signatures import forms
from model.discrepancy.thresholds import EVIDENCE_THRESHOLD_LN
from model.discrepancy.verdict.posterior import choices
from model.discrepancy.verdict.prediction_error import variance
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model import Solution, weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.measurements import FloatArray

NOT_THERE = -30.0  # ln of a scatter that is taken not to be there
MOST = 8  # effects
THRESHOLDS = (2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 64.0)  # sigmas
RIDGE = 1e-3


def answers(one: Made) -> dict[str, dict[str, object]]:
    """What each of them says of a session."""
    ready = prepare(one.hidden.measurements, options_of(one.task))
    effects = known(one.task.case.symmetric, one.task.exclude)
    base = fit_mixed_model(ready.problem, ready.theta)
    pool = candidates(base, effects)
    return {
        "repeats_bic": {"named": [c.name for c in repeats_bic(base, pool)]},
        "fixed_forms": {"named": fixed_forms(ready, effects)[0]},
        "gp": {"closed": gaussian_process(base, _honest_noise(one))},
        "stlsq": {"named": [c.name for c in stlsq(base, pool)]},
    }


def _honest_noise(one: Made) -> FloatArray:
    """Variance of each row where nothing is hidden: the floor that gaps are measured from."""
    bare = prepare(one.bare, options_of(one.task))
    return variance(fit_mixed_model(bare.problem, bare.theta))


# -------------------------------------------------------------- repeats alone, stepwise by BIC


def repeats_bic(base: MixedModelFit, pool: Sequence[Candidate]) -> list[Candidate]:
    """Return the effects in the order in which they were added."""
    data = base.linear.data
    log_sigma = base.problem.guess.copy()  # of the readings: what the repeats say
    log_sigma[: len(data.groups)] = NOT_THERE
    gram = _gram(base, pool, weigh(data, log_sigma))
    chosen: list[int] = []
    while len(chosen) < MOST:
        names = {gram.seen[i].name for i in chosen}
        free = [i for i, one in enumerate(gram.seen) if one.name not in names]
        best = min(free, key=lambda i: gram.bic([*chosen, i]))
        if gram.bic([*chosen, best]) >= gram.bic(chosen):
            break
        chosen.append(best)
    return [gram.seen[i] for i in chosen]


@dataclass(frozen=True)
class _Gram:
    """Columns as products among themselves and with the data, the base refitted."""

    seen: list[Candidate]
    A: FloatArray  # (n, n)
    b: FloatArray  # (n,)
    rows: int

    def gain(self, chosen: Sequence[int]) -> float:
        """By how much chi^2 falls."""
        if not chosen:
            return 0.0
        i = list(chosen)
        fitted = np.linalg.lstsq(self.A[np.ix_(i, i)], self.b[i], rcond=1e-10)[0]
        return float(self.b[i] @ fitted)

    def bic(self, chosen: Sequence[int]) -> float:
        """Up to a constant."""
        return len(chosen) * float(np.log(self.rows)) - self.gain(chosen)


def _gram(base: MixedModelFit, pool: Sequence[Candidate], solution: Solution) -> _Gram:
    forward = base.problem.forward
    projected = Projected.of(forward, base.linear, solution)
    A, b = projected.normal(forward, np.stack([c.columns[:, 0] for c in pool], axis=1))
    seen = [int(i) for i in np.flatnonzero(np.diag(A) > 1e-6)]
    return _Gram([pool[i] for i in seen], A[np.ix_(seen, seen)], b[seen], forward.row_index.size)


# ------------------------------------------------------------------ without tolerance of form


def fixed_forms(ready: Prepared, effects: Sequence[Effect]) -> tuple[list[str], MixedModelFit]:
    """Return names by the same search, every effect as the catalogue writes it, and the model."""
    rigid = [replace(e, form_error_along=()) for e in effects]
    outcome = search(ready.problem, ready.theta, rigid, EVIDENCE_THRESHOLD_LN)
    chosen, final = choices(outcome, rigid, EVIDENCE_THRESHOLD_LN)
    return [c.effect.name for c in chosen], final


# ------------------------------------------------------------------------ sparse regression


def stlsq(base: MixedModelFit, pool: Sequence[Candidate]) -> list[Candidate]:
    """Return the effects whose signatures are left, the threshold by BIC; `diagnose`'s noise."""
    gram = _gram(base, forms(pool, {}), base.solution)
    best: list[int] = []
    for threshold in THRESHOLDS:
        chosen = _thresholded(gram, threshold)
        if gram.bic(chosen) < gram.bic(best):
            best = chosen
    return [gram.seen[i] for i in best]


def _thresholded(gram: _Gram, threshold: float) -> list[int]:
    length = np.sqrt(np.diag(gram.A))
    chosen = list(range(len(length)))
    for _ in range(len(length)):
        if not chosen:
            break
        G = gram.A[np.ix_(chosen, chosen)] / np.outer(length[chosen], length[chosen])
        size = np.linalg.solve(G + RIDGE * np.eye(len(G)), gram.b[chosen] / length[chosen])
        kept = [i for i, x in zip(chosen, size, strict=True) if abs(x) >= threshold]
        if kept == chosen:
            break
        chosen = kept
    return chosen
