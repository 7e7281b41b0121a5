"""Predicted lengths of curves against measured ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from model import Curve, Measurements, SheetModel
from model.discrepancy.verdict.written_model.curve_lengths import length_error
from model.identification.fit import fit
from model.parameter import Parameter
from model.sheet.beam_problem import ActiveEffect
from tests.model.discrepancy.sessions import fitted, means_of, session


def with_curves(change: Callable[[Curve], Curve | None]) -> Measurements:
    bare = means_of(session())
    conditions = [
        replace(c, curve=None if c.curve is None else change(c.curve)) for c in bare.conditions
    ]
    return replace(bare, conditions=tuple(conditions))


def longer(share: float) -> Callable[[Curve], Curve]:
    return lambda curve: replace(
        curve, x_m=(1.0 + share) * curve.x_m, y_m=(1.0 + share) * curve.y_m
    )


def cut(curve: Curve) -> Curve:
    half = slice(0, len(curve.s_m) // 2)
    rows = {name: values[half] for name, values in curve.columns().items()}
    return replace(curve, **rows)


def with_scale(share: float) -> SheetModel:
    """The base model and a camera of another scale."""
    values = {"relative_error": share, "axis": 0.0}
    known = {name: Parameter(value=v, sigma=0.0, unit="") for name, v in values.items()}
    scale = ActiveEffect(name="camera_scale", parameters=known)
    return replace(fit(session()).model, effects=(scale,))


def error_of(measured: Measurements, model: SheetModel | None = None) -> float:
    return length_error(model or fit(session()).model, fitted(measured).problem.forward)


@pytest.mark.slow
def test_curves_are_as_long_as_predicted_or_longer():
    assert error_of(session()) < 2e-4
    assert error_of(with_curves(longer(1e-3))) == pytest.approx(1e-3, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.01, 0.03, 0.08])
def test_a_model_has_no_say_in_which_curves_show_the_whole_sheet(share):
    """One that was 3 % off was compared at no curve, and so counted as right."""
    as_measured = error_of(session(), with_scale(share))
    assert as_measured == pytest.approx(share / (1.0 + share), rel=0.02)
    assert error_of(with_curves(longer(share)), with_scale(share)) < 2e-3


@pytest.mark.slow
def test_curves_that_show_half_of_the_sheet_say_nothing_of_lengths():
    assert np.isnan(error_of(with_curves(cut)))
