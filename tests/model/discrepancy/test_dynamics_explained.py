"""One physics, once: what a model's dynamics explain is named by nobody, what they leave is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks._moving_dynamics import MOST_M, session, true_model
from model import Parameter, SheetModel
from model.discrepancy import DiagnoseOptions, Diagnosis, diagnose
from model.discrepancy.at_rest.at_rest import at_rest
from model.discrepancy.at_rest.excess import Scale
from model.discrepancy.at_rest.runs import planned_drive, recorded_drive
from model.dynamics import HeldVoltage
from model.effects import catalogue
from model.measurements import Measurements, ModelError, TimeSeries
from model.sheet.beam_problem import ActiveEffect

SPREADING = (("resistive_faces", 4000.0),)
CREEPING = (*SPREADING, ("slow_gel", 0.2))
SEED = 7


def diagnosed(
    hidden: tuple[tuple[str, float], ...],
    seed: int = SEED,
    *,
    dynamics: bool = True,
    **more: object,
) -> Diagnosis:
    data = session(SEED, hidden, **more)  # type: ignore[arg-type]
    model = true_model(SEED, dict(hidden), data.sheets["long"])
    return diagnose(data, DiagnoseOptions(model=model if dynamics else None))


def names(found: Diagnosis) -> set[str]:
    return {one.name for one in found.effects}


@pytest.fixture(scope="module")
def spreading() -> tuple[Measurements, SheetModel]:
    data = session(SEED, SPREADING)
    return data, true_model(SEED, dict(SPREADING), data.sheets["long"])


@pytest.fixture(scope="module")
def rested(spreading) -> Measurements:
    """What is left of it when its dynamics are taken off."""
    return at_rest(*spreading).measurements


# ---------------------------------------------------------------- what is taken off


@pytest.mark.thorough
@pytest.mark.slow
def test_at_0_V_and_at_rest_nothing_is_taken_off(spreading, rested):
    data, _ = spreading
    for before, after in zip(data.conditions, rested.conditions, strict=True):
        if before.voltage_V == 0.0:
            off = np.hypot(after.curve.x_m - before.curve.x_m, after.curve.y_m - before.curve.y_m)
            assert np.max(off) < 1e-6
            # the filter of the last one ends where the first pulse begins
            for a, b in zip(before.readings[:-1], after.readings[:-1], strict=True):
                assert b.force_N == pytest.approx(a.force_N, abs=1e-7)


@pytest.mark.thorough
def test_what_a_lumped_quick_line_says_at_the_sampling_point_is_the_static_model():
    """Charged at once and evenly, half a second is long; held sheets are at rest by then."""
    data = session(SEED, ())
    model = true_model(SEED, {}, data.sheets["long"])
    found = at_rest(data, model)
    assert found.dynamics["long"].force_N < 5e-6
    assert found.dynamics["long"].curve_m < 3e-5
    assert found.dynamics["long"].free_m > 1e-3


@pytest.mark.slow
def test_without_the_dynamics_forces_and_curves_are_those_of_one_stiffness_and_eibm(
    spreading, rested
):
    from model.discrepancy.data_checks.quick_fit import Tolerances, bare, quick_fit

    data, model = spreading
    raw, still = (quick_fit(bare(each), Tolerances.of(bare(each))) for each in (data, rested))
    assert raw.curve_rms_m > 5e-4
    assert still.curve_rms_m < 5e-5
    assert still.force_rms_N < 2.5e-5
    B = float(np.exp(still.theta[still.bases.parts[0].stiffness]))
    assert pytest.approx(model.sheets["long"].B.value, rel=0.02) == B


@pytest.mark.thorough
def test_a_curve_is_compared_at_the_instant_of_its_own_frame(spreading):
    data, model = spreading
    late = replace(
        data,
        conditions=tuple(
            replace(c, readings=tuple(replace(r, frame_s=r.time_s + 0.02) for r in c.readings))
            for c in data.conditions
        ),
    )
    one, other = (at_rest(each, model).measurements for each in (data, late))
    free = [i for i, c in enumerate(data.conditions) if c.position_m is None and c.voltage_V > 0]
    a, b = (each.conditions[free[0]].curve for each in (one, other))
    assert float(np.hypot(a.x_m[-1] - b.x_m[-1], a.y_m[-1] - b.y_m[-1])) > 1e-4
    held = next(i for i, c in enumerate(data.conditions) if c.position_m is not None)
    pair = [each.conditions[held].readings[0].force_N for each in (one, other)]
    assert pair[0] == pytest.approx(pair[1], abs=1e-9)


@pytest.mark.slow
def test_the_drive_is_the_recorded_one_or_that_which_the_readings_tell(spreading):
    data, _ = spreading
    recorded = recorded_drive(data.series[0])
    own = [c for c in data.conditions if c.position_m == data.series[0].position_m]
    told = planned_drive(own)
    assert recorded.voltage_V == pytest.approx(told.voltage_V)
    assert recorded.time_s[1:] == pytest.approx(told.time_s[1:], abs=1e-9)


def test_another_eibm_is_another_moment_per_volt_and_leaves_the_charge_as_it_is():
    """A pulse leaves charge to the next one, of the other polarity, which must not grow with it."""
    drive = HeldVoltage(np.array([0.0, 0.6, 1.2]), np.array([0.0, 2.0, -2.0]))
    one = Scale(stiffness=1.0, eibm={2.0: 1.1, -2.0: 0.9})
    assert (one.moment(1.0), one.moment(-1.0)) == pytest.approx((1.1, 0.9))
    assert one.driven(drive).voltage_V == pytest.approx(drive.voltage_V)
    several = Scale(stiffness=1.0, eibm={1.0: 1.0, 2.0: 1.2})
    assert several.moment(1.0) == pytest.approx(1.1)
    assert several.driven(drive).voltage_V[1] == pytest.approx(2.0 * 1.2 / 1.1)


def test_pulses_of_which_nothing_was_kept_are_driven_all_the_same(spreading):
    data, _ = spreading
    own = [c for c in data.conditions if c.position_m == 0.01]
    kept = [replace(c, readings=tuple(r for r in c.readings if r.kind != "discarded")) for c in own]
    times = np.arange(0.3, 8.0, 0.1)
    assert np.array_equal(planned_drive(kept).at(times), planned_drive(own).at(times))


def test_a_sample_across_an_edge_tells_when_it_was():
    time = np.arange(100) * 0.01
    volts = np.where(np.arange(100) < 50, 0.0, 2.0) + 1e-3 * np.sin(np.arange(100))
    volts[50] = 0.5
    series = TimeSeries(
        configuration="long", position_m=None, time_s=time, drive_V=volts, force_N=None
    )
    drive = recorded_drive(series)
    assert drive.voltage_V == pytest.approx([0.0, 2.0], abs=2e-3)
    assert drive.time_s == pytest.approx([-0.005, 0.495 + 0.0075], abs=2e-5)


# ---------------------------------------------------------------- who says it


def lag(beside: tuple[str, ...] = ()) -> ActiveEffect:
    time = Parameter(value=0.1, sigma=0.01, unit="s")
    return ActiveEffect(
        name="charging_lag", parameters={"time_constant_s": time}, beside_dynamics=beside
    )


def test_an_effect_that_says_again_what_the_dynamics_say_is_refused(spreading):
    data, model = spreading
    with pytest.raises(ModelError, match="'charging_lag' and a table 'dynamic' of 'long'"):
        diagnose(data, DiagnoseOptions(model=model.with_effects(lag())))
    lost = replace(model.with_effects(lag(("long",))), dynamic={})
    with pytest.raises(ModelError, match="found beside dynamics of 'long', which it lacks"):
        diagnose(data, DiagnoseOptions(model=lost))


def test_at_rest_and_in_time_a_model_counts_each_physics_once(spreading):
    """The static prediction knows no dynamics, and the motion no effects."""
    _, model = spreading
    both = model.with_effects(lag())
    alone = replace(both, dynamic={})
    assert both.predict("long", 0.01, 2.0).F_N == alone.predict("long", 0.01, 2.0).F_N
    moving, plain = both.moving("long", 0.01), model.moving("long", 0.01)
    assert moving[0].moment_per_volt_Nm == plain[0].moment_per_volt_Nm
    assert moving[0].electrodes == plain[0].electrodes


def test_a_deviation_is_marked_in_the_model_file():
    one = lag(("long",))
    again = ActiveEffect.from_dict(one.to_dict(), "effects[0]")
    assert again.beside_dynamics == ("long",)
    assert "beside_dynamics" not in lag().to_dict()
    with pytest.raises(ModelError, match="beside_dynamics: a list of names"):
        ActiveEffect.from_dict({**one.to_dict(), "beside_dynamics": "long"}, "effects[0]")


def test_five_effects_are_explained_by_dynamics():
    explained = {name for name, one in catalogue().items() if one.explained_by_dynamics}
    assert explained == {
        "charging_lag", "nonuniform_eibm", "viscoelastic_creep", "back_relaxation", "frame_delay"
    }  # fmt: skip


@pytest.mark.thorough
def test_without_dynamics_the_charge_that_spreads_has_names_of_effects():
    assert "nonuniform_eibm" in names(diagnosed(SPREADING, dynamics=False))


@pytest.mark.slow
def test_with_dynamics_the_charge_that_spreads_has_no_name():
    found = diagnosed(SPREADING)
    assert found.verdict == "nothing_missing"
    assert "The base model has the dynamics of 'long'." in found.sentence
    told = found.to_json()["dynamics"]
    assert told["deviations"] == []
    assert told["explain"]["long"]["curve_end_rms_mm"] > 1.0
    model = found.model
    assert model.dynamic["long"].moment_per_volt_Nm[0].value == pytest.approx(
        true_model(SEED, dict(SPREADING), session(SEED, SPREADING).sheets["long"])
        .dynamic["long"].moment_per_volt_Nm[0].value, rel=0.03,
    )  # fmt: skip
    assert model.sheets["long"].sheet.rise_time_s == pytest.approx(0.04)


@pytest.mark.thorough
def test_with_dynamics_creep_and_charge_together_have_no_name():
    assert diagnosed(CREEPING).verdict == "nothing_missing"


@pytest.mark.thorough
def test_dynamics_of_another_day_are_scaled_to_the_eibm_of_this_one():
    data = session(SEED, SPREADING)
    model = true_model(SEED, dict(SPREADING), data.sheets["long"])
    up, down = model.dynamic["long"].moment_per_volt_Nm
    weaker = replace(
        model.dynamic["long"],
        moment_per_volt_Nm=(up.scaled(0.88, up.unit), down.scaled(0.92, down.unit)),
    )
    found = diagnose(data, DiagnoseOptions(model=replace(model, dynamic={"long": weaker})))
    assert found.verdict == "nothing_missing"
    scaled = found.model.dynamic["long"].moment_per_volt_Nm
    assert scaled[0].value == pytest.approx(up.value, rel=0.03)
    assert scaled[1].value == pytest.approx(down.value, rel=0.03)


@pytest.mark.thorough
def test_beside_the_dynamics_another_effect_is_named():
    hidden = (*CREEPING, ("shifted_stage", 1.0))
    found = diagnosed(hidden, positions_m=MOST_M, readings=6)
    assert "position_error" in names(found)
    assert not names(found) & {"nonuniform_eibm", "charging_lag", "viscoelastic_creep"}


@pytest.mark.thorough
def test_what_the_dynamics_do_not_explain_is_called_a_deviation_from_them():
    """The model says that the charge comes evenly, which it does not."""
    data = session(SEED, SPREADING)
    even = true_model(SEED, {"resistive_faces": 400.0}, data.sheets["long"])
    found = diagnose(data, DiagnoseOptions(model=even))
    assert "nonuniform_eibm" in names(found)
    assert "What is called EIBM along the sheet" in found.sentence
    assert "is what they do not explain." in found.sentence
    assert "nonuniform_eibm" in found.to_json()["dynamics"]["deviations"]
    marked = {one.name: one.beside_dynamics for one in found.model.effects}
    assert marked["nonuniform_eibm"] == ("long",)
