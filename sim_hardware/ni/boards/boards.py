"""What each simulated board can do. Adding a board is adding an entry to `BOARDS`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AnalogIn:
    """The analog input side of a board: one 16 bit converter behind a multiplexer."""

    channels: int  # single-ended; channel i pairs with i + channels / 2, eight at a time
    ranges_V: tuple[float, ...]  # either sign, smallest first
    noise_V: tuple[float, ...]  # rms of one sample, for each range
    max_rate_hz: float  # of one channel
    max_multi_rate_hz: float  # summed over channels
    min_rate_hz: float
    timebase_hz: float  # the sample clock is this divided by an integer
    fifo_samples: int

    @property
    def min_convert_s(self) -> float:
        """Shortest time from one channel's conversion to the next channel's."""
        return 1.0 / self.max_multi_rate_hz

    def max_rate(self, channels: int) -> float:
        """Largest sample rate of so many channels together."""
        return self.max_rate_hz if channels == 1 else self.max_multi_rate_hz / channels

    def positive_of(self, channel: int) -> bool:
        """Whether a channel is the positive side of a differential pair."""
        return channel % 16 < 8

    def range_for(self, low_V: float, high_V: float) -> float | None:
        """The smallest range that holds both limits."""
        need = max(abs(low_V), abs(high_V))
        return next((r for r in self.ranges_V if need <= r * (1 + 1e-9)), None)


@dataclass(frozen=True)
class AnalogOut:
    """The analog output side of a board, 16 bit."""

    channels: int
    range_V: float  # either sign
    clocked: bool  # False: static, a write takes effect when the computer makes it

    @property
    def step_V(self) -> float:
        """Volts from one code to the next."""
        return 2 * self.range_V / 2**16


@dataclass(frozen=True)
class Port:
    """A digital port with static lines."""

    lines: int
    inputs: bool = True
    outputs: bool = True


@dataclass(frozen=True)
class BoardModel:
    """A model of board."""

    product_type: str
    product_number: int | None  # None: not known to us, and so not told
    category: int  # nidaqmx.constants.ProductCategory
    bus: int  # nidaqmx.constants.BusType
    analog_in: AnalogIn | None
    analog_out: AnalogOut | None
    ports: tuple[Port, ...]


_E_SERIES, _X_SERIES, _M_SERIES, _AO_SERIES = 14642, 15858, 14643, 14647
_PCI, _PCIE, _USB = 12582, 13612, 12586

# Noise: the makers' tables (for the 6034E a third of 'noise + quantization, single point').
BOARDS = {
    board.product_type: board
    for board in (
        BoardModel(
            "PCI-6703",
            0x2C90,
            _AO_SERIES,
            _PCI,
            None,
            AnalogOut(channels=16, range_V=10.0, clocked=False),
            (Port(8),),
        ),
        BoardModel(
            "PCI-6034E",
            0x2CA0,
            _E_SERIES,
            _PCI,
            AnalogIn(
                channels=16,
                ranges_V=(0.05, 0.5, 5.0, 10.0),
                noise_V=(9.6e-6, 19e-6, 156e-6, 311e-6),
                max_rate_hz=200e3,
                max_multi_rate_hz=200e3,
                min_rate_hz=100e3 / 2**24,
                timebase_hz=20e6,
                fifo_samples=512,
            ),
            None,
            (Port(8),),
        ),
        BoardModel(
            "PCIe-6363",
            0x7435,
            _X_SERIES,
            _PCIE,
            AnalogIn(
                channels=32,
                ranges_V=(0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
                noise_V=(6e-6, 8e-6, 14e-6, 26e-6, 52e-6, 134e-6, 271e-6),
                max_rate_hz=2e6,
                max_multi_rate_hz=1e6,
                min_rate_hz=100e6 / 2**32,
                timebase_hz=100e6,
                fifo_samples=2047,
            ),
            AnalogOut(channels=4, range_V=10.0, clocked=True),
            (Port(32), Port(8), Port(8)),
        ),
        BoardModel(
            "USB-6211",
            None,
            _M_SERIES,
            _USB,
            AnalogIn(
                channels=16,
                ranges_V=(0.2, 1.0, 5.0, 10.0),
                noise_V=(11.8e-6, 30e-6, 122e-6, 244e-6),
                max_rate_hz=250e3,
                max_multi_rate_hz=250e3,
                min_rate_hz=20e6 / 2**32,
                timebase_hz=20e6,
                fifo_samples=4095,
            ),
            AnalogOut(channels=2, range_V=10.0, clocked=True),
            (Port(4, outputs=False), Port(4, inputs=False)),
        ),
    )
}
