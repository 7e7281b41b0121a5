"""Fits of published models to data of one of them, with known noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from model.dynamics.comparison import (
    MeasuredRun,
    Noise,
    compare_models,
    fit_model,
    split_at,
    split_positions,
)
from model.dynamics.comparison.measured import correlations, residuals, whitened
from model.dynamics.models import DrivenSheet, ModelParameter, PublishedModel, Response, model
from model.dynamics.models.conformance import SHEET
from model.dynamics.models.contract import NO_FRAMES
from model.measurements import Curve, ModelError

NOISE = Noise(force_N=1e-5, current_A=1e-4, curve_m=1e-4)
TRUE = {
    "R1_ohm": 14.0, "C_F": 0.008, "R2_ohm": 300.0, "K1_per_Cm": 3.0e3, "K2_per_Cm": 1.0e3,
    "tau_s": 0.5, "B_Nm2": 1.3e-6,
}  # fmt: skip


def measured(position_m, seed, name="bao", values=TRUE, curves=True):
    """Return a pulse of 1 V and one of -1 V at 100 Hz, as a model and white noise have it."""
    time = np.linspace(0.0, 2.4, 241)
    frames = np.array([60, 119, 180, 239]) if curves else np.zeros(0, dtype=np.int64)
    driven = DrivenSheet(
        sheet=SHEET, position_m=position_m, time_s=time,
        drive_V=np.where(time < 1.2, 1.0, -1.0), frames=frames,
    )  # fmt: skip
    found = model(name).simulate(values, driven)
    random = np.random.default_rng(seed)

    def noisy(exact, sigma):
        return None if exact is None else exact + sigma * random.standard_normal(exact.shape)

    seen = []
    for x, y in zip(*found.curves_m, strict=True) if curves else ():
        s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        seen.append(Curve(s_m=s, x_m=x, y_m=noisy(y, NOISE.curve_m)))
    return MeasuredRun(
        driven=driven, force_N=noisy(found.force_N, NOISE.force_N),
        current_A=noisy(found.current_A, NOISE.current_A), curves=tuple(seen),
    )  # fmt: skip


RUNS = [measured(p, seed) for seed, p in enumerate((0.0, 0.005, 0.01, None))]


def test_a_fit_finds_the_values_that_made_the_data_within_its_intervals():
    fitted = fit_model(model("bao"), RUNS, NOISE)
    for name, true in TRUE.items():
        one = next(p for p in fitted.model.parameters if p.name == name)
        off = np.log(fitted.values[name] / true) if one.positive else fitted.values[name] - true
        assert abs(off) < 4.0 * fitted.sigma[name], name
    assert fitted.determined == {*TRUE}
    assert fitted.chi2_per_value == pytest.approx(1.0, abs=0.1)


def test_force_alone_does_not_determine_what_only_current_tells():
    runs = [replace(run, current_A=None) for run in RUNS[::3]]
    fitted = fit_model(model("bao"), runs, NOISE)
    assert "R2_ohm" not in fitted.determined
    assert "B_Nm2" in fitted.determined


def test_the_model_that_made_the_data_comes_first_and_predicts_them_best():
    fitted_to, held_out = split_positions(RUNS)
    assert [run.driven.position_m for run in held_out] == [0.005]
    others = ("huynh_alici", "bao", "lee", "gonzalez")
    rows = compare_models([model(name) for name in others], fitted_to, held_out, NOISE)
    assert rows[0].title == model("bao").title
    assert rows[0].force_rmse_N == pytest.approx(NOISE.force_N, rel=0.2)
    assert rows[0].current_rmse_A == pytest.approx(NOISE.current_A, rel=0.2)
    by = {row.title: row for row in rows}
    for name in others:
        row = by[model(name).title]
        if name != "bao":
            assert row.force_rmse_N > 1.5 * rows[0].force_rmse_N
            assert np.isnan(row.current_rmse_A)
    assert np.isnan(by[model("huynh_alici").title].curve_rmse_m)


def test_of_two_models_that_fit_alike_the_one_with_fewer_parameters_has_more_evidence():
    """Data of one lag in contact: `lee` (3) against `huynh_alici` (3) and `bao` (7)."""
    values = {"E_Pa": 5e7, "d31_m_per_V": 6e-7, "charging_s": 0.1}
    runs = [measured(p, s, "lee", values, curves=False) for s, p in enumerate((0.0, 0.01))]
    lee, bao = (fit_model(model(name), runs, NOISE) for name in ("lee", "bao"))
    assert lee.chi2_per_value == pytest.approx(1.0, abs=0.15)
    assert bao.chi2_per_value == pytest.approx(lee.chi2_per_value, abs=0.02)
    assert lee.ln_evidence > bao.ln_evidence + 1.0


@dataclass(frozen=True, kw_only=True)
class Proportional(PublishedModel):
    """F = gain (1 N/s) t: linear in its parameter, so its evidence is known exactly."""

    def simulate(self, p, run):
        return Response(force_N=p["gain"] * run.time_s)


def test_the_evidence_of_a_linear_model_is_exact():
    gain = ModelParameter(
        name="gain", meaning="slope", unit="N/s", start=1e-5, low=-1.0, high=1.0, prior_scale=3e-5
    )
    both = frozenset({"force"})
    linear = Proportional(
        name="proportional", title="after nobody", from_source=False, source="none",
        equations="F = gain t", own_reading="", states=(), parameters=(gain,),
        predicts_in_contact=both, predicts_free=both,
    )  # fmt: skip
    run = replace(RUNS[0], current_A=None)
    time, force = run.driven.time_s, run.force_N - np.mean(run.force_N)
    run = replace(run, force_N=force, curves=(), driven=replace(run.driven, frames=NO_FRAMES))
    covariance = 1e-10 * np.eye(len(time)) + 9e-10 * np.outer(time, time)
    exact = multivariate_normal(1e-5 * time, covariance).logpdf(force)
    found = fit_model(linear, [run], NOISE).ln_evidence
    assert found == pytest.approx(exact, abs=1e-3 * abs(exact) ** 0.5)
    seen = replace(run, current_A=np.where(time < 1.0, 1e-3, -1e-3))  # not predicted: normal
    spread = np.std(seen.current_A)
    alone = np.sum(norm(np.mean(seen.current_A), spread).logpdf(seen.current_A))
    assert fit_model(linear, [seen], NOISE).ln_evidence - found == pytest.approx(alone)


def test_a_model_that_predicts_nothing_measured_has_a_row_that_says_so():
    (row,) = compare_models([model("yagasaki")], RUNS[:2], RUNS[2:], NOISE)
    assert "predicts nothing of what was measured" in row.why
    assert np.isnan(row.ln_evidence)


def test_a_pulse_is_held_out_with_the_whole_drive():
    first, second = split_at(RUNS[0], 1.2)
    assert np.isnan(first.force_N).sum() == 121
    assert np.isnan(second.force_N).sum() == 120
    assert list(first.driven.frames) == [60, 119]
    assert list(second.driven.frames) == [180, 239]
    assert second.driven.drive_V is RUNS[0].driven.drive_V
    off = residuals(second, model("bao").simulate(TRUE, second.driven))
    assert np.nanstd(off["force"]) == pytest.approx(NOISE.force_N, rel=0.2)


def test_curves_are_compared_across_and_tips_by_height():
    run = RUNS[3]
    found = model("bao").simulate(TRUE, run.driven)
    off = residuals(run, found)["curve"]
    assert np.std(off) == pytest.approx(NOISE.curve_m, rel=0.35)
    moved = replace(found, curves_m=(found.curves_m[0], found.curves_m[1] + 2e-3))
    assert np.mean(residuals(run, moved)["curve"]) > 1e-3
    tip = residuals(run, replace(found, curves_m=None))["curve"]
    assert np.isnan(tip[:, :-1]).all()
    assert np.abs(tip[:, -1]).max() < 5.0 * NOISE.curve_m


def test_correlated_noise_is_whitened():
    random = np.random.default_rng(3)
    noise = Noise(correlation_s=0.05)
    rho = correlations(RUNS[0], noise)
    assert rho[1] == pytest.approx(np.exp(-0.2))
    long = np.concatenate([[0.0], np.full(20000, rho[1])])
    values = np.zeros(20001)
    values[0] = random.standard_normal()
    for i in range(1, 20001):
        fresh = random.standard_normal() * np.sqrt(1.0 - long[i] ** 2)
        values[i] = long[i] * values[i - 1] + fresh
    values[50:60] = np.nan
    white = whitened(2.0 * values, 2.0, long)
    assert len(white) == 19991
    assert np.std(white) == pytest.approx(1.0, abs=0.02)
    assert abs(np.mean(white[1:] * white[:-1])) < 0.03


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"force_N": np.zeros(3)}, "force of a run needs a value"),
        ({"curves": ()}, "a curve for each"),
    ],
)
def test_measurements_that_do_not_belong_together_are_refused(changed, sentence):
    with pytest.raises(ModelError, match=sentence):
        replace(RUNS[0], **changed)
    with pytest.raises(ModelError, match="positive"):
        Noise(force_N=0.0)
