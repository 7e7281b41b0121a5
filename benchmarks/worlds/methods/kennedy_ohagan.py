"""All signatures and a Gaussian-process discrepancy at once.

Kennedy and O'Hagan 2001, J. R. Statist. Soc. B 63, 425: data = model(parameters) + discrepancy +
noise. The parameters are B, EIBM and the amplitudes of all effects, each with a normal prior of
`WIDTH` plausible sizes; the discrepancy is a process along the arc for each force and each mode of
the curves. Its length and size maximise the marginal likelihood; an effect is named where its
amplitude is `SURE_Z` posterior deviations from none. It does not say where a discrepancy acts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from benchmarks.hidden_effects.baseline_gp import along_arc as along_the_arc
from benchmarks.hidden_effects.baseline_gp import kernel
from benchmarks.hidden_effects.records import Name, Unseen
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.methods._foretell import along_arc
from benchmarks.worlds.methods._signatures import Started
from model.discrepancy.search.evidence import Projected
from model.discrepancy.search.signatures import forms
from model.discrepancy.verdict.prediction_error import refitted
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray, Measurements

WIDTH = 10.0
LENGTHS_M, SIZES = (8e-3, 20e-3), (0.0, 0.1, 0.3, 1.0, 3.0)
SURE_Z, EVIDENCE_LN, ALIKE = 4.0, 6.0, 0.9
SEEN = 1e-6
SMOOTH = 1e-3  # share of noise in what was fitted


@dataclass(frozen=True)
class _Posterior:
    evidence: float
    size: float
    mean: FloatArray
    covariance: FloatArray
    length_m: float
    added: FloatArray  # (N,) to the base model's rows, its parameters refitted


def answer(measurements: Measurements) -> Answer:
    """Return the names, and whether a discrepancy remains."""
    started = Started.of(measurements)
    kinds = along_the_arc(started.base)
    pool = forms(started.pool, {})
    signatures = np.stack([c.columns[:, 0] for c in pool], axis=1)
    found = [p for length in LENGTHS_M for p in _posteriors(started.base, signatures, length)]
    best = max(found, key=lambda p: p.evidence)
    without = max(p.evidence for p in found if p.size == 0.0)
    deviation = np.sqrt(np.diag(best.covariance))
    z = np.abs(best.mean) / deviation
    alike = np.abs(best.covariance / np.outer(deviation, deviation)) > ALIKE
    order = [int(i) for i in np.argsort(-z)]
    named = [
        Name(pool[i].name, float(norm.cdf(z[i])),
             [pool[j].name for j in order if j != i and alike[i, j]], 0.0, {})
        for i in order if z[i] >= SURE_Z
    ]  # fmt: skip
    unknown = None
    if not named and best.evidence - without > EVIDENCE_LN:
        unknown = Unseen("", "", "", 0.0)
    return Answer(
        named=named, unknown=unknown, ranking=[(pool[i].name, float(z[i])) for i in order],
        foretell=along_arc(
            started.base, best.added, dict.fromkeys(kinds, (best.length_m, SMOOTH)),
            measurements,
        ),
    )  # fmt: skip


def _posteriors(base: MixedModelFit, signatures: FloatArray, length_m: float) -> list[_Posterior]:
    """Return the amplitudes' posterior for each size of the discrepancy."""
    forward, count = base.problem.forward, signatures.shape[1]
    columns = np.concatenate([signatures, _process(base, length_m)], axis=1)
    projected = Projected.of(forward, base.linear, base.solution)
    A, b = projected.normal(forward, columns)
    result = []
    for size in SIZES:
        use = np.arange(len(b)) < (len(b) if size else count)
        prior = np.where(np.arange(len(b)) < count, WIDTH, size)[use]
        scaled = prior[:, None] * A[np.ix_(use, use)] * prior + np.eye(int(use.sum()))
        inverse = np.linalg.inv(scaled)
        mean = inverse @ (prior * b[use])
        evidence = 0.5 * float(prior * b[use] @ mean) - 0.5 * float(np.linalg.slogdet(scaled)[1])
        covariance = (prior[:, None] * inverse * prior)[:count, :count]
        added = columns[:, use] @ (prior * mean)
        added = added - base.linear.columns @ (projected.covariance @ (projected.WX.T @ added))
        result.append(
            _Posterior(evidence, size, (prior * mean)[:count], covariance, length_m, added)
        )
    return result


def _process(base: MixedModelFit, length_m: float) -> FloatArray:
    """Return columns (N, n) whose normal amplitudes make a process of the residuals' size."""
    left, columns = refitted(base), []
    for own in along_the_arc(base).values():
        size = float(np.sqrt(np.mean(np.concatenate([left[rows] for rows, _ in own]) ** 2)))
        for rows, at_m in own:
            smooth = kernel(at_m, at_m, length_m) + SEEN * np.eye(len(at_m))
            part = np.zeros((len(left), len(rows)))
            part[rows] = size * np.linalg.cholesky(smooth)
            columns.append(part)
    return np.concatenate(columns, axis=1)
