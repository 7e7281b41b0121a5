"""From measurements to a name, to 'nothing', to 'unknown'; and one sentence for what cannot be."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from model import Measurements, ModelError, SheetGeometry
from model.discrepancy import DiagnoseOptions, diagnose, next_measurement
from model.discrepancy.at_rest.varied import Step, Varied
from model.discrepancy.prepare import prepare, setups
from tests.cases import few
from tests.model.discrepancy.sessions import (
    FALLING,
    NOTHING,
    Case,
    Hiding,
    diagnosed,
    means_of,
    session,
    without_first_pulses,
)

pytestmark = pytest.mark.usefixtures("data_unchecked")
OTHER_FORM = Case((Hiding("nonuniform_eibm", "cosh"),), seed=4)
PAIR = Case((Hiding("gravity"), Hiding("eibm_drift")), seed=3)
OUTSIDE = Case((Hiding("local_eibm"),), seed=5)
BADLY_SET = Case((Hiding("nonuniform_eibm"),), seed=6, outlier=True)
TILTED = Case((Hiding("clamp_angle", size=0.008),), seed=7)
DRYING = Case((Hiding("stiffness_drift", "exp", 0.4),), seed=8)
SOFT_END = Case((Hiding("nonuniform_stiffness", "line", -0.7),), seed=31)
FIRST = Case((Hiding("first_pulse_transient", "hyperbolic", 0.01),), seed=3)
LATE = Case((Hiding("frame_delay", "late"),), seed=5)
LAG = Case((Hiding("charging_lag"),), seed=12)
STRONG_AND_WEAK = Case((Hiding("nonuniform_eibm"), Hiding("charging_lag", size=0.02)), seed=9)
WITHOUT_DELAY = DiagnoseOptions(exclude=("frame_delay",))
KEYS = {"verdict", "effects", "invisible", "unknown", "where", "gap", "next_measurement",
        "sentence", "notes", "data_checks", "gap_closed", "noise_floor", "promises",
        "checks", "detection_limits", "not_ruled_out", "model_effects",
        "reported_set"}  # fmt: skip
NAMED_KEYS = {"name", "title", "slot", "parameters", "interval90", "by_configuration",
              "confidence", "confusable_with", "or_else", "form_share", "parameters_of",
              "probabilities"}  # fmt: skip
UNKNOWN_KEYS = {"slot", "slots", "s_mm", "profile", "band", "unit", "along", "configuration",
                "depends", "confusable_with", "probabilities", "at_unit", "under",
                "advice"}  # fmt: skip


def names(found) -> list[str]:
    return [e.name for e in found.effects]


# ---------------------------------------------------------------------------- findings


@pytest.mark.slow
@pytest.mark.parametrize("calibrate", [0, 2])
def test_the_progress_is_a_share_and_a_text_as_everywhere(calibrate: int):
    told: list[tuple[float, str]] = []
    options = DiagnoseOptions(calibrate=calibrate)
    diagnose(session(NOTHING), options, lambda share, text: told.append((share, text)))
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert told[0] == (0.0, "checking the data")
    assert told[-1] == (1.0, "done")


@pytest.mark.slow
def test_where_nothing_is_hidden_nothing_is_found():
    found = diagnosed(NOTHING)
    assert (found.verdict, names(found), found.unknown) == ("nothing_missing", [], None)
    assert np.isnan(found.closed)
    assert found.fitted.before == found.fitted.after
    assert 0.7 < found.fitted.after.chi2_per_dof < 1.3
    assert found.model.effects == ()
    assert found.outliers == ()
    assert len(found.rows) == 42
    B = found.model.sheets["long"].B
    assert abs(B.value - 1.27e-6) < 4.0 * B.sigma


@pytest.mark.thorough
def test_a_falling_eibm_is_named_also_in_another_form():
    found = diagnosed(OTHER_FORM)
    assert (found.verdict, names(found)) == ("effect_named", ["nonuniform_eibm"])
    one = found.effects[0]
    assert one.confidence > 0.9
    assert one.form is not None
    assert np.all(one.form.band >= 0.0)
    assert found.closed > 0.9
    assert found.held_out.after.force_rmse_mN < 0.2 * found.held_out.before.force_rmse_mN
    assert found.where
    assert [e.name for e in found.model.effects] == ["nonuniform_eibm"]
    best = next(r for r in found.ranking if not r.name.startswith("unknown"))
    assert best.name == "nonuniform_eibm"


@pytest.mark.thorough
def test_so_strong_an_effect_is_named_that_a_straight_line_leads_beyond_its_bounds():
    found = diagnosed(SOFT_END)
    assert (found.verdict, names(found)) == ("effect_named", ["nonuniform_stiffness"])
    assert found.effects[0].parameters["relative_change"].value == pytest.approx(-0.7, abs=0.01)
    assert found.closed > 0.98


@pytest.mark.slow
@pytest.mark.thorough  # the demo names first pulses
def test_the_discarded_pulses_tell_first_pulses_from_drifts():
    """Without them a first pulse that falls short is something that goes on along the run."""
    found = diagnosed(FIRST)
    assert (found.verdict, names(found)) == ("effect_named", ["first_pulse_transient"])
    assert found.effects[0].confidence > 0.95
    less = diagnose(without_first_pulses(session(FIRST)))
    told_apart = less.effects[0].name == "first_pulse_transient"
    # the confidence is that of the class
    assert not told_apart or less.effects[0].probability < 0.9
    before, after = found.held_out.before, found.held_out.after
    assert after.drift_rmse_mm < 0.5 * before.drift_rmse_mm
    assert found.closed > 0.9
    assert "along a run 0." in found.sentence


@pytest.mark.thorough
def test_late_pictures_that_differ_from_run_to_run_are_named():
    """How late just this run's are, the others cannot say: that does not speak against them."""
    found = diagnosed(LATE)
    assert (found.verdict, names(found)) == ("effect_named", ["frame_delay"])
    assert found.effects[0].confidence > 0.95
    assert found.closed > 0.7


