"""What a camera has kept of one run: the wanted frames, and counts of the others."""

from __future__ import annotations

import threading
from collections import deque

from drivers.cameras.capture import OpenedCapture
from drivers.interfaces import CameraCounts, Frame

_LATE_OVER_S = 2.0  # the frame that came soonest after its time stamp, within so long, was in time


class FrameSelection:
    """Frames from one `start` to the next. One thread calls `on_frame`, another the rest."""

    def __init__(self, queue_size: int, began_s: float = 0.0) -> None:
        """`began_s`: a frame that came earlier is none of this run's."""
        self._began_s = began_s
        self._queue: deque[Frame] = deque()
        self._queue_size = queue_size
        self._lock = threading.Lock()
        self._spans: list[tuple[float, float]] = []
        self._everything = False
        self._delays: deque[tuple[float, float]] = deque()  # when, and by how much its stamp is old
        self._grabbed = 0
        self._dropped = 0

    @property
    def counts(self) -> CameraCounts:
        """Frames that arrived, and wanted ones that were lost because nobody fetched them."""
        return CameraCounts(self._grabbed, self._dropped)

    def want(self, from_s: float, to_s: float) -> None:
        """Keep the frames completed between two clock times."""
        with self._lock:
            self._spans.append((from_s, to_s))

    def want_all(self) -> None:
        """Keep every frame."""
        with self._lock:
            self._everything = True

    def frames(self) -> list[Frame]:
        """Return the frames kept since the last call."""
        kept = []
        while self._queue:
            kept.append(self._queue.popleft())
        return kept

    def on_frame(self, capture: OpenedCapture, time_s: float) -> None:
        """Count a frame that came at `time_s`; decode it if it is wanted and there is room."""
        if time_s < self._began_s:
            return
        number, self._grabbed = self._grabbed, self._grabbed + 1
        device_s = capture.device_time_s()
        late_s = 0.0 if device_s is None else self._lateness(time_s, device_s)
        if not self._is_wanted(time_s):
            return
        if len(self._queue) >= self._queue_size:
            self._dropped += 1
            return
        self._queue.append(
            Frame(
                number=number,
                time_s=time_s,
                device_time_s=device_s,
                image=capture.retrieve(),
                late_s=late_s,
                device_number=capture.device_number(),
            )
        )

    def _lateness(self, time_s: float, device_s: float) -> float:
        """Compare with the frame that came soonest: the two clocks differ by a constant."""
        delays = self._delays
        delays.append((time_s, time_s - device_s))
        while delays[0][0] < time_s - _LATE_OVER_S:
            delays.popleft()
        return delays[-1][1] - min(delay for _, delay in delays)

    def _is_wanted(self, time_s: float) -> bool:
        with self._lock:
            self._spans = [span for span in self._spans if span[1] >= time_s]
            return self._everything or any(span[0] <= time_s for span in self._spans)
