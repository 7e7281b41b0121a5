"""Whatever is handed to diagnose, a person reads one sentence, and never a traceback."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.data_mistakes.mistakes import MISTAKES
from labrig.cli.main import run
from labrig.config.templates import template_text
from labrig.model_file import save_model
from labrig.session.tables.write import write_tables
from tests.cases import few
from tests.labrig.report_data import invalid, measure, truth


def tables(folder, measurements):
    """The options that name a folder's CSV tables."""
    write_tables(measurements, folder)
    (folder / "sheet.toml").write_text(template_text("sheet.toml"), encoding="utf-8")
    options = []
    for name in ("sheet.toml", "forces.csv", "curves.csv", "signals.csv"):
        if (folder / name).exists():
            options += [f"--{name.split('.')[0]}", str(folder / name)]
    return options


def only(measurements, use):
    return replace(measurements, conditions=tuple(c for c in measurements.conditions if use(c)))


def with_readings(measurements, change):
    conditions = tuple(
        replace(c, readings=tuple(change(r) for r in c.readings)) for c in measurements.conditions
    )
    return replace(measurements, conditions=conditions)


def alike(measurements):
    conditions = tuple(
        replace(c, readings=tuple(replace(r, force_N=c.readings[0].force_N) for r in c.readings))
        for c in measurements.conditions
    )
    return replace(measurements, conditions=conditions)


CASES = {
    "one condition": lambda m: only(m, lambda c: c.position_m == 0.0 and c.voltage_V == 2.0),
    "one position": lambda m: only(m, lambda c: c.position_m == 0.0),
    "one voltage": lambda m: only(m, lambda c: c.voltage_V == 2.0),
    "no 0 V": lambda m: only(m, lambda c: c.voltage_V != 0.0),
    "only 0 V": lambda m: only(m, lambda c: c.voltage_V == 0.0),
    "no curves": lambda m: replace(
        m, conditions=tuple(replace(c, curve=None) for c in m.conditions)
    ),
    "identical repeats": alike,
    "single readings": lambda m: replace(
        m, conditions=tuple(replace(c, readings=c.readings[:1]) for c in m.conditions)
    ),
    "no series": lambda m: replace(m, series=()),
    "huge forces": lambda m: with_readings(m, lambda r: replace(r, force_N=1e6 * r.force_N)),
    "no forces": lambda m: with_readings(m, lambda r: replace(r, force_N=0.0)),
    "all invalid": lambda m: invalid(m, "long", "by hand"),
}


# Of what `prepare` has tests of its own for, and ends in a search all the same.
MORE = (
    "identical repeats", "no series", "one voltage", "single readings", "one position", "no forces",
)  # fmt: skip


@pytest.fixture(scope="module")
def measured():
    return measure("long")


def told(capsys) -> str:
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err + captured.out
    assert "this should not have happened" not in captured.err
    return captured.err


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    few(
        [
            *sorted(CASES.keys() - MORE),
            *(pytest.param(name, marks=pytest.mark.thorough) for name in MORE),
        ],
        first=2,
    ),
)
def test_data_that_say_too_little_end_in_a_verdict_or_in_a_sentence(
    name, measured, tmp_path, capsys
):
    code = run(["diagnose", *tables(tmp_path, CASES[name](measured))])
    err = told(capsys)
    assert code in (0, 2)
    if code:
        last = err.strip().splitlines()[-1]
        assert last.startswith("labrig: ")
        assert len(last) < 400


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "give a session, or CSV tables with --sheet and --forces"),
        (["gone.h5"], "there is no such file"),
        (["--forces", "gone.csv"], "--sheet and --forces, --curves or both"),
        (["--sheet", "sheet.toml"], "--sheet and --forces, --curves or both"),
        (["a.h5", "--sheet", "sheet.toml"], "either a session or CSV tables"),
    ],
)
def test_arguments_that_do_not_fit_are_refused(arguments, says, capsys):
    assert run(["diagnose", *arguments]) == 2
    assert says in told(capsys)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hold_out", "says"),
    [
        ("25", "write position=25"),
        ("position=x", "a position in mm is needed"),
        ("configuration=long", "a position in mm is needed"),
        ("position=7", "measured were 0, 10, 20, 30 mm"),
        ("configuration=wide,position=10", "there is no configuration 'wide'"),
        ("position=10,position=20", "write position=25"),
    ],
)
def test_a_position_to_leave_out_must_be_one_that_was_measured(
    hold_out, says, measured, tmp_path, capsys
):
    options = tables(tmp_path, measured)
    assert run(["diagnose", *options, "--hold-out", hold_out]) == 2
    assert says in told(capsys)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_model_of_another_sheet_is_refused(measured, tmp_path, capsys):
    model = truth("long")
    one = model.sheet("long")
    longer = replace(one, sheet=replace(one.sheet, free_length_m=0.07))
    save_model(replace(model, sheets={"long": longer}), tmp_path / "other.toml")
    options = tables(tmp_path, measured)
    assert run(["diagnose", *options, "--model", str(tmp_path / "other.toml")]) == 2
    assert "free length of 70 mm" in told(capsys)


def test_a_model_file_is_not_overwritten_unasked(measured, tmp_path, capsys):
    path = tmp_path / "model.toml"
    path.write_text("mine", encoding="utf-8")
    options = tables(tmp_path, measured)
    assert run(["diagnose", *options, "-o", str(path)]) == 2
    assert "give --force" in told(capsys)
    assert path.read_text(encoding="utf-8") == "mine"


def test_where_the_data_stop_the_search_no_model_is_written_and_that_is_said(
    measured, tmp_path, capsys
):
    wrong = next(one for one in MISTAKES if one.name == "curves in m instead of mm")
    options = tables(tmp_path, wrong.make(measured, np.random.default_rng(3))[0])
    path = tmp_path / "model.toml"
    path.write_text("older", encoding="utf-8")
    assert run(["diagnose", *options, "-o", str(path), "--force"]) == 0
    captured = capsys.readouterr()
    assert "nothing is searched for and there is no model" in " ".join(captured.out.split())
    assert (
        f"{path} is not written: there is no model of data that contradict what is stated;"
        " what is there is older" in " ".join(captured.err.split())
    )
    assert path.read_text(encoding="utf-8") == "older"


@pytest.mark.parametrize(
    ("between", "says"),
    [
        (["gravity", "magnetism"], "there is no effect 'magnetism'"),
        (["gravity", "gravity"], "name two different effects"),
        pytest.param([], "the diagnosis names no two effects", marks=pytest.mark.slow),
    ],
)
def test_next_wants_two_effects_of_the_catalogue(between, says, measured, tmp_path, capsys):
    options = tables(tmp_path, measured)
    asked = ["--between", *between] if between else []
    assert run(["next", *options, *asked]) == 2
    assert says in told(capsys)


@pytest.mark.slow
def test_nan_in_a_table_is_a_sentence_about_its_line(measured, tmp_path, capsys):
    options = tables(tmp_path, measured)
    path = tmp_path / "forces.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    column = lines[0].split(",").index("force_mN")
    cells = lines[3].split(",")
    cells[column] = str(np.nan)
    path.write_text("\n".join([*lines[:3], ",".join(cells), *lines[4:]]), encoding="utf-8")
    assert run(["diagnose", *options]) == 2
    assert "line 4" in told(capsys)
