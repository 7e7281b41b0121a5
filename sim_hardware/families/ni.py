"""NI boards behind a simulated NI gRPC Device Server."""

from __future__ import annotations

from typing import Any

from drivers.interfaces import Clock
from sim_hardware.families.contract import BoardOptions, SimulatedFamily, Switch, switch_of
from sim_hardware.ni import NiDeviceServer
from sim_hardware.rig_boards import boards_of
from sim_hardware.world import World
from sim_hardware.world.settings import Signal

_GONE, _RESERVED = -200324, -50103
_RESERVING = ("TaskControl", "StartTask")


class NiBoardsOfWorld:
    """The boards that a world names, wired to it."""

    def __init__(self, world: World, server: NiDeviceServer) -> None:
        self._world = world
        self.server = server

    def transport(self) -> Any:
        """See `SimulatedBoards.transport`: a grpc.Channel."""
        return self.server.in_process_channel()

    def listen(self, port: int) -> int:
        """See `SimulatedBoards.listen`."""
        return self.server.listen(port)

    def stop(self) -> None:
        """See `SimulatedBoards.stop`."""
        self.server.stop()

    def fault(self, what: str, amount_s: float) -> Switch:
        """See `SimulatedBoards.fault`."""
        name, on, off = self._fault(what, amount_s)
        return switch_of(self.server.faults, name, on=on, off=off)

    def _fault(self, what: str, amount_s: float) -> tuple[str, object, object]:
        def wired(signal: Signal) -> set[str]:
            return self._world.settings.wiring.terminals(signal, self.server.device_names)

        known: dict[str, tuple[str, object, object]] = {
            "daq_refused": ("unavailable", True, False),
            "daq_slow": ("delay_s", amount_s, 0.0),
            "daq_buffer_overflow": ("lose_after_reads", 0, None),
            "daq_hung": ("hang", {"*"}, set()),
            "daq_read_hung": ("hang", {"ReadAnalogF64"}, set()),
            "daq_write_refused": ("refuse", {"WriteAnalogScalarF64": _GONE}, {}),
            "daq_reserved": ("refuse", dict.fromkeys(_RESERVING, _RESERVED), {}),
            "output_stuck": ("stuck_outputs", wired("drive"), set()),
            "output_underflow": ("underflow", True, False),
            "force_nan": ("nan", wired("force"), set()),
            "drive_nan": ("nan", wired("readback"), set()),
        }
        return known[what]


def _make(world: World, clock: Clock, options: BoardOptions) -> NiBoardsOfWorld:
    server = boards_of(
        world,
        clock,
        options.devices or None,
        options.driver_version,
        strict_ownership=options.strict_ownership,
    )
    return NiBoardsOfWorld(world, server)


FAMILY = SimulatedFamily(kind="ni", served_as="grpc", make=_make)
