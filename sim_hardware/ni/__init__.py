"""A simulated NI gRPC Device Server and the boards behind it."""

from sim_hardware.ni.boards import BOARDS, Board
from sim_hardware.ni.device_server import NiDeviceServer
from sim_hardware.ni.faults import Faults
from sim_hardware.ni.loopback import LoopbackBench
from sim_hardware.ni.server import PortTakenError

__all__ = ["BOARDS", "Board", "Faults", "LoopbackBench", "NiDeviceServer", "PortTakenError"]
