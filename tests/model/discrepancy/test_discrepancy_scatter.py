"""What differs from set-up to set-up is found where it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.random_effects import ASSUMED
from model.measurements import Condition, Curve, Measurements
from tests.model.discrepancy.sessions import Case, Extras, fitted, session

FREE = Case(seed=3, extras=Extras(free_shapes=True))


def blown_up(one: Condition, at_zero: Curve, share: float) -> Condition:
    """As if the EIBM were larger: all that a free shape is away from that at 0 V."""

    def more(curve: Curve | None) -> Curve | None:
        if curve is None:
            return None
        x, y = (
            zero + (1.0 + share) * (here - zero)
            for here, zero in ((curve.x_m, at_zero.x_m), (curve.y_m, at_zero.y_m))
        )
        return replace(curve, x_m=x, y_m=y)

    readings = tuple(replace(r, curve=more(r.curve)) for r in one.readings)
    return replace(one, readings=readings, curve=more(one.curve))


def with_free_shapes_that_scatter(m: Measurements, share: float) -> Measurements:
    """Each free shape under voltage with an EIBM of its own."""
    random, conditions = np.random.default_rng(1), []
    at_zero = {
        (c.configuration, c.mounting): c.curve
        for c in m.conditions
        if c.position_m is None and c.voltage_V == 0.0
    }
    for one in m.conditions:
        zero = at_zero.get((one.configuration, one.mounting))
        if one.position_m is None and one.voltage_V != 0.0 and zero is not None:
            one = blown_up(one, zero, share * random.standard_normal())
        conditions.append(one)
    return replace(m, conditions=tuple(conditions))


def times_usual(found: MixedModelFit) -> dict[str, float]:
    """Each scatter over what is assumed of it."""
    times = np.exp(found.solution.log_sigma - found.problem.guess)
    return dict(zip(ASSUMED, times[: len(ASSUMED)].tolist(), strict=True))


@pytest.mark.slow
def test_free_shapes_that_scatter_do_not_blur_what_holds_the_sheet():
    """Each may be taken by itself, at its own state of the sheet; a position's polarities are not.

    What tells effects apart is how well both polarities of a position and its curves agree.
    """
    found = times_usual(fitted(with_free_shapes_that_scatter(session(FREE), 0.02)))
    assert found["eibm_free"] > 3.0
    assert found["eibm_condition"] < 1.5
