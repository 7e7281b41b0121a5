"""At rest the moving sheet is the static one."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from model.dynamics import (
    UNDRIVEN,
    ContactSetup,
    Elongation,
    PrescribedMoment,
    Resolution,
    Simulation,
    simulate,
)
from model.mechanics.field import Field
from tests.model.dynamics.cases import CURVED, REFERENCE, B, L, R, plain

NAME = "iv_v_vi_contact_constant_kappa_R40mm.csv"


def rows() -> list[dict[str, float]]:
    with (REFERENCE / NAME).open() as file:
        return [
            {k: float(v) for k, v in row.items() if k != "case"} for row in csv.DictReader(file)
        ]


def start(row: dict[str, float], resolution: Resolution) -> Simulation:
    length = row["l_mm"] * 1e-3
    beam = plain(
        Field.constant(row["kappa_star_1_per_mm"] * 1e3, length),
        length_m=length,
        elongation=Elongation(length_m=1.0),
    )
    setup = ContactSetup(radius_m=R, position_m=row["p_mm"] * 1e-3)
    return Simulation(beam, setup, UNDRIVEN, resolution=resolution)


@pytest.mark.slow
def test_the_force_is_the_static_one_with_the_break_at_the_contact():
    errors = []
    for row in rows():
        one = start(row, Resolution(degrees=(10, 3)))
        errors.append(abs(one.state.x[0] * R**2 / B / row["N_R2_over_B"] - 1.0))
        assert one.state.x[1] == pytest.approx(row["shat_mm"] * 1e-3, rel=1e-7)
    assert len(errors) == 58
    assert max(errors) < 1e-6


@pytest.mark.slow
def test_the_force_is_nearly_the_static_one_with_the_break_up_to_3_mm_away():
    errors = []
    for number, row in enumerate(rows()):
        s_hat, length = row["shat_mm"] * 1e-3, row["l_mm"] * 1e-3
        off = (-3e-3, -1e-3, 1e-3, 3e-3)[number % 4]
        if s_hat < length:
            one = start(row, Resolution(break_m=float(np.clip(s_hat + off, 0.02, 0.97 * length))))
            errors.append(abs(one.state.x[0] * R**2 / B / row["N_R2_over_B"] - 1.0))
    assert len(errors) > 15
    assert max(errors) < 5e-4


def test_a_sheet_at_rest_stays_at_rest():
    setup = ContactSetup(radius_m=R, position_m=0.01)
    motion = simulate(plain(CURVED), setup, UNDRIVEN, np.array([0.0, 0.1]))
    assert motion.force_N[1] == pytest.approx(motion.force_N[0], abs=1e-12)
    assert motion.y_m[1] == pytest.approx(motion.y_m[0], abs=1e-12)


def test_a_moment_that_is_there_at_the_start_bends_the_sheet():
    drive = PrescribedMoment(lambda t, s: B * 30.0 * np.exp(-s / 0.012) + 0.0 * t)
    free = simulate(plain(), None, drive, np.array([0.0, 0.05]), s_m=np.array([0.0, 0.01]))
    assert free.curvature_per_m[:, 1] == pytest.approx(30.0 * np.exp(-1 / 1.2), rel=1e-6)
    setup = ContactSetup(radius_m=R, position_m=0.0)
    bent = simulate(
        plain(Field.smooth(lambda s: 30.0 * np.exp(-s / 0.012), L)), setup, UNDRIVEN, np.zeros(1)
    )
    held = simulate(plain(), setup, drive, np.array([0.0, 0.05]))
    assert held.normal_N == pytest.approx(bent.normal_N[0], rel=1e-6)
