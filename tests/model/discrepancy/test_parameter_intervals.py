"""How unsure B, the EIBM and the effects of a diagnosis are: as `fit` and its own file have it."""

from __future__ import annotations

import numpy as np
import pytest

from model.discrepancy.verdict.result.diagnosis import Diagnosis
from model.identification.fit import fit
from model.parameter import Parameter
from model.sheet.deviations import effect_key, eibm_key
from tests.model.discrepancy.sessions import FALLING, NOTHING, diagnosed, session


def base(found: Diagnosis, name: str) -> dict[str, Parameter]:
    """B and EIBM of a configuration."""
    return dict(found.base[name])


@pytest.mark.slow
def test_where_nothing_is_missing_b_is_as_unsure_as_fit_says():
    """Few set-ups tell the scatter that the data are weighed by."""
    fitted, found = fit(session(NOTHING)), diagnosed(NOTHING)
    for name, configuration in fitted.configurations.items():
        B = base(found, name)["B_Nm2"]
        assert B.sigma == pytest.approx(configuration.B.sigma, rel=0.25)
        assert B.freedom == pytest.approx(configuration.B.freedom, rel=0.6)


@pytest.mark.slow
@pytest.mark.parametrize("of", [NOTHING, FALLING], ids=["nothing", "falling EIBM"])
def test_the_file_s_deviations_are_as_unsure_as_the_parameters(of):
    found = diagnosed(of)
    for name, together in found.model.deviations.items():
        sheet = found.model.sheet(name)
        stated = {"B": sheet.B}
        for volts in sheet.eibm:
            stated[eibm_key(volts, 0)] = base(found, name)[f"EIBM {volts:+g} V"]
        for place, one in enumerate(found.model.effects):
            own = one.by_configuration.get(name, one.parameters)
            stated |= {effect_key(place, key): p for key, p in own.items()}
        rows = {key: row for key, row in together.rows.items() if key in stated}
        assert len(rows) >= 3 + len(found.model.effects)
        for key, row in rows.items():
            assert np.linalg.norm(row) == pytest.approx(stated[key].sigma, rel=1e-3), key
            told = together.freedom(row[:, None])[0]  # a file keeps few of the ways it changes
            assert 1.0 / told == pytest.approx(1.0 / stated[key].freedom, rel=0.1, abs=1e-3)