@pytest.mark.thorough
def test_late_pictures_that_no_catalogue_has_are_a_matter_of_the_camera():
    found = diagnosed(LATE, WITHOUT_DELAY)
    assert (found.verdict, names(found)) == ("unknown_effect", [])
    assert (found.unknown.location, found.unknown.along) == ("camera", "position")
    assert found.unknown.unit == "relative"
    assert np.all(found.unknown.profile < 0.0)  # pictures show less EIBM than the forces


@pytest.mark.slow
@pytest.mark.thorough  # the demo names a lag
def test_a_lag_leaves_no_gap_in_the_means_but_one_within_the_pulses_that_is_closed():
    found = diagnosed(LAG)
    assert names(found) == ["charging_lag"]
    before, after = found.held_out.before, found.held_out.after
    assert after.pulse_rmse_mN < 0.3 * before.pulse_rmse_mN
    assert found.closed > 0.9
    assert "of force within a pulse (" in found.sentence


@pytest.mark.slow
@pytest.mark.thorough  # in the demo three are named beside each other, each with its own values
def test_two_effects_are_both_named_each_with_its_own_values():
    found = diagnosed(PAIR)
    assert sorted(names(found)) == ["eibm_drift", "gravity"]
    parameters = {e.name: set(e.parameters) for e in found.effects}
    assert parameters["gravity"] == {"load_N_per_m"}
    assert "relative_change" in parameters["eibm_drift"]


@pytest.mark.slow
@pytest.mark.thorough  # late images and periodic terms are unknown in other tests
def test_what_no_catalogue_has_is_unknown_with_its_slot_and_place():
    found = diagnosed(OUTSIDE)
    assert found.verdict == "unknown_effect"
    assert found.unknown is not None
    assert found.unknown.location == "eibm"
    assert found.unknown.configuration == "long"
    assert 22.0 - 10.0 <= found.unknown.peak_mm <= 38.0 + 10.0
    assert len(found.unknown.s_mm) == len(found.unknown.profile) == len(found.unknown.band)
    assert [e.name for e in found.model.effects][-1] == "unknown"
    assert "something that is not in the catalogue" in found.sentence


@pytest.mark.slow
@pytest.mark.thorough
def test_an_effect_taken_from_the_catalogue_is_never_replaced_with_confidence():
    found = diagnosed(FALLING, DiagnoseOptions(exclude=("nonuniform_eibm",), most_effects=1))
    assert "nonuniform_eibm" not in {*names(found), *(r.name for r in found.ranking)}
    sure = [e for e in found.effects if e.confidence > 0.95 and not e.confusable_with]
    assert found.verdict == "unknown_effect" or not sure
    assert found.verdict != "nothing_missing"


