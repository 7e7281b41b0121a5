"""How far a model is from its own data: when it misses them, and which model a fit prefers."""

from __future__ import annotations

import numpy as np
import pytest

from model import SheetModel, fit
from model.sheet.misfit import misfit
from tests.model.conftest import MakeMeasurements

GOOD = {"force_rmse_N": 3e-5, "curve_rmse_m": 4e-5, "force_rms_N": 2e-3}
ALONG = {"force_rmse_along_N": 3e-5, "curve_rmse_along_m": 3e-5}


@pytest.mark.parametrize(
    ("merit", "misses"),
    [
        ({}, False),  # nothing is stated
        (GOOD, False),
        (GOOD | ALONG, False),
        (GOOD | {"curve_rmse_m": 2.1e-3}, True),  # the paper's constant EIBM of the long sheet
        (GOOD | {"curve_rmse_m": 0.81e-3}, False),  # and its EIBM along the sheet
        (GOOD | ALONG | {"curve_rmse_m": 0.5e-3}, True),
        (GOOD | ALONG | {"curve_rmse_m": 0.2e-3}, False),  # worse, and too little to matter
        (GOOD | ALONG | {"curve_rmse_m": 0.5e-3, "curve_rmse_along_m": 0.4e-3}, False),
        (GOOD | {"force_rmse_N": 5e-4}, True),
        (GOOD | ALONG | {"force_rmse_N": 2e-4}, True),
    ],
)
def test_a_model_misses_where_its_errors_matter_and_another_does_better(
    truth: SheetModel, merit: dict[str, float], misses: bool
):
    model = truth.with_merit(merit, {"long": merit})
    assert misfit(model, "long").misses is misses


def test_older_files_state_the_errors_of_all_configurations_together(truth: SheetModel):
    found = misfit(truth.with_merit(GOOD, {}), "short")
    assert found.in_words == "0.030 mN and 0.040 mm"


@pytest.mark.slow
def test_a_fit_prefers_the_model_that_describes_the_data(
    measure: MakeMeasurements, truth: SheetModel
):
    found = fit(measure(seed=3, names=("long",)))
    assert found.preferred_model is found.model
    stated = misfit(found.model, "long")
    assert stated.known_better
    assert stated.force_size_N == pytest.approx(
        np.sqrt(np.mean([r.force_N**2 for r in found.residuals if np.isfinite(r.force_N)]))
    )


@pytest.mark.slow
def test_a_model_says_whether_its_eibm_is_constant(measure: MakeMeasurements):
    found = fit(measure(seed=3, names=("long",)))
    assert misfit(found.model, "long").constant
    assert not misfit(found.varying_model, "long").constant
