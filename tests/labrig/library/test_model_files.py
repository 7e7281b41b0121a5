"""B and EIBM of a session in the library: from which model file, what they are, whose errors."""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import replace

import pytest

from labrig.cli.main import run
from labrig.library import Library
from labrig.library.fits import read_fits
from labrig.model_file import load_model, save_model
from labrig.session import open_session
from model import fit
from model.sheet.beam_problem import ActiveEffect
from tests.labrig.report_data import measure, session

pytestmark = pytest.mark.usefixtures("data_unchecked")


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """A folder with a session of two sheets, and the fit of its measurements."""
    folder = tmp_path_factory.mktemp("fitted")
    measurements = measure()
    path = session(folder / "made.h5", measurements)
    with open_session(path) as opened:
        return folder, fit(replace(measurements, checksum=opened.checksum))


@pytest.fixture
def folder(fitted, tmp_path):
    shutil.copy(fitted[0] / "made.h5", tmp_path)
    return tmp_path


def write(model, path, when):
    save_model(model, path, force=True)
    os.utime(path, (when, when))


def shown(folder):
    library = Library(folder)
    library.refresh()
    return library.entries()[0].fit


@pytest.mark.slow
def test_a_model_file_states_the_errors_of_each_configuration(fitted, tmp_path):
    found = fitted[1]
    for model, kind in ((found.model, "constant"), (found.varying_model, "varying")):
        save_model(model, tmp_path / "m.toml", force=True)
        assert load_model(tmp_path / "m.toml").own_merit == model.own_merit
        fits = read_fits(tmp_path / "m.toml").fits
        for name, one in found.configurations.items():
            errors = one.rmse[kind]
            assert fits[name]["rmse_force_mN"] == pytest.approx(1e3 * errors.force_N)
            assert fits[name]["rmse_curve_mm"] == pytest.approx(1e3 * errors.curve_m)
        assert fits["long"]["rmse_curve_mm"] != pytest.approx(fits["short"]["rmse_curve_mm"])
        overall = found.rmse[kind]
        assert fits["long"]["rmse_all_force_mN"] == pytest.approx(1e3 * overall.force_N)


@pytest.mark.slow
def test_an_older_model_file_states_the_errors_of_all_sheets_as_those_of_all(fitted, tmp_path):
    save_model(replace(fitted[1].model, own_merit={}), tmp_path / "old.toml")
    fits = read_fits(tmp_path / "old.toml").fits
    assert fits["long"]["rmse_force_mN"] is None
    assert fits["long"]["rmse_all_force_mN"] > 0


@pytest.mark.slow
def test_the_fit_is_shown_although_the_model_of_a_diagnosis_is_newer(fitted, folder):
    found = fitted[1]
    effect = ActiveEffect(name="nonuniform_eibm", parameters={}, by_configuration={})
    diagnosed = replace(found.model, effects=(effect,))
    write(found.model, folder / "first.toml", 10)
    write(found.varying_model, folder / "second.toml", 20)
    write(diagnosed, folder / "third.toml", 30)
    assert shown(folder)["long"]["model"] == "second.toml"
    assert shown(folder)["long"]["EIBM_quantity"] == "EIBM along the sheet, mean over [0, l]"
    (folder / "second.toml").unlink()
    assert shown(folder)["long"]["model"] == "first.toml"
    assert shown(folder)["long"]["EIBM_quantity"] == "constant EIBM"
    (folder / "first.toml").unlink()
    assert shown(folder)["long"]["model"] == "third.toml"
    assert shown(folder)["long"]["EIBM_quantity"] == "EIBM without the effects, mean over [0, l]"


@pytest.mark.slow
def test_the_list_names_quantity_unit_sheet_voltage_and_file(fitted, folder, capsys):
    found = fitted[1]
    write(found.model, folder / "model.toml", 10)
    assert run(["list", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "B, µN·m²" in said
    assert "EIBM, µN·m" in said
    assert f"long: {1e6 * found.configurations['long'].B.value:.4g}" in said
    assert f"long, +2 V: {1e6 * found.configurations['long'].eibm[2.0].value:.4g}" in said
    assert "constant EIBM" in said
    assert "model.toml" in said
    assert run(["list", str(folder), "--json"]) == 0
    entry = json.loads(capsys.readouterr().out)["sessions"][0]
    assert entry["fit"]["short"]["model"] == "model.toml"


@pytest.mark.thorough
@pytest.mark.slow
def test_the_errors_of_a_diagnosis_are_stated_for_each_configuration():
    from model.discrepancy import diagnose

    found = diagnose(measure())
    own, whole = found.model.own_merit, found.model.merit
    assert set(own) == {"long", "short"}
    both = [one["force_rmse_N"] ** 2 for one in own.values()]  # equally many conditions each
    assert whole["force_rmse_N"] ** 2 == pytest.approx(sum(both) / 2)
    assert own["long"] != own["short"]
