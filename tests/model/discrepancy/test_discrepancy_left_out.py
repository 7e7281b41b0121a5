"""What is predicted of a position comes from the others alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.discrepancy.prepare import DiagnoseOptions
from model.discrepancy.search.cross_validation import (
    left_out,
    left_out_rows,
    position_groups,
    predictive_gains,
    when_left_out,
)
from model.discrepancy.search.nonparametric_terms import shapes
from model.discrepancy.verdict.prediction_error import (
    cells,
    closed_gap,
    closed_share,
    floor,
    refitted,
    variance,
)
from model.discrepancy.verdict.prediction_error import gap as gap_of
from model.discrepancy.verdict.result import BeforeAfter, Gap
from model.discrepancy.verdict.written_model.left_out_gain import columns_asked_for, forms_asked_for
from model.identification.likelihood.linearisation import with_columns
from model.identification.likelihood.mixed_model import inverse_symmetric
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from tests.model.discrepancy.sessions import Case, Extras, Hiding, base_fit, diagnosed

SYMMETRIC = Case((Hiding("eibm_asymmetry"),), seed=7, symmetric=True)


def test_residuals_of_a_position_are_those_of_a_fit_without_its_runs():
    base = base_fit()
    row_index, linear = base.problem.forward.row_index, base.linear
    runs = position_groups(base)[2]
    before, after, chosen = left_out(base, base, [], [runs])
    V = np.linalg.inv(base.solution.weights)
    information, pull = np.diag(linear.data.precision), -linear.data.precision * linear.data.away
    for r in range(len(row_index.runs)):  # run by run with plain least squares of whitened rows
        if r not in runs:
            rows = np.flatnonzero(row_index.run_of == r)
            own = row_index.row_of[rows]
            white = np.linalg.inv(np.linalg.cholesky(V[r][np.ix_(own, own)]))
            X, y = white @ linear.columns[rows], white @ linear.residual[rows]
            information, pull = information + X.T @ X, pull + X.T @ y
    beta = inverse_symmetric(information) @ pull
    out = np.isin(row_index.run_of, runs)
    wanted = (linear.residual - linear.columns @ beta)[out]
    np.testing.assert_allclose(before[out], wanted, rtol=1e-5, atol=1e-5 * np.std(wanted))
    np.testing.assert_array_equal(before[out], after[out])
    np.testing.assert_array_equal(before[~out], refitted(base)[~out])
    assert chosen == [""]


def test_a_position_is_left_out_of_both_sheets_and_free_shapes_of_none():
    groups = position_groups(base_fit())
    runs = base_fit().problem.forward.row_index.runs
    assert [{runs[r][1] for r in g} for g in groups] == [{k * 5e-3} for k in range(7)]
    assert all({runs[r][0] for r in g} == {"long", "short"} for g in groups)


@pytest.mark.slow
def test_no_free_shape_counts_among_what_was_left_out():
    some = Case((), seed=1, extras=Extras(free_shapes=True))
    base, told = base_fit(some), diagnosed(some).held_out.before
    where = cells(base)
    own = where.within(left_out_rows(base))
    every = [one for v in base.problem.forward.data_vectors for one in v.seen]
    free = sum(one.free and not one.zero for one in every)
    assert free > 0
    assert len(own.force) == len(where.force)
    assert len(own.curve) == len(where.curve) - free
    left = when_left_out(base)
    assert told.curve_rmse_mm == gap_of(left, variance(base), own).curve_rmse_mm
    assert told.curve_rmse_mm != gap_of(left, variance(base), where).curve_rmse_mm


def test_a_model_is_not_more_likely_than_itself():
    base = base_fit()
    np.testing.assert_allclose(predictive_gains(base, base), 0.0, atol=1e-9)


def gap(
    force: float, curve: float = 0.01, drift: float = 0.01, sway: float = 0.01, chi2: float = 1.0
) -> Gap:
    return Gap(
        force_rmse_mN=force,
        curve_rmse_mm=curve,
        chi2_per_dof=chi2,
        drift_rmse_mN=drift,
        pulse_rmse_mN=0.01,
        drift_rmse_mm=sway,
    )


@pytest.mark.parametrize(
    ("before", "after", "share"),
    [
        (gap(0.5), gap(0.03), 1.0),  # down to the noise
        (gap(0.5), gap(0.5), 0.0),
        (gap(0.5), gap(0.02), 1.0),  # no better than the noise
        (gap(0.5), gap(0.25), 1.0 - (0.25**2 - 0.03**2) / (0.5**2 - 0.03**2)),
        (gap(0.1, 0.4), gap(0.1, 0.01), 1.0),  # of the curves, which stand out more
        (gap(0.04, 0.02, 0.09), gap(0.04, 0.02, 0.01), 1.0),  # of what goes on along a run
        (gap(0.04, 0.02, 0.01, 0.09), gap(0.04, 0.02, 0.01, 0.01), 1.0),  # of shapes, likewise
        (gap(0.04, chi2=9.0), gap(0.04, chi2=1.4), 0.95),  # of fine shapes, in units of the noise
        (gap(0.04, 0.01, 0.014), gap(0.03, 0.01, 0.014), 1.0),  # which may be noise
        (gap(0.02, 0.009), gap(0.02, 0.009), np.nan),  # there was no gap
        (gap(0.031, 0.009), gap(0.01, 0.009), np.nan),  # within the noise of the floor
    ],
)
def test_the_share_of_the_gap_that_is_closed(before, after, share):
    found = closed_share(BeforeAfter(before, after), gap(0.03))
    assert found == pytest.approx(share, nan_ok=True)


@pytest.mark.parametrize(
    ("force", "curve", "quantity"),
    [
        (0.03, 0.01, "force and neutral curve"),
        (np.nan, 0.01, "neutral curve"),
        (0.03, np.nan, "force"),
    ],
)
def test_the_gap_in_units_of_the_noise_is_of_what_was_measured(force, curve, quantity):
    both = BeforeAfter(gap(force, curve, chi2=9.0), gap(force, curve, chi2=1.4))
    found = closed_gap(both, gap(force, curve, chi2=1.0))
    assert found is not None
    assert found.quantity == quantity


def test_variances_are_those_of_noise_and_scatter_together():
    base = base_fit()
    row_index, data = base.problem.forward.row_index, base.linear.data
    sigma2 = np.exp(2.0 * base.solution.log_sigma)
    groups = sum(s * np.sum(Z**2, axis=2) for s, Z in zip(sigma2, data.groups, strict=False))
    masks = sum(s * m for s, m in zip(sigma2[len(data.groups) :], data.masks, strict=True))
    whole = (data.fixed + groups + masks)[row_index.run_of, row_index.row_of]
    np.testing.assert_allclose(variance(base), whole, rtol=1e-6)


@pytest.mark.thorough
def test_an_effect_that_scatter_could_swallow_is_still_chosen_without_each_position():
    """Its size from set-up to set-up would be an EIBM that scatters, had it no name."""
    found = diagnosed(SYMMETRIC, DiagnoseOptions(symmetric=True))
    assert [e.name for e in found.effects] == ["eibm_asymmetry"]
    assert found.closed > 0.9
    assert not any("with a position left out" in note for note in found.notes)
    before, after = found.held_out.before, found.held_out.after
    assert after.force_rmse_mN < 0.4 * before.force_rmse_mN


def test_without_its_positions_nothing_else_changes():
    base = base_fit()
    none = left_out(base, replace(base), [], [])
    np.testing.assert_array_equal(none[0], refitted(base))


def test_conditions_left_out_as_outliers_count_for_no_gap():
    base = base_fit()
    whole, some = cells(base), cells(base, [4, 41])
    block = base.problem.forward.row_block(0)
    rows = set(block.trend_rows[block.trend_of == 4])
    counted = [set(np.concatenate([*c.force, *c.drift]).tolist()) for c in (whole, some)]
    assert rows <= counted[0]
    assert not rows & counted[1]
    assert [len(c.force) for c in (whole, some)] == [42, 40]
    assert [len(c.curve) for c in (whole, some)] == [42, 40]
    noise = np.ones(base.problem.forward.row_index.size)
    noise[list(rows)] = 1e6
    assert floor(noise, some).force_rmse_mN == pytest.approx(1e3)
    assert gap_of(3.0 * np.ones(len(noise)), noise, some).force_rmse_mN == pytest.approx(3e3)


def with_hidden(part: str) -> tuple[MixedModelFit, list[str]]:
    """The load cell's free form in a fit to data in which one of its parts is; the parts."""
    base, every = base_fit(), shapes(base_fit(), "load_cell")
    columns = np.stack([one.rows for one in every], axis=1)
    hidden = np.array([one.part == part for one in every])
    linear = with_columns(base.problem.forward, base.linear, columns)
    residual = base.linear.residual + columns @ np.where(hidden, 1.0, 0.0)
    span = slice(base.linear.columns.shape[1], linear.columns.shape[1])
    final = replace(base, linear=replace(linear, residual=residual), spans=(*base.spans, span))
    return final, [one.part for one in every]


@pytest.mark.parametrize("part", ["force", "zero, session", "polarity"])
def test_a_part_of_something_unknown_that_follows_the_noise_is_not_written(part: str):
    final, parts = with_hidden(part)
    assert len(set(parts)) == 6
    kept = {parts[i] for i in columns_asked_for(final, parts)}
    assert part in kept
    # beside it only a place under voltage, which this session's scatter happens to resemble
    assert kept <= {part, "voltage"}


def test_of_something_unknown_a_single_part_stays():
    final, parts = with_hidden("force")
    assert len(columns_asked_for(final, ["all"] * len(parts))) == len(parts)


def test_without_names_there_is_no_form_to_leave_out():
    final, _ = with_hidden("force")
    assert forms_asked_for(base_fit(), final)
