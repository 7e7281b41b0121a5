"""A session of a larger or smaller rig has the same answer, in its own lengths and forces."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from model.discrepancy import Diagnosis, diagnose
from model.identification.baselines import compare
from model.identification.fit import Fit, fit
from model.measurements import Measurements, RigScale, scale_of_measurements
from tests.cases import few
from tests.fits_unchecked import fits_unchecked
from tests.model.discrepancy.sessions import Case, Hiding, session
from tests.model.scaled import scaled

# a strip of metal of half a metre, and a microstrip of 5 mm
SIZES = few([(10.0, 1e4), (0.1, 1e-4)], first=2)
HIDDEN = Case((Hiding("force_offset"), Hiding("clamp_angle")), seed=31)


@cache
def fitted() -> Fit:
    """As it was made; each size is compared with it."""
    return fit(session())


@cache
def diagnosed() -> Diagnosis:
    """The same of what is hidden."""
    with fits_unchecked():
        return diagnose(session(HIDDEN))


@pytest.mark.slow
@pytest.mark.parametrize(("length", "force"), SIZES)
def test_a_fit_of_another_size_has_the_same_numbers_and_intervals(length, force):
    as_made, other = fitted(), fit(scaled(session(), length, force))
    units = {"B": force * length**2, "B_per_width": force * length, "E": 1.0}
    for name, one in as_made.configurations.items():
        found = other.configurations[name].parameters()
        for what, p in one.parameters().items():
            by = units.get(what, force if "width" in what else force * length)
            assert found[what].value / by == pytest.approx(p.value, rel=1e-4), what
            assert found[what].sigma / by == pytest.approx(p.sigma, rel=1e-2), what
    for kind, errors in as_made.rmse.items():
        assert other.rmse[kind].force_N / force == pytest.approx(errors.force_N, rel=1e-3)
        assert other.rmse[kind].curve_m / length == pytest.approx(errors.curve_m, rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize(("length", "force"), SIZES)
def test_a_diagnosis_of_another_size_names_the_same_with_the_same_probability(length, force):
    as_made = diagnosed()
    with fits_unchecked():
        other = diagnose(scaled(session(HIDDEN), length, force))
    assert as_made.effects
    assert [e.name for e in other.effects] == [e.name for e in as_made.effects]
    for one, same in zip(as_made.effects, other.effects, strict=True):
        assert same.probability == pytest.approx(one.probability, abs=0.03)
    evidence = {r.name: r.log_bayes for r in as_made.ranking}
    assert {r.name: r.log_bayes for r in other.ranking} == pytest.approx(evidence, abs=0.5)


def test_sessions_of_about_the_paper_s_size_have_its_numbers():
    assert scale_of_measurements(session()) == RigScale()
    assert scale_of_measurements(scaled(session(), 1.3, 2.0)) == RigScale()
    larger = scale_of_measurements(scaled(session(), 10.0, 1e4))
    assert larger.length == pytest.approx(10.0)
    assert 0.5e4 < larger.force < 2e4


@pytest.mark.slow
@pytest.mark.parametrize(("length", "force"), SIZES)
def test_simpler_models_are_fitted_alike_at_another_size(length, force):
    """The full model's B is that of the fit: forces and curves both count."""
    rows = {row.model: row for row in compare(scaled(short(), length, force))}
    for row in compare(short()):
        same = rows[row.model]
        assert same.B_Nm2 / (force * length**2) == pytest.approx(row.B_Nm2, rel=1e-3)
        assert same.force_rmse_N / force == pytest.approx(row.force_rmse_N, rel=1e-3)
        assert same.curve_rmse_m / length == pytest.approx(row.curve_rmse_m, rel=1e-2)


def short() -> Measurements:
    """The session's short sheet, of 4.5 mm."""
    m = session()
    conditions = tuple(one for one in m.conditions if one.configuration == "short")
    return replace(m, sheets={"short": m.sheets["short"]}, conditions=conditions, series=())
