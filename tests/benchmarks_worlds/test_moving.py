"""The world that moves: free shapes that swing, charges that spread, the fit of its sessions."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._moving_noise import strips
from benchmarks.worlds.generators.moving import WORLD
from model import fit

pytestmark = pytest.mark.thorough

SEED = 7
FREE = Design(positions_m={"long": (0.005,)}, free_shapes=1, readings=3)


def ends(hidden: dict[str, float], *, exact: bool) -> dict[float, np.ndarray]:
    """The free long strip's end in the image of each voltage, in m."""
    found = WORLD.measure(FREE, hidden, SEED, exact=exact)
    return {
        c.voltage_V: np.array([c.curve.x_m[-1], c.curve.y_m[-1]])
        for c in found.conditions
        if c.position_m is None and c.curve is not None
    }


def test_free_shapes_swing_by_millimetres_half_a_second_after_an_edge_and_not_at_0_V() -> None:
    moving, at_rest = ends({}, exact=False), ends({}, exact=True)
    away_mm = {v: 1e3 * float(np.hypot(*(moving[v] - at_rest[v]))) for v in moving}
    assert away_mm[0.0] < 0.01
    assert 1.0 < max(away_mm.values()) < 15.0  # at either voltage it may just pass its place


def test_resistive_faces_let_the_eibm_spread_from_the_clamp_during_a_pulse() -> None:
    held = WORLD.measure(FREE, {"resistive_faces": 8000.0}, SEED, exact=True)
    bare = WORLD.measure(FREE, {}, SEED, exact=True)
    force = [one.series[0].force_N for one in (held, bare)]
    pulse = slice(60 * 6, 60 * 7)  # the second driven one, a hundredth of a second apart
    late = [f[pulse][25] - f[pulse][58] for f in force]
    assert abs(late[0]) > 30 * abs(late[1])


def test_what_is_fitted_to_sessions_is_true_within_the_stated_errors() -> None:
    z = []
    for seed in (3, 7, 11):
        found, true = fit(WORLD.measure(Design(), {}, seed)), strips(seed)
        for name, one in found.configurations.items():
            strip = true[name]
            z.append((one.B.value - strip.stiffness_Nm2) / one.B.sigma)
            for volts, share in ((2.0, 1.0), (-2.0, -strip.negative)):
                eibm = strip.stiffness_Nm2 * strip.driven_per_m * share
                z.append((one.eibm[volts].value - eibm) / one.eibm[volts].sigma)
    assert np.max(np.abs(z)) < 4.0
    assert 0.5 < float(np.sqrt(np.mean(np.square(z)))) < 1.6
