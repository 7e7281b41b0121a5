"""What few worlds have: creep, bumps, other forms, a image that deceives."""

from __future__ import annotations

import numpy as np
import pytest

from sim_hardware.world import Train, Visit, load_world
from sim_hardware.world.along import bump, fall, stiffness_rise
from sim_hardware.world.setup import MountedSheet, Scatter
from sim_hardware.world.signals.load_cell import SimulatedLoadCell
from tests.sim_hardware.test_world_timed import forces_mN, one, world

LONG_REST = Train(zero_readings=40, kept=1)


@pytest.mark.slow
def test_a_strain_that_stays_loses_its_share_of_the_force_and_keeps_its_shape() -> None:
    settings = world(creep__share=0.2, creep__time_s=1.5)
    run = one(settings, Visit(configuration="long", position_m=0.0), LONG_REST)
    stiff = one(world(), Visit(configuration="long", position_m=0.0), LONG_REST)
    zeros, whole = forces_mN(run, 0.0), forces_mN(stiff, 0.0)
    assert zeros[-1] == pytest.approx(0.8 * whole[-1], abs=2e-4)
    # one time constant after it was placed (the run begins later, so at its first reading less)
    since_s = settings.creep.time_s
    left = 1 - 0.2 * (1 - np.exp(-(LONG_REST.wet_s + 0.5) / since_s))
    assert zeros[0] / whole[0] == pytest.approx(left, abs=1e-3)
    assert np.allclose(run.curves_m[0.0], stiff.curves_m[0.0], atol=2e-8)


def test_a_creeping_sheet_that_is_driven_goes_on_bending() -> None:
    settings = world(creep__share=0.3, creep__time_s=0.2)
    run = one(settings, Visit(configuration="long", position_m=None))
    stiff = one(world(), Visit(configuration="long", position_m=None))
    ends = [[_end_rad(r.curves_m[v]) for v in (2.0, -2.0)] for r in (run, stiff)]
    assert 1.2 < np.ptp(ends[0]) / np.ptp(ends[1]) < 1.3


def _end_rad(curve: np.ndarray) -> float:
    """Direction of a curve's last piece."""
    dx, dy = curve[-1] - curve[-3]
    return float(np.arctan2(dy, dx))


def test_parts_of_what_creeps_add_up_to_the_sheet_that_crept_as_a_whole() -> None:
    # Held at 2 V for ever, a sheet with Me/B = d behaves as one with (1 - share) B.
    settings = world(creep__share=0.1)
    setup = MountedSheet(
        settings=settings, configuration="long", position_m=0.005, scatter=Scatter()
    )
    drive = np.array([0.8])
    strain = np.array([[1.0, 0.8, 0.8**2]])
    crept = setup.cell_force_per_m2(drive) + setup.crept_force_per_m2(drive, strain)
    soft = 0.9 * MountedSheet(
        settings=world(), configuration="long", position_m=0.005, scatter=Scatter()
    ).cell_force_per_m2(drive / 0.9)
    plain = setup.cell_force_per_m2(drive)
    assert crept[0] - plain[0] == pytest.approx(soft[0] - plain[0], rel=0.15)


@pytest.mark.parametrize("form", ["exp", "cosh", "line", "root"])
def test_a_moment_falls_in_any_form(form: str) -> None:
    s = np.linspace(0, 0.05, 51)
    values = fall(s, form, 0.06, 0.05)  # type: ignore[arg-type]
    assert values[0] == 1.0
    assert np.all(np.diff(values) <= 1e-12)
    assert 0.1 < values[-1] < 0.75
    assert np.array_equal(fall(s, form, 0.0, 0.05), np.ones(51))  # type: ignore[arg-type]
    # an electrode with nothing beyond its end carries no current there
    assert (values[-2] - values[-1] < 1e-3) == (form == "cosh")


@pytest.mark.parametrize("form", ["sine", "line", "step"])
def test_a_stiffness_rises_from_clamp_to_end_in_any_form(form: str) -> None:
    values = stiffness_rise(np.linspace(0, 0.05, 51), form, 0.05)  # type: ignore[arg-type]
    assert values[0] == pytest.approx(0.0, abs=1e-9)
    assert values[25] == pytest.approx(0.5)
    assert values[-1] == pytest.approx(1.0)


def test_k0_can_be_straight_between_nodes() -> None:
    sheet = world(configurations__long__rest_curvature_step_mm=10.0).configurations["long"]
    assert sheet.rest_curvature(np.array([0.015]))[0] == pytest.approx(
        12 * (np.exp(-0.25) + np.exp(-0.5)), rel=1e-12
    )


def test_a_bump_bends_the_sheet_where_it_is_and_only_the_sheet_it_is_of() -> None:
    extra = {"at_mm": 20.0, "width_mm": 1.0, "amount": 30.0, "configuration": "long"}
    for of, drive in (("rest_curvature", 0.0), ("eibm", 1.0), ("even_moment", -1.0)):
        turned = {}
        for name in ("long", "short"):
            angles = [
                MountedSheet(settings=w, configuration=name, position_m=None, scatter=Scatter())
                .free.state(drive)
                .phi_rad
                for w in (world(bumps=[{"of": of, **extra}]), world())
            ]
            turned[name] = angles[0] - angles[1]
        assert np.all(turned["short"] == 0.0)
        h_mm = 0.125
        assert turned["long"][int(16 / h_mm)] == pytest.approx(0.0, abs=1e-4)
        # an area of 30 per m x 1 mm x sqrt(2 pi), with the sign of the voltage for the EIBM only
        assert turned["long"][int(24 / h_mm)] == pytest.approx(0.0752, rel=0.01)
    assert bump(0.02, 0.02, 0.001) == 1.0


