"""labrig fit at the command line: several sessions, its options, what it prints and writes."""

from __future__ import annotations

import csv
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from labrig.cli.main import run
from labrig.model_file import load_model
from model import Along, Parameter, SheetModel, predict
from model.identification.fit import fit
from tests.cases import few
from tests.labrig.report_data import STIFFNESS, measure, session, truth

pytestmark = pytest.mark.usefixtures("data_unchecked")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fit")


@pytest.fixture(scope="module")
def day_1(folder):
    return session(folder / "day1.h5", measure("long"))


@pytest.fixture(scope="module")
def day_2(folder):
    return session(folder / "day2.h5", measure("long", seed=2))


@pytest.fixture(scope="module")
def stiffer(folder):
    """Another material: everything 1.5 times as strong, the same shapes."""
    made = measure("long", seed=3)
    conditions = tuple(
        replace(c, readings=tuple(replace(r, force_N=1.5 * r.force_N) for r in c.readings))
        for c in made.conditions
    )
    return session(folder / "stiffer.h5", replace(made, conditions=conditions))


def fitted_json(capsys, *arguments: object) -> dict:
    assert run(["fit", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)["configurations"]


def printed(capsys, *arguments: object) -> str:
    assert run(["fit", *map(str, arguments)]) == 0
    return capsys.readouterr().out


def refused(capsys, *arguments: object) -> str:
    assert run(["fit", *map(str, arguments)]) == 2
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    assert len(captured.err.strip().splitlines()) == 1
    return captured.err


# -- several sessions


@pytest.mark.slow
def test_sessions_of_the_same_sheet_share_its_parameters_and_fix_them_better(day_1, day_2, capsys):
    alone, both = fitted_json(capsys, day_1), fitted_json(capsys, day_1, day_2)
    assert list(both) == ["long"]
    B = both["long"]["B_Nm2"]
    assert abs(B["value"] - STIFFNESS["long"]) < 4 * B["sigma"]
    assert 0.5 < B["sigma"] / alone["long"]["B_Nm2"]["sigma"] < 0.9


@pytest.mark.thorough
@pytest.mark.slow
def test_sessions_apart_have_parameters_of_their_own(day_1, stiffer, tmp_path, capsys):
    path = tmp_path / "model.toml"
    found = fitted_json(capsys, day_1, stiffer, "--apart", "-o", path)
    assert list(found) == ["long@day1", "long@stiffer"]
    for name, factor in (("long@day1", 1.0), ("long@stiffer", 1.5)):
        B = found[name]["B_Nm2"]
        assert abs(B["value"] - factor * STIFFNESS["long"]) < 4 * B["sigma"]
    model = load_model(path)
    one, other = (predict(model, name, 0.01, 2.0).F_N for name in found)
    assert other == pytest.approx(1.5 * one, rel=0.01)


@pytest.mark.thorough
@pytest.mark.slow
def test_the_papers_numbers_stand_once_beside_sessions_apart(day_1, stiffer, capsys):
    out = printed(capsys, day_1, stiffer, "--apart")
    headings = [line for line in out.splitlines() if "long, paper" in line]
    assert [line.split("  ")[-1].strip() for line in headings] == ["long, paper"] * 2
    assert all(line.count("paper") == 1 for line in headings)
    assert all("long@day1" in line and "long@stiffer" in line for line in headings)


@pytest.mark.thorough
def test_sessions_apart_whose_files_have_the_same_name_are_told_by_their_folders(
    day_1, tmp_path, capsys
):
    paths = []
    for name in ("monday", "tuesday"):
        (tmp_path / name).mkdir()
        paths.append(session(tmp_path / name / "s.h5", measure("long")))
    assert list(fitted_json(capsys, *paths, "--apart")) == ["long@monday-s", "long@tuesday-s"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "said"),
    few(
        [
            ({"width_m": 0.02}, "width of 20 mm"),
            ({"arc_origin_rad": 0.1}, "of the arc of 5.7"),
        ]
    ),
)
def test_sessions_of_other_geometry_cannot_share_but_can_be_kept_apart(
    day_1, tmp_path, capsys, change, said
):
    made = measure("long")
    sheets = {"long": replace(made.sheets["long"], **change)}
    other = session(tmp_path / "other.h5", replace(made, sheets=sheets))
    err = refused(capsys, day_1, other)
    assert said in err
    assert "other.h5" in err
    if "width_m" in change:
        found = fitted_json(capsys, day_1, other, "--apart")
        ratio = found["long@day1"]["E_Pa"]["value"] / found["long@other"]["E_Pa"]["value"]
        assert ratio == pytest.approx(0.02 / 0.011, rel=1e-3)


# -- set-up by set-up


CHANGES = {0.0: 0.06, 0.01: -0.05, 0.02: 0.04, 0.03: -0.03}  # of B, by position


