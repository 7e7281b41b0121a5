"""What is stated of a measurement is compared with what the data say before a search."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import labrig
from benchmarks.data_mistakes.mistakes import MISTAKES
from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators.elements import WORLD as ELEMENTS
from labrig.session.tables.examples import write_examples
from model import Condition, Curve, Measurements, ModelError, Reading, predict
from model.discrepancy import DiagnoseOptions, check_data, diagnose, next_measurement
from model.discrepancy.data_checks import catalogue
from model.discrepancy.data_checks.catalogue import data_checks
from model.discrepancy.data_checks.changed_data import of_one
from model.discrepancy.data_checks.conformance import example_measurements, faults
from model.discrepancy.data_checks.contract import DataCheck, Suspicion
from model.discrepancy.data_checks.quick_fit import FAR_WORSE, Tolerances, bare, quick_fit
from model.discrepancy.data_checks.shape_compliance import shape_compliance
from model.discrepancy.thresholds import SURE_COMPLIANCE_SIGMA
from model.identification.data.outlier_readings import without_outliers
from model.identification.likelihood import gauss_newton
from model.plugins import Part, PluginWarning
from tests.cases import few
from tests.model.discrepancy.foreign_sessions import Foreign, foreign_session
from tests.model.discrepancy.sessions import FALLING, session

BY_NAME = {one.name: one for one in MISTAKES}


def with_mistake(name):
    return BY_NAME[name].make(session(), np.random.default_rng(3))


def forces_changed(m, change):
    """Return measurements in which `change(condition, readings' forces)` gives the forces."""

    def other(c):
        used = c.used()
        forces = dict(
            zip(map(id, used), change(c, np.array([r.force_N for r in used])), strict=True)
        )
        readings = (replace(r, force_N=float(forces.get(id(r), r.force_N))) for r in c.readings)
        return replace(c, readings=tuple(readings))

    return replace(m, conditions=tuple(other(c) for c in m.conditions), series=())


def test_polarities_exchanged_in_the_curves_are_seen_where_the_eibm_falls_along_the_sheet():
    falling = session(FALLING)
    made = BY_NAME["polarities exchanged in the curves"].make(falling, np.random.default_rng(3))
    exchanged = made[0]
    assert check_data(falling).stops == ()
    (stop,) = check_data(exchanged).stops
    assert stop.check == "polarity"


def test_the_check_on_the_page_about_extending_conforms():
    page = (Path(__file__).parents[3] / "docs" / "howto" / "extending.md").read_text(
        encoding="utf-8"
    )
    example = page.split("## A data check")[1].split("```python")[1].split("```")[0]
    there: dict[str, object] = {"__name__": "example"}
    exec(compile(example, "extending.md", "exec"), there)
    assert faults(there["CHECK"]) == []


@pytest.mark.parametrize("name", data_checks())
def test_each_data_check_conforms(name):
    assert faults(data_checks()[name]) == []


@pytest.mark.slow
class Broken(DataCheck):
    """A check of another distribution that fails on real data."""

    def suspicions(self, measurements):
        """See `DataCheck.suspicions`."""
        raise KeyError("no such thing")

    def of_stiffness(self, measurements, B_Nm2):
        """See `DataCheck.of_stiffness`."""
        yield "soft"


def test_a_check_of_another_distribution_that_fails_costs_no_fit(monkeypatch):
    part = Part("broken", Broken(name="broken", meaning="x", order=1), "labrig-extra", "0.1")
    monkeypatch.setattr(catalogue, "FOLDER", SimpleNamespace(parts=lambda: {"broken": part}))
    check = data_checks()["broken"]
    assert check is data_checks()["broken"]  # what it said of the same data is kept by it
    data = example_measurements()
    with pytest.warns(PluginWarning, match=r"the data check 'broken' of labrig-extra 0\.1 failed"):
        assert [*check.suspicions(data)] == []
    with pytest.warns(PluginWarning, match="it yielded str, not a Suspicion"):
        assert [*check.of_stiffness(data, {})] == []


@pytest.mark.slow
def test_nothing_is_suspicious_about_a_usual_session():
    found = check_data(session())
    assert found.suspicions == ()
    assert found.notes == ()
    assert found.measurements is session()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("positions of one sheet in metres", "'short' (position_mm) reach 0.03 mm; multiplied by"),
        ("curves of two positions exchanged", "are each other's (position_mm in the table of"),
        ("two positions exchanged", "forces and curves of 'long' and 'short' at"),
        ("leads exchanged at one position", "the leads seem to have been exchanged there"),
        ("polarities exchanged in the curves", "unless the polarities (voltage_V) are exchanged"),
        pytest.param(
            "tare of 3 to 7 mN forgotten",
            "the load cell seems not to have been tared",
            marks=pytest.mark.thorough,
        ),
    ],
)
def test_a_wrong_datum_is_told_with_the_value_that_would_fit(name, said):
    wrong, right = with_mistake(name)
    found = check_data(wrong)
    (one,) = found.suspicions
    assert one.severity == "stop"
    assert one.check in BY_NAME[name].told_by
    assert said in one.sentence
    if np.isfinite(BY_NAME[name].tolerance):
        scale = 1e3 if one.unit else 1.0
        assert one.value == pytest.approx(scale * right, rel=BY_NAME[name].tolerance)


@pytest.mark.thorough
def test_a_camera_of_another_scale_is_no_wrong_radius():
    """The short sheet asks for another radius than the long one."""

    def seen(curve):
        return replace(curve, s_m=1.07 * curve.s_m, x_m=1.07 * curve.x_m, y_m=1.07 * curve.y_m)

    plain = foreign_session(Foreign(), 3)
    curves = [replace(c, curve=c.curve and seen(c.curve)) for c in plain.conditions]
    found = check_data(replace(plain, conditions=tuple(curves)))
    assert found.stops == ()
    (radius,) = (one for one in found.suspicions if one.check == "arc_radius")
    assert radius.severity == "warn"
    assert radius.configurations == ("long",)
    assert "'short' asks for" in radius.sentence
    assert radius.sentence.endswith("so an effect may be the reason")


@pytest.mark.slow
def test_a_length_is_doubted_where_all_curves_end_elsewhere():
    wrong, right = with_mistake("length wrong by 8 to 15 %")
    (one,) = check_data(wrong).suspicions
    assert (one.check, one.severity) == ("sheet_length", "warn")
    assert one.value == pytest.approx(1e3 * right, rel=1e-3)
    assert "the free length of 'long' (free_length_mm in sheet.toml) is" in one.sentence


@pytest.mark.slow
def test_a_search_of_data_in_another_unit_stops_with_the_reason():
    found = diagnose(with_mistake("curves in m instead of mm")[0])
    assert found.verdict == "cannot_tell"
    assert found.effects == ()
    assert not found.searched
    assert found.sentence.startswith(
        "These data contradict what is stated of them, so nothing is searched for and there is no"
        " model: curves of 'long'"
    )
    with pytest.raises(ModelError, match="this model has no configuration: nothing was fitted"):
        predict(found.model, "long", 0.01, 2.0)
    (first, _) = found.to_json()["data_checks"]
    assert (first["check"], first["severity"]) == ("curve_unit", "stop")
    assert first["value"] == pytest.approx(1000.0, rel=0.01)
    with pytest.raises(ModelError, match="These data contradict what is stated of them"):
        next_measurement(
            with_mistake("curves in m instead of mm")[0],
            ("gravity", "clamp_angle"),
            DiagnoseOptions(),
        )


@pytest.mark.thorough
@pytest.mark.slow
def test_a_base_fit_that_fails_is_said_and_not_explained():
    random = np.random.default_rng(5)
    shuffled = forces_changed(
        of_one(session(), "short"),
        lambda _, forces: forces - forces.mean() + random.normal(0.0, 3e-3),
    )
    found = check_data(shuffled)
    assert [one.check for one in found.stops] == ["base_fit"]
    assert "the base model does not fit 'short': force error" in found.stops[0].sentence
    assert "none of those that were tried (unit, sign, order, length) mends it" in (
        found.stops[0].sentence
    )


@pytest.fixture(scope="module")
def falling(tmp_path_factory):
    """Return the example of `labrig import`: its EIBM falls steeply, so that no constant one fits.

    Of `session()` the base model fits what is changed rightly, also where something is hidden.
    """
    folder = tmp_path_factory.mktemp("falling")
    write_examples(folder)
    tables = (folder / name for name in ("sheet.toml", "forces.csv", "curves.csv"))
    return labrig.measurements_of_tables(*tables)


def staircase(decay_m, positions_m):
    """Voltages of one sign, as a staircase has them, on a sheet whose EIBM falls along it."""
    voltages = (0.0, 0.5, 1.0, 1.5, 2.0)
    model = labrig.sheet(
        free_length_mm=50, width_mm=11, thickness_mm=0.21, B_Nm2=1.27e-6,
        EIBM_Nm={V: lambda s, V=V: 63e-6 * V * np.exp(-s / decay_m) for V in voltages if V},
    )  # fmt: skip
    random, conditions = np.random.default_rng(4), []
    for position_m in positions_m:
        for V in voltages:
            there = predict(model, "sheet", position_m, V)
            readings = tuple(
                Reading(
                    index=i, kind="kept" if V else "zero",
                    force_N=there.F_N + random.normal(0.0, 1.6e-5),
                )
                for i in range(4)
            )  # fmt: skip
            conditions.append(
                Condition(
                    configuration="sheet", position_m=position_m, voltage_V=V, readings=readings,
                    curve=Curve(s_m=there.s_m, x_m=there.x_m, y_m=there.y_m),
                )
            )  # fmt: skip
    return Measurements(sheets={"sheet": model.sheet("sheet").sheet}, conditions=tuple(conditions))


@pytest.mark.slow
@pytest.mark.parametrize("decay_m", [0.012, 0.006])
def test_voltages_of_one_sign_with_an_eibm_along_the_sheet_are_no_wrong_data(decay_m):
    """The forces spread little then, and a constant EIBM is off by as much as they do."""
    data = staircase(decay_m, np.linspace(0.0, 0.03, 7))
    assert check_data(data).suspicions == ()
    found = diagnose(data)
    assert [one.name for one in found.effects] == ["nonuniform_eibm"], found.sentence
    assert found.effects[0].confusable_with == ()  # nothing is asked of the other polarity
    before, after = found.held_out.before, found.held_out.after
    assert after.force_rmse_mN < 0.3 * before.force_rmse_mN


@pytest.mark.slow
def test_the_sign_of_the_forces_is_told_where_the_base_model_fits_neither(falling):
    assert check_data(falling).suspicions == ()
    (one,) = check_data(forces_changed(falling, lambda _, forces: -forces)).suspicions
    assert (one.check, one.severity, one.value) == ("force_sign", "stop", -1.0)
    assert "'long' (force_mN) contradict the curves unless they have the other sign" in one.sentence


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "unit"), few([(1e-3, "in N"), (1e3, "in µN")]))
def test_forces_in_another_unit_are_told(falling, factor, unit):
    for data in (falling, session()):
        found = check_data(forces_changed(data, lambda _, forces: factor * forces)).suspicions
        assert {one.check for one in found} == {"force_unit"}
        assert {name for one in found for name in one.configurations} == {
            c.configuration for c in data.conditions
        }
        for one in found:
            assert one.severity == "stop"
            assert one.value == pytest.approx(1.0 / factor)
            assert f"multiplied by {1.0 / factor:g} they fit, so they seem to be {unit}" in (
                one.sentence
            )
            assert "e+" not in one.sentence.partition(" at most")[0]  # 2310 mN, not 2.31e+03 mN
            assert ("; where the strip is of metal they may be right" in one.sentence) is (
                factor > 1.0 and "e+11 Pa" in one.sentence
            )


@pytest.mark.slow
def test_a_strip_under_voltages_that_no_polymer_bears_may_be_of_metal(falling):
    """Forces of newtons and the modulus of a metal: 100 V are of a piezoelectric bimorph."""
    metal = forces_changed(falling, lambda _, forces: 1e3 * forces)
    bimorph = replace(
        metal,
        conditions=tuple(replace(c, voltage_V=50.0 * c.voltage_V) for c in metal.conditions),
        series=(),
    )
    assert {one.severity for one in check_data(metal).suspicions} == {"stop"}
    found = check_data(bimorph)
    assert {(one.check, one.severity) for one in found.suspicions} == {("force_unit", "warn")}
    assert not found.stops


@pytest.mark.thorough
@pytest.mark.slow
def test_a_wrong_thickness_is_no_unit_of_the_forces(falling):
    """Young's modulus is a thousand times too small, but the forces are those of a sheet."""
    (name,) = {c.configuration for c in falling.conditions}
    thick = replace(falling.sheets[name], thickness_m=10.0 * falling.sheets[name].thickness_m)
    found = check_data(replace(falling, sheets={**falling.sheets, name: thick}))
    assert "force_unit" not in {one.check for one in found.suspicions}


