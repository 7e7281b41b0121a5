"""The device's watchdog: registers 61600 to 61653, and what happens on time-out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

ENABLE, TIMEOUT_S, STRICT, KEY, CLEAR = 61600, 61604, 61610, 61612, 61614
DIO, DIO_STATE, DIO_DIRECTION, DIO_INHIBIT = 61630, 61632, 61634, 61636
DAC_ENABLE, DAC_V = (61640, 61650), (61642, 61652)
WHOLE = (61600, 61602, 61604, 61606, 61610, 61612, 61620, 61630, 61632, 61634, 61636, 61640, 61650)


@dataclass(kw_only=True)
class DeviceWatchdog:
    """Counts since it was cleared. `set_dac` and `set_lines` do what is due, at its time."""

    set_dac: Callable[[int, float, float], None]  # number, volts, when
    set_lines: Callable[[int, int, int, float], None]  # state, direction, inhibit, when
    values: dict[int, float] = field(default_factory=lambda: dict.fromkeys([*WHOLE, *DAC_V], 0.0))
    fired: int = 0
    _cleared_s: float = 0.0

    @property
    def enabled(self) -> bool:
        """Whether it counts."""
        return self.values[ENABLE] == 1

    def heard(self, now_s: float) -> None:
        """Any request clears it, unless it is strict."""
        if not self.values[STRICT]:
            self._cleared_s = now_s

    def clear(self, key: float, now_s: float) -> None:
        """Take a write to the register that clears it."""
        if not self.values[STRICT] or key == self.values[KEY]:
            self._cleared_s = now_s

    def enable(self, now_s: float) -> None:
        """Start to count."""
        self._cleared_s = now_s

    def advance(self, now_s: float) -> None:
        """Do what is due by now. It goes on to count: the actions come again."""
        timeout_s = self.values[TIMEOUT_S]
        while self.enabled and timeout_s > 0 and now_s >= self._cleared_s + timeout_s:
            self._cleared_s += timeout_s
            self._act(self._cleared_s)

    def _act(self, when: float) -> None:
        self.fired += 1
        values = self.values
        if values[DIO]:
            state, direction, inhibit = (
                int(values[a]) for a in (DIO_STATE, DIO_DIRECTION, DIO_INHIBIT)
            )
            self.set_lines(state, direction, inhibit, when)
        for number in range(2):
            if values[DAC_ENABLE[number]]:
                self.set_dac(number, values[DAC_V[number]], when)
