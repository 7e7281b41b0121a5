"""Square waves that come from outside to the PFI terminals of boards: what triggers wait for."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sim_hardware.ni.devices import DeviceRegistry
from sim_hardware.ni.errors import StatusError
from sim_hardware.ni.signals.terminals import Terminal, terminal
from sim_hardware.ni.signals.timing import RISING


class ExternalEdges:
    """A terminal that is named has rising edges at whole periods of the clock, falling between."""

    def __init__(self, devices: DeviceRegistry, rates_hz: Mapping[str, float]) -> None:
        """`rates_hz` by terminal, such as Dev1/PFI0. ValueError for what is no PFI terminal."""
        self._rates_hz: dict[Terminal, float] = {}
        for name, rate_hz in rates_hz.items():
            try:
                found = terminal(devices, name)
            except StatusError:
                found = None
            if found is None or found.side is not None:
                raise ValueError(f"'{name}' is no PFI terminal of a board, such as Dev1/PFI0")
            if not 0.0 < rate_hz < math.inf:
                raise ValueError(f"the edges at '{name}' need a rate above 0 Hz, not {rate_hz:g}")
            self._rates_hz[found] = rate_hz

    def next_s(self, place: Terminal, edge: int, after_s: float) -> float:
        """Return when the next edge after a time comes; inf: none ever comes."""
        rate_hz = self._rates_hz.get(place)
        if rate_hz is None:
            return math.inf
        phase = 0.0 if edge == RISING else 0.5
        number = math.floor(after_s * rate_hz - phase) + 1
        when_s = (number + phase) / rate_hz
        return when_s if when_s > after_s else (number + 1 + phase) / rate_hz
