"""A simulated NI gRPC Device Server and the boards behind it."""

from sim_hardware.ni.boards import BoardModel, board_models
from sim_hardware.ni.faults import Faults
from sim_hardware.ni.transport.device_server import NiDeviceServer
from sim_hardware.ni.transport.loopback import LoopbackWires
from sim_hardware.port_taken import PortTakenError

__all__ = [
    "BoardModel",
    "Faults",
    "LoopbackWires",
    "NiDeviceServer",
    "PortTakenError",
    "board_models",
]