def test_few_conditions_say_nothing_of_the_stiffness(falling):
    (name,) = {c.configuration for c in falling.conditions}
    assert shape_compliance(falling, name).sigmas > 3.0 * SURE_COMPLIANCE_SIGMA
    one_place = tuple(c for c in falling.conditions if c.position_m in (None, 0.0))
    assert shape_compliance(replace(falling, conditions=one_place), name) is None
    assert shape_compliance(replace(falling, conditions=()), name) is None


@pytest.mark.thorough
@pytest.mark.slow
def test_strong_effects_of_the_load_cell_are_no_wrong_data():
    lifted = forces_changed(session(), lambda _, forces: forces + 0.4e-3)
    assert check_data(lifted).suspicions == ()


@pytest.mark.slow
def test_readings_far_from_the_others_are_left_out_and_told():
    wild = forces_changed(
        session(),
        lambda c, forces: (
            forces + 3e-3 * (np.arange(len(forces)) == 4) * (c.position_m == 0.01)
            if c.voltage_V > 0.0
            else forces
        ),
    )
    found = without_outliers(wild)
    assert found.readings == 2
    assert found.sentences()[0].startswith("2 readings far from the others of their condition")
    numbers = {
        f"{c.configuration}, 10 mm, +2 V, reading {sorted(r.index for r in c.used())[4]}"
        for c in wild.conditions
        if c.position_m == 0.01 and c.voltage_V > 0.0
    }
    assert set(found.places) == numbers
    means = [
        [np.mean([r.force_N for r in c.used()]) for c in m.conditions if c.position_m is not None]
        for m in (session(), found.measurements)
    ]
    assert means[1] == pytest.approx(means[0], abs=2e-5)


