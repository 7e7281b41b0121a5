"""A form that may differ makes a parameter uncertain only as far as it is probable that it does."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from model.discrepancy.verdict.written_model.model_averaging import averaged_over_forms
from model.effects import catalogue
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.identification.likelihood.model_state import Found
from tests.model.discrepancy.sessions import Case, Hiding, base_fit

DELAYED = Case((Hiding("frame_delay"),), seed=6)
NAME, KEY = "long", "delay_s"


@cache
def fits() -> tuple[MixedModelFit, MixedModelFit]:
    """The catalogue's own form, and one that may differ."""
    base = base_fit(DELAYED)
    values = {name: {KEY: 0.4, "through_zero": 1.0} for name in base.problem.forward.names}
    one = Found(effect=catalogue()["frame_delay"], values=values)
    tolerant = fit_mixed_model(base.problem, base.theta, (one,))
    exact = fit_mixed_model(base.problem, base.theta, (replace(one, given=()),))
    return exact, tolerant


def sigma(found: tuple[Found, ...]) -> float:
    return found[0].sigma[NAME][KEY]


def value(fitted: MixedModelFit) -> float:
    return fitted.found[0].values[NAME][KEY]


@pytest.mark.slow
def test_a_form_that_the_data_ask_for_leaves_the_parameter_as_uncertain_as_it_makes_it():
    exact, tolerant = fits()
    asked = replace(tolerant, deviance=exact.deviance - 80.0)
    wide = np.hypot(sigma(tolerant.found), value(tolerant) - value(exact))
    assert sigma(averaged_over_forms(exact, asked)) == pytest.approx(wide)


@pytest.mark.slow
def test_a_form_that_the_data_exclude_leaves_it_as_well_known_as_the_data_tell():
    exact, tolerant = fits()
    excluded = replace(tolerant, deviance=exact.deviance + 80.0)
    assert sigma(averaged_over_forms(exact, excluded)) == pytest.approx(
        sigma(exact.found), rel=1e-6
    )
    assert sigma(exact.found) < 0.5 * sigma(tolerant.found)


@pytest.mark.slow
def test_what_other_shapes_make_uncertain_stays():
    exact, tolerant = fits()
    (one,) = tolerant.found
    shaped = {name: {**own, KEY: np.hypot(own[KEY], 0.3)} for name, own in one.sigma.items()}
    several = replace(tolerant, deviance=exact.deviance + 80.0, found=(replace(one, sigma=shaped),))
    assert sigma(averaged_over_forms(exact, several)) == pytest.approx(0.3, rel=0.01)
