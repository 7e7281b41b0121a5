"""Two worlds solve the same loads alike, though they share no code."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.worlds.generators import _elements_beam as elements
from benchmarks.worlds.generators import _shooting_equilibrium as shooting

pytestmark = pytest.mark.thorough

R, B = 40e-3, 1.2e-6
SOLVED = 1e-6  # what the two leave of their equations is 1e-7 and 3e-7
POSITIONS_M = np.array([0.0, 0.01, 0.025])
KAPPA_PER_M = np.array([45.0, 10.0, -10.0])


def bent(s: np.ndarray) -> np.ndarray:
    return 20.0 * np.exp(-s / 40e-3)


def both(long: bool, first: dict, second: dict, **fields: float) -> tuple[np.ndarray, np.ndarray]:
    """Force and contact (2, n) by shooting and by elements."""
    length, bar = (50e-3, 0.0) if long else (4.5e-3, 40e-3)
    given = {"length_m": length, "elongation_m": bar, "radius_m": R}
    given |= {"rest_per_m": bent, "stiffness_Nm2": B}
    stiff = np.full(3, B)
    lanes = shooting.Lanes.of(POSITIONS_M, B * KAPPA_PER_M, stiff)
    cases = elements.Cases.of(POSITIONS_M, B * KAPPA_PER_M, stiff)
    lanes.root_rad[:] = cases.root_rad[:] = fields.get("root", 0.0)
    lanes.offset_m[:] = cases.offset_m[:] = fields.get("offset", 0.0)
    one = shooting.Shooting(shooting.Strip(**given), shooting.Surroundings(**first)).solve(lanes)
    other = elements.Beam(elements.Blade(**given), elements.Setting(**second)).solve(cases)
    assert np.all(one.closed)
    assert np.all(other.held)
    return (
        np.stack([one.of_object()[0], one.contact_m]),
        np.stack([other.shown()[0], other.contact_m]),
    )


@pytest.mark.parametrize("long", [True, False])
@pytest.mark.parametrize(
    ("first", "second", "fields", "closeness"),
    [
        ({}, {}, {}, SOLVED),
        ({}, {}, {"root": 0.05}, SOLVED),
        ({}, {}, {"offset": 1e-3}, SOLVED),
        # the same weight per length; the shape of the loaded tail is taken as unloaded by one
        ({"weight_N_per_m": 4e-3, "bar_weight": 1.0}, {"weight_N_per_m": 4e-3}, {}, 2e-5),
        # limits so far off that the laws are straight lines
        (
            {"clamp_rad_per_Nm": 10.0, "clamp_most_rad": 10.0},
            {"clamp_rad_per_Nm": 10.0},
            {},
            SOLVED,
        ),
        ({"give_m_per_N": 0.05, "give_from_N": 1e6}, {"give_m_per_N": 0.05}, {}, SOLVED),
    ],
)
def test_the_two_agree(
    long: bool, first: dict, second: dict, fields: dict, closeness: float
) -> None:
    one, other = both(long, first, second, **fields)
    scale = np.array([[B / R**2], [R]])
    np.testing.assert_allclose(one / scale, other / scale, atol=closeness)
    if first or fields:
        bare, _ = both(long, {}, {})
        assert np.max(np.abs(one - bare) / scale) > 20.0 * closeness  # it matters
