"""What a world can carry beside the ideal sheet does what its words say."""

from __future__ import annotations

import numpy as np
import pytest

from sim_hardware.world import WorldSettings, load_world, reduced_session
from sim_hardware.world.setup import MountedSheet, Scatter


def changed(path: str, value: float) -> WorldSettings:
    """The shipped world with one key changed; NAME stands for both configurations."""
    content = load_world().model_dump()
    for name in ("long", "short") if "NAME" in path else ("",):
        *tables, key = path.replace("NAME", name).split(".")
        table = content
        for part in tables:
            table = table[part]
        table[key] = value
    return WorldSettings.model_validate(content)


def force_mN(settings: WorldSettings, configuration: str, position_m: float, drive: float) -> float:
    setup = MountedSheet(
        settings=settings, configuration=configuration, position_m=position_m, scatter=Scatter()
    )
    force = setup.stiffness_Nm2 * setup.cell_force_per_m2(np.array([drive]))[0]
    return float(force) * 1e3


CASES = [
    # key, value, configuration, position in m, drive, sign of the change of force
    ("gravity_N_per_m", 0.01, "long", 0.0, 0.0, -1),
    ("clamp.tilt_rad", 0.02, "long", 0.0, 0.0, 1),
    ("clamp.tilt_rad", -0.02, "short", 0.03, -0.8, -1),
    ("clamp.compliance_mrad_per_Nmm", 100.0, "long", 0.03, 0.0, 1),
    ("clamp.compliance_mrad_per_Nmm", 100.0, "short", 0.0, 1.0, -1),
    ("configurations.NAME.stiffness_change", 0.2, "long", 0.0, 0.0, 1),
    ("configurations.NAME.stiffness_change", -0.2, "long", 0.03, 0.0, 1),
    ("configurations.NAME.stiffening", 0.5, "long", 0.0, 0.0, 1),
    ("configurations.NAME.elongation_give", 0.01, "short", 0.0, 1.0, -1),
    ("configurations.NAME.rest_curvature_per_m", 30.0, "long", 0.0, 0.0, 1),
    ("arc.origin_deg", 1.0, "short", 0.0, 0.0, -1),
    ("load_cell.compliance_mm_per_mN", 0.1, "short", 0.0, 1.0, -1),
    ("load_cell.compliance_mm_per_mN", 0.1, "long", 0.03, 0.0, 1),
    ("load_cell.misalignment_deg", 5.0, "long", 0.03, 0.0, -1),
    ("rolls.offset_mm", 1.0, "long", 0.0, 0.0, 1),
    ("eibm.decay_mm", 20.0, "long", 0.0, 1.0, 1),
]


@pytest.mark.parametrize(("key", "value", "configuration", "position_m", "drive", "sign"), CASES)
def test_an_effect_moves_the_force_the_way_it_should(
    key: str, value: float, configuration: str, position_m: float, drive: float, sign: int
) -> None:
    ideal = force_mN(load_world(), configuration, position_m, drive)
    other = force_mN(changed(key, value), configuration, position_m, drive)
    assert sign * (other - ideal) > 2e-3
    # Small causes: a tenth of it makes about a tenth of the change.
    was = force_mN(load_world(), configuration, position_m, drive)
    old = load_world().model_dump()
    for part in key.replace("NAME", configuration).split("."):
        old = old[part]
    tenth = force_mN(changed(key, old + (value - old) / 10), configuration, position_m, drive)
    assert (tenth - was) / (other - ideal) == pytest.approx(0.1, abs=0.035)


def test_a_clamp_that_hardly_gives_way_is_rigid_and_one_that_gives_freely_takes_no_moment() -> None:
    stiff = force_mN(changed("clamp.compliance_mrad_per_Nmm", 1e-3), "long", 0.0, 0.0)
    soft = force_mN(changed("clamp.compliance_mrad_per_Nmm", 1e5), "long", 0.0, 0.0)
    rigid = force_mN(load_world(), "long", 0.0, 0.0)
    assert stiff == pytest.approx(rigid, rel=1e-5)
    # A cantilever of 3 B / R^3 = 60 mN/m in series with a hinge of 10 uN m/rad, over 40 mm: the
    # hinge alone gives 6 mN/m.
    assert soft == pytest.approx(rigid / (1 + 60 / 6.25), rel=0.1)


def test_water_between_sheet_and_rolls_adds_its_force() -> None:
    plain = reduced_session(load_world(), 2, positions_m=(0.01,))
    wet = reduced_session(changed("rolls.meniscus_mN", 0.2), 2, positions_m=(0.01,))
    for a, b in zip(plain.conditions, wet.conditions, strict=True):
        assert b.true_force_N - a.true_force_N == pytest.approx(0.2e-3, rel=1e-9)
        assert np.mean(b.forces_N) - np.mean(a.forces_N) == pytest.approx(0.2e-3, rel=1e-3)


def test_gravity_lets_the_free_sheet_hang_down() -> None:
    heavy, light = changed("gravity_N_per_m", 0.02), load_world()
    tips = [
        s.chain.curve(s.free.state(0.0).phi_rad, np.array([0.05]))[0, 1]
        for s in (
            MountedSheet(
                settings=settings, configuration="long", position_m=None, scatter=Scatter()
            )
            for settings in (heavy, light)
        )
    ]
    assert -0.02 < tips[0] - tips[1] < -1e-3


def test_the_reduced_session_and_the_table_agree_on_a_yielding_cell() -> None:
    settings = changed("load_cell.compliance_mm_per_mN", 0.2)
    none = {"eibm": 0.0, "stiffness": 0.0, "position_mm": 0.0}
    settings = settings.model_copy(update={"scatter": settings.scatter.model_copy(update=none)})
    session = reduced_session(settings, 1, ("long",), (0.0,), (0.0, 2.0))
    for condition in session.conditions:
        drive = settings.eibm.settled(condition.voltage_V + 0.01)
        assert condition.true_force_N * 1e3 == pytest.approx(
            force_mN(settings, "long", 0.0, drive), abs=1e-6
        )
