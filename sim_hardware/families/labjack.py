"""A LabJack T4, T7 or T8 on the network."""

from __future__ import annotations

from collections.abc import Callable

from drivers.interfaces import Clock
from sim_hardware.families.contract import BoardOptions, SimulatedFamily, Switch, switch_of
from sim_hardware.labjack import SIMULATED_MODELS, LabJackServer, SimulatedLabJack
from sim_hardware.labjack.server import InProcess
from sim_hardware.world import World, WorldError

_DEFAULT = {"T7": "T7"}
_INPUTS = {"force_nan": "force", "drive_nan": "readback"}
_OWNER = 46178


class LabJackOfWorld:
    """The device that a world names, wired to it."""

    def __init__(self, world: World, device: SimulatedLabJack) -> None:
        self._world = world
        self.device = device
        self.server: LabJackServer | None = None
        device.wired = lambda line, high, when: world.level(line, high=high, when=when)

    def transport(self) -> Callable[[], InProcess]:
        """See `SimulatedBoards.transport`: what opens a connection."""
        return lambda: InProcess(self.device)

    def listen(self, port: int) -> int:
        """See `SimulatedBoards.listen`."""
        self.server = LabJackServer(self.device, port)
        return self.server.port

    def stop(self) -> None:
        """See `SimulatedBoards.stop`."""
        if self.server is not None:
            self.server.stop()

    def fault(self, what: str, amount_s: float) -> Switch:
        """See `SimulatedBoards.fault`. A device that cannot send NaN sends the end of its range."""
        faults = self.device.faults
        if what == "daq_reserved":
            return lambda: self._mark(b"\0\0\0\7"), lambda: self._mark(bytes(4))
        if what in _INPUTS:
            return switch_of(faults, "dead_inputs", on={self._input(_INPUTS[what])}, off=set())
        if what == "output_underflow":
            raise WorldError(f"[[faults]] {what}: a LabJack's output has no buffer")
        name, on, off = {
            "daq_refused": ("unavailable", True, False),
            "daq_slow": ("delay_s", amount_s, 0.0),
            "daq_buffer_overflow": ("lose_samples", True, False),
            "daq_hung": ("hang", True, False),
            "daq_read_hung": ("hang_stream", True, False),
            "daq_write_refused": ("refuse_outputs", True, False),
            "output_stuck": ("stuck", True, False),
        }[what]
        return switch_of(faults, name, on=on, off=off)

    def _mark(self, mark: bytes) -> None:
        """Let the output be somebody else's."""
        self.device.write(_OWNER, mark)

    def _input(self, signal: str) -> str:
        wired = str(getattr(self._world.settings.wiring, signal)).rpartition("/")[2]
        return f"AIN{int(wired[2:]) * (2 if self.device.model.paired else 1)}"


def _make(world: World, clock: Clock, options: BoardOptions) -> LabJackOfWorld:
    boards = options.devices or world.settings.boards
    found = {name: kind for name, kind in boards.items() if kind in SIMULATED_MODELS} or _DEFAULT
    if options.devices and found is _DEFAULT:
        raise WorldError(f"a simulated LabJack is one of: {', '.join(sorted(SIMULATED_MODELS))}")
    name, kind = next(iter(found.items()))
    seed = world.settings.seed
    model = SIMULATED_MODELS[kind]
    return LabJackOfWorld(world, SimulatedLabJack(world, clock, model, name=name, seed=seed))


FAMILY = SimulatedFamily(kind="labjack", served_as="labjack", make=_make)
