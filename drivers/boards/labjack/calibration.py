"""From a stream's binary values to volts, by the constants in the device's flash.

A T-series device corrects single readings itself; of a stream it sends what its converter gives.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from drivers.boards.labjack.registers import FLASH_POINTER, FLASH_READ, NONE, OWN, Model
from drivers.boards.labjack.wire import Wire, Write
from drivers.interfaces import DeviceError, FloatArray

_CODES = 65536
# Volts of a code, over a range's width: a device's constants lie within a few per cent of these.
_PLAUSIBLE = (0.8, 1.3)
_T8_FIRST = 64  # bytes before the inputs' constants, and sets of each input
_T8_SETS = 11


@dataclass(frozen=True)
class Conversion:
    """Straight lines on both sides of a centre."""

    above: float  # V per code
    below: float  # V per code, as a negative number: LabJack's way to store it
    centre: float  # code at 0 V

    def volts(self, codes: npt.NDArray[np.uint16]) -> FloatArray:
        """Return codes as volts."""
        from_centre = codes.astype(np.float64) - self.centre
        slope = np.where(from_centre < 0.0, -self.below, self.above)
        return np.asarray(from_centre * slope)

    def fits(self, range_V: float) -> bool:
        """Whether these can be the constants of that range."""
        nominal = 2.0 * range_V / _CODES
        slopes = (self.above / nominal, -self.below / nominal)
        good = all(math.isfinite(s) and _PLAUSIBLE[0] < s < _PLAUSIBLE[1] for s in slopes)
        return good and abs(self.centre - _CODES / 2) < 0.1 * _CODES


def conversions(
    wire: Wire, model: Model, inputs: Sequence[int], ranges_V: Sequence[float]
) -> list[Conversion]:
    """Read the conversion of each input at its range. Raises DeviceError."""
    found = [
        _conversion(wire, model, number, range_V)
        for number, range_V in zip(inputs, ranges_V, strict=True)
    ]
    for number, range_V, each in zip(inputs, ranges_V, found, strict=True):
        if not each.fits(range_V):
            raise DeviceError(
                f"{wire.where}: its calibration of AIN{number} at ±{range_V:g} V makes no sense; "
                "it needs its maker's calibration again"
            )
    return found


def _conversion(wire: Wire, model: Model, number: int, range_V: float) -> Conversion:
    if model.differential == NONE:  # slope and offset of each input
        slope, offset = _floats(wire, model.flash + 8 * number, 2)
        return Conversion(slope, -slope, -offset / slope if slope else math.nan)
    step = sorted(model.ranges_V, reverse=True).index(range_V)
    at = model.flash + 16 * step
    if model.differential == OWN:
        at = model.flash + _T8_FIRST + 16 * (_T8_SETS * number + step)
    above, below, centre, _ = _floats(wire, at, 4)
    return Conversion(above, below, centre)


def _floats(wire: Wire, address: int, count: int) -> tuple[float, ...]:
    doing = "reading the calibration"
    wire.write(doing, Write(FLASH_POINTER, address))
    return struct.unpack(f">{count}f", wire.read_block(doing, FLASH_READ, 2 * count))
