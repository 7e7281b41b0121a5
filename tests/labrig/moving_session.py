"""A small session recorded in a moving world whose set-ups do not scatter, and its true sheet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from labrig.cli.main import run
from labrig.config.templates import write_templates
from model.dynamics import DynamicBeam, ElectrodeLine, Viscoelasticity
from model.dynamics.fluid import fluid_load
from model.mechanics.field import Field
from tests.made_once import made_once

B = 150e6 * 0.011 * 0.21e-3**3 / 12
WORLD = """
moving = true
[eibm]
saturation_V = 1e6
[water]
first_pulse_deficit = 0.0
stiffening_per_min = 0.0
weakening_per_min = 0.0
[scatter]
eibm = 0.0
stiffness = 0.0
position_mm = 0.0
"""
PROTOCOL = """
[pulse_train]
zero_readings = 2
pulses_discarded = 0
readings_per_voltage = 2
[[places]]
configuration = "long"
positions_mm = [5]
[extras]
random_order = false
free_shapes = false
reversed_approach = false
remounts = 0
[extras.release]
voltages_V = [1.0]
rest_s = 1.0
swing_s = 1.2
"""
TRUTH = DynamicBeam(  # what world.toml says of the long sheet
    length_m=0.05, mass_per_length_kg_per_m=2500 * 0.011 * 0.21e-3,
    material=Viscoelasticity(
        B_Nm2=B, shares=(0.15, 0.10), times_s=(0.02, 0.3), viscous_time_s=0.2e-3
    ),
    rest=Field.smooth(lambda s: 24 * np.exp(-s / 0.04), 0.05),
    fluid=fluid_load(0.011, 1.2, 1.82e-5, 3.32, drag_coefficient=2.0),
    electrodes=ElectrodeLine(
        electrode_ohm_per_m=4000.0, capacitance_F_per_m=0.3, bulk_ohm_m=0.5, leak_S_per_m=0.1,
        source_ohm=1.0,
    ),
    moment_per_volt_Nm=(30.0 * B, 24.0 * B),
)  # fmt: skip


def record(folder: Path, protocol: str = PROTOCOL, rig: tuple[str, str] = ("", "")) -> Path:
    """Return the session of a protocol; of rig.toml one text is replaced by another."""
    write_templates(folder, simulated=True)
    text = (folder / "rig.toml").read_text()
    assert rig[0] in text
    (folder / "rig.toml").write_text(text.replace(*rig))
    (folder / "world.toml").write_text(WORLD)
    (folder / "protocol.toml").write_text(protocol)
    files = [str(folder / name) for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    path = folder / "session.h5"
    assert run(["run", "-o", str(path), "--yes", *files]) == 0
    return path


def moving_session(factory: pytest.TempPathFactory) -> Path:
    """Return the session; leave it as it is."""
    return made_once(factory, "moving-session", record) / "session.h5"
