"""Virtual channels of a task: their settings as asked for, and as the board takes them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from sim_hardware.ni.boards.contract import AnalogInputs, AnalogOutputs, Terminals
from sim_hardware.ni.devices import Device
from sim_hardware.ni.errors import Code, StatusError


class ChannelType(IntEnum):
    """nidaqmx.constants.ChannelType."""

    ANALOG_INPUT = 10100
    ANALOG_OUTPUT = 10102
    DIGITAL_INPUT = 10151
    DIGITAL_OUTPUT = 10153


VOLTS = 10348  # nidaqmx.constants.VoltageUnits.VOLTS


@dataclass(kw_only=True)
class AnalogInputChannel:
    """A voltage input."""

    type = ChannelType.ANALOG_INPUT
    name: str
    device: Device
    side: AnalogInputs  # of the device's board
    physical: str  # ai0
    low_V: float
    high_V: float
    asked_terminals: int
    description: str = ""
    range_low_V: float | None = None  # of the converter, as asked for; None: what the limits need
    range_high_V: float | None = None

    @property
    def terminals(self) -> Terminals:
        """The configuration asked for; for `default` the first that the channel can have."""
        if self.asked_terminals != Terminals.DEFAULT:
            return Terminals(self.asked_terminals)
        return self.side.terminals_of(self.number)[0]

    @property
    def number(self) -> int:
        """0 of ai0."""
        return int(self.physical[2:])

    def verified_range(self) -> float:
        """Return the range that the board takes (either sign); -200077 when none is wide enough."""
        side = self.side
        self._check_terminals()
        _check_order(self.low_V, self.high_V, "AI", self.name)
        low_V = min(self.low_V, self.low_V if self.range_low_V is None else self.range_low_V)
        high_V = max(self.high_V, self.high_V if self.range_high_V is None else self.range_high_V)
        found = side.range_for(low_V, high_V)
        if found is None:
            raise _limit_fault("AI", low_V, high_V, side.ranges_V[-1], self.name)
        return found

    def _check_terminals(self) -> None:
        if self.asked_terminals not in (
            Terminals.DEFAULT,
            *self.side.terminals_of(self.number),
        ):
            raise StatusError(
                Code.INVALID_VALUE,
                f"Property: DAQmx_AI_TermCfg\nRequested: {self.asked_terminals} for "
                f"{self.physical}\nChannel Name: {self.name}",
            )


@dataclass(kw_only=True)
class AnalogOutputChannel:
    """A voltage output."""

    type = ChannelType.ANALOG_OUTPUT
    name: str
    device: Device
    side: AnalogOutputs  # of the device's board
    physical: str  # ao0
    low_V: float
    high_V: float
    description: str = ""

    def verified_range(self) -> float:
        """Return the range that the board takes (either sign); -200077 when none is wide enough."""
        _check_order(self.low_V, self.high_V, "AO", self.name)
        found = self.side.range_for(self.low_V, self.high_V)
        if found is None:
            widest = self.side.ranges_V[-1]
            raise _limit_fault("AO", self.low_V, self.high_V, widest, self.name)
        return found

    def converted(self, volts: float) -> float:
        """Return the nearest voltage that the converter can put out."""
        codes = 1 << self.side.resolution_bits
        step_V = 2 * self.verified_range() / codes
        return min(codes // 2 - 1, max(-codes // 2, round(volts / step_V))) * step_V


@dataclass(kw_only=True)
class DigitalChannel:
    """One line, or several read and written together."""

    name: str
    device: Device
    lines: tuple[str, ...]  # port0/line0, ...
    output: bool
    description: str = ""
    by_port: bool = False  # named as a whole port, not by its lines

    @property
    def buffered(self) -> bool:
        """Whether the board can time all the lines."""
        return all(self.device.port_of(line).buffered for line in self.lines)

    @property
    def type(self) -> ChannelType:
        """Input or output."""
        return ChannelType.DIGITAL_OUTPUT if self.output else ChannelType.DIGITAL_INPUT

    @property
    def physical(self) -> str:
        """The lines, as the driver lists them."""
        return ", ".join(self.lines)


Channel = AnalogInputChannel | AnalogOutputChannel | DigitalChannel


def _check_order(low_V: float, high_V: float, side: str, name: str) -> None:
    if not low_V < high_V:
        raise StatusError(
            Code.INVALID_VALUE,
            f"Property: DAQmx_{side}_Min ({low_V:g}) must be below DAQmx_{side}_Max ({high_V:g})\n"
            f"Channel Name: {name}",
        )


def _limit_fault(side: str, low_V: float, high_V: float, most_V: float, name: str) -> StatusError:
    which, asked = ("Max", high_V) if abs(high_V) > most_V else ("Min", low_V)
    return StatusError(
        Code.INVALID_VALUE,
        f"Property: DAQmx_{side}_{which}\nRequested Value: {asked:g}\n"
        f"Maximum Value: {most_V:g}\nMinimum Value: {-most_V:g}\nChannel Name: {name}",
    )
