"""A name stays beside a nonparametric term that knows little more, scatter being as usual."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy.search.evidence import Candidate, Projected, candidates, score
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.verdict.free_form_or_names import misses_much
from model.effects import effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray
from tests.model.discrepancy.sessions import NOTHING, base_fit


def with_rows(base: MixedModelFit, rows: FloatArray) -> MixedModelFit:
    """The same with more in the data, which set-ups that differ much take up."""
    log_sigma = base.solution.log_sigma.copy()
    log_sigma[base.problem.noise_names().index("eibm")] += np.log(20.0)
    row_index, linear = base.problem.forward.row_index, base.linear
    data = replace(linear.data, y=linear.data.y + row_index.pad(rows[:, None])[:, :, 0])
    linear = replace(linear, residual=linear.residual + rows, data=data)
    return replace(base, linear=linear, solution=replace(base.solution, log_sigma=log_sigma))


def ranked(fitted: MixedModelFit, candidate: Candidate) -> RankedCandidate:
    forward = fitted.problem.forward
    projected = Projected.of(forward, fitted.linear, fitted.solution)
    found = score(forward, projected, candidate)
    return RankedCandidate(score=found, ln_bayes_factor=found.log_bayes)


@pytest.mark.slow
@pytest.mark.parametrize(("beside", "misses"), [(0.05, False), (1.0, True)])
def test_what_a_name_misses_is_told_with_the_usual_scatter(beside, misses):
    base, drift = base_fit(NOTHING), effect("eibm_drift")
    one = candidates(base, [drift])[0]
    other = candidates(base, [effect("charging_lag")])[0].columns[:, 0]
    own = 4.0 * one.columns[:, 0]
    other = other * np.linalg.norm(own) / np.linalg.norm(other)
    true = own + beside * other
    fitted = with_rows(base, true)
    free = ranked(fitted, Candidate(
        name="unknown:time", values={}, columns=true[:, None], sizes=(1.0,), location="time",
    ))  # fmt: skip
    name = SimpleNamespace(effect=drift, ranking=[ranked(fitted, one)])
    assert misses_much(fitted, SimpleNamespace(first=free), name) is misses
