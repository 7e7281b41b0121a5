"""The boards of a simulated world, wired to it."""

from __future__ import annotations

from collections.abc import Mapping

from drivers.interfaces import Clock
from sim_hardware.ni import NiDeviceServer
from sim_hardware.ni.boards import board_model
from sim_hardware.ni.devices import Device
from sim_hardware.world import World, WorldError
from sim_hardware.world.settings import WiringSettings


def boards_of(
    world: World,
    clock: Clock,
    devices: Mapping[str, str] | None = None,
    driver_version: str = "26.0",
    *,
    strict_ownership: bool = False,
) -> NiDeviceServer:
    """Return the boards of a world, wired to it; `devices` replaces the world's `[boards]`.

    WorldError for a product type that is not simulated, and for a terminal that no board has.
    """
    devices = devices or world.settings.boards
    try:
        server = NiDeviceServer(
            world,
            clock,
            devices,
            driver_version,
            strict_ownership=strict_ownership,
            seed=world.settings.seed,
        )
    except ValueError as fault:
        raise WorldError(f"[boards] {fault}") from None
    faults = _wiring_faults(world.settings.wiring, devices)
    if faults:
        raise WorldError("; ".join(faults))
    server.lines.wired = lambda line, high, when: world.edge(line, when, high=high)
    return server


def _wiring_faults(wiring: WiringSettings, devices: Mapping[str, str]) -> list[str]:
    """Return a sentence for each signal that is wired to a device's terminal which is not there."""
    boards = [Device(name, board_model(model)) for name, model in devices.items()]
    terminals = {t.lower() for board in boards for t in board.inputs() + board.outputs()}
    return [
        f"[wiring] {signal} = '{wired}': none of the boards {', '.join(devices)} has that terminal"
        for signal, wired in wiring.model_dump().items()
        if "/" in wired and wired.lower() not in terminals
    ]
