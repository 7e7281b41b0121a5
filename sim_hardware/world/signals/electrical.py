"""The sheet as a load of the amplifier: current and read-back, as volts at the boards' inputs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim_hardware.world.settings.rig import ElectricalSettings
from sim_hardware.world.signals.amplifier import SimulatedAmplifier
from sim_hardware.world.signals.noise import WhiteNoise

FloatArray = npt.NDArray[np.float64]

_CURRENT_STREAM, _READBACK_STREAM = 0xCE112, 0xCE113


class ElectricalSignals:
    """Current and read-back with their noise, which belongs to the time since the beginning."""

    def __init__(
        self, settings: ElectricalSettings, amplifier: SimulatedAmplifier, seed: int
    ) -> None:
        self._settings = settings
        self._amplifier = amplifier
        self._current_noise = WhiteNoise(seed, _CURRENT_STREAM)
        self._readback_noise = WhiteNoise(seed, _READBACK_STREAM)

    def current_V(self, current_A: FloatArray, since_s: FloatArray) -> FloatArray:
        """Return the sheet's current as volts across the shunt."""
        e = self._settings
        noise_V = e.current_noise_mV * 1e-3 * self._current_noise.at(since_s)
        return np.asarray(e.shunt_ohm * current_A) + noise_V

    def readback_V(self, times: FloatArray, since_s: FloatArray) -> FloatArray:
        """Return the amplifier's output."""
        noise_V = self._settings.readback_noise_mV * 1e-3 * self._readback_noise.at(since_s)
        return self._amplifier.output_V(times) + noise_V
