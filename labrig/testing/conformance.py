"""The conformance function of each kind of part, under one name each."""

from __future__ import annotations

from drivers.boards.conformance import (
    family_faults,
    interlock_faults,
    output_faults,
    rescue_faults,
    signal_faults,
)
from drivers.boards.contract import faults as board_family_faults
from drivers.cameras.conformance import camera_faults
from drivers.cameras.contract import faults as camera_kind_faults
from drivers.force_sensors.conformance import force_sensor_faults
from drivers.force_sensors.contract import faults as force_sensor_kind_faults
from drivers.positioners.conformance import positioner_faults
from drivers.positioners.contract import faults as positioner_kind_faults
from labrig.cli.command import faults as command_faults

__all__ = [
    "board_family_faults",
    "camera_faults",
    "camera_kind_faults",
    "command_faults",
    "family_faults",
    "force_sensor_faults",
    "force_sensor_kind_faults",
    "interlock_faults",
    "output_faults",
    "positioner_faults",
    "positioner_kind_faults",
    "rescue_faults",
    "signal_faults",
]
