"""What a user states of columns: names by table, columns to leave out, and angles."""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import replace

import pytest

import labrig
from labrig.errors import BadInputError
from labrig.session.tables import column_names, read_and_understood
from labrig.session.tables.preview import in_one_line, rows
from tests.labrig.session.session_recording import SHEET
from tests.labrig.session.test_old_tables import LONG, SHEETS

FORCES = "p [mm];Spannung [V];F [mN]\n5;0;0,3\n5;2;1,5\n"
CURVES = "p [mm];U [V];x [mm];y [mm]\n" + "".join(f"5;2;{5 * k};{k}\n" for k in range(4))
NAMES = ("position_mm=p", "force_mN=F", "x_mm=x", "y_mm=y")


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.csv").write_text(text)
        return tmp_path

    write(forces=FORCES, curves=CURVES)
    return write


def read(*columns, ignored=(), sheets=LONG, curves="curves.csv"):
    names = column_names([*NAMES, *columns], [], ignored)
    return read_and_understood(sheets, "forces.csv", curves, names=names)


def only_forces(*columns, ignored=()):
    columns = ("position_mm=p", "voltage_V=Spannung", "force_mN=F", *columns)
    names = column_names(columns, [], ignored)
    return read_and_understood(LONG, "forces.csv", names=names)


def test_each_table_takes_the_first_name_that_it_has(files):
    found = read("voltage_V=Spannung", "voltage_V=U").measurements
    (with_curve,) = [one for one in found.conditions if one.curve is not None]
    assert (with_curve.voltage_V, len(with_curve.readings)) == (2.0, 1)


def test_a_table_that_has_none_of_the_names_says_so(files):
    wanted = (
        "curves.csv: --columns voltage_V=Spannung: there is no column 'Spannung'; the file has "
        "p [mm], U [V], x [mm], y [mm]; add --columns voltage_V=NAME with its name in this table."
    )
    with pytest.raises(BadInputError, match=f"^{re.escape(wanted)}$"):
        read("voltage_V=Spannung")


def test_no_name_is_dropped_silently(files):
    with pytest.raises(BadInputError, match=r"voltage_V=W: 'W' is no column of forces.csv or curv"):
        read("voltage_V=Spannung", "voltage_V=W", "voltage_V=U")
    files(forces=FORCES.replace("F [mN]", "F [mN];U").replace(",3", ",3;9").replace(",5", ",5;9"))
    said = "--columns voltage_V=U: no table needs it; forces.csv has 'Spannung [V]' for voltage_V"
    with pytest.raises(BadInputError, match=re.escape(said)):
        only_forces("voltage_V=U")


def test_a_column_is_left_out_where_the_user_says_so(files):
    files(forces="Nr;" + FORCES.replace("\n5", "\n7;5"))
    said = "'Nr' is not known; if this is meant, give --columns reading=Nr; --ignore Nr leaves it"
    with pytest.raises(BadInputError, match=said):
        only_forces()
    found = only_forces(ignored=["Nr"])
    assert [one.readings[0].index for one in found.measurements.conditions] == [0, 1]
    assert rows(found.tables[0])[0][:3] == ["Nr", "", "--ignore"]
    assert "not used: Nr" in in_one_line(found.tables[0])


def test_a_column_to_leave_out_must_exist_and_have_no_other_meaning(files):
    with pytest.raises(BadInputError, match=r"--ignore Nr: 'Nr' is no column of forces.csv, which"):
        only_forces(ignored=["Nr"])
    with pytest.raises(BadInputError, match="column 'F \\[mN\\]' cannot be both ignored and force"):
        only_forces(ignored=["F"])
    with pytest.raises(BadInputError, match="--ignore '': write the name"):
        only_forces(ignored=[""])


def test_a_plain_table_with_a_column_of_its_own_names_the_way_out(files):
    files(forces="configuration,position_mm,voltage_V,reading,force_mN,Lot\nlong,5,2,0,1,9\n")
    with pytest.raises(BadInputError, match=r"'Lot' is not known; .*; --ignore Lot leaves it out"):
        read_and_understood(LONG, "forces.csv")
    names = column_names([], [], ["Lot"])
    assert read_and_understood(LONG, "forces.csv", names=names).measurements.conditions


@pytest.mark.parametrize(("unit", "number"), [("°", 9), ("deg", 9), ("rad", math.pi / 20)])
def test_a_position_may_be_an_angle_on_the_arc(files, unit, number):
    radius_mm = 1e3 * LONG["long"].arc_radius_m
    text = FORCES.replace("p [mm]", f"Winkel [{unit}]").replace("\n5", f"\n{number}")
    files(forces=text.replace(".", ","))
    names = column_names(["position_mm=Winkel", "voltage_V=Spannung", "force_mN=F"], [])
    found = read_and_understood(SHEETS | LONG, "forces.csv", names=replace(names, values={
        "configuration": "long"}))  # fmt: skip
    assert found.measurements.conditions[0].position_m == pytest.approx(
        radius_mm * math.pi / 20 / 1e3, abs=1e-12
    )
    wanted = f"position_mm, angle times R = {radius_mm:g} mm"
    assert rows(found.tables[0])[0][1] == wanted
    assert f"Winkel [{unit}] is {wanted}" in in_one_line(found.tables[0])


def test_an_angle_is_no_position_where_arcs_differ(files):
    files(forces=FORCES.replace("p [mm]", "p [deg]"))
    other = replace(SHEETS["short"], arc_radius_m=0.03)
    with pytest.raises(BadInputError, match="'p \\[deg\\]' is an angle, and the sheets have diff"):
        read("voltage_V=Spannung", sheets=LONG | {"short": other}, curves=None)


def test_a_tilt_in_radians_becomes_degrees(files):
    text = "configuration,position_mm,voltage_V,reading,force_mN,tilt [rad]\nlong,5,2,0,1,0.1\n"
    files(forces=text)
    (one,) = read_and_understood(LONG, "forces.csv").measurements.conditions
    assert one.tilt_rad == pytest.approx(0.1, abs=1e-10)


def test_all_of_it_is_there_in_python(files):
    folder = files(forces="Nr;" + FORCES.replace("\n5", "\n7;5"))
    (folder / "sheet.toml").write_text(SHEET)
    columns = {"position_mm": "p", "force_mN": "F", "x_mm": "x", "y_mm": "y"}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = labrig.measurements_of_tables(
            "sheet.toml", "forces.csv", "curves.csv", values={"configuration": "long"},
            columns=columns | {"voltage_V": ["Spannung", "U"]}, ignore="Nr",
        )  # fmt: skip
    assert len(found.conditions) == 2
    assert any("not used: Nr" in str(one.message) for one in told)
