"""The channels of a session as its file describes them, for both versions of the layout."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from labrig.errors import BadInputError
from labrig.session.format import layout
from labrig.session.format.layout import Array
from protocols.execution.channels import (
    CURRENT,
    DRIVE,
    FORCE,
    Channel,
    current_channel,
    drive_channel,
    force_channel,
)

# Columns of the readings of version 1, whatever the channels were.
VERSION_1_COLUMNS = ("force_N", "drive_V", "current_A")
_LARGEST_RANGE_V = 1e3
_LONGEST_UNIT = 24
_UNIT = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def as_recorded(channel: Channel) -> Channel:
    """Return what a file can hold of a channel: not its conversion, where that is code."""
    if channel.conversion is None:
        return replace(channel, terminal="")
    return replace(channel, terminal="", gain=None, offset=0.0, conversion=None)


def version_1_channel(name: str, range_V: float) -> Channel:
    """Return a channel of a session of version 1, whose file held its name and range only."""
    if name == FORCE:
        return as_recorded(force_channel(range_V=range_V, conversion=np.asarray))
    if name == CURRENT:
        return replace(current_channel(range_V=range_V, shunt_ohm=1.0), gain=None)
    if name == DRIVE:
        return drive_channel(range_V=range_V)
    return Channel(name=name, quantity="voltage", unit="V", range_V=range_V)


def value_columns(channels: Sequence[Channel], version: int) -> tuple[str, ...]:
    """Return the columns of the readings table that hold the channels' values."""
    if version == 1:
        return VERSION_1_COLUMNS
    return tuple(channel.column for channel in channels)


def channel_rows(channels: Sequence[Channel], version: int) -> Array:
    """Return the rows of `setup/signals`."""
    rows = np.zeros(len(channels), dtype=layout.SIGNAL_ROWS[version])
    for row, channel in zip(rows, channels, strict=True):
        row["name"], row["range_V"] = channel.name.encode(), channel.range_V
        if version > 1:
            row["quantity"] = layout.cut(channel.quantity, layout.QUANTITY_BYTES)
            row["unit"] = channel.unit.encode()
            row["gain"] = math.nan if channel.gain is None else channel.gain
            row["offset"] = channel.offset
    return rows


def channels_of(rows: Array, version: int, raw_force_unit: str) -> tuple[Channel, ...]:
    """Return the channels that `setup/signals` describes (its texts decoded)."""
    found = (_channel(row, version) for row in rows)
    return tuple(
        replace(each, raw_unit=raw_force_unit) if each.name == FORCE else each for each in found
    )


def _channel(row: Any, version: int) -> Channel:
    name, range_V = str(row["name"]), float(row["range_V"])
    if version == 1:
        return version_1_channel(name, range_V)
    gain = float(row["gain"])
    return Channel(
        name=name,
        quantity=str(row["quantity"]),
        unit=str(row["unit"]),
        range_V=range_V,
        gain=None if math.isnan(gain) else gain,
        offset=float(row["offset"]),
    )


def check_channels(channels: Sequence[Channel], version: int) -> None:
    """Raise BadInputError for channels that a session cannot hold."""
    for channel in channels:
        if not 0 < channel.range_V <= _LARGEST_RANGE_V:
            raise BadInputError(f"An input range of {channel.range_V} V cannot be recorded.")
        if not _UNIT.fullmatch(channel.unit) or len(channel.unit) > _LONGEST_UNIT:
            raise BadInputError(
                f"The unit {channel.unit!r} of the channel {channel.name} cannot be recorded; use "
                "letters, digits and _, such as m_per_s."
            )
    columns = [*layout.READING_COLUMNS, *value_columns(channels, version)]
    for name in columns:
        if columns.count(name) > 1:
            raise BadInputError(f"Two columns of a reading would be called {name}; rename one.")
