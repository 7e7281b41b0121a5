"""What the rig itself states is no effect: a voltage read back at 0 V, how good a camera is."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.hidden_effects import case, hidden_session
from benchmarks.hidden_effects.recipe import Recipe
from model.discrepancy import diagnose
from model.identification.data.zero_voltage import zero_voltage_V
from model.identification.likelihood.linearisation import sensitivities
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import CameraUncertainty, Condition, Measurements, TimeSeries
from tests.model.discrepancy.sessions import fitted

OFFSET_V = 0.01  # at the sheet, which bends it by 0.2 per m where 2 V bend it by 40
OFFSET = ("amplifier.offset_mV", 1.0)  # its gain is 10
SCALE_ERROR = 3e-4


@cache
def with_changed(*changes: tuple[str, float]) -> Measurements:
    """A session of a world that is the base model but for some numbers."""

    def change(recipe: Recipe) -> None:
        for key, value in changes:
            recipe.set(key, value)

    return hidden_session(case(seed=11), change).measurements


def offset() -> Measurements:
    return with_changed(OFFSET)


def as_asked(m: Measurements) -> Measurements:
    """The same where the output was not read back."""
    return replace(m, series=tuple(replace(one, drive_V=np.round(one.drive_V)) for one in m.series))


def read_back(*drives_V: np.ndarray, asked_V: float = 2.0) -> Measurements:
    """Runs with these read-backs, and one condition."""
    runs = [
        TimeSeries(
            configuration="long", position_m=0.0, time_s=np.arange(len(each)) / 100.0, drive_V=each
        )
        for each in drives_V
    ]
    asked = Condition(configuration="long", position_m=0.0, voltage_V=asked_V, readings=())
    return Measurements(sheets={}, conditions=(asked,), series=tuple(runs))


def test_the_voltage_before_the_first_pulse_is_that_at_rest():
    rest = np.random.default_rng(1).normal(OFFSET_V, 1e-3, 400)
    pulses = np.repeat([2.01, -1.99, 0.5], 60)  # a supply that is slow to return
    found = zero_voltage_V(read_back(np.append(rest, pulses)))
    assert found == pytest.approx(OFFSET_V, abs=2e-4)
    assert zero_voltage_V(read_back(np.append(rest, pulses)), "short") == 0.0
    assert zero_voltage_V(read_back(np.append(np.nan * rest, pulses))) == 0.0
    assert zero_voltage_V(read_back(0.0 * rest, pulses)) == 0.0
    assert zero_voltage_V(read_back()) == 0.0
    assert zero_voltage_V(offset()) == pytest.approx(OFFSET_V, abs=1e-3)


def test_a_small_pulse_before_larger_ones_is_no_rest():
    small_first = np.repeat([OFFSET_V, 0.11, -0.09, 2.01, -1.99], [40, 200, 200, 60, 60])
    found = zero_voltage_V(read_back(small_first, asked_V=0.1))
    assert found == pytest.approx(OFFSET_V)


def test_an_offset_of_the_amplifier_that_was_read_back_is_no_initial_curvature():
    assert diagnose(offset()).verdict == "nothing_missing"


def test_a_voltage_that_stays_need_not_bend_the_sheet_by_its_share_of_a_pulse():
    """Before the first pulse the water is where it was: what is missing then is no k0."""
    changes = ("amplifier.offset_mV", 2.0), ("water.first_pulse_deficit", 0.3)
    found = diagnose(with_changed(*changes))
    assert [one.name for one in found.effects] == ["first_pulse_transient"]


def test_the_derivative_by_what_stays_is_that_of_the_residuals():
    one, step = fitted(offset()), 0.05
    forward, bases = one.problem.forward, one.problem.bases
    columns = sensitivities(forward, bases, one.theta)[2]
    for part in bases.parts:
        place = part.at_zero.more
        moved = step * (np.arange(bases.size) == place)
        before, after = (
            sensitivities(forward, bases, one.theta + end)[1] for end in (-moved, moved)
        )
        slope = (before - after) / (2.0 * step)  # a residual is measured less simulated
        largest = np.max(np.abs(columns[:, place]))
        assert largest > 1e-6
        np.testing.assert_allclose(columns[:, place], slope, atol=0.005 * largest)


def test_an_offset_that_nobody_read_back_is_one():
    (named,) = diagnose(as_asked(offset())).effects
    assert named.name == "initial_curvature"


def test_a_scale_that_is_off_by_no_more_than_the_calibration_states_is_no_effect():
    m = with_changed(("view.scale_error", SCALE_ERROR))
    assert diagnose(m).effects
    stated = replace(m, camera=CameraUncertainty(scale=4e-4, roll_rad=1e-4, origin_m=2e-6))
    assert diagnose(stated).verdict == "nothing_missing"


def test_a_scale_that_is_off_by_much_more_is_named_all_the_same():
    m = with_changed(("view.scale_error", 0.01))
    found = diagnose(replace(m, camera=CameraUncertainty(scale=4e-4)))
    assert "camera_scale" in found.reported_set
    assert found.effects


def test_curves_are_no_better_known_than_their_extraction_states():
    """However alike they are: what is systematic in them is no effect."""
    precise = hidden_session(case(seed=12)).measurements
    floor_m = 5e-5
    states = [replace(precise, camera=CameraUncertainty(curve_m=m)) for m in (0.0, floor_m)]
    known, vague = (fitted(one) for one in states)
    names = vague.problem.noise.names
    modes = [i for i, name in enumerate(names) if name.startswith("long mode")]
    assert len(modes) > 5

    def variances(one: MixedModelFit) -> list[float]:
        rows = [np.flatnonzero(one.problem.noise.masks[i]) for i in modes]
        return [float(np.min(one.problem.noise.fixed[of])) for of in rows]

    assert max(variances(known)) < 1e-13
    # what images miss is near rolls and ends, so there is as much of it in the higher modes
    assert variances(vague) == pytest.approx([floor_m**2] * len(modes))
    place = vague.problem.bases.parts[0].stiffness
    sigma = [one.solution.covariance[place, place] ** 0.5 for one in (known, vague)]
    assert sigma[1] > 1.02 * sigma[0]
