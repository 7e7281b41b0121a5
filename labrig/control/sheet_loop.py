"""From a model file to a linear model of the sheet on its rolls, and to controller.toml."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from labrig.config import load_load_cell, load_rig, read_text
from labrig.config.rig import ReplayConfig, RigConfig
from labrig.control.controller_file import (
    ControlledRig,
    ControlledSheet,
    ControllerConfig,
    ControllerLimits,
    DesignedFor,
    LawMatrices,
    PlantMatrices,
    StepPrediction,
    checksum_of,
    rig_checksum,
)
from labrig.errors import BadInputError
from labrig.model_file import load_model, moving_configuration
from model import ModelError
from model.measurements import SheetGeometry

if TYPE_CHECKING:
    from model.dynamics.linear.feedback import Method
    from model.dynamics.linear.loop_design import LoopDesign
    from model.dynamics.linear.state_space import LinearSystem

_DEGREES, _FREE_DEGREES = (10, 4), 12  # polynomials: 1e-5 up to 100 Hz
DEFAULT_LIMIT_V = 2.0


@dataclass(frozen=True)
class LinearSheet:
    """A configuration about rest at 0 V, on its rolls or free."""

    sheet: SheetGeometry
    position_m: float | None
    system: LinearSystem  # force_N as the load cell reads it, tip_m, current_A


@dataclass(frozen=True, kw_only=True)
class LoopGoal:
    """What is wanted of a controller."""

    method: Method
    rate_hz: float
    delay_s: float
    limit_V: float = DEFAULT_LIMIT_V
    step_N: float = 1e-3


def linear_sheet(path: Path, configuration: str | None, position_m: float | None) -> LinearSheet:
    """Return the linear model of a model file's configuration. Raises BadInputError."""
    from model.dynamics.beam import HeldVoltage
    from model.dynamics.linear.linear_model import linear_model, read_by
    from model.dynamics.linearised import linearise
    from model.dynamics.motion import Resolution, Simulation

    model = load_model(path)
    name = moving_configuration(model, path, configuration)
    drive = HeldVoltage(np.zeros(1), np.zeros(1))
    by = Resolution(degrees=_DEGREES, free_degrees=_FREE_DEGREES)
    try:
        beam, rolls = model.moving(name, position_m)
        system = linear_model(linearise(Simulation(beam, rolls, drive, resolution=by)))
        if rolls is not None and np.isfinite(rolls.resonance_hz):
            system = read_by(system, rolls.resonance_hz, rolls.damping)
    except ModelError as error:
        raise BadInputError(f"{path}: {name}: {error}.") from None
    return LinearSheet(model.sheet(name).sheet, position_m, system)


def design_loop(sheet: LinearSheet, loop: LoopGoal, path: Path) -> LoopDesign:
    """Return a controller of the force. Raises BadInputError, which names the model's file."""
    from model.dynamics.linear.loop_design import designed

    try:
        return designed(
            sheet.system.output("force_N"),
            loop.method,
            rate_hz=loop.rate_hz,
            delay_s=loop.delay_s,
            limit_V=loop.limit_V,
            step_N=loop.step_N,
        )
    except ModelError as error:
        raise BadInputError(f"{path}: {error}.") from None


def controller_config(
    sheet: LinearSheet, loop: LoopGoal, made: LoopDesign, model: Path, rig: Path | None
) -> ControllerConfig:
    """Return what controller.toml holds; `rig`: the rig that it is for, if it is for one only."""
    assert sheet.position_m is not None  # noqa: S101 - for the type checker
    return ControllerConfig(
        labrig_controller=1,
        method=loop.method,
        output="force",
        configuration=sheet.sheet.configuration,
        position_mm=round(1e3 * sheet.position_m, 9),
        rate_hz=loop.rate_hz,
        delay_ms=round(1e3 * loop.delay_s, 9),
        limits=ControllerLimits(voltage_V=loop.limit_V),
        model=DesignedFor(file=model.name, sha256=checksum_of(read_text(model))),
        sheet=ControlledSheet.of(sheet.sheet),
        rig=None if rig is None else ControlledRig(sha256=_checksum_of_rig(rig)),
        prediction=_prediction(made),
        law=LawMatrices.of(made.controller),
        plant=PlantMatrices.of(made.plant, loop.rate_hz),
    )


def rig_limit_V(rig: Path) -> float:
    """Return the largest sheet voltage of a rig."""
    return _rig(rig).limits.sheet_voltage_V


def _checksum_of_rig(rig: Path) -> str:
    config = _rig(rig)
    return rig_checksum(config, load_load_cell(config.load_cell.calibration))


def _rig(path: Path) -> RigConfig:
    config = load_rig(path)
    if isinstance(config, ReplayConfig):
        raise BadInputError(f"{path}: this rig is a recorded session, which obeys no controller.")
    return config


def _prediction(made: LoopDesign) -> StepPrediction | None:
    """Return what the linear model says of a step; None where the force never arrives."""
    step = made.step
    if np.isnan(step.settled_s) or np.isnan(step.rise_s):
        return None
    return StepPrediction(
        sensitivity_peak=made.sensitivity_peak,
        step_mN=1e3 * step.step_N,
        rise_s=step.rise_s,
        settled_s=step.settled_s,
    )
