"""load_cell.toml: a dated calibration with dead weights."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field, model_validator

from drivers.load_cell import GSO_10_CAPACITY_N, LoadCellCalibration
from labrig.config.base import ClosedModel, parse_toml, read_text, validate
from labrig.config.file_kinds import LOAD_CELL, refuse_other_kind

FORCE_UNIT = "force_channel_unit"  # key of the resolved configuration: V, or N where a meter reads


class LoadCellConfig(ClosedModel):
    """volts = offset_V + sensitivity_V_per_N * force, of the whole chain as wired on `date`."""

    date: dt.date = Field(description="when it was calibrated")
    capacity_mN: float = Field(GSO_10_CAPACITY_N * 1000, gt=0, description="GSO-10: 98.07 mN")
    sensitivity_V_per_N: float = Field(description="volts at the input for a newton")
    sensitivity_sigma_V_per_N: float = Field(0.0, ge=0, description="standard uncertainty of it")
    offset_V: float = Field(0.0, description="volts at the input without a force")
    offset_sigma_V: float = Field(0.0, ge=0, description="standard uncertainty of it")
    excitation_V: float = Field(10.0, gt=0, description="supply of the bridge")
    gain: float = Field(1.0, description="of the amplifier behind the bridge, for the record")
    serial: str = Field("", description="serial number of the load cell, for the record")

    @model_validator(mode="after")
    def _has_a_slope(self) -> LoadCellConfig:
        if self.sensitivity_V_per_N == 0:
            raise ValueError("sensitivity_V_per_N must not be 0")
        return self

    def calibration(self) -> LoadCellCalibration:
        """As `drivers` takes it."""
        values = self.model_dump(exclude={"capacity_mN"})
        return LoadCellCalibration(capacity_N=self.capacity_mN / 1000, **values)


def parse_load_cell(text: str, name: str) -> LoadCellCalibration:
    """load_cell.toml's text as a calibration."""
    refuse_other_kind(text, name, LOAD_CELL)
    return validate(LoadCellConfig, parse_toml(text, name), name).calibration()


def raw_force_unit(resolved: Mapping[str, Any]) -> str:
    """Return the unit of a session's raw samples of the force: V, or N where a meter read it."""
    return "N" if resolved.get(FORCE_UNIT) == "N" else "V"


def recorded_calibration(text: str, name: str, resolved: Mapping[str, Any]) -> LoadCellCalibration:
    """Return what a session's channel `force` means: volts of the cell, or a meter's newtons.

    `text` is the session's load_cell.toml, `resolved` its configuration as understood.
    """
    calibration = parse_load_cell(text, name)
    return calibration.in_newtons() if raw_force_unit(resolved) == "N" else calibration


def load_load_cell(path: Path) -> LoadCellCalibration:
    """Read load_cell.toml."""
    return parse_load_cell(read_text(path, LOAD_CELL), str(path))
