"""What no sheet, drive or rig is: one sentence each."""

from __future__ import annotations

import numpy as np
import pytest

from model import ModelError
from model.dynamics import (
    UNDRIVEN,
    ContactSetup,
    ElectrodeLine,
    Elongation,
    FluidLoad,
    HeldVoltage,
    Resolution,
    Simulation,
    Viscoelasticity,
    fluid_load,
    simulate,
)
from model.mechanics.field import Field
from tests.model.dynamics.cases import CURVED, B, R, driven, plain

GOOD = {"electrode_ohm_per_m": 4e3, "capacitance_F_per_m": 0.3, "bulk_ohm_m": 0.5}
CELL = ContactSetup(radius_m=R, position_m=0.0)
BAD = {
    "bending stiffness must be positive": lambda: Viscoelasticity(B_Nm2=0.0),
    "shares of a Prony series must be positive": lambda: Viscoelasticity(
        B_Nm2=B, shares=(-0.1,), times_s=(1.0,)
    ),
    "times of a Prony series must be positive": lambda: Viscoelasticity(
        B_Nm2=B, shares=(0.1,), times_s=(0.0,)
    ),
    "as many times as shares": lambda: Viscoelasticity(B_Nm2=B, shares=(0.1,)),
    "viscous time must be zero or positive": lambda: Viscoelasticity(B_Nm2=B, viscous_time_s=-1e-3),
    "mass per length must be positive": lambda: plain(mass_per_length_kg_per_m=0.0),
    "free length must be positive": lambda: plain(length_m=-0.05),
    "must end where the sheet's free length ends": lambda: plain(Field.constant(0.0, 0.04)),
    "moment per volt must be a finite number": lambda: driven(moment_per_volt_Nm=(np.nan, 0.0)),
    "added mass and drag": lambda: FluidLoad(added_mass_kg_per_m=-1.0),
    "must be positive": lambda: fluid_load(0.011, 1000.0, 0.0, 1.0),
    "resistance of the electrodes must be positive": lambda: ElectrodeLine(
        **GOOD | {"electrode_ohm_per_m": 0.0}
    ),
    "capacitance of the double layer must be positive": lambda: ElectrodeLine(
        **GOOD | {"capacitance_F_per_m": -0.3}
    ),
    "leak must be zero or positive": lambda: ElectrodeLine(**GOOD, leak_S_per_m=-0.1),
    "finite numbers": lambda: ElectrodeLine(**GOOD, leak_S_per_m=np.nan),
    "elongation's mass at the end": lambda: Elongation(length_m=0.04, end_mass_kg=-1.0),
    "arc's radius must be positive": lambda: ContactSetup(radius_m=0.0, position_m=0.0),
    "resonance must be positive": lambda: ContactSetup(
        radius_m=R, position_m=0.0, resonance_hz=0.0
    ),
    "as many voltages as times": lambda: HeldVoltage(np.zeros(2), np.zeros(1)),
    "times of a drive must ascend": lambda: HeldVoltage(np.array([1.0, 0.5]), np.zeros(2)),
    "times and voltages of a drive must be finite": lambda: HeldVoltage(
        np.zeros(1), np.array([np.inf])
    ),
    "step must be positive": lambda: Resolution(step_s=0.0),
    "rho must be between": lambda: Resolution(rho=1.5),
    "position must be a finite number at each time": lambda: simulate(
        plain(CURVED), ContactSetup(radius_m=R, position_m=lambda t: t / 0.0), UNDRIVEN, np.ones(1)
    ),
    "cannot be reached": lambda: simulate(
        plain(), ContactSetup(radius_m=R, position_m=0.06), UNDRIVEN, np.ones(1)
    ),
    "only a free sheet can be released": lambda: simulate(
        plain(), CELL, UNDRIVEN, np.ones(1), released_from=CURVED
    ),
    "needs the sheet's electrodes": lambda: simulate(
        plain(moment_per_volt_Nm=(B, B)), None, UNDRIVEN, np.ones(1)
    ),
    "times of a motion must be finite and ascend": lambda: simulate(
        plain(), None, UNDRIVEN, np.array([1.0, 0.5])
    ),
    "cannot go back": lambda: simulate(plain(), None, UNDRIVEN, np.array([-1.0])),
    "points along the sheet must lie within": lambda: simulate(
        plain(), None, UNDRIVEN, np.ones(1), s_m=np.array([0.06])
    ),
}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of the test's own division by zero
@pytest.mark.parametrize("sentence", list(BAD))
def test_what_cannot_be_is_refused_in_a_sentence(sentence):
    with pytest.raises(ModelError, match=sentence) as caught:
        BAD[sentence]()
    assert "\n" not in str(caught.value)


def test_a_sheet_that_is_pulled_out_of_the_rolls_is_reported():
    away = ContactSetup(radius_m=R, position_m=lambda t: 0.02 + 0.05 * t)
    times = np.linspace(0.0, 1.0, 11)
    one = Simulation(plain(CURVED), away, UNDRIVEN)
    motion = one.advance(UNDRIVEN, times)
    assert motion.slipped_s == pytest.approx(0.6, abs=0.2)
    before = times < motion.slipped_s
    assert np.all(np.isfinite(motion.force_N[before]))
    assert np.all(np.isnan(motion.force_N[~before]))
    after = one.advance(UNDRIVEN, np.array([1.5]))
    assert after.slipped_s == motion.slipped_s
    assert np.isnan(after.force_N[0])
