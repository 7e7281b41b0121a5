"""A channel is data: what an input measures, in which unit, and how volts become it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from drivers.interfaces import DeviceError, FloatArray, SignalInput

Conversion = Callable[[FloatArray], FloatArray]

FORCE, DRIVE, CURRENT = "force", "drive", "current"


@dataclass(frozen=True, kw_only=True)
class Channel:
    """One named input of the rig.

    Values are linear in the volts at the board, `gain * volts + offset`, unless the channel has a
    `conversion` of its own (a calibrated sensor). A recorded channel whose `gain` is None had one.
    """

    name: str  # of the input, of its raw samples in a session: force, temperature
    quantity: str  # force, electric current, temperature
    unit: str  # of its values; letters, digits and _: N, A, degC, m_per_s
    range_V: float  # of the input, either sign; in `raw_unit`
    terminal: str = ""  # PCI6034E/ai3
    gain: float | None = 1.0  # unit per V
    offset: float = 0.0  # in the unit, at 0 V
    conversion: Conversion | None = None
    raw_unit: str = "V"  # of the samples as recorded; N where a meter reads the force

    @property
    def column(self) -> str:
        """Name of its values in readings, tables and messages, with the unit: force_N."""
        return column_of(self.name, self.unit)

    def convert(self, volts: FloatArray) -> FloatArray:
        """Return the values of raw volts. Raises ValueError where the conversion is not known."""
        if self.conversion is not None:
            return self.conversion(volts)
        if self.gain is None:
            raise ValueError(f"the conversion of the channel {self.name!r} is not known")
        return np.asarray(self.gain * volts + self.offset)


def column_of(name: str, unit: str) -> str:
    """Return the name of a channel's values: force_N."""
    return f"{name}_{unit}"


# Values of a reading by the column of their channel: {"force_N": 0.0021, "drive_V": 2.0}.
Values = Mapping[str, float]
FORCE_N, DRIVE_V, CURRENT_A = (
    column_of(FORCE, "N"),
    column_of(DRIVE, "V"),
    column_of(CURRENT, "A"),
)


def drive_channel(*, range_V: float, terminal: str = "") -> Channel:
    """Return the channel that reads back the voltage at the sheet."""
    return Channel(name=DRIVE, quantity="voltage", unit="V", range_V=range_V, terminal=terminal)


def force_channel(
    *, range_V: float, conversion: Conversion, terminal: str = "", raw_unit: str = "V"
) -> Channel:
    """Return the channel of the load cell, which has a calibration of its own."""
    return Channel(
        name=FORCE,
        quantity="force",
        unit="N",
        range_V=range_V,
        terminal=terminal,
        gain=None,
        conversion=conversion,
        raw_unit=raw_unit,
    )


def current_channel(*, range_V: float, shunt_ohm: float, terminal: str = "") -> Channel:
    """Return the channel of the shunt in series with the sheet."""
    return Channel(
        name=CURRENT,
        quantity="electric current",
        unit="A",
        range_V=range_V,
        terminal=terminal,
        gain=1.0 / shunt_ohm,
    )


@dataclass(frozen=True)
class ChannelRows:
    """Which row of a block of samples belongs to which channel."""

    channels: tuple[Channel, ...]  # in the order of the rows
    force: int
    drive: int

    @classmethod
    def of(cls, signals: SignalInput, channels: tuple[Channel, ...]) -> ChannelRows:
        """Raise DeviceError when a channel that is needed is missing, or its conversion is."""
        names = list(signals.channels)
        known = {channel.name: channel for channel in channels}
        for name in (FORCE, DRIVE):
            if name not in names:
                found = ", ".join(names) or "none"
                raise DeviceError(
                    f"the signal input has no channel {name!r}, only {found}; wire it in the "
                    "boards' table of rig.toml"
                )
        for name in names:
            if name not in known:
                raise DeviceError(f"what the volts of the channel {name!r} mean is not known")
        return cls(
            channels=tuple(known[name] for name in names),
            force=names.index(FORCE),
            drive=names.index(DRIVE),
        )

    def converted(self, volts: FloatArray) -> FloatArray:
        """Return the values of a block of raw volts, row by row."""
        return np.stack(
            [channel.convert(row) for channel, row in zip(self.channels, volts, strict=True)]
        )

    def values_by_name(self, volts: FloatArray) -> dict[str, FloatArray]:
        """Return the values of a block of raw volts by the channel's name."""
        names = [channel.name for channel in self.channels]
        return dict(zip(names, self.converted(volts), strict=True))

    def values(self, row_values: FloatArray) -> dict[str, float]:
        """Return one value for each row under the name of its column."""
        return {
            channel.column: float(value)
            for channel, value in zip(self.channels, row_values, strict=True)
        }