def test_of_several_sessions_the_one_with_the_wild_reading_is_told():
    numbered = [replace(c, session=1 + (c.position_m == 0.01)) for c in session().conditions]
    wild = forces_changed(
        replace(session(), conditions=tuple(numbered)),
        lambda c, forces: forces + 1e-3 * (np.arange(len(forces)) == 4) * (c.session == 2),
    )
    found = without_outliers(wild)
    assert found.readings == 6
    assert all("10 mm" in place and ", session 2, reading " in place for place in found.places)


@pytest.mark.parametrize(
    "course",
    [
        lambda n: np.arange(n) / n,  # a drift
        lambda n: np.exp(-3.0 * np.arange(n)),  # a transient of the first pulses
        lambda n: (np.arange(n) > n / 2).astype(float),  # a slip
    ],
)
def test_what_readings_do_in_time_is_no_outlier(course):
    moving = forces_changed(session(), lambda _, forces: forces + 2e-3 * course(len(forces)))
    assert without_outliers(moving).readings == 0


def test_a_check_that_suspects_good_data_does_not_conform():
    class Grumbling(DataCheck):
        def suspicions(self, measurements):
            yield Suspicion(
                check="grumbling", severity="warn", where="", configurations=(), sentence="no"
            )

    grumbling = Grumbling(name="grumbling", meaning="nothing", order=1)
    assert faults(grumbling) == ["it suspects data in which nothing is wrong: no"]
    assert faults("text")[0].startswith("it is of type str")
    assert list(example_measurements().sheets) == ["example"]


