"""Triggers the camera, and tells which frame shows which moment.

An exposure begins so early that its middle is the sampling point. A frame is that of the trigger
to which its own time stamp fits; where the camera gives none, of the last trigger before it came.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, replace

from drivers.interfaces import Clock, DeviceTimeoutError, Frame, FrameTrigger, TriggerPulse

MOST_UNANSWERED = 5  # triggers one after another that bring no frame: the camera has failed
_PATIENCE_S = 1.0  # for the frame of a trigger
_FIRST_S = 0.25  # for the first frame of a sequence
_NEAR = 0.6  # of a period: a trigger of the sequence so close before a sampling point is left out


@dataclass
class _Fired:
    pulse: TriggerPulse
    answered: bool = False


class Exposures:
    """The exposures of one run. `every_s`: the time between two where all frames are kept."""

    def __init__(
        self, trigger: FrameTrigger, clock: Clock, exposure_s: float, every_s: float | None = None
    ) -> None:
        self._trigger = trigger
        self._clock = clock
        self._half_s = exposure_s / 2
        self._every_s = every_s
        self._due_s: list[float] = []  # a heap: of the sampling points
        self._sequence_s = float("inf") if every_s is None else clock.now()
        self._fired: list[_Fired] = []
        self._offset_s: float | None = None  # from the computer's clock to the camera's

    @property
    def next_s(self) -> float:
        """Clock time of the next trigger; infinity while none is due."""
        wanted_s = self._due_s[0] if self._due_s else float("inf")
        sequence_s = self._sequence_s
        if self._offset_s is None and self._fired and not self._fired[-1].answered:
            # One at a time, until a frame has told the camera's clock.
            sequence_s = max(sequence_s, self._fired[-1].pulse.after_s + _FIRST_S)
        if self._every_s is None or wanted_s - sequence_s < _NEAR * self._every_s:
            return wanted_s
        return min(wanted_s, sequence_s)

    @property
    def unanswered(self) -> int:
        """How many triggers have brought no frame."""
        return sum(not each.answered for each in self._fired)

    @property
    def fired(self) -> int:
        """How many triggers were given."""
        return len(self._fired)

    def expect(self, sample_s: float) -> None:
        """Expose a frame whose middle is at this clock time."""
        heapq.heappush(self._due_s, sample_s - self._half_s)

    def middle_s(self, frame: Frame) -> float | None:
        """Return the clock time of the middle of a frame's exposure; None: nothing triggered it."""
        return None if frame.trigger_s is None else frame.trigger_s + self._half_s

    def fire(self) -> None:
        """Give the trigger that is due. Raises DeviceError; DeviceTimeoutError of a dead camera."""
        due_s, now_s = self.next_s, self._clock.now()
        self._require_answers(now_s)
        if self._due_s and self._due_s[0] <= due_s:
            heapq.heappop(self._due_s)
        self._fired.append(_Fired(self._pulse()))
        if self._every_s is not None:
            self._sequence_s = max(due_s, now_s - self._every_s) + self._every_s

    def _pulse(self) -> TriggerPulse:
        """Trigger; one that is not confirmed in time costs its frame, and not yet the run."""
        before_s = self._clock.now()
        try:
            return self._trigger.fire()
        except DeviceTimeoutError:
            return TriggerPulse(before_s, self._clock.now())

    def matched(self, frames: Sequence[Frame]) -> list[Frame]:
        """Return the frames with the time of the trigger that began each."""
        return [self._matched(frame) for frame in frames]

    def _require_answers(self, now_s: float) -> None:
        last = self._fired[-MOST_UNANSWERED:]
        if len(last) < MOST_UNANSWERED or any(each.answered for each in last):
            return
        if now_s - last[0].pulse.after_s > _PATIENCE_S:
            raise DeviceTimeoutError(
                f"the camera has sent no frame for the last {MOST_UNANSWERED} triggers; check its "
                "cable and power, and the wire of its trigger"
            )

    def _matched(self, frame: Frame) -> Frame:
        fired = self._by_stamp(frame) or self._by_arrival(frame)
        if fired is None:
            return frame
        fired.answered = True
        if frame.device_time_s is not None and self._offset_s is None:
            self._offset_s = frame.device_time_s - fired.pulse.middle_s
        return replace(frame, trigger_s=fired.pulse.middle_s)

    def _by_stamp(self, frame: Frame) -> _Fired | None:
        if frame.device_time_s is None or self._offset_s is None:
            return None
        expected_s = frame.device_time_s - self._offset_s
        waiting = [each for each in self._fired if not each.answered]
        nearest = min(waiting, key=lambda each: abs(each.pulse.middle_s - expected_s), default=None)
        if nearest is None:
            return None
        gap_s = nearest.pulse.middle_s - expected_s
        if abs(gap_s) > self._tolerance_s or nearest.pulse.before_s > frame.time_s:
            self._offset_s = None  # a frame was taken for that of another trigger
            return None
        self._offset_s -= gap_s  # the two clocks drift
        return nearest

    @property
    def _tolerance_s(self) -> float:
        return 0.4 * (self._every_s or 0.05)

    def _by_arrival(self, frame: Frame) -> _Fired | None:
        for each in reversed(self._fired):
            if each.pulse.before_s <= frame.time_s:
                return None if each.answered else each
        return None
