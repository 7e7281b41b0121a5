"""Speak to one piece of hardware each; know nothing of protocols.

A part is found in its folder: `BOARD_FAMILIES.get("ni")`. Each name below is loaded when it is
first used, and vendor packages where they are used, so that a program starts fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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
_HOMES = {
    "BOARD_FAMILIES": "boards",
    "CAMERAS": "cameras",
    "FORCE_SENSORS": "force_sensors",
    "POSITIONERS": "positioners",
    "Amplifier": "amplifier",
    "CalibrationFit": "load_cell_fit",
    "Guard": "guard",
    "GuardSettings": "guard",
    "LoadCell": "load_cell",
    "LoadCellCalibration": "load_cell",
    "LoadCheck": "load_cell",
    "LoadState": "load_cell",
    "Safety": "safe_shutdown",
    "SafetyReport": "safe_shutdown",
    "SheetDrive": "amplifier",
    "fit_calibration": "load_cell_fit",
    "make_safe": "safe_shutdown",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'drivers' has no attribute {name!r}")
    return getattr(import_module(f"drivers.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return list(__all__)