@pytest.mark.parametrize("method", ["suspicions", "changes", "of_failed_fit"])
def test_a_check_that_returns_nothing_is_told_which_method_of_it(method):
    forgetful = type("Forgetful", (DataCheck,), {method: lambda _self, _measurements: None})
    found = faults(forgetful(name="forgetful", meaning="nothing", order=1))
    assert found == [f"its `{method}` returned NoneType; it must yield what it finds"]


@pytest.mark.slow
def test_sheets_of_unlike_moduli_are_told_with_the_thickness_that_would_fit():
    m = session()
    thin = replace(m.sheets["long"], thickness_m=m.sheets["long"].thickness_m / 2.0)
    (one,) = check_data(replace(m, sheets={**m.sheets, "long": thin})).suspicions
    assert one.check == "material"
    assert one.value == pytest.approx(1e3 * m.sheets["long"].thickness_m, rel=0.2)


def test_forces_in_another_unit_give_a_modulus_that_no_sheet_has():
    m = session()
    B_Nm2 = dict.fromkeys(m.sheets, 1e-9 * m.sheets["long"].width_m * 0.2**3 / 12.0)
    said = [one.sentence for one in data_checks()["material"].of_stiffness(m, B_Nm2)]
    assert any("would mean a Young's modulus of" in one for one in said)
    assert all("check that forces are in mN" in one for one in said)


