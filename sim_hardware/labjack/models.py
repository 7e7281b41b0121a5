"""The simulated models: data from the maker's pages.

Slopes of the calibration are the nominal ones where they are published (T7, T4); those of the T8
are not, and are taken from its ranges. Noise is of the order of the maker's figures.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

_CODES = 65536


@dataclass(frozen=True)
class Line:
    """Volts of codes: (code - centre) * slope."""

    slope: float
    centre: float


@dataclass(frozen=True)
class OutputStage:
    """What stands between a terminal and the rig: it puts out gain * (terminal - zero_V)."""

    zero_V: float = 0.0
    gain: float = 1.0


@dataclass(frozen=True, kw_only=True)
class SimulatedModel:
    """One model, with what is plugged into it."""

    product_type: str
    product_id: int
    inputs: int
    ranges_V: tuple[float, ...]  # largest first; the first is the default
    paired: bool  # an even input and the next one are a pair
    step_codes: int  # of the converter: 1 has 16 bits, 16 has 12
    noise_V: float  # over a range of 10 V, and less in proportion
    dac_V: float
    dac_bits: int
    most_samples_hz: float
    output: str  # the terminal that is wired to the rig
    stage: OutputStage
    flash_at: int
    tick_dac: bool  # there is an LJTick-DAC on FIO0 and FIO1

    def line(self, number: int, range_V: float) -> Line:
        """Return the calibration of an input at a range."""
        if self.product_id == 4:
            slope, offset = _T4[number]
            return Line(slope, -offset / slope)
        if self.product_id == 7:
            return Line(0.0003158058 * range_V / 10.0, 33523.0)
        return Line(1.02 * 2.0 * range_V / _CODES, 32768.0 + 3 * number)

    def flash(self) -> bytes:
        """Return the calibration as it lies in flash, from `flash_at` on."""
        if self.product_id == 4:
            return struct.pack(">8f", *(value for pair in _T4 for value in pair))
        numbers = range(self.inputs) if self.product_id == 8 else (0,)
        head = bytes(64) if self.product_id == 8 else b""
        sets = (self.line(n, range_V) for n in numbers for range_V in self.ranges_V)
        return head + b"".join(
            struct.pack(">4f", line.slope, -line.slope, line.centre, -line.centre * line.slope)
            for line in sets
        )


_T4 = (
    (3.235316e-04, -10.532965),
    (3.236028e-04, -10.534480),
    (3.235439e-04, -10.530597),
    (3.236133e-04, -10.530210),
)
_TICK = {"output": "TDAC0", "stage": OutputStage(), "tick_dac": True}
_OWN_DAC = {"output": "DAC0", "stage": OutputStage(2.5, 4.0), "tick_dac": False}


def _t4(product_type: str, **plugged: object) -> SimulatedModel:
    return SimulatedModel(
        product_type=product_type,
        product_id=4,
        inputs=4,
        ranges_V=(10.0,),
        paired=False,
        step_codes=16,
        noise_V=2e-3,
        dac_V=5.0,
        dac_bits=10,
        most_samples_hz=50e3,
        flash_at=0x3C4000,
        **plugged,  # type: ignore[arg-type]
    )


def _t7(product_type: str, **plugged: object) -> SimulatedModel:
    return SimulatedModel(
        product_type=product_type,
        product_id=7,
        inputs=14,
        ranges_V=(10.0, 1.0, 0.1, 0.01),
        paired=True,
        step_codes=1,
        noise_V=0.3e-3,
        dac_V=5.0,
        dac_bits=12,
        most_samples_hz=100e3,
        flash_at=0x3C4000,
        **plugged,  # type: ignore[arg-type]
    )


def _t8(product_type: str, **plugged: object) -> SimulatedModel:
    return SimulatedModel(
        product_type=product_type,
        product_id=8,
        inputs=8,
        ranges_V=(11.0, 9.6, 4.8, 2.4, 1.2, 0.6, 0.3, 0.15, 0.075, 0.036, 0.018),
        paired=False,
        step_codes=1,
        noise_V=0.1e-3,
        dac_V=10.0,
        dac_bits=16,
        most_samples_hz=320e3,
        flash_at=0x687000,
        **plugged,  # type: ignore[arg-type]
    )


SIMULATED_MODELS = {
    model.product_type: model
    for make, name in ((_t4, "T4"), (_t7, "T7"), (_t8, "T8"))
    for model in (make(name, **_TICK), make(f"{name} DAC0", **_OWN_DAC))
}
