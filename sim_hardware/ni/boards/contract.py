"""The contract of a simulated board: data from its maker's specifications.

A file of this folder defines `BOARD`, a `BoardModel`. Nothing of it is called: the rest of
`sim_hardware.ni` reads the values and answers for the board. All values are SI (V, Hz, s).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from nidaqmx.constants import BusType, ProductCategory


class Terminals(IntEnum):
    """nidaqmx.constants.TerminalConfiguration."""

    DEFAULT = -1
    RSE = 10083
    NRSE = 10078
    DIFFERENTIAL = 10106


MULTIPLEXED = (Terminals.DIFFERENTIAL, Terminals.RSE, Terminals.NRSE)


@dataclass(frozen=True, kw_only=True)
class AnalogInputs:
    """The analog inputs: one converter behind a multiplexer, or one for each channel."""

    channels: int  # that can be named: ai0, ai1 ...
    ranges_V: tuple[float, ...]  # either sign, smallest first
    noise_V: tuple[float, ...]  # rms of one sample, for each range
    max_rate_hz: float  # of one channel
    max_multi_rate_hz: float  # the sum over several channels; of each one where `simultaneous`
    min_rate_hz: float
    timebase_hz: float  # the sample clock is this divided by an integer
    fifo_samples: int
    resolution_bits: int = 16
    terminals: tuple[Terminals, ...] = MULTIPLEXED
    pair_offset: int = 8  # ai<i> pairs with ai<i + pair_offset>; 0: each has two terminals
    simultaneous: bool = False  # each channel has a converter
    settling_s: float = 10e-6  # the driver adds this to a conversion where there is time

    @property
    def min_convert_s(self) -> float:
        """Return the shortest time from one channel's conversion to the next channel's."""
        return 0.0 if self.simultaneous else 1.0 / self.max_multi_rate_hz

    def max_rate(self, channels: int) -> float:
        """Return the largest sample rate of so many channels together, in Hz."""
        if channels == 1:
            return self.max_rate_hz
        return self.max_multi_rate_hz / (1 if self.simultaneous else channels)

    def terminals_of(self, channel: int) -> tuple[Terminals, ...]:
        """Return the terminal configurations of a channel; the first is its default."""
        second = self.pair_offset and channel // self.pair_offset % 2
        return tuple(t for t in self.terminals if not (second and t is Terminals.DIFFERENTIAL))

    def range_for(self, low_V: float, high_V: float) -> float | None:
        """Return the smallest range that holds both limits; None: there is none."""
        return _range_for(self.ranges_V, low_V, high_V)


@dataclass(frozen=True, kw_only=True)
class AnalogOutputs:
    """The analog outputs."""

    channels: int
    ranges_V: tuple[float, ...]  # either sign, smallest first
    clocked: bool  # False: static, a write takes effect when the computer makes it
    max_rate_hz: float | None = None  # of one channel's updates; None where not clocked
    timebase_hz: float = 20e6  # the sample clock is this divided by an integer
    fifo_samples: int = 0  # that the board holds itself
    resolution_bits: int = 16
    # False: a device reset sets 0 V (M, X and C Series); E, S and AO Series keep their voltage
    keeps_voltage_on_reset: bool = True

    def range_for(self, low_V: float, high_V: float) -> float | None:
        """Return the smallest range that holds both limits; None: there is none."""
        return _range_for(self.ranges_V, low_V, high_V)


@dataclass(frozen=True)
class DigitalPort:
    """A digital port: port<i> of the board, i its index in `BoardModel.ports`."""

    lines: int
    inputs: bool = True
    outputs: bool = True
    buffered: bool = False  # the board can time its lines; False: static


@dataclass(frozen=True, kw_only=True)
class BoardModel:
    """A model of board, as the driver describes it."""

    product_type: str  # PCI-6703: the name by which it is chosen
    product_number: int | None  # None: unknown, and so not reported
    category: ProductCategory
    bus: BusType
    analog_in: AnalogInputs | None = None
    analog_out: AnalogOutputs | None = None
    ports: tuple[DigitalPort, ...] = ()
    in_chassis: bool = False  # a C Series module: it is named after its chassis and slot
    slots: int = 0  # of a chassis


def _range_for(ranges_V: tuple[float, ...], low_V: float, high_V: float) -> float | None:
    need_V = max(abs(low_V), abs(high_V))
    return next((r for r in ranges_V if need_V <= r * (1 + 1e-9)), None)
