"""Speak to one piece of hardware each; know nothing of protocols.

Nothing slow is imported here: vendor packages are, where they are used. A part is found in its
folder: `BOARD_FAMILIES.get("ni")`.
"""

from drivers.amplifier import Amplifier, SheetDrive
from drivers.boards import BOARD_FAMILIES
from drivers.cameras import CAMERAS
from drivers.force_sensors import FORCE_SENSORS
from drivers.guard import Guard, GuardSettings
from drivers.load_cell import LoadCell, LoadCellCalibration, LoadCheck, LoadState
from drivers.load_cell_fit import CalibrationFit, fit_calibration
from drivers.positioners import POSITIONERS
from drivers.safe_shutdown import Safety, SafetyReport, make_safe

__all__ = [
    "BOARD_FAMILIES",
    "CAMERAS",
    "FORCE_SENSORS",
    "POSITIONERS",
    "Amplifier",
    "CalibrationFit",
    "Guard",
    "GuardSettings",
    "LoadCell",
    "LoadCellCalibration",
    "LoadCheck",
    "LoadState",
    "Safety",
    "SafetyReport",
    "SheetDrive",
    "fit_calibration",
    "make_safe",
]
