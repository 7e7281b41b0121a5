"""From volts at the board's input to newtons on the load cell, and when that is no longer true.

Pure: no device is touched. The force is the component along the tangent of the arc.
"""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from drivers.interfaces import DeviceError, FloatArray, OverloadError

GSO_10_CAPACITY_N = 0.0980665  # 10 gram-force
WARN_AT = 1.0  # of capacity
TRIP_AT = 1.2
_AT_THE_RAIL = 0.999  # of the input's range: the last counts of the converter
_GLITCH_SAMPLES = 2  # so many samples alone are interference, not a load


class CalibrationError(DeviceError):
    """A calibration cannot be made from, or does not hold, what was given."""


@dataclass(frozen=True, kw_only=True)
class LoadCellCalibration:
    """What a load cell's volts mean: volts = offset + sensitivity * force, with uncertainty.

    `sensitivity_V_per_N` is that of the whole chain as wired on `date`: bridge, excitation and
    conditioner's gain, which are recorded beside it. Sigmas are standard uncertainties.
    """

    date: dt.date
    capacity_N: float
    sensitivity_V_per_N: float
    offset_V: float
    sensitivity_sigma_V_per_N: float = 0.0
    offset_sigma_V: float = 0.0
    input_range_V: float = 0.05  # either sign, of the input it is read with
    excitation_V: float = 10.0
    gain: float = 1.0
    serial: str = ""

    def __post_init__(self) -> None:
        for name in ("capacity_N", "input_range_V", "excitation_V"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise CalibrationError(f"load cell: {name} = {value} must be above 0")
        if not (np.isfinite(self.sensitivity_V_per_N) and self.sensitivity_V_per_N != 0.0):
            raise CalibrationError(
                f"load cell: sensitivity_V_per_N = {self.sensitivity_V_per_N} must not be 0"
            )
        for name in ("sensitivity_sigma_V_per_N", "offset_sigma_V"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise CalibrationError(f"load cell: {name} = {value} must be 0 or above")
        if not np.isfinite(self.offset_V):
            raise CalibrationError(f"load cell: offset_V = {self.offset_V} must be a number")

    def in_newtons(self) -> LoadCellCalibration:
        """Return the same cell as a meter reads it: what is called volts are newtons already."""
        return replace(
            self,
            sensitivity_V_per_N=1.0,
            offset_V=0.0,
            sensitivity_sigma_V_per_N=0.0,
            offset_sigma_V=0.0,
        )

    def newtons(self, volts: FloatArray) -> FloatArray:
        """Force in N of each voltage; not tared."""
        return (np.asarray(volts, dtype=float) - self.offset_V) / self.sensitivity_V_per_N

    def volts(self, force_N: FloatArray) -> FloatArray:
        """Return the voltage of each force."""
        return self.offset_V + self.sensitivity_V_per_N * np.asarray(force_N, dtype=float)

    def sigma_N(self, force_N: float) -> float:
        """Return the standard uncertainty of a force due to the calibration alone."""
        slope = force_N * self.sensitivity_sigma_V_per_N / self.sensitivity_V_per_N
        zero = self.offset_sigma_V / self.sensitivity_V_per_N
        return float(np.hypot(slope, zero))


class LoadState(StrEnum):
    """What a block of samples says of the load cell."""

    FINE = "fine"
    ABOVE_CAPACITY = "above_capacity"  # readings still hold, but accuracy is not promised
    SATURATED = "saturated"  # the input's range ends before the load cell's: not an overload
    OVERLOAD = "overload"  # unload it at once


@dataclass(frozen=True)
class LoadCheck:
    """The state, and a sentence for the operator (empty when fine)."""

    state: LoadState
    peak_N: float  # the largest force that was there for more than a glitch, with its sign
    text: str


class LoadCell:
    """A calibrated load cell with a tare. `input_range`: the actual range of its input.

    `raw_unit` is the unit of that range and of all samples: N where a meter reads the cell, with a
    calibration `in_newtons`.
    """

    def __init__(
        self,
        calibration: LoadCellCalibration,
        input_range: float | None = None,
        raw_unit: str = "V",
    ) -> None:
        self.calibration = calibration
        self._range = calibration.input_range_V if input_range is None else input_range
        self._end = f"the end of its range of ±{self._range:g} {raw_unit}"
        self._tare_N = 0.0

    def newtons(self, volts: FloatArray) -> FloatArray:
        """Force in N, less the tare."""
        return self.calibration.newtons(volts) - self._tare_N

    def tare(self, volts: FloatArray) -> float:
        """Make the mean of these samples the zero; returns the force taken off, in N."""
        values = np.asarray(volts, dtype=float)
        if values.size == 0 or not np.all(np.isfinite(values)):
            raise CalibrationError("load cell: no valid samples to tare with; read it again")
        self._tare_N = float(np.mean(self.calibration.newtons(values)))
        return self._tare_N

    def untare(self) -> None:
        """Take off nothing."""
        self._tare_N = 0.0

    def is_at_the_rail(self, volts: FloatArray) -> bool:
        """Whether these samples reach the end of the input's range, for more than a glitch."""
        peak = _lasting_peak(np.asarray(volts, dtype=float))
        return not abs(peak) < _AT_THE_RAIL * self._range

    def check(self, volts: FloatArray) -> LoadCheck:
        """Judge a block of samples. The tare does not count: the cell carries it too."""
        values = np.asarray(volts, dtype=float)
        if values.size == 0:
            return LoadCheck(LoadState.FINE, 0.0, "")
        peak_V = _lasting_peak(values - self.calibration.offset_V) + self.calibration.offset_V
        peak_N = float(self.calibration.newtons(np.array(peak_V)))
        trip_N = TRIP_AT * self.calibration.capacity_N
        if not np.isfinite(peak_V):
            return LoadCheck(LoadState.OVERLOAD, peak_N, "the force input delivers no numbers")
        if abs(peak_V) >= _AT_THE_RAIL * self._range and abs(peak_N) < trip_N:
            return LoadCheck(LoadState.SATURATED, peak_N, self._saturated(peak_N))
        if abs(peak_N) >= trip_N:
            return LoadCheck(LoadState.OVERLOAD, peak_N, self._overloaded(peak_N, peak_V))
        if abs(peak_N) > WARN_AT * self.calibration.capacity_N:
            return LoadCheck(LoadState.ABOVE_CAPACITY, peak_N, self._above(peak_N))
        return LoadCheck(LoadState.FINE, peak_N, "")

    def protect(self, volts: FloatArray) -> LoadCheck:
        """As `check`, but an overload raises OverloadError."""
        found = self.check(volts)
        if found.state is LoadState.OVERLOAD:
            raise OverloadError(found.text)
        return found

    def _of_capacity(self, force_N: float) -> str:
        capacity_N = self.calibration.capacity_N
        return (
            f"{force_N * 1e3:.1f} mN, {abs(force_N) / capacity_N:.0%} of its capacity of "
            f"{capacity_N * 1e3:.2f} mN"
        )

    def _saturated(self, peak_N: float) -> str:
        return (
            f"the force input is at {self._end}, which is "
            f"{abs(peak_N) * 1e3:.1f} mN: the reading is not valid; choose a larger range or a "
            "lower gain"
        )

    def _overloaded(self, peak_N: float, peak_V: float) -> str:
        text = f"the load cell carries {self._of_capacity(peak_N)}: unload it at once"
        if abs(peak_V) >= _AT_THE_RAIL * self._range:
            text += (
                f"; the input is at {self._end}, so that a broken wire or missing excitation "
                "looks the same"
            )
        return text

    def _above(self, peak_N: float) -> str:
        return f"the load cell carries {self._of_capacity(peak_N)}: reduce the load"


def _lasting_peak(values: FloatArray) -> float:
    """Return the value of largest magnitude but for those of a glitch; NaN if any is NaN."""
    if not np.all(np.isfinite(values)):
        return float("nan")
    order = np.argsort(np.abs(values))
    skipped = _GLITCH_SAMPLES if values.size > 2 * _GLITCH_SAMPLES else 0
    return float(values[order[-1 - skipped]])
