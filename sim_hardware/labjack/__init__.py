"""A simulated LabJack T4, T7 or T8, at the wire: Modbus TCP, register map, stream, watchdog."""

from sim_hardware.labjack.device import SimulatedLabJack
from sim_hardware.labjack.faults import LabJackFaults
from sim_hardware.labjack.models import SIMULATED_MODELS, SimulatedModel
from sim_hardware.labjack.server import LabJackServer

__all__ = [
    "SIMULATED_MODELS",
    "LabJackFaults",
    "LabJackServer",
    "SimulatedLabJack",
    "SimulatedModel",
]
