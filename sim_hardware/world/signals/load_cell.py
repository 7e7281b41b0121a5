"""The load cell: from the force along its axis to volts at the board's input."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from sim_hardware.world.settings import CellSettings
from sim_hardware.world.signals.noise import SlowWander, WhiteNoise

FloatArray = npt.NDArray[np.float64]

_WHITE_STREAM, _DRIFT_STREAM = 0xCE110, 0xCE111
_MAINS_HZ = 50.0
_FILTERED = 200  # samples in the mean of a reading
# An input that is connected to nothing drifts to the end of what the board's amplifier can do.
_LEANING = 1.5  # of its capacity
_OPEN_V = 11.0
_OPEN_S = 0.5
# Where along the arc the pull of the cell's cable is stated.
_CABLE_M = 0.03


class CellFault(StrEnum):
    """Faults of the load cell and its wiring."""

    NONE = "none"
    OPEN = "open"  # a broken signal wire: the input drifts to a rail
    NO_EXCITATION = "no_excitation"  # the bridge gives nothing but noise
    OVERLOADED = "overloaded"  # loaded beyond its capacity


class SimulatedLoadCell:
    """Volts of a force; noise is a function of the time since the world's beginning."""

    def __init__(self, settings: CellSettings, seed: int) -> None:
        from sim_hardware.world.signals import kernels

        self._approach, self._waves = kernels.approach, kernels.waves
        s = self._settings = settings
        self._white = WhiteNoise(seed, _WHITE_STREAM)
        shortest, longest = sorted((s.drift_shortest_s, s.drift_longest_s))
        self._wander = SlowWander(seed, _DRIFT_STREAM, shortest, longest)
        self._fault, self._fault_s = CellFault.NONE, -math.inf

    def reaches_N(self, sticking_N: float) -> FloatArray:
        """Return how far the two elements of hysteresis turn: the cell's own, the rolls'."""
        return np.array([self._settings.hysteresis_reach_mN * 1e-3, sticking_N])

    def felt_N(self, force_N: FloatArray, turned_N: FloatArray) -> FloatArray:
        """Return the cell's response to a force, without noise; `turned_N` (n, 2): hysteresis."""
        s = self._settings
        bend = s.nonlinearity * force_N * np.abs(force_N) / (s.capacity_mN * 1e-3)
        loop = s.hysteresis_mN / s.hysteresis_reach_mN * turned_N[:, 0]
        return np.asarray(force_N + bend - loop - turned_N[:, 1])

    def stray_N(self, position_m: float | None, sheet_V: FloatArray) -> FloatArray:
        """Return the force of cables: its own by its position, the drive's by its voltage."""
        s = self._settings
        cable_mN = s.cable_mN * ((position_m or 0.0) / _CABLE_M) ** 2
        return np.asarray((cable_mN + s.pickup_mN * sheet_V / 2.0) * 1e-3)

    def zero_N(self, since_s: FloatArray) -> FloatArray:
        """Its zero without noise: offset, warming up, what comes again and again."""
        s = self._settings
        part = np.maximum(since_s, 0.0) / s.warming_s
        if s.warming_form == "root":
            part = np.sqrt(part)
        elif s.warming_form == "exp":
            part = self._approach(part, 1.0, 1.0)
        beat = s.beat_mN * self._waves(since_s, np.array([2 * math.pi / s.beat_s]), np.zeros(1))
        offset_N = s.offset_uV * 1e-6 / s.sensitivity_V_per_N
        return np.asarray(offset_N + (s.warming_mN * part + beat) * 1e-3)

    def noise_N(self, since_s: FloatArray) -> FloatArray:
        """Noise of single samples, wander and hum."""
        s = self._settings
        noise_mN = s.noise_mN * self._white.at(since_s) + s.drift_mN * self._wander.at(since_s)
        noise_mN += s.hum_mN * self._hum(since_s)
        return np.asarray(noise_mN * 1e-3)

    def volts(self, felt_N: FloatArray, since_s: FloatArray) -> FloatArray:
        """Volts at the input."""
        s = self._settings
        signal = np.where(self._excited(since_s), felt_N, 0.0) + self.noise_N(since_s)
        volts = s.sensitivity_V_per_N * (self.zero_N(since_s) + signal)
        if self._fault is CellFault.OVERLOADED:
            more_N = _LEANING * s.capacity_mN * 1e-3
            volts = volts + s.sensitivity_V_per_N * more_N * (since_s >= self._fault_s)
        if self._fault is CellFault.OPEN:
            gone = 1.0 - self._approach(np.maximum(0.0, since_s - self._fault_s), 1.0, 1 / _OPEN_S)
            volts = _OPEN_V + (volts - _OPEN_V) * gone
        return np.asarray(volts)

    def filtered_N(
        self, force_N: float, since_s: FloatArray, random: np.random.Generator
    ) -> FloatArray:
        """Return readings of a steady force, each the mean over 0.2 s at 1 kHz, in newtons.

        Only for sessions without signals, in which nothing lags behind.
        """
        s = self._settings
        felt = self.felt_N(np.array([force_N]), np.zeros((1, 2)))[0]
        white = s.noise_mN / math.sqrt(_FILTERED) * random.standard_normal(since_s.size)
        noise_N = (white + s.drift_mN * self._wander.at(since_s)) * 1e-3
        return np.asarray(felt + self.zero_N(since_s) + noise_N)

    def fail(self, fault: CellFault, since_s: float) -> None:
        """From now on this is wrong with it, or nothing any more."""
        self._fault, self._fault_s = fault, since_s

    def _hum(self, since_s: FloatArray) -> FloatArray:
        return self._waves(since_s, np.array([2 * math.pi * _MAINS_HZ]), np.zeros(1))

    def _excited(self, since_s: FloatArray) -> npt.NDArray[np.bool_]:
        broken = self._fault is CellFault.NO_EXCITATION
        return (since_s < self._fault_s) if broken else np.ones(since_s.shape, dtype=bool)
