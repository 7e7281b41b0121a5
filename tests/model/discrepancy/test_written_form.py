"""The model that is written is the one that was fitted: its forms act in every prediction."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest

from benchmarks.hidden_effects.predicted import base_model, errors
from benchmarks.hidden_effects.unmeasured import unmeasured
from model import SheetModel, predict
from model.discrepancy import DiagnoseOptions, diagnose
from model.discrepancy.search.nonparametric_terms import all_shapes
from model.discrepancy.verdict.inferred_form import form_of
from model.discrepancy.verdict.written_model.written_form import terms_of
from model.effects import catalogue
from model.effects.conformance import plausible
from model.identification.likelihood.form_error import effect_columns, formed
from model.identification.likelihood.linearisation import linearise
from model.identification.likelihood.model_state import FormWay, Found
from model.identification.observations import observe
from model.identification.residuals import against
from model.locations import location, locations
from model.locations.camera import KNOCK
from model.sheet.free_effect import free_effect
from model.sheet.misfit import misfit
from tests.model.discrepancy.sessions import Case, Hiding, base_fit, diagnosed, fitted, session

OWN_FORM = Case((Hiding("nonuniform_eibm"),), seed=6)
OTHER_FORM = Case((Hiding("nonuniform_stiffness", "line", 0.5),), seed=41)
IN_NO_CATALOGUE = Case((Hiding("local_eibm", "bump", 60.0),), seed=42)
DRIFTING = Case((Hiding("force_drift"),), seed=6)
MORE = (pytest.param(case, marks=pytest.mark.thorough) for case in (OWN_FORM, IN_NO_CATALOGUE))
CASES = [OTHER_FORM, *MORE]
ALIKE = 0.12  # of a wave's length: straight lines between nodes are not quite the finest wave


@cache
def read_back(of: Case) -> SheetModel:
    return SheetModel.from_dict(json.loads(json.dumps(diagnosed(of).model.to_dict())))


def rms(values) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nonlinear_stiffness", "roll_friction", "force_drift", "gravity"])
def test_a_deviation_is_to_a_model_what_it_was_to_the_search(name: str):
    base = base_fit()
    problem, forward = base.problem, base.problem.forward
    values = {n: plausible(catalogue()[name]) for n in forward.names}
    one = Found(effect=catalogue()[name], values=values)
    linear = linearise(forward, problem.bases, problem.noise, base.theta, (one.active,))
    searched = effect_columns(forward, linear, one, (one.active,))[0][:, len(one.parameters()) :]
    same = formed(forward, linear, one, np.zeros(searched.shape[1]))
    of_runs = name == "roll_friction"  # how the sheet came to a position at 0 V is in no file
    assert len(same.ways) == searched.shape[1] - of_runs
    written = effect_columns(forward, linear, same, (same.active,))[0][:, len(one.parameters()) :]
    for before, after in zip(searched.T, written.T, strict=True):
        scale = max(np.linalg.norm(before), 1e-6 * np.linalg.norm(searched))
        assert np.linalg.norm(after - before) < ALIKE * scale or scale < 1e-9


@pytest.mark.slow
def test_each_basis_shape_of_a_location_is_a_term_that_does_the_same():
    base = base_fit()
    forward = base.problem.forward
    for name in locations():
        every = all_shapes(base, name)
        for shape in (one for one in every if one.terms):
            way = FormWay(terms=terms_of(forward, shape), size=0.0, sigma=1.0)
            nothing = {n: dict[str, float]() for n in forward.names}
            one = Found(effect=free_effect(location(name)), values=nothing, ways=(way,))
            (column,) = effect_columns(forward, base.linear, one, (one.active,))[0].T
            apart = np.linalg.norm(column - shape.rows) / np.linalg.norm(shape.rows)
            assert apart < ALIKE, (name, shape.part)
            for term in (one for one in way.terms if one.along == "position"):
                (own,) = term.configurations  # between its positions nothing was measured
                stated = forward.configuration_models[forward.names.index(own)].stated_m
                assert term.at == tuple(np.unique(stated[np.isfinite(stated)]))
        parts = {shape.part for shape in every if not shape.terms}
        without = {part for part in parts if not part.startswith(KNOCK)}
        of_no_mean = {
            "EIBM, pulse", "EIBM, period", "force, period", "place, session", "scale, session",
            "position, run",
        }  # fmt: skip
        at_its_time = {"position"} if name == "eibm" else set[str]()
        assert without <= of_no_mean | at_its_time, name


@pytest.mark.slow
@pytest.mark.parametrize("of", CASES)
def test_the_written_model_predicts_what_the_fit_says_of_the_measured_conditions(of: Case):
    found, model = diagnosed(of), read_back(of)
    assert any(effect.form for effect in model.effects)
    touching = [row for row in found.rows if row.position_m is not None]
    seen = [predict(model, r.configuration, r.position_m, r.voltage_V) for r in touching]
    for row, one in zip(touching, seen, strict=True):
        assert pytest.approx(row.after_N, abs=2e-6) == one.F_N
    # and the errors that the file states are those of the predictions
    stated = rms([one.F_N - row.force_N for row, one in zip(touching, seen, strict=True)])
    assert model.merit["force_rmse_N"] == pytest.approx(stated, rel=1e-3)
    # they are what the file of a fit states, and `compare --model` says
    own, observed = misfit(model, "long"), observe(session(of), "long")
    answers = against(observed, model)
    off = [o.force_N - a.force_N for o, a in zip(observed.observations, answers, strict=True)]
    assert own.force_N == pytest.approx(rms(off), rel=1e-3)
    assert own.curve_m == pytest.approx(rms([a.curve_m for a in answers]), rel=1e-3)
    forces = [o.force_N for o in observed.observations]
    assert own.force_size_N == pytest.approx(rms(forces), rel=1e-3)


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("of", CASES)
def test_the_written_model_predicts_what_nobody_measured(of: Case):
    truth = unmeasured(of)
    assert len(truth) == 20
    written = errors(read_back(of), truth)
    base = errors(base_model(session(of), of), truth)
    assert written[0] < 0.5 * base[0]
    assert written[1] < 0.5 * base[1]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_form_that_only_follows_the_session_is_not_written():
    """A prediction is one amid the session, away from the times that were measured."""
    model = read_back(DRIFTING)
    assert [effect.name for effect in model.effects] == ["force_drift"]
    assert not any(effect.form for effect in model.effects)


@pytest.mark.thorough
@pytest.mark.slow
def test_with_the_written_model_nothing_is_missing_and_no_form_is_let_in_again():
    options = DiagnoseOptions(model=read_back(OTHER_FORM))
    again = diagnose(session(OTHER_FORM), options)
    assert (again.verdict, again.effects, again.unknown) == ("nothing_missing", (), None)
    assert again.model.merit["force_rmse_N"] == pytest.approx(
        read_back(OTHER_FORM).merit["force_rmse_N"], rel=0.1
    )
    known = fitted(session(OTHER_FORM), DiagnoseOptions(model=read_back(OTHER_FORM)))
    (one,), (span,) = known.found, known.spans
    assert span.stop - span.start == len(one.parameters())
    assert form_of(known, 0)[0] == pytest.approx(0.0, abs=1e-9)
