"""The channels of a rig: three that every rig has, and those that rig.toml adds."""

from __future__ import annotations

from collections.abc import Mapping

from drivers.force_sensors.load_cell import LoadCell
from labrig.config import RigConfig
from protocols.execution.channels import (
    CURRENT,
    DRIVE,
    FORCE,
    Channel,
    current_channel,
    drive_channel,
    force_channel,
)


def inputs_of(config: RigConfig) -> tuple[tuple[str, str, float], ...]:
    """Return name, terminal and wanted range (V) of each input, in the order of the rows."""
    ni = config.ni
    return (
        (FORCE, ni.force, ni.ranges_V.force),
        (CURRENT, ni.current, ni.ranges_V.current),
        (DRIVE, ni.drive_readback, ni.ranges_V.drive),
        *((name, each.input, each.range_V) for name, each in config.channels.items()),
    )


def channels_of(
    config: RigConfig, load_cell: LoadCell, ranges_V: Mapping[str, float]
) -> tuple[Channel, ...]:
    """Return the channels of an open input; `ranges_V` holds its actual ranges by name."""
    ni = config.ni
    shunt_ohm = config.current_sense.shunt_ohm
    here_V = {name: range_V for name, _, range_V in inputs_of(config)} | dict(ranges_V)
    every = (
        force_channel(range_V=here_V[FORCE], conversion=load_cell.newtons, terminal=ni.force),
        current_channel(range_V=here_V[CURRENT], shunt_ohm=shunt_ohm, terminal=ni.current),
        drive_channel(range_V=here_V[DRIVE], terminal=ni.drive_readback),
        *(each.channel(name, here_V[name]) for name, each in config.channels.items()),
    )
    return tuple(channel for channel in every if channel.name in ranges_V)
