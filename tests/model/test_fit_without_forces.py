"""Curves alone say EIBM/B, k0 and what changes shapes; B is what is stated."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from model import Fit, FitOptions, Measurements, ModelError, fit
from model.discrepancy import DiagnoseOptions, Diagnosis, diagnose
from tests.model.discrepancy.sessions import Case, Hiding, session

EIBM_OVER_B_PER_M = {2.0: 30.0, -2.0: -24.0}  # what is hidden in the long sheet


def of_long(m: Measurements) -> Measurements:
    """Return the curves of the long sheet alone."""
    curves = (replace(c, readings=()) for c in m.conditions if c.configuration == "long")
    return replace(m, sheets={"long": m.sheets["long"]}, conditions=tuple(curves), series=())


@cache
def fitted(stiffness_Nm2: float | None = None) -> Fit:
    return fit(of_long(session(Case(seed=3))), FitOptions(stiffness_Nm2=stiffness_Nm2))


@cache
def diagnosed(*hidden: Hiding) -> Diagnosis:
    return diagnose(of_long(session(Case(hidden, seed=3))))


@pytest.mark.slow
def test_shapes_determine_the_ratio_of_eibm_and_stiffness():
    found = fitted().configurations["long"]
    for voltage, wanted in EIBM_OVER_B_PER_M.items():
        ratio = found.eibm_over_B[voltage]
        assert abs(ratio.value - wanted) < 3.0 * ratio.sigma < 0.015 * abs(wanted)
    assert fitted().rmse["constant"].curve_m < 5e-5


@pytest.mark.slow
def test_what_they_leave_open_is_said_and_not_made_up():
    assert not fitted().configurations["long"].B_known
    said = fitted().to_json()["configurations"]["long"]
    assert (said["B_Nm2"], said["E_Pa"]) == (None, None)
    assert set(said["EIBM_over_B_per_m"]) == {"2.0", "-2.0"}
    assert any("B is not determined by these data, only EIBM/B is" in n for n in fitted().notes)


@pytest.mark.slow
def test_a_stated_stiffness_is_kept_and_scales_the_eibm():
    usual, stated = (f.configurations["long"] for f in (fitted(), fitted(2e-6)))
    assert stated.B.value == pytest.approx(2e-6, rel=1e-5)
    assert stated.eibm_over_B[2.0].value == pytest.approx(usual.eibm_over_B[2.0].value, rel=1e-3)
    assert stated.eibm[2.0].value / usual.eibm[2.0].value == pytest.approx(
        2e-6 / usual.B.value, rel=1e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize("stiffness_Nm2", [0.0, -1e-6, float("nan")])
def test_a_stiffness_that_is_none_is_refused(stiffness_Nm2):
    with pytest.raises(ModelError, match=r"stiffness_Nm2 .* number.* is needed"):
        fit(of_long(session(Case(seed=3))), FitOptions(stiffness_Nm2=stiffness_Nm2))


@pytest.mark.slow
def test_with_nothing_hidden_nothing_is_found_in_shapes():
    assert diagnosed().verdict == "nothing_missing"
    assert set(diagnosed().base["long"]) == {"EIBM/B -2 V", "EIBM/B +2 V"}
    assert any("B is not determined" in note for note in diagnosed().notes)


@pytest.mark.thorough
@pytest.mark.slow
def test_what_changes_shapes_is_found_in_them():
    found = diagnosed(Hiding("camera_scale"))
    assert [one.name for one in found.effects] == ["camera_scale"]
    assert "load_cell_hysteresis" in found.invisible


@pytest.mark.slow
def test_a_stated_stiffness_is_that_of_the_model_that_is_written():
    data = of_long(session(Case(seed=3)))
    found = diagnose(data, DiagnoseOptions(stiffness_Nm2=2e-6))
    assert found.model.sheets["long"].B.value == pytest.approx(2e-6, rel=1e-5)
