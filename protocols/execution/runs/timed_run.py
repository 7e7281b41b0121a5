"""A run that the board puts out by the clock of its inputs: its edges are samples."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from drivers.interfaces import DeviceError, SampleClock, TimedVoltage, VoltageWrite
from protocols.execution.events import ActionTaken
from protocols.execution.runs.run_context import RunContext
from protocols.planning.schedule import PlannedRun

LATE_S = 0.5  # after its end by our clock, the board has put out its run
_DRIFT = 1e-3  # relative: far beyond what two clocks differ


class BoardTimedRun:
    """The steps of a run as samples of its acquisition."""

    def __init__(
        self,
        context: RunContext,
        first: int,
        waveform: Sequence[TimedVoltage],
        board_V: Sequence[float],
    ) -> None:
        """`first`: the sample of the run's time 0; `board_V`: of each voltage, at the board."""
        self._context = context
        self._first = first
        self._waveform = waveform
        self._board_V = board_V
        self._clock = SampleClock(0.0, 0.0, 1.0)

    def begin(self, clock: SampleClock) -> float:
        """Take the clock of the acquisition that has started; return when time 0 is on it."""
        self._clock = clock
        return clock.time_of(self._first)

    def write(self, step: int) -> VoltageWrite:
        """Return a step's edge as a write that took no time, at its sample."""
        edge = self._waveform[step]
        when_s = self._clock.time_of(edge.index)
        self._context.output.reached(edge.volts)
        return VoltageWrite(edge.volts, self._board_V[step], when_s, when_s)

    def confirm_end(self) -> bool:
        """Return whether the board has come to the run's last 0 V; then 0 V is written, too.

        Raises DeviceError when the board has failed, or is overdue.
        """
        if self._context.output.is_done():
            self._context.output.write(0.0)
            return True
        end_s = self._clock.time_of(self._waveform[-1].index)
        overdue_s = LATE_S + _DRIFT * (end_s - self._clock.start_s)
        if self._context.clock.now() > end_s + overdue_s:
            raise DeviceError(
                "the board has not put out its run in time: its clock is slow, or it was not "
                "started with the inputs; set timed_output = false to have each edge written"
            )
        return False


def load_timed(context: RunContext, run: PlannedRun) -> BoardTimedRun | None:
    """Give the board a run, where it can time it; None: each edge is to be written in its time.

    A controller and a move during the run decide later what is written. A run that takes longer
    than the sheet may be under voltage is left to us, too: the guard sums the time of a run that
    the board puts out as one.
    """
    longest_s = context.longest_timed_s - context.timing.lead_in_s - LATE_S
    by_us = bool(run.reference) or run.move is not None or run.duration_s > longest_s
    if by_us or not context.output.is_timed:
        return None
    rate_hz = context.devices.signals.rate_hz
    first = round(context.timing.lead_in_s * rate_hz)
    waveform = tuple(
        TimedVoltage(first + round(step.time_s * rate_hz), step.voltage_V) for step in run.steps
    )
    apart = all(a.index < b.index for a, b in pairwise(waveform))
    if not apart or waveform[-1].volts != 0.0:
        return None
    what = f"gave run {run.index + 1} to the board, which puts it out by the clock of its inputs"
    context.emit(ActionTaken(context.clock.now(), "labrig", what))
    return BoardTimedRun(context, first, waveform, context.output.load(waveform, rate_hz))