def scattered():
    """A session in which each set-up finds another stiffness, with the same EIBM."""
    made = measure("long")
    one = truth("long").sheets["long"]
    conditions = []
    for c in made.conditions:
        B = one.B.value * (1.0 + CHANGES[c.position_m])
        other = SheetModel(
            sheets={"long": replace(one, B=Parameter(value=B, sigma=0.0, unit="N m^2"))}
        )
        asked = (c.position_m, c.voltage_V)
        there = predict(other, "long", *asked)
        moved = there.F_N - predict(truth("long"), "long", *asked).F_N
        curve = replace(
            c.curve, s_m=there.s_m, x_m=there.x_m, y_m=there.y_m,
            curvature_per_m=there.curvature_per_m, sigma_m=np.full(len(there.s_m), 2e-6),
        )  # fmt: skip
        readings = tuple(replace(r, force_N=r.force_N + moved) for r in c.readings)
        conditions.append(replace(c, readings=readings, curve=curve))
    return replace(made, conditions=tuple(conditions))


@pytest.fixture(scope="module")
def uneven():
    return scattered()


@pytest.mark.thorough
@pytest.mark.slow
def test_each_set_up_has_the_stiffness_it_was_made_with(uneven):
    from model.identification.mounting import by_run

    found = by_run(fit(uneven).joint)
    assert [one.position_m for one in found] == list(CHANGES)
    for one in found:
        B = STIFFNESS["long"] * (1.0 + CHANGES[one.position_m])
        assert abs(one.B.value - B) < 3 * one.B.sigma
        assert one.B.value == pytest.approx(B, rel=0.015)
        assert 0 < one.B.sigma < 0.02 * B
        assert set(one.eibm) == {2.0, -2.0}
        assert one.eibm[2.0].value > 0 > one.eibm[-2.0].value


@pytest.mark.thorough
def test_by_run_prints_a_row_for_each_set_up_below_the_common_values(uneven, tmp_path, capsys):
    path = session(tmp_path / "uneven.h5", uneven)
    out = printed(capsys, path, "--by-run")
    lines = out[out.index("B and EIBM of each set-up") :].splitlines()
    rows = [line for line in lines if line.startswith("long, ")][:5]
    assert [re.split("  +", row)[0] for row in rows] == [
        "long, all", "long, 0 mm", "long, 10 mm", "long, 20 mm", "long, 30 mm",
    ]  # fmt: skip
    off = [float(re.split("  +", row)[2]) for row in rows[1:]]
    assert np.sign(off).tolist() == [1, -1, 1, -1]
    assert "B and EIBM of each set-up" not in printed(capsys, path)


@pytest.mark.thorough
def test_by_run_names_the_session_of_each_set_up(day_1, day_2, capsys):
    out = printed(capsys, day_1, day_2, "--by-run")
    for name in ("day1", "day2"):
        for place in ("0 mm", "10 mm", "20 mm", "30 mm"):
            assert out.count(f"long, {place}, {name} ") == 1


# -- options


@pytest.mark.thorough
@pytest.mark.slow
def test_symmetric_gives_both_polarities_one_size(day_1, capsys):
    free, one = fitted_json(capsys, day_1), fitted_json(capsys, day_1, "--symmetric")
    plus, minus = (np.array(one["long"]["EIBM_along_sheet"][v]["Me_Nm"]) for v in ("2.0", "-2.0"))
    assert np.allclose(plus, -minus, rtol=1e-9)
    assert free["long"]["EIBM_Nm"]["2.0"]["value"] > 1.1 * abs(
        free["long"]["EIBM_Nm"]["-2.0"]["value"]
    )


@pytest.mark.thorough
@pytest.mark.slow
def test_measured_curvature_does_not_need_what_sheet_toml_states(tmp_path, capsys):
    made = measure("long")
    sheet = made.sheets["long"]
    s_m, k0 = sheet.initial_curvature
    wrong = replace(sheet, initial_curvature=(s_m, k0 + 8.0))
    path = session(tmp_path / "wrong.h5", replace(made, sheets={"long": wrong}))
    model = tmp_path / "model.toml"
    B = fitted_json(capsys, path, "--measured-curvature", "-o", model)["long"]["B_Nm2"]
    assert abs(B["value"] - STIFFNESS["long"]) < 4 * B["sigma"]
    rest = load_model(model).sheets["long"].rest
    assert isinstance(rest, Along)
    assert np.allclose(np.interp(rest.s_m, s_m, k0), rest.values, atol=0.5)


@pytest.mark.slow
def test_hold_out_predicts_what_was_left_out_and_keeps_it_in_the_model_file(
    day_1, tmp_path, capsys
):
    path = tmp_path / "model.toml"
    out = printed(capsys, day_1, "--hold-out", "configuration=long,position=20", "-o", path)
    table = out[out.index("Predictions at left-out positions") :]
    rows = [line for line in table.splitlines() if line.startswith("long, ")]
    assert [re.split("  +", row)[0] for row in rows] == [
        "long, 20 mm, 0 V", "long, 20 mm, +2 V", "long, 20 mm, -2 V",
    ]  # fmt: skip
    assert all(abs(float(re.split("  +", row)[2])) < 0.05 for row in rows)
    assert "RMS errors: EIBM along the sheet 0.0" in out
    assert len(load_model(path).held_out) == 3
    assert "20 mm" in load_model(path).held_out[0]


