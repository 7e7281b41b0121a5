"""Arrays of conditions are solved in one batch and say the same as one by one."""

from __future__ import annotations

import numpy as np
import pytest

from model import ModelError, Prediction, SheetModel, predict, predict_array
from model.parameter import Parameter
from model.sheet.beam_problem import ActiveEffect


def acting(name: str, location: str, **values: float) -> ActiveEffect:
    parameters = {n: Parameter(value=v, sigma=0.0, unit="") for n, v in values.items()}
    return ActiveEffect(name=name, location=location, parameters=parameters)


EFFECTS = {
    "none": (),
    "sheet and rolls": (
        acting("roll_friction", "position", coefficient=0.1),
        acting("nonlinear_stiffness", "compliance", relative_change_at_10_per_m=0.1),
    ),
    "load cell": (
        acting("load_cell_hysteresis", "load_cell", force_mN=0.1),
        acting("force_offset", "load_cell", force_mN=0.2),
    ),
    "camera": (
        acting("camera_scale", "camera", relative_error=0.02),
        acting("frame_delay", "camera", delay_s=0.04),
    ),
    "time": (acting("charging_lag", "time", time_constant_s=0.05),),
}
POSITIONS_M, VOLTAGES = np.array([0.0, 0.012, 0.03]), np.array([-2.0, 0.0, 1.0, 2.0])
SETTLED_M = 1e-8  # effects that depend on the force are repeated until they settle


@pytest.mark.slow
@pytest.mark.parametrize(
    "effects",
    [
        pytest.param(some, id=name, marks=[pytest.mark.thorough] * (name == "sheet and rolls"))
        for name, some in EFFECTS.items()
    ],
)
def test_a_batch_says_the_same_as_one_condition_after_the_other(truth: SheetModel, effects):
    model = truth.with_effects(*effects)
    batch = predict_array(model, "long", POSITIONS_M[:, None], VOLTAGES)
    assert batch.shape == (3, 4)
    for i, position_m in enumerate(POSITIONS_M):
        for j, voltage_V in enumerate(VOLTAGES):
            one = predict(model, "long", float(position_m), float(voltage_V))
            assert batch.reachable[i, j]
            assert batch.F_N[i, j] == pytest.approx(one.F_N, rel=1e-7, abs=1e-11)
            assert batch.N_N[i, j] == pytest.approx(one.N_N, rel=1e-7, abs=1e-11)
            assert batch.s_hat_m[i, j] == pytest.approx(one.s_hat_m, rel=1e-7)
            assert batch.phi_hat_rad[i, j] == pytest.approx(one.phi_hat_rad, rel=1e-6)
            assert batch.x_m[i, j] == pytest.approx(one.x_m, abs=SETTLED_M)
            assert batch.y_m[i, j] == pytest.approx(one.y_m, abs=SETTLED_M)
            assert batch.curvature_per_m[i, j] == pytest.approx(one.curvature_per_m, abs=1e-5)
    assert isinstance(batch[1, 2], Prediction)
    assert abs(batch[1, 2].F_N - batch.F_N[1, 2]) < 1e-10


@pytest.mark.slow
def test_what_is_not_reachable_is_nan_and_says_why(truth: SheetModel):
    found = truth.predict("long", [0.01, 0.1], 2.0)
    assert found.reachable.tolist() == [True, False]
    assert np.isnan(found.F_N[1])
    assert np.isnan(found.x_m[1]).all()
    assert np.isfinite(found.x_m[0]).all()
    assert found[1].why.startswith("not reachable")
    assert "1 of them are not reachable" in repr(found)
    frame = found.to_dataframe()
    assert frame.F_N[0] == found.F_N[0]
    assert frame.reachable.tolist() == [True, False]


def test_two_numbers_give_one_prediction(truth: SheetModel):
    assert isinstance(truth.predict("long", 0.01, 2.0), Prediction)
    assert isinstance(truth.predict("long", np.array(0.01), np.int64(2)), Prediction)


@pytest.mark.parametrize(
    ("positions", "voltages", "said"),
    [
        ([0.0, 0.01, 0.02], [2.0, -2.0], r"cannot be broadcast; give, for all combinations"),
        ([], 2.0, "at least one position"),
        ([0.0, np.nan], 2.0, "finite"),
        ([0.0], 5.0, "outside"),
    ],
)
def test_a_wrong_array_is_one_sentence(truth: SheetModel, positions, voltages, said):
    with pytest.raises(ModelError, match=said):
        predict_array(truth, "long", positions, voltages)
