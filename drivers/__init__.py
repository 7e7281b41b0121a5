"""Speak to one piece of hardware each; know nothing of protocols.

Nothing slow is imported here: vendor packages are, where they are used.
"""

from drivers.amplifier import Amplifier, SheetDrive
from drivers.camera import camera_for
from drivers.camera_opencv import OpenCvCamera
from drivers.dpm3 import Dpm3Meter
from drivers.guard import Guard, GuardSettings
from drivers.load_cell import LoadCell, LoadCellCalibration, LoadCheck, LoadState
from drivers.load_cell_fit import CalibrationFit, fit_calibration
from drivers.ni_connection import NiConnection, NiDevice
from drivers.ni_input import InputChannel, NiSignalInput
from drivers.ni_interlock import NiInterlock
from drivers.ni_output import NiVoltageOutput
from drivers.safe import Safety, SafetyReport, make_safe
from drivers.stage_manual import ManualStage
from drivers.stage_zaber import ZaberStage
from drivers.take_over import OutputPlace, take_over

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
