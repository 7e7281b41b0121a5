"""The load cell's bridge on an input of the board; [load_cell] says what its volts mean."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.force_sensors.contract import ForceSensorKind


@dataclass(frozen=True)
class LoadCellSettings:
    """The input and the calibration have tables of their own."""


FORCE_SENSOR = ForceSensorKind(
    kind="load_cell",
    help="the load cell on the board's input `force`, by its calibration",
    settings=LoadCellSettings,
)