@pytest.mark.slow
def test_the_same_data_are_fitted_once(monkeypatch):
    fitted = []
    monkeypatch.setattr(
        "model.discrepancy.data_checks.check._of_the_fit", lambda data, _: fitted.append(data) or ()
    )
    data = session()
    check_data(data)
    check_data(replace(session(), checksum="after results were kept in the file"))
    assert len(fitted) == 1
    check_data(forces_changed(data, lambda _, forces: 1.01 * forces))
    assert len(fitted) == 2


@pytest.mark.slow
def test_a_hopeless_change_is_given_up_after_a_few_solutions(monkeypatch):
    """Positions in reverse order, of data that fit as they are stated."""
    counts = []
    solved = gauss_newton.sensitivities
    monkeypatch.setattr(
        gauss_newton, "sensitivities", lambda *given: counts.append(1) or solved(*given)
    )
    few = of_one(bare(session()), "long")
    tolerances = Tolerances.of(few)
    stated = quick_fit(few, tolerances)
    turned = replace(
        few,
        conditions=tuple(
            replace(c, position_m=None if c.position_m is None else -c.position_m)
            for c in few.conditions
        ),
    )
    counts.clear()
    whole = quick_fit(turned, tolerances)
    steps = len(counts)
    counts.clear()
    given_up = quick_fit(turned, tolerances, stated=stated)
    assert len(counts) == 1 + gauss_newton.FEW_STEPS < steps
    assert min(whole.squares, given_up.squares) > FAR_WORSE * stated.squares


@pytest.mark.slow
def test_a_heavy_elongation_is_no_sheet_that_was_straight():
    """Its weight takes up what the initial curvature does, in the forces of the short sheet."""
    positions = {"short": tuple(1e-3 * p for p in range(0, 35, 5))}
    design = Design(positions_m=positions, series=False)
    heavy = ELEMENTS.measure(design, {"gravity": 0.0273}, 5)  # N/m: a sheet of 1.2 g/cm^3
    assert check_data(heavy).stops == ()


@pytest.mark.parametrize(
    ("curvature_per_m", "factors"),
    [(28.0, [-1.0]), (0.028, [-1.0, 1e3]), (28e3, [-1.0, 1e-3]), (0.0, [])],
)
def test_an_initial_curvature_is_doubted_where_a_unit_may_be_mistaken(curvature_per_m, factors):
    (sheet,) = (one for name, one in session().sheets.items() if name == "short")
    stated = (np.zeros(1), np.array([curvature_per_m]))
    data = Measurements(sheets={"short": replace(sheet, initial_curvature=stated)}, conditions=())
    changes = data_checks()["initial_curvature"].changes(data)
    assert [value for one in changes for value in one.values] == factors
