"""The work along the arc against the sheet's energy, and when an elongation pays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import ModelError, SheetModel, predict_array
from model.design.elongation_map import elongation_map
from model.design.sizing import least_area
from model.design.work import work_along_arc

LOW_M, HIGH_M = 0.0, 0.03


def energy_J(model: SheetModel, name: str, position_m: float, voltage_V: float) -> float:
    """B/2 times the integral of (k - k0 - Me/B)^2: what a frictionless sheet gives off."""
    one = model.sheet(name)
    L, B = one.sheet.free_length_m, one.B.value
    found = predict_array(model, name, position_m, voltage_V)
    inside = found.s_m <= L + 1e-12
    s, k = found.s_m[inside], found.curvature_per_m[inside]
    free = one.rest.field(L)(s) + one.eibm_at(voltage_V)(s) / B
    return float(0.5 * B * np.trapezoid((k - free) ** 2, s))


@pytest.mark.parametrize("name", ["long", "short"])
def test_the_work_is_what_the_sheet_gives_off(truth: SheetModel, name):
    work = work_along_arc(truth, name, LOW_M, HIGH_M)
    for voltage_V, found in work.outward_J.items():
        given_off = energy_J(truth, name, LOW_M, voltage_V) - energy_J(
            truth, name, HIGH_M, voltage_V
        )
        assert found.value == pytest.approx(given_off, abs=3e-8)
    high, low = work.outward_J[2.0].value, work.outward_J[-2.0].value
    assert work.cycle_J.value == pytest.approx(high - low)
    assert work.cycle_J.value > 0
    assert work.voltages_V == (-2.0, 2.0)


def test_the_work_carries_the_uncertainty_of_the_model(truth: SheetModel):
    one = truth.sheet("long")
    unsure = replace(one, B=replace(one.B, sigma=0.05 * one.B.value))
    work = work_along_arc(replace(truth, sheets={"long": unsure}), "long", 0.01, 0.02)
    assert work.cycle_J.sigma == pytest.approx(0.05 * work.cycle_J.value, rel=0.2)


def test_a_section_that_is_not_reachable_has_no_work(truth: SheetModel):
    with pytest.raises(ModelError, match="not reachable everywhere"):
        work_along_arc(truth, "long", 0.0, 0.1)


@pytest.mark.slow
def test_the_map_agrees_with_the_least_area_of_one_section(truth: SheetModel):
    found = elongation_map(truth, "long", [0.0, 0.01], [0.01, 0.02])
    assert np.isnan(found.ratio[1, 0])
    force_N = 5e-4
    for elongated, areas in ((False, found.alone_m2_per_N), (True, found.elongated_m2_per_N)):
        size = least_area(truth, "long", 0.0, 0.02, force_N, elongated=elongated)
        assert areas[0, 1] * force_N == pytest.approx(size.area_m2.value, rel=0.03)
    assert found.ratio[0, 1] < 1.0


@pytest.mark.slow
def test_the_map_keeps_the_margin_of_a_model_that_is_uncertain(truth: SheetModel):
    one = truth.sheet("long")
    eibm = {v: replace(a, sigma=0.1 * np.abs(a.values)) for v, a in one.eibm.items()}
    unsure = replace(truth, sheets={"long": replace(one, eibm=eibm)})
    found = elongation_map(unsure, "long", [0.0], [0.02])
    size = least_area(unsure, "long", 0.0, 0.02, 5e-4, elongated=False)
    assert found.alone_m2_per_N[0, 0] * 5e-4 == pytest.approx(size.area_m2.value, rel=2e-3)


@pytest.mark.slow
def test_a_section_that_no_length_reaches_has_no_sheet_without_an_elongation(truth: SheetModel):
    found = elongation_map(truth, "long", [0.02, 0.04], [0.025, 0.044])
    assert np.isfinite(found.alone_m2_per_N[0, 0])
    assert found.alone_m2_per_N[1, 1] == np.inf  # reached, without a force both ways
    beyond = elongation_map(truth, "long", [0.08], [0.084])
    assert beyond.alone_m2_per_N[0, 0] == np.inf
    with pytest.raises(ModelError, match="no length of this sheet reaches"):
        least_area(truth, "long", 0.08, 0.084, 5e-4, elongated=False)


def test_a_map_without_a_section_is_refused(truth: SheetModel):
    with pytest.raises(ModelError, match="an end above a beginning"):
        elongation_map(truth, "long", [0.02], [0.01])
