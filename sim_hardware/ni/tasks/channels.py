"""Virtual channels of a task: their settings as asked for, and as the board takes them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from sim_hardware.ni.boards.boards import AnalogIn, AnalogOut
from sim_hardware.ni.boards.devices import Device
from sim_hardware.ni.errors import Code, StatusError


class ChannelType(IntEnum):
    """nidaqmx.constants.ChannelType."""

    ANALOG_INPUT = 10100
    ANALOG_OUTPUT = 10102
    DIGITAL_INPUT = 10151
    DIGITAL_OUTPUT = 10153

    @property
    def is_digital(self) -> bool:
        """Lines rather than volts."""
        return self in (ChannelType.DIGITAL_INPUT, ChannelType.DIGITAL_OUTPUT)

    @property
    def is_output(self) -> bool:
        """Written rather than read."""
        return self in (ChannelType.ANALOG_OUTPUT, ChannelType.DIGITAL_OUTPUT)


class Terminals(IntEnum):
    """nidaqmx.constants.TerminalConfiguration."""

    DEFAULT = -1
    RSE = 10083
    NRSE = 10078
    DIFFERENTIAL = 10106


VOLTS = 10348  # nidaqmx.constants.VoltageUnits.VOLTS


@dataclass
class AnalogInputChannel:
    """A voltage input."""

    type = ChannelType.ANALOG_INPUT
    name: str
    device: Device
    side: AnalogIn  # of the device's board
    physical: str  # ai0
    low_V: float
    high_V: float
    asked_terminals: int
    description: str = ""

    @property
    def terminals(self) -> Terminals:
        """What `default` means: differential where the channel can be, else referenced."""
        if self.asked_terminals != Terminals.DEFAULT:
            return Terminals(self.asked_terminals)
        pair = self.side.positive_of(self.number)
        return Terminals.DIFFERENTIAL if pair else Terminals.RSE

    @property
    def number(self) -> int:
        """0 of ai0."""
        return int(self.physical[2:])

    def verified_range(self) -> float:
        """The range the board takes (either sign); -200077 when it has none that is wide enough."""
        side = self.side
        _check_terminals(
            self.asked_terminals, self.number, side.positive_of(self.number), self.name
        )
        _check_order(self.low_V, self.high_V, "AI", self.name)
        found = side.range_for(self.low_V, self.high_V)
        if found is None:
            widest = side.ranges_V[-1]
            raise _limit_fault("AI", self.low_V, self.high_V, widest, self.name)
        return found


@dataclass
class AnalogOutputChannel:
    """A voltage output."""

    type = ChannelType.ANALOG_OUTPUT
    name: str
    device: Device
    side: AnalogOut  # of the device's board
    physical: str  # ao0
    low_V: float
    high_V: float
    description: str = ""

    def verify(self) -> None:
        """-200077 when the limits are beyond the board's."""
        side = self.side
        _check_order(self.low_V, self.high_V, "AO", self.name)
        if max(abs(self.low_V), abs(self.high_V)) > side.range_V * (1 + 1e-9):
            raise _limit_fault("AO", self.low_V, self.high_V, side.range_V, self.name)


@dataclass
class DigitalChannel:
    """One line, or several read and written together."""

    name: str
    device: Device
    lines: tuple[str, ...]  # port0/line0, ...
    output: bool
    description: str = ""

    @property
    def type(self) -> ChannelType:
        """Input or output."""
        return ChannelType.DIGITAL_OUTPUT if self.output else ChannelType.DIGITAL_INPUT

    @property
    def physical(self) -> str:
        """The lines, as the driver lists them."""
        return ", ".join(self.lines)


Channel = AnalogInputChannel | AnalogOutputChannel | DigitalChannel


def _check_terminals(asked: int, number: int, can_be_positive: bool, name: str) -> None:
    if asked not in list(Terminals) or (asked == Terminals.DIFFERENTIAL and not can_be_positive):
        raise StatusError(
            Code.INVALID_VALUE,
            f"Property: DAQmx_AI_TermCfg\nRequested: {asked} for ai{number}\nChannel Name: {name}",
        )


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
