"""The output as a session uses it: every change of its state is reported."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Protocol

from drivers.interfaces import (
    Clock,
    TimedOutput,
    TimedVoltage,
    VoltageOutput,
    VoltageWrite,
)
from protocols.execution.events import Event, OutputChanged, OutputState


class MadeSafe(Protocol):
    """What became of making the output safe."""

    @property
    def is_safe(self) -> bool:
        """Whether 0 V was written and read back."""

    @property
    def text(self) -> str:
        """One sentence for the operator."""


# Write 0 V and read it back, whatever it takes; must not raise.
MakeSafe = Callable[[], MadeSafe]


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
    ) -> None:
        self._output = output
        self._clock = clock
        self._emit = emit
        self._on_energised = on_energised
        self._on_guard = False
        self._reported: OutputState | None = None
        self.state = OutputState.UNKNOWN
        self.energised_once = False
        self.is_loaded = False  # the board has a run, and puts it out by itself
        self._zero_since_s: float | None = None  # since when no other voltage was written

    @property
    def at_zero(self) -> bool:
        """Whether 0 V was confirmed by the last write."""
        return self.state in (OutputState.ARMED, OutputState.SAFE)

    def write(self, sheet_V: float) -> VoltageWrite:
        """Write a voltage, at once; `report` is for when the edge is over.

        Guarding ends here and not with the report, which may take long: a guard that hears no
        beat meanwhile would take this program for dead.
        """
        if sheet_V != 0.0:
            self._begin_guarding()
            self._zero_since_s = None
        self.state = OutputState.UNKNOWN  # should the write raise
        self.is_loaded = False  # a write ends it
        write = self._output.write(sheet_V)
        self.reached(sheet_V)
        if sheet_V == 0.0:
            self._end_guarding()
        return write

    @property
    def is_timed(self) -> bool:
        """Whether a whole run can be loaded into the board."""
        return isinstance(self._output, TimedOutput) and self._output.is_timed

    def load(self, waveform: Sequence[TimedVoltage], rate_hz: float) -> Sequence[float]:
        """Give the board a run; see `TimedOutput.load`.

        From the input's start on the board acts without us, so that a hang must be noticed at any
        time, and not only while there is a voltage: guarding begins here. It begins when all is
        loaded: that may take longer than a guard waits for a beat.
        """
        assert isinstance(self._output, TimedOutput)  # noqa: S101 - see `is_timed`
        self.state = OutputState.UNKNOWN  # should it raise
        board_V = self._output.load(waveform, rate_hz)
        self.is_loaded = True
        self.reached(0.0)
        self._begin_guarding()
        return board_V

    def reached(self, sheet_V: float) -> None:
        """Note a voltage that was confirmed, or that the board has come to in its run."""
        self.state = OutputState.ARMED if sheet_V == 0.0 else OutputState.ENERGISED
        if sheet_V != 0.0:
            self._zero_since_s = None
        elif self._zero_since_s is None:
            self._zero_since_s = self._clock.now()

    def at_zero_s(self, now_s: float) -> float:
        """Return how long before a clock time 0 V was confirmed with nothing else since; 0: not."""
        if not self.at_zero or self._zero_since_s is None:
            return 0.0
        return now_s - self._zero_since_s

    def is_done(self) -> bool:
        """Return whether the board has put out its run, up to the last 0 V: guarding ends then.

        Raises DeviceError when it has failed.
        """
        assert isinstance(self._output, TimedOutput)  # noqa: S101 - see `is_timed`
        done = self._output.is_done()
        if done:
            self._end_guarding()
        return done

    def _begin_guarding(self) -> None:
        if not self._on_guard:
            self.energised_once = True
            self._on_guard = True
            self._on_energised(True)  # noqa: FBT003 - the hook has this one meaning

    def _end_guarding(self) -> None:
        if self._on_guard:
            self._on_guard = False
            self._on_energised(False)  # noqa: FBT003 - as above

    def zero(self) -> VoltageWrite | None:
        """Write 0 V at once; never raises. None: it could not be written, and is still to be."""
        with suppress(Exception):  # what matters now is 0 V; the state shows the failure
            return self.write(0.0)
        return None

    def report(self, why: str) -> None:
        """Emit the state when it has changed."""
        if self.state is not self._reported:
            self._reported = self.state
            self._emit(OutputChanged(self._clock.now(), self.state, why))

    def settle(self, make_safe: MakeSafe) -> str:
        """Make safe at the end, settle on SAFE or UNKNOWN, and return how it went in words."""
        self.state = OutputState.UNKNOWN
        made = make_safe()
        if made.is_safe:
            self.state = OutputState.SAFE
            if self._on_guard:
                self._on_guard = False
                with suppress(Exception):  # a guard that is gone need not know
                    self._on_energised(False)  # noqa: FBT003 - as above
        return made.text