@pytest.mark.thorough
def test_what_is_alike_in_every_set_up_does_not_hide_in_their_scatter():
    """A tilt of the clamp would make each set-up tilted, if nobody asked why always to one side."""
    found = diagnosed(TILTED, DiagnoseOptions(exclude=("clamp_angle",)))
    assert found.verdict == "unknown_effect"
    assert found.unknown is not None
    assert found.unknown.location == "rest_curvature"
    assert found.unknown.peak_mm < 5.0


@pytest.mark.thorough
def test_what_is_left_of_a_large_effect_s_form_is_no_second_effect():
    found = diagnosed(DRYING)
    assert (found.verdict, names(found)) == ("effect_named", ["stiffness_drift"])
    assert found.closed > 0.95


@pytest.mark.slow
@pytest.mark.thorough
def test_a_weak_effect_in_other_rows_is_named_beside_a_strong_one():
    found = diagnosed(STRONG_AND_WEAK)
    assert sorted(names(found)) == ["charging_lag", "nonuniform_eibm"]


@pytest.mark.thorough
def test_a_run_set_up_badly_is_left_out_beside_an_effect():
    found = diagnosed(BADLY_SET)
    assert names(found) == ["nonuniform_eibm"]
    assert len(found.outliers) == 3
    assert len({name.rsplit(",", 1)[0] for name in found.outliers}) == 1
    assert found.closed > 0.9
    assert any(note.startswith("outliers, left out: ") for note in found.notes)
    assert "left out, as nothing explains" in found.sentence


@pytest.mark.slow
@pytest.mark.thorough  # as by the commands, in tests/labrig/diagnose/test_diagnose_end_to_end.py
def test_a_model_that_has_the_effect_already_is_missing_nothing_more():
    first = diagnosed(FALLING)
    again = diagnose(session(FALLING), DiagnoseOptions(model=first.model))
    assert (again.verdict, names(again)) == ("nothing_missing", [])
    assert [e.name for e in again.model.effects] == ["nonuniform_eibm"]
    one, two = (m.effects[0].parameters["decay_length_mm"] for m in (first.model, again.model))
    assert two.value == pytest.approx(one.value, rel=0.05)


@pytest.mark.slow
@pytest.mark.thorough
def test_what_a_model_lacks_beside_what_it_has_is_named_with_its_own_values():
    """Findings are not mistaken for what the model had before."""
    given = diagnosed(PAIR).model
    alone = replace(given, effects=tuple(e for e in given.effects if e.name == "eibm_drift"))
    found = diagnose(session(PAIR), DiagnoseOptions(model=alone))
    assert names(found) == ["gravity"]
    assert set(found.effects[0].parameters) == {"load_N_per_m"}
    assert sorted(e.name for e in found.model.effects) == ["eibm_drift", "gravity"]
    assert found.closed > 0.5


def test_a_position_to_hold_out_may_be_rounded():
    whole, less = (prepare(session(), DiagnoseOptions(hold_out=h)) for h in ((), (("", 0.015004),)))
    assert setups(less) < setups(whole)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_position_held_out_is_neither_fitted_nor_told():
    found = diagnose(session(FALLING), DiagnoseOptions(hold_out=(("", 0.015),)))
    assert names(found) == ["nonuniform_eibm"]
    assert len(found.rows) == 36
    assert all(row.position_m != 0.015 for row in found.rows)
    assert found.model.held_out == ("all, 15 mm",)


@pytest.mark.thorough
def test_the_same_data_give_the_same_answer_and_the_threshold_may_be_simulated():
    found = diagnose(session(NOTHING), DiagnoseOptions(calibrate=5))
    assert found.threshold_from == "5 simulated sessions of the base model"
    assert found.verdict == "nothing_missing"
    a, b = diagnose(session(NOTHING)), diagnosed(NOTHING)
    assert json.dumps(a.to_json()) == json.dumps(b.to_json())


# -------------------------------------------------------------------------------- JSON


