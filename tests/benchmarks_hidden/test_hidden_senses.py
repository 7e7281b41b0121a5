"""Every hidden effect changes the data the way its name says, in each of its forms."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from benchmarks.hidden_effects import CATALOGUE, OUTSIDE, Form, Hidden, case, forms_of
from benchmarks.hidden_effects import hidden_session as session
from model import Measurements
from tests.benchmarks_hidden.senses import SENSES

pytestmark = pytest.mark.thorough

SEED = 11
FORMS = [form for effect in (*CATALOGUE, *OUTSIDE) for form in forms_of(effect)]
# A tenth of what a mean force or a curve is uncertain by: far below what these sizes do.
LEAST = {"force": 1e-3, "curve": 1e-4}


@cache
def bare(symmetric: bool) -> Measurements:
    return session(case(seed=SEED, symmetric=symmetric)).measurements


@cache
def hiding(effect: str, form: str) -> Hidden:
    symmetric = effect == "eibm_asymmetry"
    return session(case(effect, form, seed=SEED, symmetric=symmetric))


def test_every_effect_has_a_sense() -> None:
    assert len(OUTSIDE) >= 8
    assert set(SENSES) == {*CATALOGUE, *OUTSIDE}
    slots = {form.slot for effect in OUTSIDE for form in forms_of(effect)}
    assert slots == {
        "rest_curvature", "eibm", "even_moment", "compliance", "position", "load_cell", "camera",
        "time",
    }  # fmt: skip


@pytest.mark.parametrize("form", FORMS, ids=lambda f: f"{f.effect}-{f.form}")
def test_an_effect_changes_the_data_in_the_sense_of_its_name(form: Form) -> None:
    hidden, other = hiding(form.effect, form.form).measurements, bare(form.symmetric)
    change = SENSES[form.effect](hidden) - SENSES[form.effect](other)
    assert change > LEAST[form.felt_by]


def _curves_differ(a: Measurements, b: Measurements) -> bool:
    pairs = zip(a.conditions, b.conditions, strict=True)
    return any(not np.array_equal(c.curve.y_m, d.curve.y_m) for c, d in pairs)  # type: ignore[union-attr]


def _forces_differ(a: Measurements, b: Measurements) -> bool:
    pairs = zip(a.conditions, b.conditions, strict=True)
    return any(
        r.force_N != s.force_N
        for c, d in pairs
        for r, s in zip(c.readings, d.readings, strict=True)
    )


@pytest.mark.parametrize("effect", [*CATALOGUE, *OUTSIDE])
def test_what_the_camera_does_no_force_feels_and_what_the_cell_does_no_curve_shows(
    effect: str,
) -> None:
    (form, *_) = forms_of(effect)
    hidden, other = hiding(effect, form.form).measurements, bare(form.symmetric)
    if form.slot == "camera":
        assert _curves_differ(hidden, other)
        assert not _forces_differ(hidden, other)
    elif form.slot == "load_cell" and effect != "load_cell_compliance":
        assert _forces_differ(hidden, other)
        assert not _curves_differ(hidden, other)
    else:
        assert _forces_differ(hidden, other)
