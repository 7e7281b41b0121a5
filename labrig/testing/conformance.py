"""The conformance function of each kind of part, under one name each."""

from __future__ import annotations

from drivers.boards.contract import faults as board_faults
from drivers.cameras.contract import faults as camera_faults
from drivers.force_sensors.contract import faults as force_sensor_faults
from drivers.positioners.contract import faults as positioner_faults
from labrig.cli.command import faults as command_faults
from labrig.extractors.conformance import faults as extractor_faults
from labrig.extractors.conformance import faults_of_curve as curve_faults
from labrig.panel.pages.conformance import faults as page_faults
from labrig.report.sections.conformance import content_faults as section_content_faults
from labrig.report.sections.conformance import faults as section_faults
from model.effects.conformance import faults as effect_faults
from protocols.kinds.conformance import faults as protocol_faults
from sim_hardware.ni.boards import faults as simulated_board_faults
from sim_hardware.serial_devices.contract import faults as simulated_serial_device_faults

__all__ = [
    "board_faults",
    "camera_faults",
    "command_faults",
    "curve_faults",
    "effect_faults",
    "extractor_faults",
    "force_sensor_faults",
    "page_faults",
    "positioner_faults",
    "protocol_faults",
    "section_content_faults",
    "section_faults",
    "simulated_board_faults",
    "simulated_serial_device_faults",
]
