"""B, EIBM and errors of a fit on the pages of sessions: whose they are, what, and in which unit."""

from __future__ import annotations

import pytest

from tests.panel_browser.conftest import text_of

ONE = {
    "B_Nm2": 1.2787e-6, "B_sigma": 6.8e-9, "E_Pa": 1.5e8,
    "EIBM_Nm": {"2.0": 36.52e-6, "-2.0": -28.16e-6}, "EIBM_sigma": {"2.0": 1.1e-7, "-2.0": None},
    "EIBM_quantity": "constant EIBM", "kind": "constant", "model": "model.toml",
    "rmse_force_mN": 0.465, "rmse_curve_mm": 1.80,
    "rmse_all_force_mN": 0.330, "rmse_all_curve_mm": 1.27,
}  # fmt: skip
SESSION = {
    "name": "a.h5", "started": "2026-11-21T12:00:00Z", "sheet": ["long", "short"],
    "protocol": "pulse_train", "outcome": "completed", "output": "safe", "reason": "",
    "simulated": True, "runs": 14, "runs_complete": 14, "readings": 448, "invalid": 0,
    "bytes": 12345678, "duration_s": 930.0, "analysed": True, "largest_force_mN": 2.43,
    "scatter_mN": 0.017, "error": None, "log": [],
    "fit": {"long": ONE, "short": ONE | {"rmse_force_mN": 0.036, "rmse_curve_mm": 0.023}},
}  # fmt: skip


def facts(page):
    return text_of(page, ".facts")


def shown(fake, visit, session):
    fake.answers["GET", "/api/library/session"] = session
    page = visit(f"{fake.url}#/session?name=a.h5")
    page.wait_for_selector(".facts dd")
    return " ".join(facts(page).split())


def test_each_sheet_has_its_own_errors_and_the_common_ones_are_named_so(fake, visit):
    said = shown(fake, visit, SESSION)
    assert "RMSE, long force 0.465 mN, curve 1.8 mm" in said
    assert "RMSE, short force 0.036 mN, curve 0.023 mm" in said
    assert "RMSE, all sheets together force 0.33 mN, curve 1.27 mm" in said
    assert "constant EIBM, long, +2 V 36.52 ± 0.11 µN·m" in said
    assert "constant EIBM, long, −2 V −28.16 µN·m" in said
    assert "model file model.toml" in said


@pytest.mark.thorough
def test_errors_that_a_file_states_for_all_sheets_stand_under_none_of_them(fake, visit):
    old = ONE | {"rmse_force_mN": None, "rmse_curve_mm": None}
    said = shown(fake, visit, SESSION | {"fit": {"long": old, "short": old}})
    assert "RMSE, long" not in said
    assert "RMSE, all sheets together force 0.33 mN" in said


@pytest.mark.thorough
def test_the_list_of_sessions_names_the_kind_of_eibm_and_the_file(fake, visit):
    fake.answers["GET", "/api/library"] = {"sessions": [SESSION], "total": 1, "damaged": 0}
    page = visit(f"{fake.url}#/library")
    page.wait_for_selector(".library-table tbody tr")
    said = " ".join(text_of(page, ".library-table").split())
    assert "36.52 at +2 V, −28.16 at −2 V" in said
    assert "constant EIBM; model.toml" in said
    width = "document.querySelector('.library-table')"
    assert page.evaluate(f"{width}.scrollWidth <= {width}.clientWidth")
