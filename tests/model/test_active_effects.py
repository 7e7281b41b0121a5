"""A model with effects predicts what a sheet with them does, and survives its file."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from model import Along, ModelError, Parameter, SheetModel, predict, predict_free
from model.design.force_map import force_map
from model.effects import catalogue
from model.identification.likelihood.form_ways import sampled
from model.sheet.beam_problem import ActiveEffect, Profile
from model.sheet.instruments import as_imaged
from tests.cases import few

POSITION_M = 0.01
RISE_S = 0.05
MEAN_POWER = 0.25 / np.log(2.0)  # of 1/2, over all powers from 1 to 2
# they are 0 in the middle of a session, or at the sampling point, or a matter of the rise time
NOT_IN_MEANS = {"force_drift", "stiffness_drift", "eibm_drift", "back_relaxation", "frame_delay"}


def active(name: str, **values: float) -> ActiveEffect:
    return ActiveEffect(
        name=name, parameters={k: Parameter(value=v, sigma=0.0, unit="") for k, v in values.items()}
    )


def along(*values: float, along: str = "s") -> Profile:
    at = tuple(np.linspace(0.0, 0.05, len(values)))
    return Profile(along=along, at=at, values=values, sigma=tuple(0.0 for _ in values), unit="")


def unknown(location: str, profile: Profile) -> ActiveEffect:
    return ActiveEffect(name="unknown", profile=profile, location=location)


def with_eibm_times(model: SheetModel, factor: float) -> SheetModel:
    sheets = {
        name: replace(
            one, eibm={v: replace(a, values=a.values * factor) for v, a in one.eibm.items()}
        )
        for name, one in model.sheets.items()
    }
    return replace(model, sheets=sheets)


def plausible(name: str) -> ActiveEffect:
    return active(
        name,
        **{parameter.name: parameter.prior_scale for parameter in catalogue()[name].parameters},
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", few(sorted(catalogue()), first=12))
def test_every_effect_of_the_catalogue_can_be_in_a_model(truth: SheetModel, name: str):
    model = truth.with_effects(plausible(name)).in_session(2)
    for configuration in truth.sheets:
        for voltage in (0.0, -2.0):
            found = predict(model, configuration, POSITION_M, voltage)
            assert found.reachable
            assert np.isfinite([found.F_N, found.N_N, found.s_hat_m]).all()
            assert np.isfinite(found.x_m).all()
    assert seen_difference(model, truth) > 1e-8 or name in NOT_IN_MEANS


def seen_difference(model: SheetModel, other: SheetModel) -> float:
    differences = []
    for configuration in other.sheets:
        one, two = (predict(m, configuration, 0.028, -2.0) for m in (model, other))
        differences += [abs(one.F_N - two.F_N), float(np.max(np.abs(one.x_m - two.x_m)))]
    return max(differences)


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_an_effect_at_its_neutral_value_changes_nothing(truth: SheetModel, name: str):
    parameters = catalogue()[name].parameters
    values = {p.name: p.neutral if p.estimated else p.prior_scale for p in parameters}
    if not np.isfinite(parameters[0].neutral):
        pytest.skip("its absence is no number that a file could hold")
    values[parameters[0].name] = max(parameters[0].neutral, parameters[0].low)
    model = truth.with_effects(active(name, **values))
    for voltage in (0.0, -2.0):
        one, two = (predict(m, "long", POSITION_M, voltage) for m in (model, truth))
        assert pytest.approx(two.F_N, rel=2e-3, abs=1e-9) == one.F_N
        assert one.x_m == pytest.approx(two.x_m, abs=2e-5)


@pytest.mark.slow
def test_a_falling_eibm_is_the_same_as_one_written_out_along_the_sheet(truth: SheetModel):
    decay_m, length = 0.02, 0.05
    s = np.linspace(0.0, length, 201)
    share = np.exp(-s / decay_m) * (length / decay_m) / (1.0 - np.exp(-length / decay_m))
    one = truth.sheet("long")
    written = {v: Along(s, share * a.values[0], 0.0 * s, "N m") for v, a in one.eibm.items()}
    known = replace(truth, sheets={"long": replace(one, eibm=written)})
    model = truth.with_effects(active("nonuniform_eibm", decay_length_mm=20.0))
    for voltage in (2.0, -2.0):
        ours, theirs = (predict(m, "long", POSITION_M, voltage) for m in (model, known))
        assert pytest.approx(theirs.F_N, rel=1e-4) == ours.F_N
        assert ours.y_m == pytest.approx(theirs.y_m, abs=2e-7)
        free, known_free = (predict_free(m, "long", voltage) for m in (model, known))
        assert free[2] == pytest.approx(known_free[2], abs=1e-6)


def test_a_clamp_that_gives_way_turns_by_the_moment_that_the_force_has(truth: SheetModel):
    model = truth.with_effects(active("clamp_compliance", rotation_rad_per_Nm=400.0))
    found = predict(model, "long", POSITION_M, 2.0)
    root = np.arctan2(found.y_m[1] - found.y_m[0], found.x_m[1] - found.x_m[0])
    bent = 0.5 * 0.5e-3 * found.curvature_per_m[0]  # half of the first step's own turn
    assert root - bent == pytest.approx(400.0 * -0.04 * found.F_N, abs=2e-5)
    x, y = predict_free(model, "long", 2.0)[1:]
    assert np.arctan2(y[1], x[1]) == pytest.approx(0.5 * 0.5e-3 * 49.0, abs=1e-3)


def test_the_sheet_passes_beside_the_arcs_point_by_the_rolls_offset(truth: SheetModel):
    model = truth.with_effects(active("roll_offset", offset_mm=0.5))
    found = predict(model, "long", POSITION_M, 2.0)
    angle = POSITION_M / 0.04
    away = np.hypot(found.x_m - 0.04 * np.cos(angle), found.y_m - 0.04 * np.sin(angle))
    assert away.min() == pytest.approx(0.5e-3, rel=2e-2)
    assert found.s_m[away.argmin()] == pytest.approx(found.s_hat_m, abs=0.5e-3)


@pytest.mark.parametrize("of", [0.0, 1.0])
def test_an_arc_of_another_radius_is_as_if_that_were_stated(truth: SheetModel, of: float):
    model = truth.with_effects(active("arc_error", offset_mm=0.5, of=of))
    long = truth.sheet("long")
    stated = replace(long, sheet=replace(long.sheet, arc_radius_m=0.0405))
    there = replace(truth, sheets={**truth.sheets, "long": stated})
    along = 1.0 if of == 0.0 else 0.0405 / 0.04  # positions that are angles
    for voltage in (0.0, -2.0):
        found = predict(model, "long", POSITION_M, voltage)
        wanted = predict(there, "long", along * POSITION_M, voltage)
        assert pytest.approx(wanted.F_N, rel=1e-6) == found.F_N
        np.testing.assert_allclose(found.y_m, wanted.y_m, atol=1e-8)


def test_an_elongation_that_gives_way_makes_the_sheet_softer(truth: SheetModel):
    stiff, firm, soft = (
        predict(m, "short", 0.03, 0.0).F_N
        for m in (truth, *(
            truth.with_effects(active("elongation_flexibility", relative_compliance=c))
            for c in (1e-9, 0.05)
        ))
    )  # fmt: skip
    assert firm == pytest.approx(stiff, rel=1e-6)
    assert abs(soft) < 0.95 * abs(stiff)


@pytest.mark.parametrize("location", ["compliance", "eibm"])
def test_an_unknown_that_goes_with_the_way_the_sheet_is_bent_acts_one_way(
    truth: SheetModel, location: str
):
    one_way = Profile(
        along="bending", at=(-100.0, 0.0, 100.0), values=(0.0, 0.0, 0.4), sigma=(0.0,) * 3, unit=""
    )
    model = truth.with_effects(unknown(location, one_way))
    for voltage_V, grows in ((2.0, True), (-2.0, False)):
        (_, x, y), (_, other_x, other_y) = (
            predict_free(m, "long", voltage_V) for m in (truth, model)
        )
        moved_m = float(np.max(np.hypot(other_x - x, other_y - y)))
        assert moved_m > 1e-4 if grows else moved_m < 1e-9


@pytest.mark.parametrize("voltage_V", [0.0, 2.0])
def test_an_elongation_that_bends_may_be_drawn_straight_in_the_picture(
    truth: SheetModel, voltage_V: float
):
    shown, drawn = (
        predict(
            truth.with_effects(
                active("elongation_flexibility", relative_compliance=0.03, in_the_joint=how)
            ),
            "short", 0.03, voltage_V,
        )
        for how in (0.0, 2.0)
    )  # fmt: skip
    assert drawn.F_N == shown.F_N
    sheet = drawn.s_m <= truth.sheet("short").sheet.free_length_m
    np.testing.assert_array_equal(drawn.y_m[sheet], shown.y_m[sheet])
    slopes = [np.arctan2(np.diff(one.y_m), np.diff(one.x_m)) for one in (shown, drawn)]
    beyond = ~sheet[:-1]
    bent, straight = (np.ptp(slope[beyond]) for slope in slopes)
    assert straight < 5e-3 * bent
    # it goes on from the sheet's end as the elongation does that is shown
    first = int(np.flatnonzero(beyond)[0])
    assert slopes[1][first] == pytest.approx(slopes[0][first], abs=0.05 * bent)


def test_what_the_load_cell_adds_is_seen_and_not_felt(truth: SheetModel):
    model = truth.with_effects(active("force_offset", force_mN=0.3))
    plain, seen = (predict(m, "long", POSITION_M, 2.0) for m in (truth, model))
    felt = predict(model, "long", POSITION_M, 2.0, as_seen=False)
    assert pytest.approx(plain.F_N + 0.3e-3, abs=1e-9) == seen.F_N
    assert pytest.approx(plain.F_N, abs=1e-9) == felt.F_N
    assert pytest.approx(plain.N_N, rel=1e-9) == seen.N_N


def test_a_load_cell_that_hangs_behind_brings_the_polarities_together(truth: SheetModel):
    model = truth.with_effects(active("load_cell_hysteresis", force_mN=0.1, from_no_load=0.0))
    gaps = [
        predict(m, "long", POSITION_M, 2.0).F_N - predict(m, "long", POSITION_M, -2.0).F_N
        for m in (truth, model)
    ]
    assert abs(gaps[0]) - abs(gaps[1]) == pytest.approx(0.2e-3, rel=0.01)


def test_what_the_camera_adds_is_seen_and_not_there(truth: SheetModel):
    model = truth.with_effects(active("camera_scale", relative_error=0.02))
    plain, seen = (predict(m, "long", POSITION_M, 2.0) for m in (truth, model))
    assert seen.x_m == pytest.approx(1.02 * plain.x_m, abs=1e-12)
    there = predict(model, "long", POSITION_M, 2.0, as_seen=False)
    assert there.x_m == pytest.approx(plain.x_m, abs=1e-12)


def test_an_eibm_that_has_not_arrived_is_smaller_in_the_mean(truth: SheetModel):
    tau = 0.2
    model = truth.with_effects(active("charging_lag", time_constant_s=tau, remembers=0.0))
    eibm = truth.sheet("long").eibm
    for voltage in (2.0, -2.0, 0.0):
        # it comes from the EIBM of the other polarity
        gone = float(eibm[-voltage].values[0] / eibm[voltage].values[0]) - 1.0 if voltage else 0.0
        smaller = with_eibm_times(truth, 1.0 + gone * np.exp(-0.5 / tau))
        lagging, same = (predict(m, "long", POSITION_M, voltage) for m in (model, smaller))
        assert pytest.approx(same.F_N, rel=1e-6) == lagging.F_N


def test_factors_on_the_form_change_the_effect_where_they_say(truth: SheetModel):
    whole = active("initial_curvature", curvature_error_per_m=4.0)
    none, twice = (truth.with_effects(replace(whole, profile=along(f, f))) for f in (0.0, 2.0))
    double = truth.with_effects(active("initial_curvature", curvature_error_per_m=8.0))
    force = [predict(m, "long", POSITION_M, 2.0).F_N for m in (truth, none, double, twice)]
    assert force[0] == pytest.approx(force[1], rel=1e-9)
    assert force[2] == pytest.approx(force[3], rel=1e-9)


def test_an_unknown_term_acts_at_its_slot(truth: SheetModel):
    less = with_eibm_times(truth, 0.9)
    eibm = truth.with_effects(unknown("eibm", along(-0.1, -0.1)))
    rest = truth.with_effects(unknown("rest_curvature", along(4.0, 4.0)))
    same = truth.with_effects(active("initial_curvature", curvature_error_per_m=4.0))
    cell = truth.with_effects(unknown("load_cell", along(0.2, 0.2, along="position")))
    for one, two in ((eibm, less), (rest, same)):
        forces = [predict(m, "long", POSITION_M, 2.0).F_N for m in (one, two)]
        assert forces[0] == pytest.approx(forces[1], rel=1e-9)
    assert (pytest.approx(0.2e-3, rel=1e-9)) == predict(cell, "long", 0.0, 0.0).F_N - predict(
        truth, "long", 0.0, 0.0
    ).F_N


@pytest.mark.parametrize(
    ("under", "added_mN"), [("", (0.2, 0.2, 0.2)), ("voltage", (0.0, 0.2, 0.2)),
                            ("polarity", (0.0, 0.2, -0.2))],
)  # fmt: skip
def test_an_unknown_force_acts_at_the_voltages_it_depends_on(
    truth: SheetModel, under: str, added_mN: tuple[float, ...]
):
    profile = replace(along(0.2, 0.2, along="position"), under=under)
    cell = truth.with_effects(unknown("load_cell", profile))
    for voltage, wanted in zip((0.0, 2.0, -2.0), added_mN, strict=True):
        forces = [predict(m, "long", POSITION_M, voltage).F_N for m in (cell, truth)]
        assert 1e3 * (forces[0] - forces[1]) == pytest.approx(wanted, abs=1e-9)


def test_an_unknown_force_may_be_a_function_of_the_force(truth: SheetModel):
    plain = predict(truth, "long", POSITION_M, 2.0).F_N
    profile = Profile(
        along="force", at=(0.0, 2.0 * plain), values=(0.0, 0.4), sigma=(0.0, 0.0), unit="mN"
    )
    bent = truth.with_effects(unknown("load_cell", profile))
    assert pytest.approx(plain + 0.2e-3) == predict(bent, "long", POSITION_M, 2.0).F_N


def test_an_unknown_force_in_the_course_of_time_is_in_no_single_prediction(truth: SheetModel):
    drift = truth.with_effects(unknown("load_cell", along(0.2, 0.2, along="time")))
    forces = [predict(m, "long", POSITION_M, 2.0).F_N for m in (drift, truth)]
    assert forces[0] == forces[1]


def test_an_unknown_change_of_the_eibm_may_go_with_the_position(truth: SheetModel):
    less = with_eibm_times(truth, 0.9)
    here = truth.with_effects(unknown("eibm", along(-0.1, -0.1, along="position")))
    forces = [predict(m, "long", POSITION_M, 2.0).F_N for m in (here, less)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)


def test_an_unknown_age_of_pictures_bends_shapes_but_not_forces(truth: SheetModel):
    late = truth.with_effects(unknown("camera", along(-0.1, -0.1, along="position")))
    # a tenth of half the way that the EIBM comes from the other polarity
    ratio = -truth.sheet("long").mean_eibm(-2.0) / truth.sheet("long").mean_eibm(2.0)
    less = with_eibm_times(truth, 1.0 - 0.1 * 0.5 * (1.0 + ratio))
    for voltage in (0.0, 2.0):
        seen, plain = (predict(m, "long", POSITION_M, voltage) for m in (late, truth))
        assert pytest.approx(plain.F_N, rel=1e-12) == seen.F_N
        other = predict(less, "long", POSITION_M, voltage)
        np.testing.assert_allclose(seen.y_m, other.y_m, atol=1e-9)
    assert not np.allclose(seen.y_m, plain.y_m, atol=1e-5)


def test_each_configuration_may_have_its_own_value(truth: SheetModel):
    effect = ActiveEffect(
        name="initial_curvature",
        by_configuration={
            "long": {"curvature_error_per_m": Parameter(value=4.0, sigma=0.1, unit="1/m")}
        },
    )
    model = truth.with_effects(effect)
    same = truth.with_effects(active("initial_curvature", curvature_error_per_m=4.0))
    long, known = (predict(m, "long", POSITION_M, 0.0).F_N for m in (model, same))
    assert long == pytest.approx(known, rel=1e-12)
    short, plain = (predict(m, "short", POSITION_M, 0.0).F_N for m in (model, truth))
    assert short == pytest.approx(plain, rel=1e-12)


def test_a_model_with_everything_in_it_survives_being_written_and_read(truth: SheetModel):
    effects = (
        replace(active("nonuniform_eibm", decay_length_mm=21.0), profile=along(1.1, 0.9, 1.0)),
        replace(unknown("eibm", along(0.1, -0.1)), configurations=("long",)),
        ActiveEffect(
            name="clamp_angle",
            by_configuration={
                "short": {"angle_rad": Parameter(value=0.01, sigma=0.001, unit="rad")}
            },
        ),
    )
    model = truth.with_effects(*effects)
    again = SheetModel.from_dict(json.loads(json.dumps(model.to_dict())))
    assert again.effects == effects
    forces = [predict(m, "long", POSITION_M, 2.0).F_N for m in (model, again)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-12)


def test_a_form_is_a_factor_on_what_the_effect_does_wherever_that_is(truth: SheetModel):
    offset = active("force_offset", force_mN=0.4)
    half = replace(along(0.5, 0.5, along="position"), under="polarity", configurations=("long",))
    for name, voltage, factor in (
        ("long", 2.0, 1.5), ("long", -2.0, 0.5), ("long", 0.0, 1.0), ("short", 2.0, 1.0),
    ):  # fmt: skip
        plain, formed = (
            predict(truth.with_effects(*effects), name, POSITION_M, voltage).F_N
            for effects in ((), (replace(offset, form=(half,)),))
        )
        assert 1e3 * (formed - plain) == pytest.approx(0.4 * factor, abs=1e-9)


def test_a_form_along_the_sheet_may_take_an_effect_away_or_double_it(truth: SheetModel):
    tapered = active("nonuniform_stiffness", relative_change=0.4)
    less, gone = (
        predict(truth.with_effects(*effects), "long", POSITION_M, 2.0)
        for effects in ((), (replace(tapered, form=(along(-1.0, -1.0),)),))
    )
    assert pytest.approx(less.F_N, rel=1e-9) == gone.F_N
    np.testing.assert_allclose(gone.y_m, less.y_m, atol=1e-12)
    more = replace(tapered, form=(along(0.2, 0.2), along(-0.2, -0.2)))
    same = [predict(truth.with_effects(e), "long", POSITION_M, 2.0).F_N for e in (tapered, more)]
    assert same[0] == pytest.approx(same[1], rel=1e-9)


def test_what_is_even_in_the_voltage_begins_with_a_mean_of_powers(truth: SheetModel):
    flat = replace(along(0.2, 0.2, along="position"), unit="mN", full_V=2.0)
    begun = {"voltage": (1.0, MEAN_POWER), "polarity": (1.0, 0.5), "": (1.0, 1.0)}
    for under, shares in begun.items():
        model = truth.with_effects(unknown("load_cell", replace(flat, under=under)))
        for voltage, share in zip((2.0, 1.0), shares, strict=True):
            forces = [predict(m, "long", POSITION_M, voltage).F_N for m in (model, truth)]
            assert 1e3 * (forces[0] - forces[1]) == pytest.approx(0.2 * share, abs=1e-9)


def test_an_even_share_rises_from_nothing_to_all_and_stays():
    term = replace(along(0.2, 0.2), under="voltage", full_V=2.0)
    volts = np.array([0.0, 1e-9, 0.5, 1.0, 1.999999, 2.0, 3.0])
    powers = np.linspace(1.0, 2.0, 2001)
    mean = [np.trapezoid(np.minimum(v / 2.0, 1.0) ** powers, powers) for v in volts]
    np.testing.assert_allclose(term.share(volts), mean, rtol=1e-6, atol=1e-12)
    np.testing.assert_array_equal(term.share(-volts), term.share(volts))


def test_an_even_moment_begins_with_a_mean_of_powers(truth: SheetModel):
    at_1_V = [
        predict(truth.with_effects(unknown("even_moment", term)), "long", POSITION_M, 1.0).F_N
        for term in (
            replace(along(0.1, 0.1), full_V=2.0),
            # without `full_V` it goes with the size of the EIBM, half as large there
            along(0.2 * MEAN_POWER, 0.2 * MEAN_POWER),
        )
    ]
    assert at_1_V[0] == pytest.approx(at_1_V[1], rel=1e-9)


def test_a_file_says_the_version_that_it_needs_and_the_older_one_is_read(truth: SheetModel):
    old = truth.with_effects(unknown("eibm", along(0.1, -0.1)))
    terms = (replace(along(0.1, -0.1), configurations=("long",)), along(0.2, along="configuration"))
    new = truth.with_effects(replace(active("clamp_angle", angle_rad=0.02), form=terms))
    camera = replace(active("camera_scale", relative_error=0.01), across_curve=True)
    across = truth.with_effects(camera)
    for model, version in ((truth, 1), (old, 1), (new, 2), (across, 2)):
        data = json.loads(json.dumps(model.to_dict()))
        assert data["labrig_model"] == version
        assert SheetModel.from_dict(data).effects == model.effects
    assert "form" not in old.to_dict()["effects"][0]
    with pytest.raises(ModelError, match="has format 3 and this labrig reads formats 1 and 2"):
        SheetModel.from_dict({**new.to_dict(), "labrig_model": 3})


def test_forces_over_positions_hold_the_effects_too(truth: SheetModel):
    model = truth.with_effects(active("nonuniform_eibm", decay_length_mm=15.0))
    found = force_map(model, "long", [0.0, POSITION_M], [-2.0, 0.0, 2.0])
    for j, voltage in enumerate((-2.0, 0.0, 2.0)):
        one = predict(model, "long", POSITION_M, voltage).F_N
        assert found.tangential_N[1, j] == pytest.approx(one, rel=1e-6)


@pytest.mark.parametrize(
    ("effect", "text"),
    [
        (active("nonuniform_eibm"), "lacks its decay_length_mm"),
        (active("camera_scale", relative_error=7.0), "must be within -0.5 and 0.5"),
    ],
)
def test_an_effect_that_makes_no_sense_is_refused_with_its_name(truth: SheetModel, effect, text):
    with pytest.raises(ModelError, match=text):
        predict(truth.with_effects(effect), "long", 0.0, 2.0)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"profile": {"along": "up"}}, "one of s, curvature, bending, position"),
        ({"profile": {"along": "s", "at": [0.0, 0.0], "value": [1, 1], "sigma": [0, 0]}}, "ascend"),
        ({"profile": {"along": "s", "at": [0.0], "value": [1, 1], "sigma": [0]}}, "equally long"),
        (
            {"form": [{"along": "fine_y", "at": [0.0], "value": [0.1], "sigma": [0.0]}]},
            r"form\[0\].at: the numbers of the 36 waves across the image are wanted, 0 to 35",
        ),
        (
            {"form": [{"along": "s", "at": [0.0], "value": [1.0], "sigma": [0.0], "full_V": -2.0}]},
            r"form\[0\].full_V: a voltage above 0 is wanted, or none",
        ),
        ({"by_configuration": 3}, "by_configuration: a table"),
        ({"configurations": [3]}, "a list of names"),
    ],
)
def test_a_broken_effect_in_a_model_file_is_refused_with_its_key(truth, change, text):
    data = json.loads(json.dumps(truth.with_effects(active("clamp_angle")).to_dict()))
    data["effects"][0].update(change)
    with pytest.raises(ModelError, match=text):
        SheetModel.from_dict(data)


def test_friction_that_only_the_load_cell_feels_is_in_the_predicted_force(truth: SheetModel):
    model = truth.with_effects(active("roll_friction", coefficient=0.1, force_alone=1.0))
    for voltage in (2.0, -2.0):
        one, two = (predict(m, "long", POSITION_M, voltage) for m in (model, truth))
        np.testing.assert_array_equal(one.x_m, two.x_m)
        lean = two.phi_hat_rad - POSITION_M / truth.sheet("long").sheet.arc_radius_m
        most = 0.1 * abs(two.N_N * np.sin(lean))
        assert 0.5 * most < abs(one.F_N - two.F_N) <= most * (1.0 + 1e-9)


@pytest.mark.parametrize(("along", "waves"), [("image_x", 10), ("fine_y", 36)])
def test_waves_across_the_image_are_read_as_a_diagnosis_writes_them(along, waves):
    """Their numbers are those of a division, which ends beside whole numbers."""
    made = sampled(np.cos, along, 0.0, waves - 1.0, nodes=waves, unit="mm")
    assert Profile.from_dict(made.to_dict(), "form[0]") == made


def test_a_late_image_shows_another_eibm_and_the_same_weight(truth: SheetModel):
    s_m, late = np.linspace(0.0, 0.05, 11), active("frame_delay", delay_s=0.45)
    slow = _rising(truth, truth.sheet("long").eibm)
    light, heavy = (
        slow.with_effects(late, *more) for more in ((), (active("gravity", load_N_per_m=0.02),))
    )
    changes = []
    for model in (light, heavy):
        setup = model.setup("long", POSITION_M, 2.0)
        changes.append(as_imaged(setup, model.effects, POSITION_M).eibm(s_m) - setup.eibm(s_m))
    assert np.max(np.abs(changes[0])) > 0.1 * abs(truth.sheet("long").mean_eibm(2.0))
    np.testing.assert_allclose(changes[1], changes[0], rtol=1e-9)


def test_a_late_image_shows_what_is_left_of_the_other_polarity(truth: SheetModel):
    """Twice the EIBM at -2 V leaves twice as much."""
    weak = truth.sheet("long").eibm[2.0]
    changes = []
    for factor in (-1.0, -2.0):
        eibm = {2.0: weak, -2.0: replace(weak, values=factor * weak.values)}
        model = _rising(truth, eibm).with_effects(active("frame_delay", delay_s=0.45))
        setup = model.setup("long", POSITION_M, 2.0)
        then = as_imaged(setup, model.effects, POSITION_M)
        changes.append((then.eibm(0.0) / setup.eibm(0.0)).item())
    left = np.exp(-0.05 / RISE_S)
    assert 1.0 - np.array(changes) == pytest.approx([2.0 * left, 3.0 * left], rel=0.02)


def _rising(truth: SheetModel, eibm: dict[float, Along]) -> SheetModel:
    one = truth.sheet("long")
    geometry = replace(one.sheet, rise_time_s=RISE_S)
    return replace(truth, sheets={"long": replace(one, sheet=geometry, eibm=eibm)})
