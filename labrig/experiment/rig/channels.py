"""The channels of a rig: three that every rig has, and those that rig.toml adds."""

from __future__ import annotations

from collections.abc import Mapping

from drivers.boards import BoardInput
from drivers.load_cell import LoadCell
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


def inputs_of(config: RigConfig) -> tuple[BoardInput, ...]:
    """Return every input of the boards, in the order of the rows."""
    further = (BoardInput(name, each.input, each.range_V) for name, each in config.channels.items())
    return (*config.family.inputs(config.boards.settings()), *further)


def channels_of(
    config: RigConfig, load_cell: LoadCell, ranges_V: Mapping[str, float]
) -> tuple[Channel, ...]:
    """Return the channels of an open input; `ranges_V` holds its actual ranges by name.

    The range of a force that a meter reads is in N.
    """
    shunt_ohm = config.current_sense.shunt_ohm
    inputs = inputs_of(config)
    at = {each.name: each.terminal for each in inputs}
    here_V = {each.name: each.range_V for each in inputs} | dict(ranges_V)
    every = (
        force_channel(
            range_V=here_V[FORCE],
            conversion=load_cell.newtons,
            terminal=at[FORCE],
            raw_unit=config.raw_force_unit,
        ),
        current_channel(range_V=here_V[CURRENT], shunt_ohm=shunt_ohm, terminal=at[CURRENT]),
        drive_channel(range_V=here_V[DRIVE], terminal=at[DRIVE]),
        *(each.channel(name, here_V[name]) for name, each in config.channels.items()),
    )
    return tuple(channel for channel in every if channel.name in ranges_V)


def planned_channels(config: RigConfig, load_cell: LoadCell) -> tuple[Channel, ...]:
    """Return the channels that a rig will have once it is open, with the ranges of rig.toml."""
    ranges_V = {each.name: each.range_V for each in inputs_of(config)}
    return channels_of(config, load_cell, ranges_V)