@pytest.mark.slow
@pytest.mark.parametrize(
    "of",
    [(NOTHING,), (FALLING,), pytest.param((LATE, WITHOUT_DELAY), marks=pytest.mark.thorough)],
    ids=["nothing_missing", "effect_named", "unknown_effect"],
)
def test_json_has_these_keys_and_nothing_that_is_no_number(request, of):
    """Of what is unknown: tests/model/discrepancy/test_verdict_checks.py."""
    told = json.loads(json.dumps(diagnosed(*of).to_json(), allow_nan=False))
    assert told["verdict"] in request.node.name
    assert set(told) == KEYS
    assert all(set(e) == NAMED_KEYS for e in told["effects"])
    assert told["unknown"] is None or set(told["unknown"]) == UNKNOWN_KEYS
    for w in told["where"]:
        assert set(w) - {"detail"} == {
            "observable", "configuration", "voltage_V", "position_mm", "s_mm", "z"
        }  # fmt: skip
    assert set(told["gap"]) == {"fitted", "held_out"}
    for part in told["gap"].values():
        assert set(part) == {"before", "after"}
        in_time = {"drift_rmse_mN", "drift_rmse_mm", "pulse_rmse_mN"}
        assert set(part["after"]) == {"force_rmse_mN", "curve_rmse_mm", "chi2_per_dof"} | in_time
    assert told["next_measurement"] is None or set(told["next_measurement"]) == {
        "why", "protocol", "between", "separation_now", "separation_expected", "minutes"
    }  # fmt: skip


# ----------------------------------------------------------------- what data do not allow


def kept(m, condition):
    return replace(m, conditions=tuple(c for c in m.conditions if condition(c)))


@pytest.mark.slow
@pytest.mark.thorough
def test_a_clamp_far_askew_is_something_unknown_where_the_catalogue_lacks_it():
    """It acts alike in every set-up, and must not pass for their scatter."""
    askew = Case((Hiding("clamp_angle", size=0.07),), seed=12)
    found = diagnosed(askew, DiagnoseOptions(exclude=("clamp_angle",)))
    assert (found.verdict, names(found)) == ("unknown_effect", [])
    assert found.unknown.location == "rest_curvature"


@pytest.mark.thorough
def test_samples_that_were_all_stamped_late_are_no_lag_of_the_sheet():
    m = session()
    late = [replace(s, time_s=s.time_s - 0.5 * np.median(np.diff(s.time_s))) for s in m.series]
    assert names(diagnose(replace(m, series=tuple(late)))) == []


@pytest.mark.slow
def test_a_zero_that_differs_between_set_ups_as_no_rig_s_does_is_something_unknown():
    m, random = session(), np.random.default_rng(1)
    zero = {
        key: 4e-4 * random.standard_normal() for key in dict.fromkeys(map(_place, m.conditions))
    }
    moved = [
        replace(
            c, readings=tuple(replace(r, force_N=r.force_N + zero[_place(c)]) for r in c.readings)
        )
        for c in m.conditions
    ]
    found = diagnose(replace(m, conditions=tuple(moved)))
    assert (found.verdict, names(found)) == ("unknown_effect", [])
    assert found.unknown is not None
    assert (found.unknown.location, found.unknown.unit) == ("load_cell", "mN")
    assert np.max(np.abs(found.unknown.profile)) > 0.4
    assert "of its own in each set-up" in found.sentence


def shifted(m: Measurements, off_m) -> Measurements:
    """The same with the curves of each set-up elsewhere in the picture, by `off_m` of it."""

    def moved(curve, by):
        return (
            None if curve is None else replace(curve, x_m=curve.x_m + by[0], y_m=curve.y_m + by[1])
        )

    conditions = [
        replace(
            c,
            curve=moved(c.curve, off_m[_place(c)]),
            readings=tuple(replace(r, curve=moved(r.curve, off_m[_place(c)])) for r in c.readings),
        )
        for c in m.conditions
    ]
    return replace(m, conditions=tuple(conditions))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("off_m", "why"),
    [
        pytest.param(
            lambda places, random: 4e-4 * random.standard_normal((len(places), 2)),
            "repeat three positions", id="anywhere",
        ),
        pytest.param(  # 0.06 mm: what chance may do, were it not one knock amid the session
            lambda places, _: [(0.0, 6e-5 if at > 0.012 else -6e-5) for _, at in places],
            "that is no chance", id="knocked once",
        ),
    ],
)  # fmt: skip
def test_pictures_that_lie_elsewhere_in_each_set_up_allow_no_verdict(off_m, why: str):
    m = session()
    places = list(dict.fromkeys(_place(c) for c in m.conditions))
    off = dict(zip(places, off_m(places, np.random.default_rng(2)), strict=True))
    found = diagnose(shifted(m, off))
    assert (found.verdict, names(found)) == ("cannot_tell", [])
    assert "the place in the picture differs from set-up to set-up" in found.sentence
    assert why in found.sentence


