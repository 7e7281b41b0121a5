"""The settings of a simulated world."""

from sim_hardware.world.settings.faults import FaultKind, FaultSettings
from sim_hardware.world.settings.rig import (
    AmplifierSettings,
    CellSettings,
    Signal,
    WiringSettings,
)
from sim_hardware.world.settings.world import WorldSettings

__all__ = [
    "AmplifierSettings",
    "CellSettings",
    "FaultKind",
    "FaultSettings",
    "Signal",
    "WiringSettings",
    "WorldSettings",
]
