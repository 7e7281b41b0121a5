"""The table `dynamic` of a model file."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from labrig.model_file import load_model, save_model
from model import ModelError, SheetModel
from model.dynamics import VACUUM, HeldVoltage, simulate
from model.dynamics.dynamic_sheet import fluid_around
from tests.model.dynamics.cases import B


def number(value: float, **more: object) -> dict[str, object]:
    return {"value": value, "sigma": 0.1 * value, "unit": "", **more}


DYNAMIC = {
    "mass_per_length_kg_per_m": number(5.775e-3, determined_by="data"),
    "viscous_time_s": number(2e-4, determined_by="prior"),
    "electrode_ohm_per_m": number(4e3),
    "capacitance_F_per_m": number(0.3),
    "bulk_ohm_m": number(0.5),
    "leak_S_per_m": number(0.1),
    "source_ohm": number(1.0),
    "moment_per_volt_Nm": {"positive": number(30 * B), "negative": number(24 * B)},
    "prony": [{"share": number(0.15), "time_s": number(0.02, determined_by="data")}],
    "fluid": "air",
    "load_cell": {"resonance_hz": number(80.0), "damping": number(0.02)},
}


def file_with(truth: SheetModel, **changes: object) -> dict[str, object]:
    data = truth.to_dict()
    data["configurations"]["long"]["dynamic"] = copy.deepcopy(DYNAMIC) | changes
    return data


def test_it_is_read_and_written_with_what_determined_it(truth, tmp_path):
    model = SheetModel.from_dict(file_with(truth))
    save_model(model, tmp_path / "model.toml")
    again = load_model(tmp_path / "model.toml")
    assert again.dynamic == model.dynamic
    one = again.dynamic["long"]
    assert one.mass_per_length_kg_per_m.sigma == pytest.approx(5.775e-4)
    assert one.determined_by == {
        "mass_per_length_kg_per_m": "data",
        "viscous_time_s": "prior",
        "prony[0].time_s": "data",
    }
    assert "short" not in again.dynamic


@pytest.mark.slow
def test_a_model_file_moves(truth):
    model = SheetModel.from_dict(file_with(truth))
    beam, setup = model.moving("long", 0.01)
    drive = HeldVoltage(np.zeros(1), np.array([2.0]))
    motion = simulate(beam, setup, drive, np.array([0.0, 0.5]))
    still = model.predict("long", 0.01, 0.0).F_N
    assert motion.force_N[0] == pytest.approx(still, rel=2e-3)  # k0 has kinks within a panel
    assert motion.force_N[1] != pytest.approx(still, rel=0.1)
    assert setup is not None
    assert setup.resonance_hz == 80.0
    assert model.moving("long", None)[1] is None


BAD = {
    "long.dynamic.mass_per_length_kg_per_m: must be positive, not 0": {
        "mass_per_length_kg_per_m": number(0.0)
    },
    "long.dynamic.mass_per_length_kg_per_m: must be positive, not -0.001": {
        "mass_per_length_kg_per_m": {"value": -1e-3, "unit": "kg/m"}
    },
    r"prony\[0\].share: must be positive": {
        "prony": [{"share": {"value": -0.1}, "time_s": {"value": 1.0}}]
    },
    r"prony\[0\].time_s: must be positive": {
        "prony": [{"share": {"value": 0.1}, "time_s": {"value": 0.0}}]
    },
    "viscous_time_s: must be zero or positive": {"viscous_time_s": {"value": -1.0}},
    "load_cell.resonance_hz: must be positive": {
        "load_cell": {"resonance_hz": {"value": 0.0}, "damping": {"value": 0.0}}
    },
    "fluid: one of air, water, vacuum is wanted": {"fluid": "mercury"},
    "bulk_ohm_m: a finite number is wanted": {"bulk_ohm_m": "much"},
    "moment_per_volt_Nm: a table is wanted": {"moment_per_volt_Nm": 3.0},
    "prony: a list of tables is wanted": {"prony": 3.0},
    "unknown key 'mass'": {"mass": number(1.0)},
}


@pytest.mark.parametrize("sentence", list(BAD))
def test_what_cannot_be_is_refused_with_its_place(truth, sentence):
    with pytest.raises(ModelError, match=sentence):
        SheetModel.from_dict(file_with(truth, **BAD[sentence]))


@pytest.mark.parametrize("name", ["mercury", "Water", ""])
def test_an_unknown_fluid_is_no_vacuum(name):
    with pytest.raises(ModelError, match=f"'{name}' is no fluid.* air, water, vacuum"):
        fluid_around(name, 0.011)
    assert fluid_around("vacuum", 0.011) == VACUUM


def test_without_the_table_the_answer_says_so(truth):
    with pytest.raises(ModelError, match="has no table 'dynamic'"):
        truth.moving("long", 0.01)


def test_an_elongation_needs_its_mass(truth):
    data = truth.to_dict()
    data["configurations"]["short"]["dynamic"] = copy.deepcopy(DYNAMIC)
    with pytest.raises(ModelError, match="needs elongation_mass_kg_per_m"):
        SheetModel.from_dict(data).moving("short", 0.005)
    data["configurations"]["short"]["dynamic"]["elongation_mass_kg_per_m"] = number(4e-3)
    beam, _ = SheetModel.from_dict(data).moving("short", 0.005)
    assert beam.elongation.mass_per_length_kg_per_m == 4e-3
