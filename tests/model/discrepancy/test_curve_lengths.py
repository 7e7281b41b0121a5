"""Predicted lengths of curves against measured ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from model import Curve, Measurements
from model.discrepancy.verdict.written_model.curve_lengths import length_error
from model.identification.fit import fit
from tests.model.discrepancy.sessions import fitted, means_of, session


def with_curves(change: Callable[[Curve], Curve | None]) -> Measurements:
    bare = means_of(session())
    conditions = [
        replace(c, curve=None if c.curve is None else change(c.curve)) for c in bare.conditions
    ]
    return replace(bare, conditions=tuple(conditions))


def longer(curve: Curve) -> Curve:
    return replace(curve, x_m=1.001 * curve.x_m, y_m=1.001 * curve.y_m)


def cut(curve: Curve) -> Curve:
    half = slice(0, len(curve.s_m) // 2)
    rows = {name: values[half] for name, values in curve.columns().items()}
    return replace(curve, **rows)


def error_of(measured: Measurements) -> float:
    return length_error(fit(session()).model, fitted(measured).problem.forward)


@pytest.mark.slow
def test_curves_are_as_long_as_predicted_or_longer():
    assert error_of(session()) < 2e-4
    assert error_of(with_curves(longer)) == pytest.approx(1e-3, abs=1e-4)


@pytest.mark.slow
def test_curves_that_show_half_of_the_sheet_say_nothing_of_lengths():
    assert np.isnan(error_of(with_curves(cut)))
