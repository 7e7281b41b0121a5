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


def each_reading(configuration_model: ConfigurationModel, beam, of, eibm, stiffness) -> np.ndarray:
    """Forces (n,) of the readings, each from a beam solved for its own EIBM and stiffness."""
    result = np.zeros(len(of))
    for r, k in enumerate(of):
        a, b = 1.0 + eibm[r], 1.0 + stiffness[r]
        own = replace(beam, eibm=beam.eibm * a / b, stiffness=beam.stiffness * b)
        result[r] = configuration_model.forces(own)[k]
    return result


@pytest.mark.slow
@pytest.mark.parametrize("name", STRONG)
def test_a_large_change_in_time_is_what_solving_each_reading_alone_gives(name):
    base = base_fit()
    forward, one = base.problem.forward, effect(name)
    values = {**plausible(one), **STRONG[name]}
    block = forward.row_block(0)
    configuration_model = forward.configuration_models[0]
    plain = base.linear.states[0].base
    state = forward.state(0, plain, (AppliedEffect(one, {"long": values}),))
    eibm, stiffness = one.course(block.clock, values)
    driven = block.clock.voltage_V != 0.0
    # every fourth reading is enough
    some = np.arange(0, len(block.reading_of), 4)
    exact = each_reading(
        configuration_model, plain, block.reading_of[some], (eibm * driven)[some], stiffness[some]
    )
    predicted = np.linalg.lstsq(
        block.trend, block.trend @ block.measured_N - state.residual[block.trend_rows], rcond=None
    )[0]
    # only the mean and three trends of each condition are predicted: compare those of the exact
    every = each_reading(configuration_model, plain, block.reading_of, eibm * driven, stiffness)
    np.testing.assert_allclose(exact, every[some])
    wanted = block.trend @ every
    found = block.trend @ predicted
    assert np.max(np.abs(found - wanted)) < 0.01 * np.max(np.abs(wanted))
    first = forward.rows_of(
        0, base.linear.states[0], forward.step(0, base.linear.states[0], one, values)
    )
    force = base.linear.states[0].solved.force_N[block.reading_of]
    linear = block.trend @ force + first[block.trend_rows]
    trends = ~block.is_mean
    off = [np.sqrt(np.mean((x - wanted)[trends] ** 2)) for x in (found, linear)]
    assert off[0] < 0.2 * off[1]  # to first order it would be much farther off


@pytest.mark.slow
def test_pictures_that_are_very_late_show_what_a_beam_with_so_little_eibm_does():
    base = base_fit()
    forward, plain = base.problem.forward, base.linear.states[0].base
    block, configuration_model = forward.row_block(0), forward.configuration_models[0]
    late = {"delay_s": 0.46, "through_zero": 0.0}
    state = forward.state(0, plain, (AppliedEffect(effect("frame_delay"), {"long": late}),))
    rise_s = block.clock.rise_s
    then, now = (1.0 - (1.0 - block.clock.opposite) * np.exp(-t / rise_s) for t in (0.04, 0.5))
    of, counts = block.reading_of, (block.clock.pulse < 0.0) | (block.clock.pulse >= 2.0)
    count = np.maximum(np.bincount(of, counts, minlength=configuration_model.K), 1)
    seen = np.where(block.clock.voltage_V != 0.0, then / now, 1.0)
    change = np.bincount(of, np.where(counts, seen - 1.0, 0.0), configuration_model.K) / count
    assert np.min(change) < -0.4  # no straight line leads there
    held = configuration_model.touching[configuration_model.has_curve[configuration_model.touching]]
    wanted = configuration_model.modes_of(replace(plain, eibm=plain.eibm * (1.0 + change[:, None])))
    np.testing.assert_allclose(
        state.residual[block.mode_rows[held]], wanted[held], atol=1e-9
    )  # metres; forces stay
    same = base.linear.states[0].residual[block.trend_rows]
    np.testing.assert_allclose(state.residual[block.trend_rows], same, atol=1e-12)


@pytest.mark.slow
def test_the_noise_of_a_short_sheet_that_hardly_moves_stays_what_it_is():
    """Its curves are not divided by how little the EIBM moves them."""
    base = base_fit()
    forward = base.problem.forward
    for block, state in zip(forward.row_index.blocks, base.linear.states, strict=True):
        assert np.max(np.abs(state.residual[block.sway_rows])) < 1e-4  # metres
    assert base.linear.states[1].reach_m.max() < 0.02 * base.linear.states[0].reach_m.max()
