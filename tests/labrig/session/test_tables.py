"""CSV files: every rule of their columns, and no loss on the way there and back."""

from __future__ import annotations

import math
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrig.config import parse_sheet
from labrig.errors import BadInputError
from labrig.session import (
    export_session,
    import_session,
    load_measurements,
    open_session,
    read_tables,
    verify,
    write_tables,
)
from labrig.session.tables import decimals
from labrig.session.tables.decimals import (
    degrees,
    from_degrees,
    from_milli,
    from_plain,
    milli,
    plain,
)
from labrig.session.tables.write import TABLES
from model.measurements import CameraUncertainty, Measurements
from protocols.execution.events import Outcome
from tests.labrig.session.measured import measurements, same
from tests.labrig.session.session_recording import SHEET

SHEETS = parse_sheet(SHEET, "sheet.toml")
FORCES = """configuration,position_mm,voltage_V,reading,force_mN
long,5,0,0,0.31
long,5,0,1,0.29
long,5,2,10,1.5
"""
CURVES = """configuration,position_mm,voltage_V,point,x_mm,y_mm
long,5,2,0,0,0
long,5,2,1,10,0.5
long,5,2,2,20,2
"""
SIGNALS = """configuration,position_mm,time_s,drive_V
long,5,0,0
long,5,0.005,2
"""

finite = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.slow
@given(finite)
def test_numbers_survive_to_the_last_bit(value):
    assert from_plain(plain(value)) == value


@pytest.mark.slow
@given(finite.filter(lambda v: abs(v) < 1e300))
def test_thousandths_survive_to_the_last_bit(value):
    assert from_milli(milli(value)) == value


@pytest.mark.slow
@given(st.floats(-7, 7))
def test_angles_survive_to_the_last_bit(value):
    assert from_degrees(degrees(value)) == value


def test_numbers_look_as_people_write_them():
    assert [milli(0.005), milli(0.1 / 3), milli(-2e-6)] == ["5", "33.33333333333333", "-0.002"]
    assert [plain(2.0), plain(-0.0), plain(1e-20)] == ["2", "0", "1E-20"]
    assert degrees(math.pi / 2) == "90"


def read(tmp_path, forces=FORCES, curves=None, signals=None):
    paths = []
    for name, text in (("forces.csv", forces), ("curves.csv", curves), ("signals.csv", signals)):
        path = None
        if text is not None:
            path = tmp_path / name
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
        paths.append(path)
    return read_tables(SHEETS, *paths)


def comparable(found: Measurements, wanted: Measurements) -> Measurements:
    """What tables do not hold, as it was: where the data are from, warnings, contacts as seen."""
    conditions = tuple(
        replace(c, contact=w.contact)
        for c, w in zip(found.conditions, wanted.conditions, strict=True)
    )
    return replace(
        found, source=wanted.source, checksum=wanted.checksum, warnings=wanted.warnings,
        conditions=conditions,
    )  # fmt: skip


def test_curves_alone_are_measurements_without_readings(tmp_path):
    found = read(tmp_path, forces=None, curves=CURVES)
    assert found.source == "curves.csv"
    (condition,) = found.conditions
    assert condition.readings == ()
    assert condition.curve is not None
    assert not any("but no force" in text for text in found.warnings)
    with pytest.raises(BadInputError, match="neither a table of forces nor one of curves"):
        read_tables(SHEETS, None)


def test_a_session_can_be_made_of_curves_alone(tmp_path):
    (tmp_path / "sheet.toml").write_text(SHEET, encoding="utf-8")
    (tmp_path / "curves.csv").write_text(CURVES, encoding="utf-8")
    sheet, curves, output = (tmp_path / n for n in ("sheet.toml", "curves.csv", "old.h5"))
    made = import_session(sheet, None, output, curves=curves)
    assert [check for check in verify(output) if not check.ok] == []
    assert same(load_measurements(output), made)


def test_a_round_trip_loses_nothing(tmp_path):
    wanted = measurements()
    paths = write_tables(wanted, tmp_path / "out")
    assert [path.name for path in paths] == [*TABLES[:3], "camera_uncertainty.csv"]
    found = read_tables(wanted.sheets, *paths[:3])
    by_key = {
        (c.configuration, c.position_m, c.voltage_V, c.mounting, c.approach, c.run): c
        for c in found.conditions
    }
    ordered = tuple(
        by_key[c.configuration, c.position_m, c.voltage_V, c.mounting, c.approach, c.run]
        for c in wanted.conditions
    )
    assert same(comparable(replace(found, conditions=ordered), wanted), wanted)


