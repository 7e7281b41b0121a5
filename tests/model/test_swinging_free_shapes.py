"""Free shapes that swing are no shapes at rest; a transient that the forces have, too, is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import Condition, Curve, Measurements, Reading
from model.identification.data.swinging_shapes import swings_m, without_swinging

RISE_M = 0.03  # of the free end under voltage
REACH_N = np.array([1.2e-3, 1.5e-3, 0.9e-3, 1.4e-3, 1.1e-3])  # what the voltage does, by position
DEFICIT = np.array([-0.03, -0.005, 0.0, 0.0])  # of the first pulses


def shape(height_m: float) -> Curve:
    s = np.linspace(0.0, 0.05, 3)
    return Curve(s_m=s, x_m=s, y_m=np.linspace(0.0, height_m, 3), sigma_m=np.full(3, 6e-6))


def readings(forces_N, curves=(None,) * 9, driven=True) -> tuple[Reading, ...]:
    kinds = ["discarded", "kept", "kept", "kept"] if driven else ["zero"] * 4
    parts = zip(kinds, forces_N, curves, strict=False)
    return tuple(
        Reading(index=i, kind=kind, force_N=float(force), curve=curve)
        for i, (kind, force, curve) in enumerate(parts)
    )


def table(in_shapes, in_forces, noise_N: float = 1e-5) -> Measurements:
    """Four pulses without contact and at five positions, each with a share less or more."""
    random = np.random.default_rng(1)
    free = [shape(RISE_M * (1.0 + share)) for share in in_shapes]
    still = [shape(0.0)] * 4
    conditions = [
        Condition(
            configuration="long", position_m=None, voltage_V=volts, curve=curves[-1],
            readings=readings(np.zeros(4), curves, driven=volts > 0.0),
        )
        for volts, curves in ((0.0, still), (2.0, free))
    ]  # fmt: skip
    for k, reach_N in enumerate(REACH_N):
        for volts, forces_N in ((0.0, np.zeros(4)), (2.0, reach_N * (1.0 + np.array(in_forces)))):
            noisy = forces_N + noise_N * random.standard_normal(4)
            conditions.append(
                Condition(
                    configuration="long", position_m=5e-3 * k, voltage_V=volts, curve=None,
                    readings=readings(noisy, driven=volts > 0.0),
                )
            )  # fmt: skip
    return Measurements(sheets={}, conditions=tuple(conditions))


def test_a_transient_that_the_forces_have_is_no_swing():
    data = table(DEFICIT, DEFICIT)
    assert swings_m(data) == {}
    assert without_swinging(data) == (data, ())


def test_what_the_forces_do_not_have_is_a_swing():
    found = swings_m(table(DEFICIT, 0.0 * DEFICIT))
    assert list(found) == [("long", 2.0)]
    assert found["long", 2.0] == pytest.approx(RISE_M * 0.0255 / np.sqrt(6.0), rel=0.02)


def test_a_swing_beside_a_transient_is_seen():
    assert swings_m(table(DEFICIT + np.array([0.0, 0.03, 0.0, 0.03]), DEFICIT))


def test_forces_too_noisy_to_tell_do_not_excuse_a_swing():
    assert swings_m(table(DEFICIT, DEFICIT, noise_N=2e-4))


def test_shapes_stay_where_they_are_all_that_there_is():
    data = table(DEFICIT, 0.0 * DEFICIT)
    alone = replace(data, conditions=data.conditions[:2])
    assert without_swinging(alone, where_touched=True)[0] is alone
    assert len(without_swinging(alone)[0].conditions) == 1
    assert len(without_swinging(data, where_touched=True)[0].conditions) == 11
