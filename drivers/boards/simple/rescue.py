"""Make the output of a simple board safe from another process than the one that drove it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drivers.boards.contract import DRIVE
from drivers.boards.simple.board import SimpleSettings
from drivers.boards.simple.connection import SimpleConnection, inputs_of
from drivers.interfaces import Clock, DeviceError
from drivers.safe_shutdown import READ_BACK_S, SafetyReport, attempt, judge, mean_when_low

_HELD_S = 0.1  # so long a program that lives may need to let go by itself
_RETRY_S = 0.01


class SimpleRescue:
    """An `OutputRescue`. It takes the board when it must, not before: the program has it."""

    def __init__(
        self,
        connection: SimpleConnection,
        settings: SimpleSettings,
        safe_below_V: float,
        clock: Clock,
    ) -> None:
        self._connection, self._settings = connection, settings
        self._safe_below_V, self._clock = safe_below_V, clock

    def open(self) -> None:
        """See `OutputRescue.open`. There is nothing to load."""

    def make_safe(self, patience_s: float, on_held: Callable[[], None]) -> SafetyReport:
        """See `OutputRescue.make_safe`."""
        failures: list[str] = []
        seen: list[float] = []
        written = False
        if attempt(failures, lambda: self._take(patience_s, on_held)):
            # Only 0 V is ever written here.
            written = attempt(failures, self._connection.voltage_output(0.0).open)
            attempt(failures, lambda: seen.append(self._read_back()))
        attempt(failures, self._connection.close)
        return judge(written, seen[0] if seen else None, self._safe_below_V, failures)

    def close(self) -> None:
        """See `OutputRescue.close`."""
        self._connection.close()

    def _take(self, patience_s: float, on_held: Callable[[], None]) -> None:
        """Open the board as soon as nobody has it."""
        began_s = self._clock.now()
        while True:
            try:
                return self._connection.open()
            except DeviceError:
                waited_s = self._clock.now() - began_s
                if waited_s > patience_s:
                    raise
                if waited_s > _HELD_S:
                    on_held()
            self._clock.sleep_until(self._clock.now() + _RETRY_S)

    def _read_back(self) -> float:
        drive = [each for each in inputs_of(self._settings) if each.name == DRIVE]
        signals = self._connection.signal_input(drive)
        signals.open()
        try:
            return mean_when_low(
                lambda: float(np.mean(signals.measure(READ_BACK_S))), self._safe_below_V
            )
        finally:
            attempt([], signals.close)
