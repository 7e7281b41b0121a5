"""A controller for a sheet that answers like a first-order lag, and its files."""

from pathlib import Path

import numpy as np

from labrig.config import load_sheet
from labrig.control.controller_file import (
    ControlledSheet,
    ControllerConfig,
    ControllerLimits,
    DesignedFor,
    LawMatrices,
    PlantMatrices,
    checksum_of,
    save_controller,
)
from model.dynamics.linear.feedback import pi
from model.dynamics.linear.state_space import LinearSystem, discretised

MODEL_TEXT = "labrig_model = 1\n"
GAIN_N_PER_V = 1.2e-3
LAG_S = 0.2
REFERENCE = "time_s,force_mN\n0,0\n0.5,0.5\n2,-0.3\n3,0\n4,0\n"


def lag(gain_N_per_V: float = GAIN_N_PER_V, time_s: float = LAG_S) -> LinearSystem:
    return LinearSystem(
        A=np.array([[-1 / time_s]]),
        B=np.array([[1 / time_s]]),
        C=np.array([[gain_N_per_V]]),
        D=np.zeros((1, 1)),
        inputs=("voltage_V",),
        outputs=("force_N",),
    )


def controller(
    sheet: Path,
    *,
    rate_hz: float = 100.0,
    position_mm: float = 5.0,
    plant: LinearSystem | None = None,
    **changes: object,
) -> ControllerConfig:
    """A PI controller of the long sheet."""
    sampled = discretised(plant or lag(), 1 / rate_hz, 0.005)
    found = pi(sampled, 1.3)
    values = {
        "labrig_controller": 1,
        "method": "pi",
        "output": "force",
        "configuration": "long",
        "position_mm": position_mm,
        "rate_hz": rate_hz,
        "delay_ms": 5.0,
        "limits": ControllerLimits(voltage_V=2.0, saturated_s=0.5),
        "model": DesignedFor(file="model.toml", sha256=checksum_of(MODEL_TEXT)),
        "sheet": ControlledSheet.of(load_sheet(sheet)["long"]),
        "law": LawMatrices.of(found),
        "plant": PlantMatrices.of(sampled, rate_hz),
    }
    return ControllerConfig(**{**values, **changes})


def write_control(folder: Path, reference: str = REFERENCE, **changes: object) -> list[object]:
    """Write controller.toml and force.csv beside a rig's files; return the options of a run."""
    save_controller(controller(folder / "sheet.toml", **changes), folder / "controller.toml")
    (folder / "force.csv").write_text(reference)
    return ["--controller", folder / "controller.toml", "--reference", folder / "force.csv"]
