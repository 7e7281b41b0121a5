"""A simulated rig of wires alone: each leads from an output to an input."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping

import numpy as np

from sim_hardware.simulated_rig import FloatArray


class LoopbackWires:
    """Inputs see the outputs they are wired to; all others see 0 V.

    An end is `ao0`, on whichever board has it, or `PCI6703/ao0`.
    """

    # An output's history is cut to half when it reaches this many changes.
    KEPT_CHANGES = 200_000

    def __init__(self, wires: Mapping[str, str] | Iterable[tuple[str, str]]) -> None:
        """`wires` lead from output to input; pairs, where an output has several."""
        pairs = wires.items() if isinstance(wires, Mapping) else wires
        self._source = {sink.lower(): source.lower() for source, sink in pairs}
        self._times: dict[str, list[float]] = {}
        self._volts: dict[str, list[float]] = {}
        self._lock = threading.Lock()

    def is_wired(self, device: str, channel: str) -> bool:
        """Return whether a wire leads to an input."""
        return any(name in self._source for name in _names(device, channel))

    def write(self, device: str, channel: str, volts: float, when: float) -> None:
        """See `AnalogSide.write`."""
        with self._lock:
            for output in _names(device, channel):
                self._times.setdefault(output, [-np.inf]).append(when)
                self._volts.setdefault(output, [0.0]).append(volts)
                if len(self._times[output]) > self.KEPT_CHANGES:
                    del self._times[output][: self.KEPT_CHANGES // 2]
                    del self._volts[output][: self.KEPT_CHANGES // 2]

    def read(self, device: str, channel: str, times: FloatArray) -> FloatArray:
        """See `AnalogSide.read`."""
        sources = (self._source[name] for name in _names(device, channel) if name in self._source)
        source = next(sources, None)
        with self._lock:
            if source not in self._times:
                return np.zeros(len(times))
            after = np.searchsorted(self._times[source], times, side="right")
            return np.asarray(self._volts[source])[np.maximum(after - 1, 0)]


def _names(device: str, channel: str) -> tuple[str, str]:
    return f"{device}/{channel}".lower(), channel.lower()