@pytest.mark.slow
@pytest.mark.parametrize(("every", "verdict"), [(12, "cannot_tell"), (120, "nothing_missing")])
def test_readings_that_are_left_out_too_often_allow_no_verdict(every: int, verdict: str):
    m, number, conditions = session(), 0, []
    for c in m.conditions:
        readings = []
        for r in c.readings:
            number += 1
            readings.append(r if number % every else replace(r, force_N=0.0, curve=None))
        conditions.append(replace(c, readings=tuple(readings)))
    found = diagnose(replace(m, conditions=tuple(conditions)))
    assert (found.verdict, names(found)) == (verdict, [])
    assert ("something acts on single readings" in found.sentence) == (verdict == "cannot_tell")


def _place(c) -> tuple:
    return c.configuration, c.position_m


@pytest.mark.slow
def test_few_set_ups_name_nothing_and_say_why():
    few = means_of(kept(session(), lambda c: c.configuration == "long" and c.position_m < 0.012))
    found = diagnose(few)
    assert found.verdict == "cannot_tell"
    assert "3 set-ups of the load cell, too few" in found.sentence
    assert (names(found), found.unknown, found.threshold) == ([], None, np.inf)


@pytest.mark.thorough
@pytest.mark.slow
def test_one_position_is_few_set_ups_too():
    found = diagnose(means_of(kept(session(), lambda c: c.position_m == 0.01)))
    assert found.verdict == "cannot_tell"
    assert "2 set-ups" in found.sentence


def test_zero_volts_alone_are_refused():
    with pytest.raises(ModelError, match="measured at 0 V alone: that fixes B, but says nothing"):
        prepare(kept(session(), lambda c: c.voltage_V == 0.0), DiagnoseOptions())


def test_readings_under_voltage_that_do_not_count_are_not_called_unmeasured():
    def spoilt(c):
        off = [replace(r, valid=False, why="the drive reads back 0.2 V") for r in c.readings]
        return c if c.voltage_V == 0.0 else replace(c, readings=tuple(off))

    found = session()
    spoilt_all = replace(found, conditions=tuple(map(spoilt, found.conditions)))
    with pytest.raises(ModelError, match=r"under voltage counts .*reads back 0\.2 V"):
        prepare(spoilt_all, DiagnoseOptions())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("condition", "said"),
    few(
        [
            (lambda c: c.voltage_V >= 0.0, "was driven at one voltage"),
            (lambda c: c.voltage_V != 0.0, "was not measured at 0 V"),
        ]
    ),
)
def test_what_voltages_do_not_allow_is_said(condition, said: str):
    notes = prepare(kept(session(), condition), DiagnoseOptions()).notes
    assert any(said in note for note in notes), notes


@pytest.mark.slow
def test_data_without_curves_or_without_times_can_be_searched_and_say_what_they_lack():
    bare = means_of(session())
    forces = replace(bare, conditions=tuple(replace(c, curve=None) for c in bare.conditions))
    ready = prepare(forces, DiagnoseOptions())
    assert setups(ready) == 14
    assert any("has no curves" in note for note in ready.notes)
    single = replace(
        bare, conditions=tuple(replace(c, readings=c.readings[-1:]) for c in bare.conditions)
    )
    notes = prepare(single, DiagnoseOptions()).notes
    assert any("has no two readings of a condition in their order" in note for note in notes)


@pytest.mark.slow
def test_identical_repeats_are_noted():
    m = means_of(session())
    same = tuple(
        replace(c, readings=tuple(replace(r, force_N=c.readings[-1].force_N) for r in c.readings))
        for c in m.conditions
    )
    notes = prepare(replace(m, conditions=same), DiagnoseOptions()).notes
    assert any("are identical: they are taken as one reading each" in note for note in notes)


def test_nothing_valid_is_refused_with_the_reason():
    m = session()
    broken = tuple(
        replace(c, readings=tuple(replace(r, valid=False, why="overload") for r in c.readings))
        for c in m.conditions
    )
    with pytest.raises(ModelError, match=r"no valid readings at all \(overload\)"):
        prepare(replace(m, conditions=broken), DiagnoseOptions())


def test_no_conditions_are_refused():
    with pytest.raises(ModelError, match="there are no measurements"):
        prepare(replace(session(), conditions=()), DiagnoseOptions())


