"""The output as a session uses it: every change of its state is told, and 0 V is insisted on."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from drivers.interfaces import Clock, FloatArray, VoltageOutput, VoltageWrite
from protocols.events import Event, OutputChanged, OutputState
from protocols.rules import Timing

SWITCH_OFF = "switch the amplifier off"


class GuardedOutput:
    """Wraps a VoltageOutput and knows what is known of the sheet's voltage.

    `on_energised(True)` is called before the first voltage is written, so that whoever watches
    over the process is on guard by then; `on_energised(False)` after 0 V was confirmed.
    """

    def __init__(
        self,
        output: VoltageOutput,
        clock: Clock,
        emit: Callable[[Event], None],
        on_energised: Callable[[bool], None],
        timing: Timing,
    ) -> None:
        self._output = output
        self._clock = clock
        self._emit = emit
        self._on_energised = on_energised
        self._timing = timing
        self._on_guard = False
        self._told: OutputState | None = None
        self.state = OutputState.UNKNOWN
        self.energised_once = False

    @property
    def at_zero(self) -> bool:
        """Whether 0 V was confirmed by the last write."""
        return self.state in (OutputState.ARMED, OutputState.SAFE)

    def write(self, sheet_V: float) -> VoltageWrite:
        """Write a voltage, at once; `tell` is for when the edge is over.

        Guarding ends here and not with the telling, which may take long: a guard that hears no
        beat meanwhile would take this program for dead.
        """
        if sheet_V != 0.0 and not self._on_guard:
            self.energised_once = True
            self._on_guard = True
            self._on_energised(True)  # noqa: FBT003 - the hook has this one meaning
        self.state = OutputState.UNKNOWN  # should the write raise
        write = self._output.write(sheet_V)
        self.state = OutputState.ARMED if sheet_V == 0.0 else OutputState.ENERGISED
        if sheet_V == 0.0 and self._on_guard:
            self._on_guard = False
            self._on_energised(False)  # noqa: FBT003 - as above
        return write

    def zero(self) -> VoltageWrite | None:
        """Write 0 V, again when that fails; never raises. None: it could not be written."""
        for attempt in range(self._timing.attempts):
            if attempt:
                with suppress(Exception):
                    self._clock.sleep_until(self._clock.now() + self._timing.retry_s)
            with suppress(Exception):  # what matters now is 0 V; the state tells of the failure
                return self.write(0.0)
        return None

    def tell(self, why: str) -> None:
        """Emit the state when it has changed."""
        if self.state is not self._told:
            self._told = self.state
            self._emit(OutputChanged(self._clock.now(), self.state, why))

    def verify(self, read_back: Callable[[float], FloatArray], safe_below_V: float) -> str:
        """Write 0 V once more, read it back, and settle on SAFE or UNKNOWN; the reason in words.

        `read_back(duration_s)` returns samples of the sheet's voltage. Never raises.
        """
        if self.zero() is None:
            return f"0 V could not be written; {SWITCH_OFF}"
        self.state = OutputState.UNKNOWN
        try:
            self._clock.sleep_until(self._clock.now() + self._timing.settle_s)
            samples_V = read_back(self._timing.read_back_s)
            found_V = float(np.mean(samples_V)) if samples_V.size else float("nan")
        except Exception as error:  # noqa: BLE001 - unknown is the answer to all of them
            return f"0 V was written but could not be read back ({error}); {SWITCH_OFF}"
        if not abs(found_V) < safe_below_V:
            return f"0 V was written but {found_V:.3g} V is read back; {SWITCH_OFF}"
        self.state = OutputState.SAFE
        return f"0 V written and read back as {found_V * 1e3:.1f} mV"
