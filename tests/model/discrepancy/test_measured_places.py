"""Many measured conditions at once: what `predict` says of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import SheetModel, predict
from model.discrepancy.verdict.measured_places import seen_at
from model.effects import Effect, catalogue
from model.identification.fit import fit
from model.parameter import Parameter
from model.sheet.beam_problem import ActiveEffect
from tests.model.discrepancy.sessions import session

PLACES = [(at_m, volts) for at_m in (0.005, 0.02) for volts in (2.0, -2.0, 1.0, -1.0, 0.0)]


def with_effect(effect: Effect) -> SheetModel:
    """The base model and one of the catalogue's effects, at a size that is found now and then."""
    amplitude = effect.amplitude.name
    values = {
        k.name: k.prior_scale
        if k.name == amplitude and not k.log
        else float(k.starting_values[0])
        if k.starting_values
        else k.neutral
        for k in effect.parameters
    }
    known = {
        k.name: Parameter(value=values[k.name], sigma=0.0, unit=k.unit) for k in effect.parameters
    }
    plain = fit(session()).model
    own = dict.fromkeys(plain.sheets, known) if effect.by_configuration else {}
    active = ActiveEffect(name=effect.name, parameters={} if own else known, by_configuration=own)
    return replace(plain, effects=(active,))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(catalogue()))
def test_a_run_alternates_between_a_voltage_and_its_own_opposite(name):
    """Pulses of +1 V were taken to alternate with +2 V where both had been measured."""
    model = with_effect(catalogue()[name])
    seen = seen_at(model, "long", PLACES)
    assert len(seen) == len(PLACES)
    for (at_m, volts), found in zip(PLACES, seen, strict=True):
        wanted = predict(model, "long", at_m, volts)
        assert pytest.approx(wanted.F_N, abs=1e-9) == found.F_N
        np.testing.assert_allclose(found.x_m, wanted.x_m, atol=1e-9)
        np.testing.assert_allclose(found.y_m, wanted.y_m, atol=1e-9)