def test_a_soft_place_turns_more_under_load() -> None:
    notch = {"of": "stiffness", "at_mm": 10.0, "width_mm": 1.0, "amount": -0.5}
    forces = [
        MountedSheet(
            settings=w, configuration="long", position_m=0.03, scatter=Scatter()
        ).cell_force_per_m2(np.zeros(1))[0]
        for w in (world(bumps=[notch]), world())
    ]
    assert forces[1] < forces[0] < 0.0


def test_a_joint_and_a_soft_elongation_of_equal_give_take_the_same_force_away() -> None:
    lever_mm = 40.0 - 4.5
    even = world(configurations__short__elongation_give=0.03)
    joint = world(configurations__short__elongation_joint_mm=0.03 * lever_mm / 3)
    loss = [
        MountedSheet(
            settings=w, configuration="short", position_m=0.02, scatter=Scatter()
        ).cell_force_per_m2(np.zeros(1))[0]
        for w in (even, joint, world())
    ]
    assert (loss[0] - loss[2]) == pytest.approx(loss[1] - loss[2], rel=0.05)
    assert abs(loss[0]) < abs(loss[2])


def test_drying_goes_on_in_any_form_and_is_the_same_after_a_minute() -> None:
    changes = []
    for form in ("line", "root", "exp"):
        setup = MountedSheet(
            settings=world(water__drying_form=form),
            configuration="short",
            position_m=0.0,
            scatter=Scatter(),
        )
        from sim_hardware.world.mechanics import Stage

        values = Stage(start_s=0.0, setup=setup).stiffening(np.array([0.0, 10.0, 60.0])) - 1
        assert values[0] == 0.0
        changes.append(values[1:])
    early, late = np.array(changes).T
    assert late == pytest.approx(late[0], rel=1e-9)
    assert early[0] < early[1] < early[2]  # with drying_s = 8 s the last is all but over at 10 s


@pytest.mark.slow
def test_a_slow_share_of_the_moment_comes_late_and_tiredness_stays() -> None:
    slow = one(
        world(eibm__relaxation=-0.5, eibm__relaxation_s=0.5),
        Visit(configuration="short", position_m=0.0),
    )
    plain = one(world(), Visit(configuration="short", position_m=0.0))
    swing = [forces_mN(r, 2.0)[-1] - forces_mN(r, -2.0)[-1] for r in (slow, plain)]
    assert swing[0] > swing[1]
    from sim_hardware.world import timed_session

    tired = timed_session(
        world(water__tiring_per_min=1.0),
        [Visit(configuration="short", position_m=0.0)] * 2,
        train=LONG_REST,
    )
    plain_2 = timed_session(
        world(), [Visit(configuration="short", position_m=0.0)] * 2, train=LONG_REST
    )
    lost = [
        1 - np.ptp([forces_mN(a, v)[-1] for v in (2, -2)])
        / np.ptp([forces_mN(b, v)[-1] for v in (2, -2)])
        for a, b in zip(tired, plain_2, strict=True)
    ]  # fmt: skip
    assert 0.02 < lost[0] < lost[1]


def test_the_cell_warms_beats_and_hears_its_cables() -> None:
    settings = world(
        load_cell__warming_mN=2.0, load_cell__warming_s=100.0, load_cell__warming_form="root",
        load_cell__cable_mN=0.9, load_cell__pickup_mN=0.4,
    )  # fmt: skip
    cell = SimulatedLoadCell(settings.load_cell, 1)
    assert cell.zero_N(np.array([0.0, 25.0, 100.0])) * 1e3 == pytest.approx([0.0, 1.0, 2.0])
    assert cell.stray_N(0.01, np.array([0.0, 2.0, -2.0])) * 1e3 == pytest.approx([0.1, 0.5, -0.3])
    beating = SimulatedLoadCell(world(load_cell__beat_mN=0.3).load_cell, 1)
    assert beating.zero_N(np.array([3.7 / 4])) * 1e3 == pytest.approx([0.3])


def test_the_stage_errs_as_it_is_told_to() -> None:
    arc = world(arc__scale_error=0.01, arc__screw_mm=0.2, arc__slip_mm=0.5).arc
    assert arc.reached_m(0.0) == 0.0
    assert arc.reached_m(0.003) == pytest.approx(3.03e-3 + 0.2e-3)
    assert arc.reached_m(0.021) == pytest.approx(21.21e-3 + 0.5e-3 - 0.2e-3, abs=1e-9)


def test_the_image_is_distorted_as_the_world_says() -> None:
    points = np.array([[0.0, 0.0], [0.05, 0.0], [0.035, 0.025]])
    assert load_world().view.seen(points) is points
    grown = world(view__scale_error=0.1, view__stretch=0.1).view.seen(points)
    assert grown[1] == pytest.approx([0.05 * 1.21, 0.0])
    turned = world(view__perspective_x=0.1).view.seen(points)
    assert turned[1] == pytest.approx([0.055, 0.0])
    rolled = world(view__roll_rad=0.1).view.seen(points)
    assert rolled[1] == pytest.approx([0.05 * np.cos(0.1), 0.05 * np.sin(0.1)])
    dented = world(view__dent_mm=0.5).view.seen(points)
    assert dented[2] - points[2] == pytest.approx([0.0, 0.5e-3])
    assert dented[0] == pytest.approx([0.0, 0.0], abs=1e-6)