def test_the_smallest_file_is_enough(tmp_path):
    found = read(tmp_path)
    zero, two = found.conditions
    assert (zero.position_m, zero.voltage_V, len(zero.readings)) == (0.005, 0.0, 2)
    assert [r.force_N for r in zero.readings] == [0.00031, 0.00029]
    assert two.readings[0].kind == "kept"
    assert two.readings[0].valid
    assert two.readings[0].time_s is None


@pytest.mark.parametrize("ending", ["\r\n", "\n", "\r"])
def test_a_byte_order_mark_and_any_line_ending_are_accepted(tmp_path, ending):
    text = ("\ufeff" + FORCES).replace("\n", ending)
    assert same(read(tmp_path, text.encode("utf-8")), read(tmp_path))


def test_columns_may_stand_in_any_order(tmp_path):
    lines = [line.split(",") for line in FORCES.split()]
    turned = "\n".join(",".join(reversed(cells)) for cells in lines)
    assert same(read(tmp_path, turned), read(tmp_path))


def test_spaces_and_empty_lines_do_no_harm(tmp_path):
    text = FORCES.replace(",", " , ") + "\n,,,,\n\n"
    assert same(read(tmp_path, text), read(tmp_path))


def test_all_optional_columns_are_read(tmp_path):
    text = (
        "configuration,position_mm,voltage_V,reading,force_mN,time_s,session_s,wetted_s,mounting,"
        "kind,valid,approach,tilt_deg,run\n"
        "short,,-2,7,-1,3.5,100,9,2,no_contact,false,down,180,1\n"
    )
    (condition,) = read(tmp_path, text).conditions
    assert condition.position_m is None
    assert (condition.mounting, condition.approach, condition.run) == (2, "down", 1)
    assert condition.tilt_rad == math.pi
    (reading,) = condition.readings
    assert (reading.kind, reading.valid, reading.index) == ("no_contact", False, 7)
    assert (reading.time_s, reading.session_s, reading.wetted_s) == (3.5, 100.0, 9.0)


def test_a_curve_gets_its_arc_length(tmp_path):
    curve = read(tmp_path, curves=CURVES).conditions[1].curve
    np.testing.assert_allclose(curve.x_m, [0, 0.01, 0.02])
    chords = np.hypot(np.diff(curve.x_m), np.diff(curve.y_m)).cumsum()
    assert (curve.s_m[1:] > chords).all()
    assert (curve.s_m[1:] < 1.01 * chords).all()


def test_a_free_shape_needs_no_force(tmp_path):
    free = CURVES.replace("long,5,2", "short,,0")
    condition = read(tmp_path, curves=free).conditions[-1]
    assert (condition.configuration, condition.position_m) == ("short", None)
    assert condition.readings == ()
    assert len(condition.curve.s_m) == 3


def test_a_curve_of_one_reading_goes_to_that_reading(tmp_path):
    lines = CURVES.strip().split("\n")
    text = "\n".join([lines[0] + ",reading", *(line + ",10" for line in lines[1:])])
    condition = read(tmp_path, curves=text).conditions[1]
    assert condition.curve is None
    assert len(condition.readings[0].curve.s_m) == 3


def test_a_curve_finds_its_condition_without_naming_its_run(tmp_path):
    lines = FORCES.strip().split("\n")
    runs = "\n".join([lines[0] + ",run,approach", *(line + ",3,down" for line in lines[1:])])
    assert read(tmp_path, runs, CURVES).conditions[1].curve is not None


def test_curves_that_do_not_name_their_run_go_to_the_runs_in_order(tmp_path):
    lines = FORCES.strip().split("\n")
    up = "\n".join([lines[0] + ",run,approach", *(line + ",0,up" for line in lines[1:])])
    twice = up + "\nlong,5,2,10,1.5,1,down"
    once = read(tmp_path, twice, CURVES)
    assert [c.curve is not None for c in once.conditions if c.voltage_V == 2.0] == [True, False]
    assert "does not say of which run" in once.warnings[0]
    again = CURVES.strip() + "\n" + "\n".join(CURVES.strip().split("\n")[1:])
    both = read(tmp_path, twice, again)
    assert [c.curve is not None for c in both.conditions if c.voltage_V == 2.0] == [True, True]


