"""From gains to names: posteriors, thresholds, outliers, what is left; and rough beginnings."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy.search import forward_selection as searching
from model.discrepancy.search.evidence import Candidate, Score, candidates
from model.discrepancy.search.forward_selection import SelectionStep, search
from model.discrepancy.search.nonparametric_terms import unknowns
from model.discrepancy.search.null_calibration import null_gains, threshold
from model.discrepancy.search.outliers import (
    OUT,
    condition_name,
    condition_runs,
    numbers_of,
    outlier_candidates,
    without,
)
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.search.signatures import (
    classes,
    detection_limits,
    forms,
    invisible,
    largest_amplitude,
    signatures,
)
from model.discrepancy.thresholds import (
    EVIDENCE_TEMPERATURE,
    FALSE_NAME_RATE,
)
from model.discrepancy.verdict.posterior import (
    Choice,
    ResidualTerms,
    choice,
    posterior,
    rest_of_another,
    with_shapes,
)
from model.discrepancy.verdict.prediction_error import variance
from model.effects import catalogue, effect
from model.identification.likelihood.mixed_model_fit import fit_mixed_model
from model.identification.likelihood.model_state import Found
from model.measurements import Reading
from tests.model.discrepancy.sessions import base_fit, fitted, means_of, session


def ranked(name: str, gain: float) -> RankedCandidate:
    known = effect(name) if ":" not in name else None
    candidate = Candidate(
        name=name, values={}, columns=np.zeros((1, 1)), sizes=(1.0,), effect=known, location=""
    )
    return RankedCandidate(
        score=Score(candidate=candidate, log_bayes=gain, amplitude=1.0, scale=1.0, length=1.0),
        ln_bayes_factor=gain,
    )


def test_posteriors_are_of_the_catalogue_s_effects_and_add_up_to_one():
    ranking = [ranked("gravity", 20.0), ranked("outlier:3", 50.0),
               ranked("unknown:time", 30.0), ranked("clamp_angle", 17.0)]  # fmt: skip
    found = posterior(ranking)
    assert list(found) == ["gravity", "clamp_angle"]
    assert sum(found.values()) == pytest.approx(1.0)
    assert found["gravity"] / found["clamp_angle"] == pytest.approx(
        np.exp(3.0 / EVIDENCE_TEMPERATURE)
    )
    assert posterior([ranked("unknown:time", 3.0)]) == {}


def test_a_free_form_cannot_be_chosen_as_a_name():
    with pytest.raises(TypeError, match="unknown:time is no effect"):
        choice(ranked("unknown:time", 3.0), [], base_fit())


def named(name: str, gain: float, confidence: float, of_location: float) -> Choice:
    return Choice(
        effect=effect(name),
        confidence=confidence,
        ln_bayes_factor=gain,
        of_location=of_location,
        before=base_fit(),
        ranking=(),
    )


@pytest.mark.parametrize(
    ("second", "dropped"),
    [
        (("eibm_drift", 12.0, 0.5, 1.0), 1),  # time beside time, and no clear name
        (("eibm_drift", 12.0, 0.9, 1.0), None),  # a clear name
        (("roll_offset", 12.0, 0.5, 0.5), 1),  # several locations would do
        (("roll_offset", 12.0, 0.5, 0.9), None),  # a class, but of one location
        (("eibm_drift", 200.0, 0.5, 1.0), None),  # the stronger of the two
    ],
)
def test_what_several_effects_explain_as_well_is_the_rest_of_a_stronger_one(second, dropped):
    weaker = named(*second)
    assert rest_of_another([named("viscoelastic_creep", 100.0, 1.0, 1.0), weaker]) == dropped
    assert rest_of_another([weaker]) is None
    assert rest_of_another([]) is None


@pytest.mark.parametrize(("gain", "total", "share"), [(5.0, 50.0, 0.1), (-1.0, 50.0, 0.0)])
def test_what_is_left_is_a_share_of_all_there_was(gain, total, share):
    first = ranked("unknown:time", total)
    assert ResidualTerms(
        ln_bayes_factor=gain,
        total=total,
        location="time",
        first=first,
        last=first,
        ln_bayes_factor_beside=gain,
    ).share == pytest.approx(share)


# ------------------------------------------------------------------------------- nulls


def test_the_threshold_is_exceeded_by_one_in_a_hundred():
    random = np.random.default_rng(0)
    found = np.array([threshold(3.0 + random.exponential(2.0, 300)) for _ in range(40)])
    exact = 3.0 - 2.0 * np.log(FALSE_NAME_RATE)
    assert np.mean(found) == pytest.approx(exact, rel=0.05)
    assert np.std(found) < 0.12 * exact
    assert threshold(np.full(30, -4.0)) == 2.0  # never so low that anything would do


@pytest.mark.slow
def test_nulls_are_drawn_as_noise_and_scatter_are_and_repeat_with_their_seed():
    base = base_fit()
    pool = [*candidates(base, [effect("gravity"), effect("force_offset")]), *unknowns(base)]
    told = []
    gains = null_gains(base, pool, 3, 3, lambda share, what: told.append((share, what)))
    assert np.all(np.isfinite(gains))
    assert np.max(gains) < 10.0
    np.testing.assert_array_equal(gains, null_gains(base, pool, 3, 3))
    assert not np.array_equal(gains[:1], null_gains(base, pool, 1, 4))
    assert told[-1] == (1.0, "simulating sessions of the base model")


# ---------------------------------------------------------------------------- outliers


@pytest.mark.slow
def test_each_condition_and_each_set_up_may_be_an_outlier():
    base = base_fit()
    found = [numbers_of(c.name) for c in outlier_candidates(base)]
    assert sorted(n[0] for n in found if len(n) == 1) == list(range(42))
    runs = condition_runs(base.problem)
    for numbers in (n for n in found if len(n) > 1):
        assert len({runs[i] for i in numbers}) == 1
        assert len(numbers) == 3
    assert condition_name(base.problem, 0) == "long, 0 mm, 0 V"
    assert condition_name(base.problem, 41) == "short, 30 mm, -2 V"


@pytest.mark.slow
def test_a_condition_left_out_has_no_say():
    base = base_fit()
    k = 4
    block, size = base.problem.forward.row_block(0), base.problem.forward.row_index.size
    own = block.of_condition(k, size)
    assert set(block.sway_rows[block.sway_of == k]) | set(block.bin_rows[block.bin_of == k])
    problem = without(base, [k])
    assert np.array_equal(problem.noise.fixed != base.problem.noise.fixed, own)
    # of forces and curves alike, whatever their units
    ratio = problem.noise.fixed[own] / variance(base)[own]
    np.testing.assert_allclose(ratio, OUT, rtol=1e-3)
    again = fit_mixed_model(problem, base.theta)
    assert np.all(variance(again)[own] > 1e5 * variance(base)[own])


@pytest.mark.thorough
@pytest.mark.slow
def test_a_slip_of_one_reading_s_force_is_left_out_and_nothing_else():
    m = session()
    odd = replace(m.conditions[4], readings=tuple(
        replace(r, force_N=r.force_N + 6e-4) for r in m.conditions[4].readings))  # fmt: skip
    slipped = means_of(replace(m, conditions=(*m.conditions[:4], odd, *m.conditions[5:])))
    base = fitted(slipped)
    outcome = search(base.problem, base.theta, [effect("gravity"), effect("force_offset")], 6.0)
    assert [condition_name(base.problem, n) for n in outcome.outliers] == ["long, 5 mm, +2 V"]
    assert outcome.final.found == ()
    clean = fitted(means_of(m))
    known = [0, 1, 2, 4, 5, 6]  # B and EIBM; what lies between the nodes of k0 hardly shows
    np.testing.assert_allclose(outcome.base.theta[known], clean.theta[known], rtol=2e-3)


# -------------------------------------------------------------------------- signatures


def test_detection_limits_say_from_which_amplitude_on_an_effect_is_seen():
    lengths = {"force_offset": 0.4, "charging_lag": 2.0, "gravity": 0.0}
    limits = detection_limits(lengths, catalogue())
    assert list(limits) == ["force_offset"]  # a lag has no scale, and no amplitude shows gravity
    assert limits["force_offset"].to_json() == {
        "parameter": "force_mN",
        "value": pytest.approx(0.5),
        "unit": "mN",
    }  # 4 / 0.4 * 0.05 mN


@pytest.fixture(scope="module")
def seen():
    base = base_fit()
    pool = forms(candidates(base, list(catalogue().values())), {})
    return base, pool, signatures(base, pool, {})


@pytest.mark.slow
def test_an_effect_is_no_distance_from_itself_and_parallel_to_itself(seen):
    _, pool, found = seen
    assert found.names == tuple(catalogue())
    np.testing.assert_allclose(np.diag(found.distance), 0.0)
    strong = found.detectability > 0.1
    np.testing.assert_allclose(np.diag(found.cosine)[strong], 1.0)
    assert np.max(np.abs(found.cosine[np.ix_(strong, strong)])) <= 1.0 + 1e-9
    assert len(pool) == len(catalogue())


@pytest.mark.slow
def test_what_the_base_model_has_already_cannot_be_seen(seen):
    base, _, found = seen
    asymmetry = candidates(base, [effect("eibm_asymmetry")])
    alike = [c for c in asymmetry if c.values["fall_mm"] == 0.0]  # along the sheet: an EIBM each
    assert signatures(base, alike, {}).detectability[0] < 0.3 * np.median(found.detectability)
    told = invisible(base, found, catalogue())
    assert set(told) == {n for n, d in zip(found.names, found.detectability, strict=True)
                         if largest_amplitude(effect(n)) * d < 4.0}  # fmt: skip
    assert all(told.values())


@pytest.mark.slow
def test_an_effect_is_invisible_where_no_amplitude_of_a_laboratory_would_show_it(seen):
    """A prior scale is a guess, and a laboratory may have many times as much."""
    base, _, found = seen
    faint = replace(found, detectability=np.full(len(found.names), 0.25))
    told = invisible(base, faint, catalogue())
    assert "force_offset" not in told  # 4 / 0.25 * 0.05 mN = 0.8 mN
    assert told["load_cell_misalignment"].endswith("Here it is seen from 0.8 rad on.")
    gone = replace(found, detectability=np.full(len(found.names), 1e-4))
    told = invisible(base, gone, catalogue())
    assert told["force_offset"].endswith("Here it is not seen at any size that it can have.")
    creep = told["viscoelastic_creep"]  # whose sizes are negative, down to -0.4
    assert creep.endswith("Here it is not seen at any size that it can have.")


@pytest.mark.slow
def test_an_effect_that_failed_is_not_said_to_be_invisible(seen):
    base, _, found = seen
    without = [n not in ("gravity", "force_drift") for n in found.names]
    left = tuple(n for n, kept in zip(found.names, without, strict=True) if kept)
    told = invisible(
        base, replace(found, names=left, detectability=found.detectability[without]), catalogue()
    )
    assert "gravity" not in told
    assert told["force_drift"].startswith("when in the session each reading was taken")


@pytest.mark.parametrize("name", catalogue())
def test_no_effect_is_invisible_for_the_sign_of_its_prior_scale(name):
    assert largest_amplitude(effect(name)) > 0.0


def test_classes_are_of_effects_closer_than_four_sigma_and_an_effect_is_in_one_at_most(seen):
    _, _, found = seen
    groups = classes(found, {})
    names = [n for group in groups for n in group]
    assert len(names) == len(set(names))
    for first, *others in groups:
        at = found.names.index(first)
        for other in others:
            to = found.names.index(other)
            assert min(found.distance[at, to], found.distance[to, at]) < 4.0


# ------------------------------------------------------------------------------ settle


def test_a_fit_ends_where_a_second_one_begins():
    base = base_fit()
    again = fit_mixed_model(base.problem, base.theta, (), base.solution.log_sigma)
    sigma = np.sqrt(np.diag(base.solution.covariance))
    assert np.max(np.abs(again.theta - base.theta) / sigma) < 0.06
    assert again.deviance == pytest.approx(base.deviance, abs=0.05)


@pytest.mark.thorough
@pytest.mark.slow
def test_parameters_are_found_whatever_the_readings_order():
    m = session()
    mixed = tuple(
        replace(c, readings=tuple(sorted(c.readings, key=lambda r: -r.index))) for c in m.conditions
    )
    assert isinstance(mixed[0].readings[0], Reading)
    np.testing.assert_allclose(
        fitted(replace(m, conditions=mixed)).theta, base_fit().theta, rtol=1e-9
    )


def test_an_interval_holds_the_values_of_a_shape_that_explains_as_much():
    relaxing = effect("back_relaxation")

    def fit(deviance: float, loss: float, tau: float):
        values = {"long": {"relative_loss_at_sample": loss, "time_constant_s": tau}}
        sigma = {"long": {"relative_loss_at_sample": 0.002, "time_constant_s": 0.01}}
        found = (Found(effect=relaxing, values=values, sigma=sigma),)
        return replace(base_fit(), found=found, deviance=deviance)

    best, other = fit(100.0, 0.05, 0.1), fit(100.0, 0.02, 0.3)
    alone = Choice(
        effect=relaxing, confidence=1.0, ln_bayes_factor=50.0, of_location=1.0,
        tried=(best,), before=best, ranking=(),
    )  # fmt: skip
    assert with_shapes(best, [alone]) is best
    sigma = with_shapes(best, [replace(alone, tried=(best, other))]).found[-1].sigma["long"]
    assert sigma["relative_loss_at_sample"] == pytest.approx(np.hypot(0.002, 0.03 / np.sqrt(2.0)))
    # of a time constant it is the logarithm that is uncertain
    logs = 0.1 * np.log(3.0) / np.sqrt(2.0)
    assert sigma["time_constant_s"] == pytest.approx(np.hypot(0.01, logs))
    worse = replace(alone, tried=(best, replace(other, deviance=200.0)))
    sigma = with_shapes(best, [worse]).found[-1].sigma["long"]
    assert sigma["time_constant_s"] == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("share", "worth", "named"), [(0.53, 100.0, True), (0.9, 100.0, True), (0.9, 20.0, False)]
)
def test_beside_others_the_form_itself_must_count(monkeypatch, share, worth, named):
    """Half of what a lag seems to be may be a third effect that is not in the model yet."""
    one = SimpleNamespace(known=True, fitted=base_fit(), ln_bayes_factor=worth, name="charging_lag")
    before = SimpleNamespace(found=(SimpleNamespace(effect=effect("gravity")),))
    for name, value in (("form_share", share), ("evidence_beside", worth), ("supported", True)):
        monkeypatch.setattr(searching, name, lambda *_, value=value: value)
    assert (searching._worth(SelectionStep(before, [one]), 6.0) is one) == named


@pytest.mark.parametrize(
    ("free", "first", "second", "replaced"),
    [
        (187.0, 84.0, None, True),  # not even three names of 84 each would do
        (160.0, 84.0, None, False),  # two would
        (95.0, 84.0, None, False),  # one of another form does
        (187.0, 100.0, 20.0, True),
        (187.0, 100.0, 85.0, False),
    ],
)
def test_names_end_where_one_nonparametric_term_stands_for_as_many_as_there_may_be(
    free, first, second, replaced
):
    base, names = SimpleNamespace(deviance=0.0), ["gravity", "clamp_angle"]
    gains = [g for g in (first, second) if g is not None]
    turns = [
        SelectionStep(base, [ranked("unknown:camera", free), ranked("gravity", first)])
        for _ in gains
    ]
    for step, name, gain in zip(turns, names, gains, strict=False):
        step.chosen = ranked(name, gain)
    final = SimpleNamespace(deviance=-2.0 * sum(gains))
    found = searching.SearchResult(base, turns, final)
    assert searching.nonparametric_replaces_any_names(found, 3) is replaced
