"""Tables of other programs: letters, separators, decimals, headers, units and names."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from labrig.config import parse_sheet
from labrig.errors import BadInputError
from labrig.files import typed
from labrig.session.derived.arrays import measurements_from_tables, tables_from_measurements
from labrig.session.tables import column_names, read_and_understood, read_tables, write_tables
from labrig.session.tables.examples import CURVES, FORCES, LABVIEW, write_examples
from labrig.session.tables.preview import in_one_line, rows
from labrig.session.tables.text.layout import find_layout
from labrig.session.tables.text.names import is_meant, may_mean, shift, split_name
from model import fit
from tests.labrig.report_data import measure
from tests.labrig.session.measured import same
from tests.labrig.session.session_recording import SHEET

SHEETS = parse_sheet(SHEET, "sheet.toml")
LONG = {"long": SHEETS["long"]}
PLAIN = """configuration,position_mm,voltage_V,reading,force_mN
long,5,0,0,0.31
long,5,0,1,-0.29
long,5.5,2,10,1.5
"""
HEADER = "Measured by\tme\nDate\t2014/05/12\n\n***End_of_Header***\n\n"


def other(text: str, delimiter: str = "\t", comma: bool = True) -> str:
    """The same table as another program writes it."""
    changed = [
        [cell.replace(".", ",") if comma else cell for cell in row]
        for row in csv.reader(io.StringIO(text))
    ]
    return "\n".join(delimiter.join(row) for row in changed) + "\n"


def read(tmp_path: Path, text: str | bytes, *columns: str, values=(), sheets=SHEETS, curves=None):
    path = tmp_path / "old.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    if curves is not None:
        (tmp_path / "curves.txt").write_text(curves)
        curves = tmp_path / "curves.txt"
    names = column_names(list(columns), list(values))
    return read_and_understood(sheets, path, curves, names=names)


def alike(found, wanted) -> bool:
    return same(replace(found.measurements, source=""), replace(wanted.measurements, source=""))


WRITTEN = {
    "semicolons, decimal comma": other(PLAIN, ";").encode(),
    "tabs, decimal comma": other(PLAIN).encode(),
    "tabs, decimal point": other(PLAIN, comma=False).encode(),
    "a header": (HEADER + other(PLAIN)).encode(),
    "a header before commas": ("Run;1\nOperator;me\n\n" + PLAIN).encode(),
    "UTF-16 with a mark": (HEADER + other(PLAIN)).encode("utf-16"),
    "UTF-16, big end first": b"\xfe\xff" + other(PLAIN).encode("utf-16-be"),
    "UTF-16 without a mark": other(PLAIN).encode("utf-16-le"),
    "with the last byte of a file of DOS": other(PLAIN).encode("cp1252") + b"\x1a",
    "Latin-1": "Prüfer\tHöß\n".encode("latin-1") + other(PLAIN).encode(),
    "lines of Windows": other(PLAIN).replace("\n", "\r\n").encode(),
    "an empty column at the end": other(PLAIN).replace("\n", "\t\n").encode(),
    "quotes": other(PLAIN).replace("long", '"long"').encode(),
    "capitals and brackets": PLAIN.replace("force_mN", "Force [mN]")
    .replace("position_mm", "Position (mm)").encode(),
    "a line of units": other(PLAIN).replace("force_mN\n", "force\n\tmm\tV\t\tmN\n")
    .replace("position_mm", "position").replace("voltage_V", "voltage").encode(),
    "a line of units below our names": PLAIN.replace("_mN\n", "_mN\n,mm,V,-,mN\n").encode(),
    "spaces": other(PLAIN, " ", comma=False).encode(),
    "spaces, decimal comma": other(PLAIN, "  ").encode(),
    "columns of one width": "\n".join(
        "".join(f"{cell:>16}" for cell in line.split(",")) for line in PLAIN.splitlines()
    ).encode(),
    "numpy.savetxt with commas": f"# of 2014\n# {PLAIN}".encode(),
    "numpy.savetxt with spaces": f"# of 2014\n# {other(PLAIN, ' ', comma=False)}".encode(),
    "six decimals everywhere": other(PLAIN).replace("\t0\t0\t", "\t0,000000\t0,000000\t")
    .replace("\t10\t", "\t10,000000\t").encode(),
}  # fmt: skip


@pytest.mark.parametrize("how", WRITTEN)
def test_a_table_of_another_program_is_the_same_table(tmp_path, how):
    wanted = read(tmp_path, PLAIN)
    found = read(tmp_path, WRITTEN[how])
    assert alike(found, wanted)
    assert in_one_line(wanted.tables[0]) == ""
    assert in_one_line(found.tables[0]).startswith(f"{tmp_path / 'old.txt'}: 3 rows")


UNITS = [
    ("force [N]", "0.00031", "force_mN", 0.00031),
    ("Force (µN)", "310", "force_mN", 0.00031),
    ("Force (uN)", "310", "force_mN", 0.00031),
    ("force/mN", "0.31", "force_mN", 0.00031),
    ("force in N", "3.1e-4", "force_mN", 0.00031),
    ("FORCE_N", "0.00031", "force_mN", 0.00031),
    ("force (gf)", "0.1", "force_mN", 0.000980665),
    ("force [mgf]", "100", "force_mN", 0.000980665),
]


@pytest.mark.parametrize(("name", "value", "ours", "wanted"), UNITS)
def test_units_in_names_are_converted_to_the_last_bit(tmp_path, name, value, ours, wanted):
    text = PLAIN.replace("force_mN", name).replace("0.31", value)
    (first, *_) = read(tmp_path, text).measurements.conditions
    assert first.readings[0].force_N == wanted


@pytest.mark.parametrize("unit", ["1/mm", "m-1", "per_m", "uV", "kN"])
def test_each_unit_that_a_name_may_have_may_stand_in_a_line_of_units(tmp_path, unit):
    assert split_name(f"k [{unit}]").unit is not None
    text = other(PLAIN).replace("position_mm", "position").replace("force_mN\n", "force_mN\tk\n")
    names, *lines = text.splitlines()
    text = "\n".join([names, f"\tmm\tV\t-\tmN\t{unit}", *(f"{line}\t1" for line in lines)])
    assert alike(read(tmp_path, text), read(tmp_path, PLAIN))


def test_a_line_of_units_is_not_taken_for_the_names(tmp_path):
    text = "pos\tk\nmm\t1/mm\n0\t1\n1\t2\n"
    layout = find_layout(text, lambda _: 0)
    assert (layout.names, layout.units) == (("pos", "k"), ("mm", "1/mm"))


def test_positions_in_metres_and_centimetres_become_metres(tmp_path):
    for name, value in (("position [m]", "0.0055"), ("position (cm)", "0.55")):
        text = PLAIN.replace("position_mm", name).replace("long,5.5", f"long,{value}")
        assert read(tmp_path, text).measurements.conditions[-1].position_m == 0.0055


def test_a_unit_of_another_quantity_is_refused(tmp_path):
    text = PLAIN.replace("force_mN", "F (V)")
    with pytest.raises(BadInputError, match=r"column 'F \(V\)': 'V' is no unit of force_mN"):
        read(tmp_path, text, "force_mN=F (V)")
    with pytest.raises(BadInputError) as told:
        read(tmp_path, PLAIN.replace("force_mN", "F (kg)"), "force_mN=F")
    assert str(told.value).endswith(
        "'kg' is no unit of force_mN; convert the column, or write kgf where it is a weight."
    )
    with pytest.raises(BadInputError, match="line below its name says 'm'; state one unit"):
        read(tmp_path, PLAIN.replace("_mN\n", "_mN\n,m,V,-,mN\n"))


def test_a_force_needs_the_place_of_the_load_cell(tmp_path):
    text = PLAIN.replace("long,5,0,1", "long,,0,1")
    with pytest.raises(BadInputError, match="line 3: column position_mm is empty, but there is a"):
        read(tmp_path, text)


def test_a_table_with_a_column_for_each_voltage_is_told_as_such(tmp_path):
    text = "position (mm);-2 V;0 V;+2 V\n0;-1;0;1\n5;-2;0;2\n"
    with pytest.raises(BadInputError, match=r"a column for each voltage_V \(-2 V, 0 V, \+2 V\);"):
        read(tmp_path, text, values=["configuration=long"])


def test_where_no_column_is_known_all_are_listed(tmp_path):
    for text, names in (("a;b\n1;2\n2;3\n", "a, b"), ("1 2 3\n4 5 6\n", "1, 2, 3")):
        with pytest.raises(BadInputError, match=rf"--columns \w+=NAME \(the file has {names}\) or"):
            read(tmp_path, text, values=["configuration=long"])


def test_names_in_other_letters_are_offered(tmp_path):
    names = "configuration,\u4f4d\u7f6e (mm),\u96fb\u5727 [V],reading,\u529b (mN)"
    text = PLAIN.replace(PLAIN.splitlines()[0], names)
    with pytest.raises(BadInputError, match="--columns 'position_mm=\u4f4d\u7f6e' --col"):
        read(tmp_path, text)
    with pytest.raises(BadInputError, match=r"is it position_mm\? Give --columns 'position_mm="):
        read(tmp_path, PLAIN.replace("position_mm", "\u8ddd\u79bb (mm)"))
    with pytest.raises(BadInputError, match="letters of the file are wrong, save it as UTF-8"):
        read(tmp_path, text.encode("cp932"))


def test_other_names_are_taken_only_as_stated(tmp_path):
    text = PLAIN.replace("force_mN", "F").replace("voltage_V", "U")
    with pytest.raises(BadInputError) as caught:
        read(tmp_path, text)
    said = str(caught.value)
    assert said.endswith(
        "columns 'U', 'F' are not known; if this is meant, give --columns voltage_V=U "
        "--columns force_mN=F; --ignore NAME leaves one out."
    )
    found = read(tmp_path, text, "force_mN=F", "voltage_V=U")
    assert alike(found, read(tmp_path, PLAIN))


def test_a_column_of_sheets_is_not_offered_as_the_voltage(tmp_path):
    with pytest.raises(BadInputError, match="column voltage_V is missing; give"):
        read(tmp_path, other(PLAIN).replace("voltage_V", "sheet"))
    with pytest.raises(BadInputError, match=r"'U_sheet' is not known; .* --columns voltage_V=U_"):
        read(tmp_path, other(PLAIN).replace("voltage_V", "U_sheet"))


def test_a_name_with_a_blank_is_offered_as_it_is_typed(tmp_path):
    with pytest.raises(BadInputError) as caught:
        read(tmp_path, PLAIN.replace("force_mN", "mean force"))
    offered = str(caught.value).rpartition("give ")[2].rstrip(".")
    assert offered == (
        f"--columns {typed('force_mN=mean force')}; --ignore {typed('mean force')} leaves it out"
    )


def test_a_stated_name_may_leave_its_unit_out(tmp_path):
    found = read(
        tmp_path, PLAIN.replace("force_mN", "F (N)").replace("0.31", "0.00031"), "force_mN=F"
    )
    assert found.measurements.conditions[0].readings[0].force_N == 0.00031


def test_columns_that_are_not_needed_are_told(tmp_path):
    text = other(PLAIN).replace("force_mN", "force_mN\tComment").replace("1\n", "1\thot\n")
    (table,) = read(tmp_path, text).tables
    assert in_one_line(table).endswith("not used: Comment.")
    assert ["Comment", "", "not used", "", "", "", "", ""] in rows(table)


def test_a_slip_in_a_name_is_an_error_in_any_table(tmp_path):
    text = other(PLAIN).replace("force_mN", "force_mN\ttilt_dge").replace("1\n", "1\t0\n")
    with pytest.raises(BadInputError, match="'tilt_dge' is not known; did you mean tilt_deg"):
        read(tmp_path, text)


def test_the_preview_shows_range_and_signs(tmp_path):
    (table,) = read(tmp_path, other(PLAIN)).tables
    assert rows(table)[-1] == ["force_mN", "force_mN", "as named", "-0.29", "1.5", "1", "0", "2"]
    assert rows(table)[0][3] == "long"


def test_what_no_column_says_is_stated(tmp_path):
    lines = [line.removeprefix("long,") for line in PLAIN.split("\n")[1:]]
    text = "\n".join(["position_mm,voltage_V,reading,force_mN", *lines])
    with pytest.raises(BadInputError, match="column configuration is missing"):
        read(tmp_path, text)
    wanted = read(tmp_path, PLAIN)
    assert alike(read(tmp_path, text, values=["configuration=long"]), wanted)
    only = read(tmp_path, text, sheets=LONG)  # a sheet with one configuration needs no name of it
    assert only.tables[0].values == {"configuration": "long"}
    assert only.measurements.conditions == wanted.measurements.conditions


def test_a_value_that_the_column_says_too_is_taken(tmp_path):
    text = "\n".join(line for line in PLAIN.split("\n") if ",2," not in line)
    wanted = read(tmp_path, text)
    assert alike(read(tmp_path, text, values=["voltage_V=0.0", "configuration=long"]), wanted)


def test_a_value_serves_the_table_that_lacks_the_column(tmp_path):
    curves = "position_mm,voltage_V,x_mm,y_mm\n5,2,0,0\n5,2,5,1\n5,2,10,3\n"
    text = PLAIN + "short,5,2,0,1\n"
    found = read(tmp_path, text, curves=curves, values=["configuration=long"]).measurements
    (condition,) = [c for c in found.conditions if c.curve is not None]
    assert condition.configuration == "long"


def test_a_minus_sign_of_typesetters_and_separators_at_the_end_are_understood(tmp_path):
    wanted = read(tmp_path, PLAIN)
    assert alike(read(tmp_path, PLAIN.replace("-", "\N{MINUS SIGN}")), wanted)
    assert alike(read(tmp_path, other(PLAIN).replace("-", "\N{MINUS SIGN}")), wanted)
    assert alike(read(tmp_path, PLAIN.replace("\n", ",,\n")), wanted)
    in_newtons = PLAIN.replace("force_mN", "Force [N]").replace("-", "\N{MINUS SIGN}")
    assert read(tmp_path, in_newtons).measurements.conditions[0].readings[1].force_N == -0.29


def test_curves_of_photographs_are_curves_of_free_sheets(tmp_path):
    path = tmp_path / "strip.csv"
    path.write_text(
        "image,point,s_mm,x_mm,y_mm,curvature_per_m,sigma_mm,curvature_sigma_per_m,state,frame,"
        "time_s,reason,strip\n"
        + "".join(f"strip,{k},{5 * k},{5 * k},{k * k / 9},9,0.01,0.1,seen,,,,\n" for k in range(4))
    )
    names = column_names([], ["position_mm=", "voltage_V=0"])
    found = read_and_understood(LONG, None, path, names=names)
    (condition,) = found.measurements.conditions
    assert (condition.configuration, condition.position_m) == ("long", None)
    np.testing.assert_array_equal(condition.curve.x_m, [0.0, 0.005, 0.01, 0.015])


@pytest.mark.parametrize("name", ["force_lbf", "force (mg)"])
def test_a_unit_that_is_not_known_is_answered_with_those_that_are(tmp_path, name):
    with pytest.raises(
        BadInputError, match="did you mean force_mN, in N, mN, uN, kN, gf, mgf or kgf"
    ):
        read(tmp_path, PLAIN.replace("force_mN", name))


def test_lines_without_a_number_of_reading_are_counted(tmp_path):
    lines = [line.split(",") for line in PLAIN.strip().split("\n")]
    text = "\n".join(",".join([*cells[:3], cells[4]]) for cells in lines)
    found = read(tmp_path, text).measurements
    assert [r.index for c in found.conditions for r in c.readings] == [0, 1, 2]


def test_points_without_a_number_are_counted_along_each_curve(tmp_path):
    head, rest = "configuration,position_mm,voltage_V,x_mm,y_mm\n", ""
    for volts in (0, 2):
        rest += "".join(f"long,5,{volts},{x},{x * volts / 10}\n" for x in (0, 10, 20))
    found = read(tmp_path, PLAIN, curves=head + rest).measurements
    assert [c.curve.x_m.tolist() for c in found.conditions if c.curve] == [[0.0, 0.01, 0.02]] * 2


def test_a_table_without_names_has_numbered_columns(tmp_path):
    text = "5,0\t0,0\t0,31\n5,0\t2,0\t1,5\n"
    names = ("position_mm=1", "voltage_V=2", "force_mN=3")
    found = read(tmp_path, text, *names, values=["configuration=long"]).measurements
    assert [c.readings[0].force_N for c in found.conditions] == [0.00031, 0.0015]


def test_a_mean_keeps_its_scatter_and_count(tmp_path):
    text = "configuration;position_mm;voltage_V;force_mN;sd_mN;mean_of\nlong;5;2;1,5;0,02;10\n"
    found = read(tmp_path, text).measurements
    (reading,) = found.conditions[0].readings
    assert (reading.mean_of, reading.sd_N) == (10, 2e-5)
    assert same(read_tables(SHEETS, *write_tables(found, tmp_path / "out")), replace(
        found, source="forces.csv"))  # fmt: skip
    assert same(measurements_from_tables(tables_from_measurements(found)), found)


BAD = {
    "line 3: '0.29' has a decimal point and '0,31' (line 2) a comma": (
        other(PLAIN).replace("-0,29", "0.29")
    ),
    "line 3: '0,29' has a decimal comma and '0.31' (line 2) a point": (
        other(PLAIN, comma=False).replace("-0.29", "0,29")
    ),
    "line 8: column force_mN: 'O,29' is not a number": (
        HEADER + other(PLAIN).replace("-0,29", "O,29")
    ),
    "line 2: column force_mN (Force [N]): 'x' is not a number": (
        other(PLAIN).replace("force_mN", "Force [N]").replace("0,31", "x")
    ),
    "line 3: 6 values for 5 columns.": other(PLAIN).replace("-0,29", "-0,29\t3"),
    "columns 'Force [N]' and 'force (mN)' are both force_mN; remove one": (
        other(PLAIN).replace("reading\tforce_mN", "Force [N]\tforce (mN)")
    ),
    "column force_mN is missing; is it kraftwerk? Give": PLAIN.replace(
        "force_mN", "kraftwerk").replace("voltage_V", "Voltage (V)"),
    # neither a temperature nor a number is a name of a sheet
    "column configuration is missing; give --columns configuration=NAME or": (
        "Temp (°C);position_mm;voltage_V;reading;force_mN\n21;5;0;0;0,31\n"
    ),
    "column force_mN is missing; give --columns force_mN=NAME or": (
        "Temp (°C);Temp 2 (°C);configuration;position_mm;voltage_V;reading\n21;22;long;5;0;0\n"
    ),
    "column force_mN is missing; is it Messwert [N]? Give": (
        "Temp (°C);Messwert [N];Datum;configuration;position_mm;voltage_V\n21;1;x;long;5;0\n"
    ),
    "column configuration is missing; is it Film? Give": (
        "Temp (°C);Film;position_mm;voltage_V;force_mN\n21;A3;5;0;0,31\n"
    ),
    "sd_mN: '-1' is not a number from 0": (
        "configuration,position_mm,voltage_V,force_mN,sd_mN\nlong,5,2,1,-1\n"
    ),
    "mean_of: '0' is not a whole number from 1": (
        "configuration,position_mm,voltage_V,force_mN,mean_of\nlong,5,2,1,0\n"
    ),
}  # fmt: skip


@pytest.mark.parametrize("said", BAD)
def test_a_fault_in_such_a_table_is_one_sentence_with_its_place(tmp_path, said):
    with pytest.raises(BadInputError) as caught:
        read(tmp_path, BAD[said])
    assert said in str(caught.value).replace("columns 'force (mN)'", "columns 'Force [N]'")
    assert "old.txt" in str(caught.value)


@pytest.mark.parametrize(
    ("columns", "values", "said"),
    [
        (["F"], [], "--columns 'F': write labrig's column, '=' and the name in the file"),
        (["forse_mN=F"], [], "'forse_mN' is no column of labrig's; did you mean force_mN"),
        (["force_mN=G"], [], "--columns force_mN=G: 'G' is no column of"),
        (["voltage_V=F"], [], "old.txt has 'voltage_V' for voltage_V, which --ignore voltage_V"),
        (["voltage_V=reading"], [], "no table needs it; "),
        ([], ["run=1", "run=2"], "--value run: it has two values; give one."),
        (["tilt_deg=G"], [], "--columns tilt_deg=G: 'G' is no column of"),
        ([], ["configuration"], "write labrig's column, '=' and the value in all lines"),
        (["run=R"], ["run=1"], "--value run: --columns names a column for it already"),
        ([], ["voltage_V=2"], "old.txt has a column voltage_V, with '0' in it; leave --value out"),
        ([], ["force_mN=1"], "--value force_mN: --columns names a column for it already"),
        ([], ["tilt_deg=2,5"], "--value tilt_deg=2,5: '2,5' is not a number."),
    ],
)
def test_a_wrong_statement_is_told(tmp_path, columns, values, said):
    with pytest.raises(BadInputError) as caught:
        read(tmp_path, PLAIN.replace("force_mN", "F"), "force_mN=F", *columns, values=values)
    assert said in str(caught.value)


def test_names_are_split_from_their_units():
    assert split_name("F (mN)").unit.measures == "force"
    assert split_name("x / mm").base == "x"
    assert split_name("curvature_per_m").unit.measures == "curvature"
    assert is_meant(split_name("Position [m]"), "position_mm")
    assert not is_meant(split_name("position"), "position_mm")  # the unit is a guess
    assert may_mean(split_name("position"), "position_mm")
    assert not may_mean(split_name("F (V)"), "force_mN")
    assert shift(split_name("F (N)").unit, "force_mN") == 3


def test_dates_and_settings_in_a_header_are_not_taken_for_the_table():
    text = HEADER + "Channels\t2\nSamples\t100\t100\nY_Unit\tVolts\tVolts\nX0\t0,0\t0,0\n\n"
    layout = find_layout(text + other(PLAIN), lambda names: sum("_m" in one for one in names))
    assert layout.names[-1] == "force_mN"


def test_the_examples_are_read(tmp_path):
    write_examples(tmp_path)
    found = read_tables(LONG, tmp_path / FORCES, tmp_path / CURVES)
    names = column_names(
        ["position_mm=p", "voltage_V=U", "force_mN=F", "sd_mN=std", "mean_of=n"],
        ["configuration=long"],
    )
    means = read_tables(LONG, tmp_path / LABVIEW, names=names)
    assert len(found.conditions) == len(means.conditions) == 12
    for one, mean in zip(found.conditions, means.conditions, strict=True):
        (reading,) = mean.readings
        assert np.mean([r.force_N for r in one.readings]) == pytest.approx(
            reading.force_N, abs=5e-5
        )
        assert reading.mean_of == 10
    with pytest.raises(BadInputError, match="already there"):
        write_examples(tmp_path)


@pytest.mark.thorough
@pytest.mark.slow
def test_means_with_their_scatter_say_what_their_readings_say():
    whole = measure("long")
    means = replace(whole, conditions=tuple(_mean(c) for c in whole.conditions), series=())
    wanted, found = fit(whole).model.sheets["long"], fit(means).model.sheets["long"]
    assert found.B.value == pytest.approx(wanted.B.value, rel=2e-3)
    ratio = found.B.sigma / wanted.B.sigma
    assert 0.8 < ratio < 1.25


def _mean(condition):
    forces = np.array([r.force_N for r in condition.readings])
    one = replace(
        condition.readings[0], force_N=float(forces.mean()), sd_N=float(forces.std(ddof=1)),
        mean_of=len(forces),
    )  # fmt: skip
    return replace(condition, readings=(one,))
