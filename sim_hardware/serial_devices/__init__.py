"""Simulated serial devices, and the ports they can hang on."""

from sim_hardware.serial_devices.in_memory import InMemorySerial
from sim_hardware.serial_devices.meter import SimulatedDpm3Meter
from sim_hardware.serial_devices.pty_port import PtyPort
from sim_hardware.serial_devices.stage import SimulatedZaberStage
from sim_hardware.serial_devices.wire import SerialDevice, SerialFaults

__all__ = [
    "InMemorySerial",
    "PtyPort",
    "SerialDevice",
    "SerialFaults",
    "SimulatedDpm3Meter",
    "SimulatedZaberStage",
]
