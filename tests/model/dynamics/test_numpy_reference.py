"""The compiled kernel against the NumPy reference, which takes its derivatives by complex step."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from model import ModelError
from model.dynamics import (
    ClampTurn,
    ContactSetup,
    Elongation,
    FluidLoad,
    HeldVoltage,
    Resolution,
    fluid_load,
    simulate,
)
from model.mechanics.field import Field
from tests.model.dynamics.cases import CURVED, LINE, B, R, driven, material

TIMES = np.array([0.0, 0.0105, 0.024])
KICK = HeldVoltage(np.array([0.0, 0.0083]), np.array([2.0, -2.0]))
WATER = FluidLoad(
    added_mass_kg_per_m=0.12,
    normal_Ns_per_m2=0.1,
    quadratic_Ns2_per_m3=5.0,
    tangential_Ns_per_m2=0.05,
)
SHORT = 0.0045


def short_sheet():
    return driven(
        Field.constant(28.0, SHORT),
        length_m=SHORT,
        elongation=Elongation(
            length_m=0.04, mass_per_length_kg_per_m=4e-3, end_mass_kg=2e-5, fluid=WATER
        ),
    )


TURN = ClampTurn(
    angle_rad=lambda t: 0.2 * (1.0 - np.cos(50.0 * t)),
    rate_rad_per_s=lambda t: 10.0 * np.sin(50.0 * t),
    acceleration_rad_per_s2=lambda t: 500.0 * np.cos(50.0 * t),
)
MOVED = ContactSetup(radius_m=R, position_m=lambda t: 0.005 + 0.002 * (1.0 - np.cos(60.0 * t)))
CASES = {
    "free": (driven(CURVED), None, None),
    "free in a fluid, asymmetric": (
        driven(CURVED, fluid=WATER, moment_per_volt_Nm=(30.0 * B, 24.0 * B)), None, None,
    ),
    "contact": (driven(CURVED), ContactSetup(radius_m=R, position_m=0.01), None),
    "contact in a fluid": (
        driven(CURVED, fluid=WATER), ContactSetup(radius_m=R, position_m=0.01), None,
    ),
    "contact on the elongation": (short_sheet(), ContactSetup(radius_m=R, position_m=0.005), None),
    "free elongation": (short_sheet(), None, None),
    "load cell moves": (driven(CURVED), MOVED, None),
    "clamp turns": (driven(CURVED, fluid=WATER), None, TURN),
}  # fmt: skip


@pytest.mark.parametrize("name", list(CASES))
def test_the_compiled_kernel_is_the_reference(name):
    beam, setup, clamp = CASES[name]
    by = Resolution(step_s=1e-3, degrees=(5, 2), free_degrees=6, tolerance_per_s2=1e-6)
    one, two = (
        simulate(beam, setup, KICK, TIMES, resolution=by, clamp=clamp, engine=engine)
        for engine in ("compiled", "numpy")
    )
    moved = np.abs(two.y_m[-1] - two.y_m[0]).max()
    assert moved > 1e-8
    assert one.y_m == pytest.approx(two.y_m, abs=1e-6 * moved)
    assert one.curvature_per_m == pytest.approx(two.curvature_per_m, rel=1e-6, abs=1e-6)
    if setup is not None:
        assert one.normal_N == pytest.approx(two.normal_N, rel=1e-6)
        assert one.s_hat_m == pytest.approx(two.s_hat_m, rel=1e-8)
    assert np.array_equal(one.current_A, two.current_A)


def test_without_numba_the_numpy_reference_is_used(monkeypatch):
    import model.dynamics

    monkeypatch.setitem(sys.modules, "model.dynamics.kernel", None)
    monkeypatch.delattr(model.dynamics, "kernel", raising=False)
    by = Resolution(free_degrees=4)
    motion = simulate(driven(), None, KICK, TIMES[:2], resolution=by)
    assert np.all(np.isfinite(motion.y_m))
    with pytest.raises(ModelError, match="numba"):
        simulate(driven(), None, KICK, TIMES[:2], resolution=by, engine="compiled")


def test_a_motion_in_pieces_is_the_motion_in_one():
    from model.dynamics import Simulation

    setup = ContactSetup(radius_m=R, position_m=0.01, resonance_hz=80.0, damping=0.05)
    drive = HeldVoltage(np.array([0.01, 0.05]), np.array([2.0, -2.0]))
    by = Resolution(tolerance_per_s2=1e-5)
    whole = simulate(driven(), setup, drive, np.linspace(0.0, 0.12, 13), resolution=by)
    one = Simulation(driven(), setup, drive, resolution=by)
    pieces = [one.advance(drive, whole.time_s[i : i + 4]) for i in range(0, 13, 4)]
    for name in ("force_N", "reading_N", "current_A", "s_hat_m"):
        found = np.concatenate([getattr(p, name) for p in pieces])
        assert found == pytest.approx(getattr(whole, name), rel=1e-6, abs=1e-9), name


def test_the_load_cell_rings_at_its_own_resonance():
    """A force that begins to grow evenly is followed late by 2 zeta/w, with a decaying ripple."""
    from model.dynamics.load_cell import LoadCellFilter

    w, zeta, step = 2.0 * np.pi * 80.0, 0.05, 1e-3
    cell = LoadCellFilter(ContactSetup(radius_m=R, position_m=0.0, resonance_hz=80.0, damping=zeta))
    t = step * np.arange(200)
    found = cell.follow(np.full(199, step), t)
    wd = w * np.sqrt(1.0 - zeta**2)
    ripple = 2.0 * zeta / w * np.cos(wd * t) + (2.0 * zeta**2 - 1.0) / wd * np.sin(wd * t)
    assert found == pytest.approx(t - 2.0 * zeta / w + np.exp(-zeta * w * t) * ripple, abs=1e-13)


def test_water_slows_the_sheet_as_its_added_mass_says():
    from model.dynamics import UNDRIVEN, Simulation
    from model.dynamics.linearised import linearise
    from tests.model.dynamics.cases import STRAIGHT, plain

    water = fluid_load(0.011, 1000.0, 1e-3, 0.71)
    air, wet = (
        linearise(Simulation(plain(STRAIGHT, **more), None, UNDRIVEN)).frequencies_hz()[0]
        for more in ({}, {"fluid": water})
    )
    mass = 5.775e-3
    slower = np.sqrt(mass / (mass + water.added_mass_kg_per_m))
    assert wet == pytest.approx(air * slower, rel=1e-9)
    assert wet == pytest.approx(0.71, abs=0.02)


def test_the_loss_slows_nothing_at_the_resting_force():
    """After a long time the force is that of the relaxed stiffness, however lossy the sheet is."""
    setup = ContactSetup(radius_m=R, position_m=0.01)
    drive = HeldVoltage(np.array([0.0]), np.array([2.0]))
    forces = [
        simulate(
            driven(CURVED, material=made, electrodes=LINE), setup, drive, np.array([6.0]),
            resolution=Resolution(step_s=5e-3),
        ).force_N[0]
        for made in (material(True), material(False, 2e-3))
    ]  # fmt: skip
    assert forces[0] == pytest.approx(forces[1], rel=1e-4)
