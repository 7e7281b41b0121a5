"""Force and shape of a set-up over the drive, against solving for each drive."""

from __future__ import annotations

import numpy as np
import pytest

from sim_hardware.world import load_world
from sim_hardware.world.chain.contact import ContactState
from sim_hardware.world.setup import MountedSheet, Scatter


@pytest.mark.parametrize("configuration", ["long", "short"])
@pytest.mark.parametrize("position_m", [0.0, 0.015, 0.03])
def test_the_table_agrees_with_the_chain_to_a_nanonewton(
    configuration: str, position_m: float
) -> None:
    setup = MountedSheet(
        settings=load_world(), configuration=configuration, position_m=position_m, scatter=Scatter()
    )
    drives = np.linspace(-0.97, 1.22, 23)
    assert not setup.slipped(drives).any()
    forces_N = setup.stiffness_Nm2 * setup.cell_force_per_m2(drives)
    contact = ContactState(setup.chain, setup.arc)
    for drive, force_N in zip(drives, forces_N, strict=True):
        start = contact.place(0.0, setup.arc_rad)
        assert start is not None
        state, whole = contact.drive_to(start, float(drive), setup.arc_rad)
        assert whole
        assert setup.stiffness_Nm2 * state.along_per_m2 == pytest.approx(force_N, abs=1e-9)
        found = setup.held.state(float(drive))
        assert found.phi_rad == pytest.approx(state.phi_rad, abs=1e-6)
        assert found.s_m == pytest.approx(state.s_m, abs=5e-8)


def test_force_scales_with_stiffness_when_the_moment_does_too() -> None:
    settings = load_world()
    drives = np.array([-0.8, 0.0, 1.0])
    thin = MountedSheet(settings=settings, configuration="long", position_m=0.01, scatter=Scatter())
    thick = MountedSheet(
        settings=settings,
        configuration="long",
        position_m=0.01,
        scatter=Scatter(eibm=1.7, stiffness=1.7),
    )
    ratio = (thick.stiffness_Nm2 * thick.cell_force_per_m2(drives * thick.drive_share)) / (
        thin.stiffness_Nm2 * thin.cell_force_per_m2(drives * thin.drive_share)
    )
    assert ratio == pytest.approx(1.7, rel=1e-12)


def test_the_table_ends_where_the_sheet_slips_out() -> None:
    setup = MountedSheet(
        settings=load_world(), configuration="long", position_m=0.03, scatter=Scatter()
    )
    drives = np.array([-3.0, -2.0, 0.0, 1.0])
    assert list(setup.slipped(drives)) == [True, True, False, False]
    edge = setup.held.lowest
    contact = ContactState(setup.chain, setup.arc)
    start = contact.place(0.0, setup.arc_rad)
    assert start is not None
    inside, reached = contact.drive_to(start, edge + 1e-3, setup.arc_rad)
    _, beyond = contact.drive_to(start, edge - 1e-3, setup.arc_rad)
    assert reached
    assert not beyond
    assert inside.s_m < 0.05
    assert setup.held.state(edge + 1e-3).along_per_m2 == pytest.approx(
        inside.along_per_m2, rel=1e-3
    )


def test_misalignment_mixes_the_outward_force_in() -> None:
    settings = load_world()
    cell = settings.load_cell.model_copy(update={"misalignment_deg": 90.0 * 2 / 90})
    turned = MountedSheet(
        settings=settings.model_copy(update={"load_cell": cell}),
        configuration="long",
        position_m=0.03,
        scatter=Scatter(),
    )
    straight = MountedSheet(
        settings=settings, configuration="long", position_m=0.03, scatter=Scatter()
    )
    drive = np.array([0.3])
    along, outward = straight.held.forces_per_m2(drive)[:, 0]
    expected = along * np.cos(np.radians(2)) - outward * np.sin(np.radians(2))
    assert turned.cell_force_per_m2(drive)[0] == pytest.approx(expected, rel=1e-12)