def test_a_curve_may_name_its_run(tmp_path):
    lines = FORCES.strip().split("\n")
    up = "\n".join([lines[0] + ",run,approach", *(line + ",0,up" for line in lines[1:])])
    curves = CURVES.strip().split("\n")
    named = "\n".join([curves[0] + ",run", *(line + ",1" for line in curves[1:])])
    found = read(tmp_path, up + "\nlong,5,2,10,1.5,1,down", named)
    assert [c.run for c in found.conditions if c.curve is not None] == [1]
    assert not found.warnings


def test_a_curve_without_a_force_is_kept_with_a_warning(tmp_path):
    found = read(tmp_path, curves=CURVES.replace("long,5,", "long,6,"))
    assert found.warnings == ("There is a curve of long at 6 mm and +2 V, but no force.",)
    assert found.conditions[-1].readings == ()


def test_signals_make_a_series_for_each_position(tmp_path):
    (series,) = read(tmp_path, signals=SIGNALS).series
    assert series.position_m == 0.005
    np.testing.assert_array_equal(series.time_s, [0, 0.005])
    assert series.force_N is None


def test_times_in_ms_under_time_s_are_asked_about(tmp_path):
    lines = [f"long,5,{k},{2 * (k // 3 % 2)}" for k in range(12)]
    found = read(tmp_path, signals="\n".join([SIGNALS.split("\n", maxsplit=1)[0], *lines]))
    said = "The signals have a sample every 1 s, a run of up to 11 s: is time_s in s?"
    assert said in found.warnings
    assert not any("time_s" in one for one in read(tmp_path, signals=SIGNALS).warnings)


def test_signals_that_begin_anew_are_of_the_next_run(tmp_path):
    again = SIGNALS + "\n".join(SIGNALS.strip().split("\n")[1:])
    assert [s.run for s in read(tmp_path, signals=again).series] == [0, 1]
    named = "\n".join(
        line + ("," + ("run" if i == 0 else "3")) for i, line in enumerate(SIGNALS.split("\n")[:3])
    )
    assert [s.run for s in read(tmp_path, signals=named).series] == [3]


HEAD = "configuration,position_mm,voltage_V,reading,force_mN"
BAD_FORCES = {
    "forces.csv: column 'forse_mN' is not known; did you mean force_mN": "configuration,forse_mN\n",
    "forces.csv: column force_mN is missing": "configuration,position_mm,voltage_V,reading\n",
    "forces.csv: column reading is there twice": f"{HEAD},reading\n",
    "forces.csv: this is an empty file; a forces.csv is needed": "",
    "forces.csv: holds no readings": f"{HEAD}\n",
    "line 3: column force_mN: 'O.29' is not a number": FORCES.replace("0.29", "O.29"),
    "line 3: column force_mN: 'nan' is not a number; leave lines out in which nothing was": (
        FORCES.replace("0.29", "nan")
    ),
    "line 2: column time_s: '10:01:02' is not a number; give seconds since the beginning.": (
        f"{HEAD},time_s\nlong,5,0,0,1,10:01:02\n"
    ),
    "line 2: column time_s: 'n/a' is not a number; leave the cell empty where nothing was": (
        f"{HEAD},time_s\nlong,5,0,0,1,n/a\n"
    ),
    "line 3: column force_mN: '1e999' is not a number": FORCES.replace("0.29", "1e999"),
    "line 3: column force_mN is empty; a number is needed": FORCES.replace("0.29", ""),
    "line 3: 6 values for 5 columns; a number must have a point": FORCES.replace("0.29", "0,29"),
    "line 3: 4 values for 5 columns.": FORCES.replace(",0.29", ""),
    "line 3: column reading: '-1' is not a whole number": FORCES.replace("0,1,0.29", "0,-1,0.29"),
    "line 3: column reading: '1.5' is not a whole": FORCES.replace("0,1,0.29", "0,1.5,0.29"),
    "line 3: column reading: reading 0 of this condition": FORCES.replace("0,1,0.29", "0,0,1"),
    "line 2: configuration 'lang' is no table of the sheet, long, short": (
        FORCES.replace("long,5,0,0", "lang,5,0,0")
    ),
    "line 2: column kind: 'keep' is not zero or": f"{HEAD},kind\nlong,5,0,0,1,keep\n",
    "line 2: column valid: 'yes' is not true or false": f"{HEAD},valid\nlong,5,0,0,1,yes\n",
    "line 2: column approach: 'left' is not up or down": f"{HEAD},approach\nlong,5,0,0,1,left\n",
    "line 3: tilt_deg differs": f"{HEAD},tilt_deg\nlong,5,0,0,1,1\nlong,5,0,1,1,2\n",
    "not a text file (byte 2 cannot be read)": b"ab\xff\x01\x02",
    "line 2: not valid CSV": f'{HEAD}\nlong,5,0,0,"1',
}


