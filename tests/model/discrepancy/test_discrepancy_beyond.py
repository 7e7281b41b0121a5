"""Large changes in time, and what must not depend on how little a curve is moved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.effects import effect
from model.effects.conformance import plausible
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.model_state import AppliedEffect
from tests.model.discrepancy.sessions import base_fit

STRONG = {
    "stiffness_drift": {"relative_change": 0.4, "since_wetting": 1.0},
    "eibm_drift": {"relative_change": -0.5, "since_wetting": 1.0},
    "viscoelastic_creep": {"relative_change_per_decade": -0.2, "time_s": 0.0},
}


def each_reading(scene: ConfigurationModel, beam, of, eibm, stiffness) -> np.ndarray:
    """Forces (n,) of the readings, each from a beam solved for its own EIBM and stiffness."""
    result = np.zeros(len(of))
    for r, k in enumerate(of):
        a, b = 1.0 + eibm[r], 1.0 + stiffness[r]
        own = replace(beam, eibm=beam.eibm * a / b, stiffness=beam.stiffness * b)
        result[r] = scene.forces(own)[k]
    return result


@pytest.mark.slow
@pytest.mark.parametrize("name", STRONG)
def test_a_large_change_in_time_is_what_solving_each_reading_alone_gives(name):
    base = base_fit()
    forward, one = base.problem.forward, effect(name)
    values = {**plausible(one), **STRONG[name]}
    part, scene, plain = forward.part(0), forward.scenes[0], base.linear.states[0].base
    state = forward.state(0, plain, (AppliedEffect(one, {"long": values}),))
    eibm, stiffness = one.course(part.clock, values)
    driven = part.clock.voltage_V != 0.0
    # every fourth reading is enough
    some = np.arange(0, len(part.reading_of), 4)
    exact = each_reading(
        scene, plain, part.reading_of[some], (eibm * driven)[some], stiffness[some]
    )
    predicted = np.linalg.lstsq(
        part.trend, part.trend @ part.measured_N - state.residual[part.trend_rows], rcond=None
    )[0]
    # only the mean and three trends of each condition are predicted: compare those of the exact
    every = each_reading(scene, plain, part.reading_of, eibm * driven, stiffness)
    np.testing.assert_allclose(exact, every[some])
    wanted = part.trend @ every
    found = part.trend @ predicted
    assert np.max(np.abs(found - wanted)) < 0.01 * np.max(np.abs(wanted))
    first = forward.rows_of(
        0, base.linear.states[0], forward.step(0, base.linear.states[0], one, values)
    )
    force = base.linear.states[0].solved.force_N[part.reading_of]
    linear = part.trend @ force + first[part.trend_rows]
    trends = ~part.is_mean
    off = [np.sqrt(np.mean((x - wanted)[trends] ** 2)) for x in (found, linear)]
    assert off[0] < 0.2 * off[1]  # to first order it would be much farther off


@pytest.mark.slow
def test_pictures_that_are_very_late_show_what_a_beam_with_so_little_eibm_does():
    base = base_fit()
    forward, plain = base.problem.forward, base.linear.states[0].base
    part, scene = forward.part(0), forward.scenes[0]
    late = {"delay_s": 0.46, "through_zero": 0.0}
    state = forward.state(0, plain, (AppliedEffect(effect("frame_delay"), {"long": late}),))
    rise_s = part.clock.rise_s
    then, now = (1.0 - (1.0 - part.clock.opposite) * np.exp(-t / rise_s) for t in (0.04, 0.5))
    of, counts = part.reading_of, (part.clock.pulse < 0.0) | (part.clock.pulse >= 2.0)
    count = np.maximum(np.bincount(of, counts, minlength=scene.K), 1)
    seen = np.where(part.clock.voltage_V != 0.0, then / now, 1.0)
    change = np.bincount(of, np.where(counts, seen - 1.0, 0.0), scene.K) / count
    assert np.min(change) < -0.4  # no straight line leads there
    held = scene.touching[scene.has_curve[scene.touching]]
    wanted = scene.modes_of(replace(plain, eibm=plain.eibm * (1.0 + change[:, None])))
    np.testing.assert_allclose(
        state.residual[part.mode_rows[held]], wanted[held], atol=1e-9
    )  # metres; forces stay
    same = base.linear.states[0].residual[part.trend_rows]
    np.testing.assert_allclose(state.residual[part.trend_rows], same, atol=1e-12)


@pytest.mark.slow
def test_the_noise_of_a_short_sheet_that_hardly_moves_stays_what_it_is():
    """Its curves are not divided by how little the EIBM moves them."""
    base = base_fit()
    forward = base.problem.forward
    for part, state in zip(forward.layout.parts, base.linear.states, strict=True):
        assert np.max(np.abs(state.residual[part.sway_rows])) < 1e-4  # metres
    assert base.linear.states[1].reach_m.max() < 0.02 * base.linear.states[0].reach_m.max()
