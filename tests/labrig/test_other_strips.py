"""Strips of other laboratories at the command line: a microstrip, and 100 V at a strip of metal."""

from __future__ import annotations

import pytest

from labrig.cli.main import run
from tests.labrig.report_data import TEXTS, measure, session
from tests.model.scaled import scaled

MICRO = 0.1, 1e-4  # of lengths and forces
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("data_unchecked")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("strips")


@pytest.fixture(scope="module")
def micro(folder):
    return session(folder / "micro.h5", scaled(measure("long"), *MICRO))


@pytest.fixture(scope="module")
def micro_model(folder, micro):
    assert run(["fit", str(micro), "-o", str(folder / "micro.toml")]) == 0
    return folder / "micro.toml"


def test_forces_of_nanonewtons_are_printed_with_their_digits(micro, micro_model, capsys):
    where = ["--configuration", "long", "--position-mm", "1.2", "--voltage", "2"]
    for asked in (["fit", micro], ["compare", micro], ["simulate", micro_model, *where]):
        assert run(list(map(str, asked))) == 0
        printed = capsys.readouterr().out
        assert "mN" in printed
        assert "0.000 " not in printed, printed
        assert "0.000\n" not in printed, printed


def test_a_measurement_at_voltages_of_another_laboratory_is_proposed_without_protocol(
    folder, capsys
):
    lines = [
        f"long,{1e3 * c.position_m:g},{50.0 * c.voltage_V:g},{1e3 * r.force_N:.6g}"
        for c in measure("long").conditions
        for r in c.readings
    ]
    forces, sheet = folder / "forces.csv", folder / "sheet.toml"
    forces.write_text("\n".join(["configuration,position_mm,voltage_V,force_mN", *lines]))
    sheet.write_text(TEXTS["sheet.toml"])
    tables = ["--sheet", str(sheet), "--forces", str(forces)]
    assert run(["next", *tables, "--between", "gravity", "force_offset"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("Measure next: ")
    assert "# labrig cannot run it: an entry of voltages_V = 100 must be at most 30." in printed
