"""An effect that can act in one sense alone is no explanation of its opposite."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.wordings import WORDINGS, worded
from benchmarks.worlds.cases import PAPER
from model.discrepancy import diagnose
from model.discrepancy.prepare import prepare
from model.effects import effect
from model.identification.likelihood.mixed_model_fit import fit_mixed_model
from model.identification.likelihood.model_state import Found
from model.measurements import Measurements
from tests.model.discrepancy.sessions import NOTHING, DiagnoseOptions, of_one_sheet, session

LEADS_N = 3e-4  # by which forces of the two polarities are farther apart than the load


def ahead_of_the_load(m: Measurements) -> Measurements:
    """A session in which the reading runs ahead: what no hysteresis does."""
    return replace(m, series=(), conditions=tuple(
        replace(one, readings=tuple(
            replace(r, force_N=r.force_N + LEADS_N * one.voltage_V / 2.0) for r in one.readings
        ))
        for one in m.conditions
    ))  # fmt: skip


@pytest.mark.slow
def test_an_eibm_that_rises_is_none_that_falls_and_the_file_predicts_it():
    """A decay length beyond infinity was promised; the file had a form 0.2 mN off the data."""
    words = next(one for one in WORDINGS if one.words == "rises evenly")
    hidden = worded(words).measure(PAPER, {"nonuniform_eibm": 0.6}, 4)
    found = diagnose(of_one_sheet(hidden, "long"))
    assert not found.effects
    assert found.unknown is not None
    assert found.unknown.location == "eibm"
    assert [one.name for one in found.model.effects] == ["unknown"]
    assert found.held_out.after.force_rmse_mN < 1.2 * found.floor.force_rmse_mN
    fitted = diagnose(of_one_sheet(hidden, "long"), DiagnoseOptions(model=found.model))
    assert fitted.verdict == "nothing_missing"


@pytest.mark.parametrize("begins_mN", [0.02, 0.1, 0.2])
def test_what_a_step_to_the_other_sense_promises_is_no_merit(begins_mN):
    ready = prepare(ahead_of_the_load(session(NOTHING)), DiagnoseOptions())
    base = fit_mixed_model(ready.problem, ready.theta)
    values = {"force_mN": begins_mN, "from_no_load": 0.0, "reach_mN": 0.3}
    hysteresis = Found(
        effect=effect("load_cell_hysteresis"),
        values={name: dict(values) for name in ready.problem.forward.names},
    )
    found = fit_mixed_model(ready.problem, base.theta, (hysteresis,))
    assert found.deviance > base.deviance - 1.0
