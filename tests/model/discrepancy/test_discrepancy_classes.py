"""Names that these data cannot tell apart are reported as one class, everywhere."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy.criticism.criticise import Criticism
from model.discrepancy.prepare import Options, prepare
from model.discrepancy.search.evidence import candidates
from model.discrepancy.search.forward_selection import SearchResult, SelectionStep
from model.discrepancy.search.ranking import rank
from model.discrepancy.search.signatures import forms, signatures
from model.discrepancy.verdict import finding as verdicts
from model.discrepancy.verdict.finding import Finding
from model.discrepancy.verdict.posterior import Choice
from model.effects import effect
from model.identification.likelihood.mixed_model_fit import fit_mixed_model
from model.identification.likelihood.model_state import Found
from tests.model.discrepancy.sessions import base_fit, session

PAIR = ("gravity", "clamp_angle")


def found_with(alternatives: tuple[tuple[str, float], ...], confidence: float):
    """A name as it is reported, from the search's posterior."""
    base = base_fit()
    names = [scene.sheet.configuration for scene in base.problem.forward.scenes]
    values = {name: {"load_N_per_m": 0.01 * (i + 1)} for i, name in enumerate(names)}
    one = replace(base, found=(Found(effect=effect("gravity"), values=values),))
    choice = Choice(
        effect=effect("gravity"), confidence=confidence, alternatives=alternatives, gain=50.0,
        of_location=1.0, before=base, ranking=(),
    )  # fmt: skip
    return choice, SimpleNamespace(written=one, known=one, criticism=Criticism())


@pytest.fixture
def reported(monkeypatch):
    """Reports a choice; its form and its neighbours in these data are not looked at."""
    seen = signatures(base_fit(), forms(candidates(base_fit(), [effect("gravity")]), {}), {})
    monkeypatch.setattr(verdicts, "form_of", lambda *_: (0.0, None))
    monkeypatch.setattr(verdicts, "parameters_of", lambda *_: {})

    def named(alternatives, confidence):
        return verdicts._named(*found_with(alternatives, confidence), seen)

    return named


def test_the_confidence_of_a_class_is_the_sum_over_its_members(reported):
    one = reported((("clamp_angle", 0.966), ("roll_offset", 0.03)), 0.004)
    assert one.confusable_with == ("clamp_angle",)  # the other one is below 5 %
    assert one.confidence == pytest.approx(0.97)
    assert one.probabilities == {"gravity": 0.004, "clamp_angle": 0.966}
    assert one.probability == 0.004


@pytest.mark.parametrize(
    ("confidence", "rival", "verdict"),
    [(0.94, 0.05, "indistinguishable"), (0.85, 0.15, "indistinguishable"),
     (0.97, 0.03, "effect_named")],
)  # fmt: skip
def test_a_name_has_no_rival_of_five_percent(reported, confidence, rival, verdict):
    one = reported((("clamp_angle", rival),), confidence)
    assert Finding._verdict(None, [one], None, "") == verdict
    assert (verdict == "effect_named") == (one.confusable_with == ())


def test_what_is_reported_is_not_invisible(reported):
    one = reported((("clamp_angle", 0.4),), 0.6)
    unseen = {"gravity": "a", "clamp_angle": "b", "roll_offset": "c"}
    assert verdicts._not_reported(unseen, [one]) == {"roll_offset": "c"}


def finding(promised=()) -> Finding:
    """A search that has chosen gravity."""
    ready = prepare(session(), Options())
    base = fit_mixed_model(ready.problem, ready.theta, ready.found)
    effects = [effect(name) for name in PAIR]
    ranking = rank(base, effects, locations=False)
    chosen = next(c for c in ranking if c.name == "gravity")
    size = replace(chosen, score=replace(chosen.score, amplitude=1.0))
    ranking = [size if c is chosen else c for c in ranking]
    step = SelectionStep(base, ranking, size)
    return Finding(
        measurements=session(), options=Options(promised=promised), ready=ready,
        outcome=SearchResult(base, (step,), base), effects=effects, threshold=6.0,
        threshold_from="",
    )  # fmt: skip


@pytest.mark.slow
def test_the_promise_of_a_measurement_is_judged_by_the_distance_that_is_proposed_by():
    one = finding()
    proposed = one.separating([effect(name) for name in PAIR])
    assert proposed.between == PAIR
    (promise,) = finding((proposed,))._promises()
    assert promise.proposal is proposed
    assert promise.found == pytest.approx(proposed.separation)  # nothing was measured since
    other_way = one.separating([effect(name) for name in PAIR[::-1]])
    assert other_way.separation == pytest.approx(proposed.separation)
    assert np.isfinite(proposed.expected)
