"""A simulated NI gRPC Device Server and the boards behind it."""

from sim_hardware.ni.boards.boards import BOARDS, BoardModel
from sim_hardware.ni.faults import Faults
from sim_hardware.ni.transport.device_server import NiDeviceServer
from sim_hardware.ni.transport.loopback import LoopbackBench
from sim_hardware.ni.transport.server import PortTakenError

__all__ = ["BOARDS", "BoardModel", "Faults", "LoopbackBench", "NiDeviceServer", "PortTakenError"]
