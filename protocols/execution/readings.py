"""Makes readings while a run is under way: which samples, which frame, valid or why not."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from drivers.interfaces import Frame, InterpolatedForce, SampleClock, SignalBlock
from protocols.execution.channels import DRIVE_V
from protocols.execution.devices import Devices
from protocols.execution.events import FramesArrived, ReadingTaken, VoltageSet
from protocols.execution.filters import symmetric_mean, window
from protocols.execution.lateness import lateness_s, written_s
from protocols.execution.rules import (
    Rules,
    bad_frame,
    bad_samples,
    force_across_edge,
    late_edge,
    wrong_drive,
)
from protocols.execution.runs.exposures import Exposures
from protocols.execution.samples import SampleBuffer
from protocols.planning.loop_timing import LoopTiming
from protocols.planning.schedule import PlannedReading, PlannedRun

CENTRE_DECIMALS = 6  # of a sample


@dataclass(frozen=True, kw_only=True)
class _Pending:
    """A reading whose edge has been written."""

    planned: PlannedReading
    edge: VoltageSet
    sample_s: float  # clock time of the sampling point
    centre: float  # its sample index, with its fraction
    half_window: float  # in samples

    @property
    def last_sample(self) -> int:
        return window(self.centre, self.half_window)[1]


class ReadingMaker:
    """Is told of edges, samples and frames; hands over readings in their order when complete.

    The sampling point is `delay_s` after the edge as written. A reading is complete when the
    samples of its window are there, and the first frame after its sampling point, or when that
    frame is overdue.
    """

    def __init__(
        self,
        run: PlannedRun,
        devices: Devices,
        sample_clock: SampleClock,
        frame_rate_hz: float,
        rules: Rules,
        timing: LoopTiming,
        *,
        keep_all_frames: bool,
        exposures: Exposures | None = None,
    ) -> None:
        """`exposures`: of a camera that is triggered."""
        self._exposures = exposures
        self._run = run
        self._devices = devices
        self._rows = devices.rows()
        self._sample_clock = sample_clock
        self._rules = rules
        self._timing = timing
        self._keep_all = keep_all_frames
        self._reach_s = rules.frame_periods / frame_rate_hz
        self._pending: deque[_Pending] = deque()
        self._frames: deque[Frame] = deque()
        self._last_frame: Frame | None = None  # of the last reading that had one
        self._used: set[int] = set()  # numbers of frames that went with a reading
        self.samples = SampleBuffer(len(devices.signals.channels))

    @property
    def waiting(self) -> bool:
        """Whether readings are not complete yet."""
        return bool(self._pending)

    def edge(self, event: VoltageSet) -> None:
        """Expect the readings of a step that was written."""
        for planned in self._run.readings:
            if planned.step == event.step:
                self._expect(planned, event)

    def forget_after(self, run_s: float) -> None:
        """Drop the readings that are not over by plan at the run's time `run_s`: it is cut short.

        By plan, because the window of a pulse that is over ends a little later than its pulse
        when its edge was written a little late.
        """
        over = [p for p in self._pending if self._planned_end_s(p.planned) <= run_s]
        self._pending = deque(over)

    def add_block(self, block: SignalBlock) -> None:
        """Add samples that have arrived."""
        self.samples.add(block)

    def add_frames(self, frames: Sequence[Frame]) -> None:
        """Frames have arrived."""
        self._frames.extend(frames if self._exposures is None else self._exposures.matched(frames))

    def complete(self, now_s: float) -> Iterator[ReadingTaken | FramesArrived]:
        """Yield readings that are complete by now, and frames that no reading can want any more."""
        while self._pending and self._is_complete(self._pending[0], now_s):
            yield self._make(self._pending.popleft(), now_s)
        self._forget_samples()
        first_s = min(now_s, self._pending[0].sample_s if self._pending else now_s)
        yield from self._release_frames(first_s - self._reach_s, now_s)

    def leftover_frames(self, now_s: float) -> Iterator[FramesArrived]:
        """Yield the frames that went with no reading, when all are kept and the run is over."""
        yield from self._release_frames(float("inf"), now_s)

    def _planned_end_s(self, planned: PlannedReading) -> float:
        rounding_s = 1e-9
        return self._run.time_of(planned) + planned.half_window_s - rounding_s

    def _expect(self, planned: PlannedReading, event: VoltageSet) -> None:
        sample_s = written_s(event.write) + planned.delay_s
        # A clock that has run longer has coarser times; without its rounding a session that is
        # replayed has the same readings to the last bit.
        centre = round(self._sample_clock.index_at(sample_s), CENTRE_DECIMALS)
        half_window = planned.half_window_s * self._sample_clock.rate_hz
        self._pending.append(
            _Pending(
                planned=planned,
                edge=event,
                sample_s=sample_s,
                centre=centre,
                half_window=half_window,
            )
        )
        if self._exposures is not None:
            self._exposures.expect(sample_s)
        elif self._devices.camera is not None and not self._keep_all:
            self._devices.camera.want(sample_s - self._reach_s, sample_s + self._reach_s)

    def _is_complete(self, pending: _Pending, now_s: float) -> bool:
        if self.samples.end <= pending.last_sample:
            return False
        if self._devices.camera is None:
            return True
        overdue_s = pending.sample_s + self._reach_s + self._timing.frame_grace_s
        return now_s > overdue_s or any(self._when(f) >= pending.sample_s for f in self._frames)

    def _make(self, pending: _Pending, now_s: float) -> ReadingTaken:
        first, last = window(pending.centre, pending.half_window)
        # One sample more on either side: they carry no weight, whichever way the index rounds.
        volts = self.samples.between(first - 1, last + 1)
        signals = self._rows.converted(volts)
        centre = pending.centre - (first - 1)
        values = self._rows.values(symmetric_mean(signals, centre, pending.half_window).value)
        frame = self._nearest_frame(pending.sample_s)
        inner = volts[:, 1:-1]
        why = [
            *late_edge(lateness_s(pending.edge), self._rules),
            *bad_samples(inner, self._rows.channels),
            *wrong_drive(values[DRIVE_V], pending.edge.write.sheet_V, self._rules),
            *self._interpolated(pending, first, last),
        ]
        if frame is not None:
            why += bad_frame(frame, self._last_frame, self._reach_s, self._rules)
            self._last_frame = frame
        elif self._devices.camera is not None:
            why.append(f"no frame within {self._reach_s * 1e3:.0f} ms of the sampling point")
        return ReadingTaken(
            time_s=now_s,
            run=self._run.index,
            planned=pending.planned,
            sample_index=pending.centre,
            sample_time_s=pending.sample_s,
            values=values,
            frame=frame,
            frame_offset_s=None if frame is None else self._when(frame) - pending.sample_s,
            valid=not why,
            why="; ".join(why),
        )

    def _interpolated(self, pending: _Pending, first: int, last: int) -> Iterator[str]:
        """Yield a reason where a meter read the force too seldom about a window."""
        signals, time_of = self._devices.signals, self._sample_clock.time_of
        if isinstance(signals, InterpolatedForce):
            times_s = signals.force_times_s(time_of(first), time_of(last))
            edge_s = written_s(pending.edge.write)
            end_s = edge_s + self._run.held_s(pending.planned.step)
            yield from force_across_edge(times_s, edge_s, end_s, self._rules)

    def _nearest_frame(self, sample_s: float) -> Frame | None:
        near = [f for f in self._frames if abs(self._when(f) - sample_s) <= self._reach_s]
        if not near:
            return None
        # A frame was exposed before it was complete: of two equally near, the later one is right.
        frame = min(near, key=lambda f: (round(abs(self._when(f) - sample_s), 6), -f.time_s))
        self._used.add(frame.number)
        return frame

    def _when(self, frame: Frame) -> float:
        """Return the clock time that counts as a frame's: when it came, or its exposure's middle.

        A frame that nothing has triggered is no reading's.
        """
        if self._exposures is None:
            return frame.time_s
        middle_s = self._exposures.middle_s(frame)
        return float("-inf") if middle_s is None else middle_s

    def _forget_samples(self) -> None:
        """Keep what pending readings need, or one whose edge is being written."""
        if self._pending:
            self.samples.forget_before(
                window(self._pending[0].centre, self._pending[0].half_window)[0] - 1
            )
        else:
            self.samples.forget_before(self.samples.end - int(self._sample_clock.rate_hz))

    def _release_frames(self, before_s: float, now_s: float) -> Iterator[FramesArrived]:
        released = []
        while self._frames and self._frames[0].time_s < before_s:
            frame = self._frames.popleft()
            if frame.number in self._used:
                self._used.discard(frame.number)
            else:
                released.append(frame)
        if released and self._keep_all:
            yield FramesArrived(now_s, self._run.index, tuple(released))
