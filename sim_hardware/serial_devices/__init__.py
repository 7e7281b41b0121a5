"""Simulated serial devices, one file each, and the ports at which they answer."""

from sim_hardware.plugins import PluginFolder
from sim_hardware.serial_devices.contract import SerialDevice, SimulatedSerial, faults
from sim_hardware.serial_devices.dpm3 import SimulatedDpm3Meter
from sim_hardware.serial_devices.in_memory import InMemorySerial
from sim_hardware.serial_devices.pty_port import PtyPort
from sim_hardware.serial_devices.wire import SerialFaults
from sim_hardware.serial_devices.zaber import SimulatedZaberStage

FOLDER: PluginFolder[SimulatedSerial] = PluginFolder(
    what="simulated serial device",
    package="sim_hardware.serial_devices",
    constant="SERIAL_DEVICE",
    group="labrig.simulated_serial_devices",
    faults=faults,
)

__all__ = [
    "FOLDER",
    "InMemorySerial",
    "PtyPort",
    "SerialDevice",
    "SerialFaults",
    "SimulatedDpm3Meter",
    "SimulatedSerial",
    "SimulatedZaberStage",
    "faults",
]