@pytest.mark.parametrize("said", BAD_FORCES)
def test_a_fault_in_the_forces_is_named_with_its_place(tmp_path, said):
    with pytest.raises(BadInputError) as caught:
        read(tmp_path, BAD_FORCES[said])
    assert said in str(caught.value)
    assert "forces.csv" in str(caught.value)


BAD_CURVES = {
    "line 3: column point: point 0 of this curve is there twice": CURVES.replace("1,10", "0,10"),
    "line 3: column x_mm: 'x' is not a number": CURVES.replace("1,10", "1,x"),
    "fewer than three points": CURVES[: CURVES.index("long,5,2,2")],
    "the same place": CURVES.replace("10,0.5", "0,0"),
    "column sigma_mm is empty for some points": (
        CURVES.replace("y_mm", "y_mm,sigma_mm").replace("0,0\n", "0,0,1\n").replace("5\n", "5,\n")
        .replace("20,2\n", "20,2,1\n")
    ),
    "there is no force of reading 3": (
        CURVES.replace("y_mm\n", "y_mm,reading\n").replace("0,0\n", "0,0,3\n")
        .replace("5\n", "5,3\n").replace(",2\n", ",2,3\n")
    ),
}  # fmt: skip


@pytest.mark.parametrize("said", BAD_CURVES)
def test_a_fault_in_the_curves_is_named_with_its_place(tmp_path, said):
    with pytest.raises(BadInputError) as caught:
        read(tmp_path, curves=BAD_CURVES[said])
    assert said in str(caught.value)
    assert "curves.csv, line" in str(caught.value)


def test_times_that_fall_back_are_named(tmp_path):
    with pytest.raises(BadInputError, match=r"signals\.csv, line 3: column time_s"):
        read(tmp_path, signals=SIGNALS.replace("0.005", "-1"))


def test_existing_files_are_not_written_over(tmp_path):
    (tmp_path / "curves.csv").write_text("mine")
    with pytest.raises(BadInputError, match=r"curves\.csv exists already"):
        write_tables(measurements(), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["curves.csv"]


# --------------------------------------------------------------------------------------- sessions


@pytest.fixture
def imported(tmp_path):
    for name, text in (("forces", FORCES), ("curves", CURVES), ("signals", SIGNALS)):
        (tmp_path / f"{name}.csv").write_text(text)
    (tmp_path / "sheet.toml").write_text(SHEET)
    import_session(
        tmp_path / "sheet.toml",
        tmp_path / "forces.csv",
        tmp_path / "s.h5",
        curves=tmp_path / "curves.csv",
        signals=tmp_path / "signals.csv",
    )
    return tmp_path / "s.h5"


def test_an_imported_session_is_a_whole_session(imported):
    assert [check for check in verify(imported) if not check.ok] == []
    with open_session(imported) as session:
        assert session.outcome is Outcome.COMPLETED
        assert session.reason == "Imported from forces.csv, curves.csv, signals.csv."
        assert session.texts == {"sheet.toml": SHEET}
        assert session.runs == ()


def test_an_imported_session_holds_the_measurements_of_its_tables(imported, tmp_path):
    found = load_measurements(imported)
    wanted = read(tmp_path, FORCES, CURVES, SIGNALS)
    assert same(replace(found, checksum=""), wanted)
    assert len(found.checksum) == 64


def test_import_then_export_then_import_is_the_same(imported, tmp_path):
    paths = export_session(imported, tmp_path / "out")
    again = read_tables(SHEETS, *paths)
    assert same(replace(again, checksum=""), replace(load_measurements(imported), checksum=""))


def test_a_session_of_imported_tables_says_so_and_of_no_output(imported):
    with open_session(imported) as session:
        assert session.imported
        assert "imported tables" in str(session.summary())
        assert "output" not in str(session.summary())


def test_how_well_the_camera_is_known_stands_beside_the_curves(tmp_path):
    (tmp_path / "camera_uncertainty.csv").write_text("scale_fraction,origin_mm\n0.004,0.02\n")
    found = read(tmp_path, FORCES, CURVES).camera
    assert found == CameraUncertainty(scale=0.004, origin_m=2e-5)
    assert read(tmp_path, FORCES).camera == CameraUncertainty()
    (tmp_path / "sheet.toml").write_text(SHEET, encoding="utf-8")
    tables = {"forces": tmp_path / "forces.csv", "curves": tmp_path / "curves.csv"}
    import_session(tmp_path / "sheet.toml", output=tmp_path / "old.h5", **tables)
    assert load_measurements(tmp_path / "old.h5").camera == found
    with open_session(tmp_path / "old.h5") as session:
        assert session.reason.endswith("forces.csv, curves.csv, camera_uncertainty.csv.")
        assert set(session.resolved["imported_sha256"]) == {*TABLES[:2], TABLES[3]}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("scale\n0.004\n", "column 'scale' is not known"),
        ("scale_fraction\n-0.004\n", "line 2: column scale_fraction: .* from 0"),
        ("scale_fraction\nwide\n", "line 2: column scale_fraction: 'wide' is not a number from 0"),
        ("scale_fraction\n0.004\n0.004\n", "it has 2 lines of values; write one"),
        ("scale_fraction\n", "it has 0 lines of values; write one"),
    ],
)
def test_a_fault_in_how_well_the_camera_is_known_is_told(tmp_path, text, told):
    (tmp_path / "camera_uncertainty.csv").write_text(text)
    with pytest.raises(BadInputError, match=rf"camera_uncertainty\.csv.*{told}"):
        read(tmp_path, FORCES, CURVES)


