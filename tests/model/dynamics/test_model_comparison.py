"""Fits of models to data of one of them, with known noise, and the comparison of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from model.dynamics import ContactSetup, HeldVoltage, Resolution
from model.dynamics.comparison import (
    FullContender,
    MeasuredRun,
    PublishedContender,
    compare_models,
    fit_model,
    hold_out,
)
from model.dynamics.comparison.compared_run import distances_m
from model.dynamics.identification import ChannelNoise, RecordedRun, RecordingNoise, RunPlan
from model.dynamics.identification.noise import Whitening
from model.dynamics.models import ModelParameter, PublishedModel, Response, model, models
from model.dynamics.models.conformance import SHEET
from model.measurements import ModelError
from model.mechanics.field import Field
from tests.cases import few
from tests.model.dynamics.cases import AIR
from tests.model.dynamics.cases import driven as moving
from tests.model.dynamics.compared import NOISE, PULSES, planned, recorded

POSITIONS = (0.0, 0.005, 0.01, None)
COARSE = Resolution(step_s=2e-3, degrees=(6, 2), free_degrees=6, line_terms=6)


def away(contender, seed, sigma=0.3):
    """Values off the start: by 30 %, or a tenth of the prior."""
    random = np.random.default_rng(seed)

    def value(one):
        off = random.standard_normal()
        return (
            one.start * np.exp(sigma * off)
            if one.positive
            else one.start + 0.1 * (off * one.prior_scale)
        )

    return {one.name: value(one) for one in contender.parameters}


def runs_of(contender, values, seed=0, positions=POSITIONS):
    made = [recorded(contender, values, p, seed + i) for i, p in enumerate(positions)]
    return [run for run in made if run is not None]


def contender(name):
    return PublishedContender(model(name))


@pytest.fixture(scope="module")
def bao_runs():
    return runs_of(contender("bao"), away(contender("bao"), 1))


USUAL = ("bao", "lee", "tamagawa")  # in `make test`: each takes seconds


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    few([pytest.param(n, marks=[] if n in USUAL else [pytest.mark.thorough]) for n in models()]),
)
def test_a_model_finds_the_values_that_made_its_own_data_within_its_intervals(name):
    one = contender(name)
    true = away(one, 7)
    runs = runs_of(one, true, seed=7)
    fitted = fit_model(one, runs)
    for p in one.parameters:
        off = (
            np.log(fitted.values[p.name] / true[p.name])
            if p.positive
            else (fitted.values[p.name] - true[p.name])
        )
        assert abs(off) < 4.0 * fitted.sigma[p.name], p.name
    missing = {p.name for p in one.parameters} - fitted.determined
    assert missing <= {"ghm_rad_per_s", "ghm_damping"}  # of a damped oscillator only the ratio
    assert set(fitted.misfit.values()) == {1.0}
    count = sum(len(run.values(q).ravel()) for run in runs for q in run.measured)
    assert fitted.chi2_per_value == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / count))


@pytest.mark.thorough
@pytest.mark.slow
def test_the_full_model_is_one_of_them():
    start = moving(fluid=AIR, rest=Field.constant(5.0, SHEET.free_length_m))
    full = FullContender(start, COARSE)
    true = {one.name: one.start for one in full.parameters}
    runs = runs_of(full, true, positions=(0.0, None))
    fitted = fit_model(full, runs, away(full, 2, sigma=0.05))
    for p in full.parameters:
        assert abs(np.log(fitted.values[p.name] / true[p.name])) < 4.0 * fitted.sigma[p.name]
    assert {"B", "mass_per_length", "capacitance", "share_1"} <= fitted.determined
    assert set(fitted.misfit.values()) == {1.0}


@pytest.mark.slow
def test_force_alone_does_not_determine_what_only_current_tells(bao_runs):
    fitted = fit_model(contender("bao"), [run.only("force") for run in bao_runs[::2]])
    assert "R2_ohm" not in fitted.determined
    assert "B_Nm2" in fitted.determined
    assert list(fitted.misfit) == ["force"]


@pytest.mark.slow
def test_the_model_that_made_the_data_comes_first_and_predicts_them_best(bao_runs):
    data = hold_out(bao_runs)
    names = ("huynh_alici", "bao", "lee", "gonzalez")
    told = []
    rows = compare_models(
        [contender(name) for name in names], data, lambda *_: None,
        lambda share, text: told.append((share, text)),
    )  # fmt: skip
    assert told == [(i / 4, model(name).title) for i, name in enumerate(names)]
    first, by = rows[0], {row.name: row for row in rows}
    assert first.name == "bao"
    assert first.scores["force"].rmse == pytest.approx(NOISE.force.white, rel=0.2)
    assert first.scores["current"].rmse == pytest.approx(NOISE.current.white, rel=0.2)
    assert first.scores["shape"].share == 1.0
    for name in ("huynh_alici", "lee", "gonzalez"):
        mine, best = by[name].scores, first.scores
        assert mine["force"].rmse > 1.5 * best["force"].rmse
        assert mine["force"].ln_evidence < best["force"].ln_evidence - 50.0
        assert "current" not in mine
    assert set(by["huynh_alici"].scores) == {"force"}


@pytest.mark.thorough
@pytest.mark.slow
def test_of_two_models_that_fit_alike_the_one_with_fewer_parameters_has_more_evidence():
    """Data of one lag in contact: `lee` (3) against `bao` (7)."""
    lee, bao = contender("lee"), contender("bao")
    runs = [run.only("force") for run in runs_of(lee, away(lee, 3), positions=(0.0, 0.01))]
    one, other = fit_model(lee, runs), fit_model(bao, runs)
    assert one.misfit == other.misfit == {"force": 1.0}
    assert one.ln_evidence > other.ln_evidence + 1.0


@dataclass(frozen=True, kw_only=True)
class Proportional(PublishedModel):
    """F = gain (1 N/s) t: linear in its parameter, so its evidence is known exactly."""

    def simulate(self, p, run):
        return Response(force_N=p["gain"] * np.maximum(run.time_s, 0.0))


GAIN = ModelParameter(
    name="gain", meaning="slope", unit="N/s", start=1e-5, low=-1.0, high=1.0, prior_scale=3e-5
)
LINEAR = PublishedContender(Proportional(
    name="proportional", title="after nobody", from_source=False, source="none",
    equations="F = gain t", own_reading="", states=(), parameters=(GAIN,),
    predicts_in_contact=frozenset({"force"}), predicts_free=frozenset({"force"}),
))  # fmt: skip
DRIFTING = RecordingNoise(
    force=ChannelNoise(white=1e-5, zero=2e-5, drift_per_sqrt_s=3e-5, hum=2e-5),
    current=ChannelNoise(white=1e-4), curve_m=1e-4, mains_hz=30.0,
)  # fmt: skip


def covariance(noise, t):
    """Of what a channel records: white noise, zero, drift and hum between knots 1 s apart."""
    knots = np.linspace(t[0], t[-1], int(np.ceil(t[-1] - t[0])) + 1)
    hats = np.stack([np.interp(t, knots, row) for row in np.eye(len(knots))])
    hum = sum(np.outer(h, h) for h in hats) * np.cos(2 * np.pi * 30.0 * (t[:, None] - t))
    walk = noise.drift_per_sqrt_s**2 * np.minimum(t[:, None], t)
    return noise.white**2 * np.eye(len(t)) + noise.zero**2 + walk + noise.hum**2 * hum


def test_the_whitening_knows_its_determinant():
    t = np.arange(0.0, 2.0, 0.05)
    white = Whitening(DRIFTING.force, t, 30.0)
    exact = -0.5 * np.linalg.slogdet(covariance(DRIFTING.force, t))[1]
    assert white.ln_determinant == pytest.approx(exact, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [NOISE, DRIFTING])
def test_the_evidence_of_a_linear_model_is_exact(noise):
    from scipy.stats import multivariate_normal, norm  # slow to import

    t = np.arange(0.0, 2.5, 5e-3)
    C = covariance(noise.force, t)
    force = 4e-5 * t + np.random.default_rng(1).multivariate_normal(0.0 * t, C)
    plan = replace(planned(0.0), frame_s=np.zeros(0), points_m=np.zeros(0), current=False)
    run = MeasuredRun(run=RecordedRun(plan=plan, force_N=force), sheet=SHEET, noise=noise)
    exact = multivariate_normal(1e-5 * t, C + 9e-10 * np.outer(t, t)).logpdf(force)
    found = fit_model(LINEAR, [run]).ln_evidence
    assert found == pytest.approx(exact, abs=0.01)
    current = np.where(t < 1.0, 1e-3, -1e-3)  # not predicted: normal about its mean
    seen = RecordedRun(plan=replace(plan, current=True), force_N=force, current_A=current)
    far = np.min(np.abs(t[:, None] - PULSES.time_s), axis=1) > 2e-4  # from the edges
    alone = np.sum(norm(np.mean(current[far]), np.std(current[far])).logpdf(current[far]))
    both = fit_model(LINEAR, [replace(run, run=seen)]).ln_evidence
    assert both - found == pytest.approx(alone, abs=0.01)


@pytest.mark.thorough
def test_a_bad_prediction_of_one_quantity_does_not_silence_the_others(bao_runs):
    """`yim` has no leak: its current is wrong, and its force, shape and evidence are not worse."""
    leaking = contender("bao")
    values = away(leaking, 1) | {"R2_ohm": 20.0}
    runs = runs_of(leaking, values, positions=(0.0, 0.01))
    fitted = fit_model(contender("yim"), runs)
    assert fitted.misfit["current"] > 20.0
    alone = fit_model(contender("yim"), [run.only("force") for run in runs if run.plan.force])
    assert fitted.misfit["force"] < 2.0 * alone.misfit["force"]
    assert fitted.ln_evidence > fit_model(contender("lee"), runs).ln_evidence


def test_a_model_that_predicts_nothing_measured_has_a_row_that_says_so(bao_runs):
    held = [run for run in bao_runs if run.position_m is not None]
    (row,) = compare_models([contender("yagasaki")], hold_out(held), lambda *_: None)
    assert "predicts nothing of what was measured" in row.why
    assert np.isnan(row.ln_evidence)
    assert row.scores == {}


def test_the_middle_position_and_the_last_pulses_are_held_out(bao_runs):
    data = hold_out(bao_runs)
    assert [run.position_m for run in data.fitted] == [0.0, 0.01, None]
    assert [run.position_m for run in data.predicted] == [0.0, 0.005, 0.01, None]
    assert data.in_words == "all at 5 mm and the last third of the pulses of each other run"
    first, last = data.fitted[0].plan, data.predicted[0].plan
    assert first.time_s[-1] < 1.9 <= last.time_s[0]  # the last edge of four
    assert first.frame_s[-1] < 1.9 <= last.frame_s[0]
    assert last.drive is first.drive


def test_a_run_of_one_pulse_is_cut_in_time(bao_runs):
    """A release: an edge to the voltage, and one back."""
    free = bao_runs[-1]
    drive = HeldVoltage(np.array([0.1, 0.7]), np.array([1.0, 0.0]))
    plan = replace(free.plan, drive=drive)
    release = replace(free, run=replace(free.run, plan=plan))
    data = hold_out([release])
    assert data.predicted[0].plan.time_s[0] == pytest.approx(2.0 / 3.0 * 2.495, abs=6e-3)
    assert data.in_words == "the last third of the pulses of each other run"


def test_samples_at_a_voltage_edge_do_not_count(bao_runs):
    run = bao_runs[0]
    edges = np.searchsorted(run.plan.time_s, [0.1, 0.7, 1.3, 1.9])
    said = contender("bao").respond(away(contender("bao"), 1), run)
    wrong = said.current_A.copy()
    wrong[edges] += 1.0  # the voltage before the edge instead of that after it
    same = run.residuals(replace(said, current_A=wrong), "current")
    assert len(same) == len(run.plan.time_s) - 4
    assert np.std(same) == pytest.approx(NOISE.current.white, rel=0.15)


def test_distances_are_signed_and_go_on_straight_beyond_the_end():
    x, y = np.array([[0.0, 1.0, 2.0]]), np.array([[0.0, 0.0, 1.0]])
    points = np.array([[0.5, 3.0, np.nan]]), np.array([[0.25, 1.0, 0.0]])
    found = distances_m(*points, x, y)[0]
    assert found[0] == pytest.approx(-0.25)  # the line lies below the point
    assert found[1] == pytest.approx(np.sqrt(0.5))
    assert np.isnan(found[2])


def test_a_load_cell_that_moves_is_refused_in_a_sentence(bao_runs):
    setup = ContactSetup(radius_m=0.04, position_m=lambda t: 0.001 * t)
    plan = RunPlan(drive=PULSES, time_s=np.arange(3.0), setup=setup, current=False, name="step")
    with pytest.raises(ModelError, match="step: the load cell moves during the run"):
        MeasuredRun(run=RecordedRun(plan=plan, force_N=np.zeros(3)), sheet=SHEET, noise=NOISE)
