"""A camera of another scale stretches a curve and its length: the fit finds by how much."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from model.discrepancy import diagnose
from model.discrepancy.prepare import DiagnoseOptions, prepare
from model.effects import effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.identification.likelihood.model_state import Found
from model.measurements import Curve, FloatArray, Measurements
from tests.cases import few

OVER_M = 0.05
Pictured = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def larger(error: float) -> Pictured:
    return lambda x, y: ((1.0 + error) * x, (1.0 + error) * y)


def askew(error: float) -> Pictured:
    """The scale grows along x."""
    return lambda x, y: ((1.0 + error * x / OVER_M) * x, (1.0 + error * x / OVER_M) * y)


def imaged(made: Measurements, camera: Pictured) -> Measurements:
    """The same session with another camera: s is the length along what it shows."""

    def seen(curve: Curve) -> Curve:
        before = np.hypot(np.diff(curve.x_m), np.diff(curve.y_m))
        x, y = camera(curve.x_m, curve.y_m)
        stretch = np.hypot(np.diff(x), np.diff(y)) / before
        s = np.concatenate([[0.0], np.cumsum(np.diff(curve.s_m) * stretch)])
        return replace(curve, s_m=s, x_m=x, y_m=y)

    conditions = [replace(c, curve=seen(c.curve)) for c in made.conditions if c.curve is not None]
    return replace(made, conditions=tuple(conditions))


def along_the_sheet(made: Measurements, camera: Pictured) -> Measurements:
    """The same, s still the place along the sheet itself: a camera that knows the sheet."""
    conditions = []
    for c in made.conditions:
        assert c.curve is not None
        x, y = camera(c.curve.x_m, c.curve.y_m)
        conditions.append(replace(c, curve=replace(c.curve, x_m=x, y_m=y)))
    return replace(made, conditions=tuple(conditions))


def fitted(made: Measurements, name: str, **values: float) -> MixedModelFit:
    ready = prepare(made, DiagnoseOptions())
    first = {"relative_error": 0.01, **values}
    found = Found(effect=effect(name), values=dict.fromkeys(made.sheets, first), width=10.0)
    return fit_mixed_model(ready.problem, ready.theta, (found,), form=1e-3)


def interval(fit: MixedModelFit) -> tuple[float, float]:
    """The scale's error and its 90 % interval's half width."""
    (one,) = fit.found
    return (
        one.values["long"]["relative_error"],
        1.645 * one.sigma["long"]["relative_error"],
    )


@pytest.fixture(scope="module")
def made(measure) -> Measurements:
    """Without scatter; a little noise, which the fit's uncertainties are of."""
    return measure(force_N=5e-6, curve_m=2e-6, scatter=0.0, positions_mm=(0, 15, 30), free=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    "error", few([-0.05, *(pytest.param(e, marks=pytest.mark.thorough) for e in (0.05, 0.15))])
)
@pytest.mark.parametrize("seen", few([imaged, along_the_sheet]))
def test_a_scale_is_what_it_is(made: Measurements, seen, error: float):
    value, half = interval(fitted(seen(made, larger(error)), "camera_scale", axis=0.0))
    assert value == pytest.approx(error, abs=half)
    assert half < 0.01 * abs(error)


@pytest.mark.slow
def test_a_perspective_is_what_it_is(made: Measurements):
    session = imaged(made, askew(0.05))
    value, half = interval(fitted(session, "camera_perspective", direction_rad=0.0))
    assert value == pytest.approx(0.05, abs=half)
    assert half < 5e-4


@pytest.mark.thorough
@pytest.mark.slow
def test_a_rolled_camera_is_named_and_not_a_sheet_that_is_bent(measure):
    """All set-ups have it, so that it would hide in the scatter of the clamp's direction."""
    cos, sin = np.cos(0.03), np.sin(0.03)
    usual = measure(positions_mm=(0, 10, 20, 30))
    found = diagnose(along_the_sheet(usual, lambda x, y: (cos * x - sin * y, sin * x + cos * y)))
    assert (found.verdict, [one.name for one in found.effects]) == ("effect_named", ["camera_roll"])
    assert found.effects[0].parameters["angle_rad"].value == pytest.approx(0.03, rel=0.02)
