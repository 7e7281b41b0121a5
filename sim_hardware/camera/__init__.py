"""The simulated camera: as an object on any clock, and on the network in real time."""

from sim_hardware.camera.capture import SimulatedCapture
from sim_hardware.camera.faults import CameraFaults, from_frame
from sim_hardware.camera.server import CameraServer

__all__ = ["CameraFaults", "CameraServer", "SimulatedCapture", "from_frame"]