@pytest.mark.thorough
def test_hold_out_without_a_configuration_leaves_out_the_position_of_all(
    day_1, stiffer, tmp_path, capsys
):
    path = tmp_path / "model.toml"
    printed(capsys, day_1, stiffer, "--apart", "--hold-out", "position=0", "-o", path)
    held = load_model(path).held_out
    assert [sum(name in text for text in held) for name in ("@day1", "@stiffer")] == [3, 3]


@pytest.mark.thorough
def test_configuration_fits_one_alone(tmp_path, capsys):
    path = session(tmp_path / "both.h5", measure())
    assert list(fitted_json(capsys, path, "--configuration", "short")) == ["short"]


@pytest.mark.thorough
def test_bootstrap_says_how_simulated_repeats_scatter(day_1, capsys):
    out = printed(capsys, day_1, "--bootstrap", "60")
    table = out[out.index("Bootstrap check of the uncertainties") :]
    ratios = [float(line.split()[-1]) for line in table.splitlines() if line.startswith("long ")]
    assert len(ratios) == 3
    assert all(0.7 < ratio < 1.4 for ratio in ratios)
    assert "60 simulated sessions" in table


# -- what is printed and written


@pytest.mark.slow
def test_the_papers_tables_are_printed_with_its_numbers(day_1, capsys):
    out = printed(capsys, day_1)
    places = [out.index(f"Table {number}.") for number in (4, 5, 6)]
    assert places == sorted(places)
    five, six = out[places[1] : places[2]], out[places[2] :]
    assert re.search(r"constant EIBM +2\.\d\d +2\.23", five)
    assert re.search(r"EIBM along the sheet: force, mN +0\.0\d\d +0\.322", six)
    assert "states no numbers of its table 4" in out


@pytest.mark.slow
def test_figures_8_and_9_are_written_as_png_and_svg(day_1, tmp_path, capsys):
    folder = tmp_path / "new" / "figures"
    out = printed(capsys, day_1, "--figures", folder)
    names = {f"figure-{n}.{ending}" for n in (8, 9) for ending in ("png", "svg")}
    assert {path.name for path in folder.iterdir()} == names
    for name in names:
        assert f"wrote {folder / name}" in out
    assert (folder / "figure-8.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (folder / "figure-9.svg").read_text(encoding="utf-8")


@pytest.mark.thorough
@pytest.mark.slow
def test_without_neutral_curves_there_is_no_figure_8(tmp_path, capsys):
    path = session(tmp_path / "forces.h5", measure("long", curves=False))
    out = printed(capsys, path, "--figures", tmp_path / "figures")
    assert "figure-8" not in out
    assert {p.name for p in (tmp_path / "figures").iterdir()} == {"figure-9.png", "figure-9.svg"}
    assert "Table 5" not in out


# -- what is refused


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["{day_1}", "{day_1}"], "is given twice"),
        (["{day_1}", "--apart"], "give several sessions"),
        (["{day_1}", "--configuration", "wide"], "measured were long"),
        (["{day_1}", "--hold-out", "position=7"], "nothing was measured at 7 mm"),
        (["{day_1}", "--hold-out", "7"], "write position=25"),
        (["{day_1}", "--bootstrap", "3"], "at least 20"),
        (["{day_1}", "--figures", "{day_1}"], "this is a file, a folder is needed"),
    ],
)
def test_a_mistake_is_one_sentence(day_1, capsys, arguments, said):
    assert said in refused(capsys, *[a.format(day_1=day_1) for a in arguments])


@pytest.mark.slow
@pytest.mark.parametrize("command", few(["fit", "fit --apart", "diagnose", "next"]))
def test_a_copy_of_a_session_is_no_further_measurement(day_1, day_2, tmp_path, capsys, command):
    copy = shutil.copy(day_1, tmp_path / "copy.h5")
    assert run([*command.split(), str(day_1), str(day_2), str(copy)]) == 2
    said = f"{copy}: is a copy of {day_1}; give each session once."
    assert said in capsys.readouterr().err


def test_all_positions_held_out_is_one_sentence(day_1, capsys):
    held = [text for p in (0, 10, 20, 30) for text in ("--hold-out", f"position={p}")]
    assert "every condition is held out" in refused(capsys, day_1, *held)


# -- data that contradict each other


@pytest.mark.slow
def test_a_fit_says_that_voltages_of_the_wrong_sign_leave_it_wrong(tmp_path, capsys):
    """The forces alone have them, so no B and EIBM explain forces and curves together."""
    tables = Path(__file__).parents[2] / "docs" / "tutorials" / "data"
    with (tables / "forces.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    forces = tmp_path / "forces.csv"
    with forces.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows({**row, "voltage_V": -float(row["voltage_V"])} for row in rows)
    others = "--sheet", tables / "sheet.toml", "--curves", tables / "curves.csv"
    said = printed(capsys, *others, "--forces", forces)
    assert "B and EIBM are not to be trusted; check the signs and units of forces" in said
    assert "not to be trusted" not in printed(capsys, *others, "--forces", tables / "forces.csv")