@pytest.mark.slow
@pytest.mark.parametrize("value", few([np.nan, np.inf]))
def test_a_number_that_is_not_finite_costs_its_sheet_and_is_told_with_its_place(value: float):
    m = session()
    c = m.conditions[1]
    bad = replace(c, readings=(*c.readings[:-1], replace(c.readings[-1], force_N=value)))
    odd = replace(m, conditions=(m.conditions[0], bad, *m.conditions[2:]))
    said = "a force of condition long, 0 mm, +2 V is not a finite number; mark it invalid"
    ready = prepare(odd, DiagnoseOptions())
    assert f"left out: {said}" in ready.notes
    assert ready.problem.forward.names == ["short"]
    with pytest.raises(ModelError) as refused:  # where no other sheet is left
        prepare(kept(odd, lambda c: c.configuration == "long"), DiagnoseOptions())
    assert str(refused.value) == said


@pytest.mark.slow
def test_a_sheet_that_was_not_measured_is_left_out():
    ready = prepare(kept(session(), lambda c: c.configuration == "short"), DiagnoseOptions())
    assert ready.problem.forward.names == ["short"]


@pytest.mark.slow
def test_a_sheet_that_cannot_be_used_is_left_out_with_a_note():
    m = session()
    broken = tuple(
        replace(c, readings=tuple(replace(r, valid=False, why="dry") for r in c.readings))
        if c.configuration == "short" else c for c in m.conditions
    )  # fmt: skip
    ready = prepare(replace(m, conditions=broken), DiagnoseOptions())
    assert ready.problem.forward.names == ["long"]
    assert any(n.startswith("left out: ") and "'short'" in n for n in ready.notes)


@pytest.mark.slow
def test_dynamics_of_a_sheet_that_is_left_out_change_nothing():
    m = kept(session(), lambda c: c.configuration == "long")
    of_short = Varied(Step(configuration="short", of="unsure"), m)
    ready = prepare(m, DiagnoseOptions(), (of_short,))
    assert ready.problem.bases.size == prepare(m, DiagnoseOptions()).problem.bases.size


@pytest.mark.slow
@pytest.mark.parametrize(
    ("measured", "said"),
    [
        ({"free_length_m": 0.045}, "a free length of 50 mm, these data are of one with 45 mm"),
        ({"width_m": 0.005}, "a width of 11 mm, these data are of one with 5 mm"),
        ({"thickness_m": 0.4e-3}, "a thickness of 0.21 mm, these data are of one with 0.4 mm"),
    ],
)
def test_a_model_of_another_sheet_is_refused(truth, measured, said):
    m = session()
    other: SheetGeometry = replace(m.sheets["long"], **measured)
    unlike = replace(m, sheets={**m.sheets, "long": other})
    with pytest.raises(ModelError, match=said):
        prepare(unlike, DiagnoseOptions(model=truth))


@pytest.mark.parametrize("first", [(), (("long", 0.015),)])
def test_a_position_that_was_not_measured_cannot_be_held_out(first):
    with pytest.raises(ModelError, match=r"at the position to be held out \(long, 12 mm\)"):
        prepare(session(), DiagnoseOptions(hold_out=(*first, ("long", 0.012))))


@pytest.mark.thorough
@pytest.mark.slow
def test_an_effect_that_does_not_exist_cannot_be_excluded():
    with pytest.raises(ModelError, match="there is no effect called 'gravitty'"):
        diagnose(session(), DiagnoseOptions(exclude=("gravitty",)))


# ------------------------------------------------------------------- what to measure next


@pytest.mark.slow
def test_what_tells_two_effects_apart_is_on_the_menu():
    found = next_measurement(means_of(session()), ("gravity", "clamp_angle"))
    assert found.expected > found.separation
    assert found.minutes > 0.0
    assert set(found.protocol) == {"extras"}
    assert found.between == ("gravity", "clamp_angle")
    assert found.why.endswith(", to separate gravity from clamp angle")


@pytest.mark.parametrize(
    "names", [("gravity",), ("gravity", "gravity"), ("gravity", "clamp_angle", "force_offset")]
)
def test_two_effects_can_be_told_apart_and_neither_one_nor_three(names):
    with pytest.raises(ModelError, match="name two effects to be told apart"):
        next_measurement(means_of(session()), names)
