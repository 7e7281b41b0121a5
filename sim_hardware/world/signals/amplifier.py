"""The amplifier: from the board's written volts to the volts at the sheet's clamp, exactly."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim_hardware.world.settings import AmplifierSettings

FloatArray = npt.NDArray[np.float64]


class SimulatedAmplifier:
    """Gain, input offset, rails and a first-order lag; the output is known at any past time.

    Between two writes the output goes exponentially to its new level, so that it and its integral
    are given in closed form, however late or in what pieces they are asked for.
    """

    def __init__(self, settings: AmplifierSettings, start_s: float) -> None:
        from sim_hardware.world.signals import kernels

        self._settling = kernels.settling
        self._settings = settings
        self._lag_s = settings.lag_ms * 1e-3
        self._supplied = True
        level = self._level(0.0)
        # One entry a write: time, level aimed at, output and its integral at that time.
        self._history: list[tuple[float, float, float, float]] = [(start_s, level, level, 0.0)]
        self._table: FloatArray | None = None  # the history as an array (writes, 4)
        self._board_V = 0.0

    @property
    def asked_V(self) -> float:
        """Sheet volts that the board asks for now: without offset and lag, within the rails.

        Nothing while the amplifier has no supply.
        """
        if not self._supplied:
            return 0.0
        s = self._settings
        return max(-s.rail_V, min(s.rail_V, s.gain * self._board_V))

    def write(self, board_V: float, when: float) -> None:
        """Change the board's output; not earlier than the write before."""
        self._board_V = board_V
        self._turn(when)

    def supply(self, when: float, *, on: bool) -> None:
        """Close or open the relay in its supply; not earlier than the last write."""
        self._supplied = on
        self._turn(when)

    def output_V(self, times: FloatArray) -> FloatArray:
        """Volts at the output."""
        return self._at(times)[0]

    def mean_V(self, edges: FloatArray) -> FloatArray:
        """Mean output between each two neighbours of `edges` (n + 1,): (n,)."""
        return np.diff(self._at(edges)[1]) / np.diff(edges)

    def mean_between(self, from_s: FloatArray, to_s: FloatArray) -> FloatArray:
        """Mean output between pairs of times; the output itself where they coincide."""
        span = to_s - from_s
        there, until = self._at(to_s)
        integral = until - self._at(from_s)[1]
        return np.where(span > 0, integral / np.where(span > 0, span, 1.0), there)

    def forget(self, before_s: float) -> None:
        """Forget the output before a time; it is not asked for again."""
        keep = 0
        while keep + 1 < len(self._history) and self._history[keep + 1][0] <= before_s:
            keep += 1
        if keep:
            del self._history[:keep]
            self._table = None

    def _turn(self, when: float) -> None:
        """From now on the output aims at another level."""
        when = max(when, self._history[-1][0])
        output, integral = self._at(np.array([when]))
        level = self._level(self._board_V)
        self._history.append((when, level, float(output[0]), float(integral[0])))
        self._table = None

    def _level(self, board_V: float) -> float:
        if not self._supplied:
            return 0.0
        s = self._settings
        return max(-s.rail_V, min(s.rail_V, s.gain * (board_V + s.offset_mV * 1e-3)))

    def _at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Output, and its integral since the beginning."""
        if self._table is None:
            self._table = np.array(self._history)
        return self._settling(times, self._table, self._lag_s)
