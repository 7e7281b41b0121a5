"""Speak to one piece of hardware each; know nothing of protocols.

Nothing slow is imported here: vendor packages are, where they are used.
"""

from drivers.amplifier import Amplifier, SheetDrive
from drivers.boards.ni.analog_input import InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection, NiDevice
from drivers.boards.ni.interlock import NiInterlock
from drivers.boards.ni.take_over import OutputPlace, take_over
from drivers.cameras.choice import camera_for
from drivers.cameras.opencv import OpenCvCamera
from drivers.force_sensors.calibration import CalibrationFit, fit_calibration
from drivers.force_sensors.dpm3 import Dpm3Meter
from drivers.force_sensors.load_cell import LoadCell, LoadCellCalibration, LoadCheck, LoadState
from drivers.guard import Guard, GuardSettings
from drivers.positioners.manual import ManualStage
from drivers.positioners.zaber import ZaberStage
from drivers.safe_shutdown import Safety, SafetyReport, make_safe

__all__ = [
    "Amplifier",
    "CalibrationFit",
    "Dpm3Meter",
    "Guard",
    "GuardSettings",
    "InputChannel",
    "LoadCell",
    "LoadCellCalibration",
    "LoadCheck",
    "LoadState",
    "ManualStage",
    "NiConnection",
    "NiDevice",
    "NiInterlock",
    "NiSignalInput",
    "NiVoltageOutput",
    "OpenCvCamera",
    "OutputPlace",
    "Safety",
    "SafetyReport",
    "SheetDrive",
    "ZaberStage",
    "camera_for",
    "fit_calibration",
    "make_safe",
    "take_over",
]