def test_an_import_overwrites_nothing_and_leaves_nothing_behind(imported, tmp_path):
    before = imported.read_bytes()
    with pytest.raises(BadInputError, match="exists already"):
        import_session(tmp_path / "sheet.toml", tmp_path / "forces.csv", imported)
    assert imported.read_bytes() == before
    with pytest.raises(BadInputError, match="no such file"):
        import_session(tmp_path / "sheet.toml", tmp_path / "none.csv", tmp_path / "b.h5")
    with pytest.raises(BadInputError, match="no such folder"):
        import_session(tmp_path / "sheet.toml", tmp_path / "forces.csv", tmp_path / "no" / "b.h5")
    assert not list(tmp_path.glob("b.h5*"))


def test_signals_with_a_force_and_no_voltage_are_signals_that_lack_a_column(tmp_path):
    forces, signals = tmp_path / "forces.csv", tmp_path / "signals.csv"
    forces.write_text(FORCES)
    signals.write_text("configuration,position_mm,time_s,force_mN\nlong,5,0,1\nlong,5,0.1,1\n")
    with pytest.raises(BadInputError, match=r"signals\.csv: column drive_V is missing"):
        read_tables(SHEETS, forces, None, signals)
    with pytest.raises(BadInputError, match=r"forces\.csv: this is a forces\.csv; a signals\.csv"):
        read_tables(SHEETS, forces, None, forces)


def test_a_table_of_signals_without_samples_is_refused(tmp_path):
    with pytest.raises(BadInputError, match=r"signals\.csv: holds no samples"):
        read(tmp_path, signals=SIGNALS.splitlines()[0] + "\n")


@pytest.mark.parametrize("read", [decimals.from_milli, decimals.from_plain])
def test_numbers_are_read_the_short_way_as_exactly_as_the_long_way(read):
    dice = np.random.default_rng(5)
    scale = 3 if read is decimals.from_milli else 0
    texts = [repr(float(x)) for x in dice.normal(size=300) * 10.0 ** dice.integers(-8, 9, 300)]
    texts += [f"{x:.4f}" for x in dice.normal(size=300)]
    texts += ["-0", "+1.5", ".5", "5.", "1e3", "1E-400", "1_0", "0" * 40 + "1", "9" * 60]
    for text in texts:
        value = Decimal(text).scaleb(-scale)
        assert read(text) == float(value)
    for text in ("nan", "inf", "-inf", "1e400", "", "1,5", "1 e", "0x1", "e", "--1"):
        with pytest.raises(ValueError):  # noqa: PT011 - any will do
            read(text)
