"""A sheet cut to another length keeps its material: effects belong to places along the sheet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import Along, Parameter, SheetModel
from model.design.force_map import force_map, resized
from model.sheet.beam_problem import ActiveEffect, Profile
from model.sheet.solution import free_curvature

LENGTHS_M = (0.047, 0.05, 0.07, 0.1)
POSITIONS_M = (0.0, 0.005, 0.01)
VOLTS = (-2.0, 0.0, 2.0)
FALL_M = 0.012


def falling() -> ActiveEffect:
    decay = Parameter(value=1e3 * FALL_M, sigma=0.0, unit="mm")
    return ActiveEffect(name="nonuniform_eibm", parameters={"decay_length_mm": decay})


def stiffer(change: float = 2.0) -> ActiveEffect:
    much = Parameter(value=change, sigma=0.0, unit="")
    return ActiveEffect(name="nonuniform_stiffness", parameters={"relative_change": much})


def formed() -> ActiveEffect:
    at, values = (0.0, 0.02, 0.05), (0.3, -0.2, 0.1)
    term = Profile(along="s", at=at, values=values, sigma=(0.0,) * 3, unit="")
    return replace(falling(), form=(term,))


def unknown(location: str, *values: float) -> ActiveEffect:
    at = tuple(np.linspace(0.0, 0.05, len(values)))
    term = Profile(along="s", at=at, values=values, sigma=(0.0,) * len(values), unit="")
    return ActiveEffect(name="unknown", location=location, form=(term,))


MATERIAL = {
    "falling EIBM": (falling(),),
    "stiffness": (stiffer(),),
    "stiffness that falls": (stiffer(-0.6),),
    "both": (falling(), stiffer()),
}
INFERRED = {
    "form": (formed(),),
    "unknown compliance": (unknown("compliance", 0.1, -0.1, 0.2),),
    "unknown EIBM": (unknown("eibm", 0.1, -0.1, 0.2),),
}


def curvature(model: SheetModel, length_m: float, s_m: np.ndarray) -> np.ndarray:
    """Free curvature of a sheet of that length at its highest voltage, 1/m."""
    cut = resized(model, "long", length_m, 0.0)
    return np.asarray(free_curvature(cut.setup("long", None, 2.0))(s_m))


@pytest.mark.parametrize("effects", MATERIAL.values(), ids=MATERIAL)
def test_a_place_keeps_its_curvature_however_long_the_sheet_is(truth, effects):
    s_m = np.linspace(0.0, 0.046, 12)
    found = [curvature(truth.with_effects(*effects), length, s_m) for length in LENGTHS_M]
    assert np.ptp(found, axis=0).max() < 1e-4  # of 100


@pytest.mark.slow
@pytest.mark.parametrize("effects", MATERIAL.values(), ids=MATERIAL)
def test_what_lies_beyond_the_contact_changes_nothing(truth, effects):
    model = truth.with_effects(*effects)
    maps = [
        force_map(resized(model, "long", length, 0.0), "long", POSITIONS_M, VOLTS)
        for length in LENGTHS_M
    ]
    assert all(one.all_reachable() for one in maps)
    assert max(one.s_hat_m.max() for one in maps) < LENGTHS_M[0]
    for one in maps:
        np.testing.assert_allclose(one.s_hat_m, maps[1].s_hat_m, rtol=1e-5)
        np.testing.assert_allclose(one.tangential_N, maps[1].tangential_N, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("effects", INFERRED.values(), ids=INFERRED)
def test_an_inferred_form_stays_at_its_places(truth, effects):
    model = truth.with_effects(*effects)
    maps = [
        force_map(resized(model, "long", length, 0.0), "long", POSITIONS_M, VOLTS).tangential_N
        for length in LENGTHS_M
    ]
    spread = np.ptp(np.abs(maps[1:]), axis=0)  # longer ones: the same polynomials to the last digit
    np.testing.assert_allclose(spread, 0.0, atol=1e-6 * np.abs(maps[1]).max())
    # a shorter one has polynomials of its own through the kinks of a form
    np.testing.assert_allclose(maps[0], maps[1], rtol=0.02, atol=1e-5)


def test_an_effect_and_the_same_material_written_down_are_cut_alike(truth):
    """The falling EIBM as an effect, and as values along the sheet, as a fit has it."""
    one = truth.sheet("long")
    s = np.linspace(0.0, 0.05, 201)
    shape = np.exp(-s / FALL_M) * (0.05 / FALL_M / -np.expm1(-0.05 / FALL_M))
    along = {
        volts: Along(s, a.values[0] * shape, np.zeros(len(s)), a.unit)
        for volts, a in one.eibm.items()
    }
    written = replace(truth, sheets={"long": replace(one, eibm=along)})
    for length in (0.02, 0.05, 0.1):
        elongation = 0.06 if length < 0.04 else 0.0
        found = [
            force_map(
                resized(model, "long", length, elongation), "long", POSITIONS_M, VOLTS
            ).tangential_N
            for model in (truth.with_effects(falling()), written)
        ]
        np.testing.assert_allclose(found[0], found[1], rtol=2e-3, atol=2e-7)


def test_a_sheet_that_is_cut_twice_still_knows_the_measured_length(truth):
    model = truth.with_effects(falling())
    once = resized(model, "long", 0.03, 0.05)
    twice = resized(resized(model, "long", 0.1, 0.0), "long", 0.03, 0.05)
    maps = [force_map(m, "long", POSITIONS_M, VOLTS).tangential_N for m in (once, twice)]
    np.testing.assert_array_equal(maps[0], maps[1])
