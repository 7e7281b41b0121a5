"""Models of stated numbers: what nobody can mean is refused before it is solved."""

from __future__ import annotations

import numpy as np
import pytest

from model import ModelError, SheetGeometry
from model.sheet.stated import stated_model


@pytest.fixture
def sheet() -> SheetGeometry:
    return SheetGeometry(
        configuration="long",
        free_length_m=0.05,
        width_m=0.011,
        thickness_m=2.1e-4,
        elongation_m=0.0,
        arc_radius_m=0.04,
        arc_origin_rad=0.0,
        initial_curvature=None,
    )


@pytest.mark.parametrize(
    ("B_Nm2", "eibm"),
    [
        (1.3e-6, 36.0),  # in uN m
        (1.3e-6, -0.036),
        (1.3e-6, (np.array([0.0, 0.05]), np.array([36e-6, 36.0]))),
        (1e-13, 36e-6),
    ],
)
def test_an_eibm_that_winds_the_sheet_up_is_refused(sheet, B_Nm2, eibm):
    said = r"the EIBM stated at \+2 V would wind 'long' up .* times: .* N m with B = "
    with pytest.raises(ModelError, match=said):
        stated_model(sheet, B_Nm2, {2.0: eibm})


NO_SOLID = "N m² of 'long' means a Young modulus of .* Pa, which no solid has; "


@pytest.mark.parametrize(
    ("B_Nm2", "said"),
    [
        (1.27, NO_SOLID + r"1\.27 µN m² are 1\.27e-06 N m²"),
        (1e9, NO_SOLID + "check width and thickness, too"),
        (1e-30, NO_SOLID + "check width and thickness, too"),
    ],
)
def test_a_stiffness_that_no_solid_has_is_refused(sheet, B_Nm2, said):
    with pytest.raises(ModelError, match=said):
        stated_model(sheet, B_Nm2, {})


@pytest.mark.parametrize("modulus_Pa", [2.0, 1e6, 150e6, 1.2e12])
def test_one_that_some_solid_has_is_taken(sheet, modulus_Pa):
    B_Nm2 = modulus_Pa * sheet.width_m * sheet.thickness_m**3 / 12.0
    assert stated_model(sheet, B_Nm2, {}).sheets["long"].B.value == B_Nm2


def test_one_that_bends_the_sheet_into_a_circle_is_taken(sheet):
    model = stated_model(sheet, 1.3e-6, {2.0: 2 * np.pi * 1.3e-6 / 0.05})
    assert model.sheets["long"].eibm[2.0].values == pytest.approx(1.634e-4, rel=1e-3)
