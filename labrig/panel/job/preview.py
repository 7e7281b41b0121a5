"""A camera that shows some of its frames while it works for a run."""

from __future__ import annotations

import math

import numpy as np

from drivers.interfaces import (
    AcquisitionSettings,
    Camera,
    CameraCounts,
    Clock,
    Frame,
    TriggerPulse,
)

MOST_BYTES_PER_S = 20e6  # of raw pictures: what is beyond costs the run more than it shows
_FRAMES = 1.5  # a window of so many frame periods holds at least one frame


class Preview:
    """The same camera; frames that no reading asked for are kept, too, and the newest can be had.

    The scheduler's thread calls all methods but `newest`, which another one may call. Frames that
    no reading asked for are handed on with the others: whoever makes readings leaves them out.
    """

    def __init__(self, camera: Camera, clock: Clock, frame_rate_hz: float) -> None:
        self._camera = camera
        self._clock = clock
        self._period_s = 1 / frame_rate_hz
        self._next_s = 0.0
        self._newest: Frame | None = None

    @property
    def every_s(self) -> float:
        """Every frame, unless frames are so large that they would be a burden."""
        size = math.prod(self._camera.frame_shape) * self._camera.dtype.itemsize
        return max(self._period_s, size / MOST_BYTES_PER_S)

    def newest(self) -> Frame | None:
        """Return the newest frame, when it has not been asked for yet."""
        frame, self._newest = self._newest, None
        return frame

    @property
    def frame_shape(self) -> tuple[int, int]:
        """See `Camera`."""
        return self._camera.frame_shape

    @property
    def dtype(self) -> np.dtype[np.uint8] | np.dtype[np.uint16]:
        """See `Camera`."""
        return self._camera.dtype

    @property
    def settings(self) -> AcquisitionSettings:
        """See `Camera`."""
        return self._camera.settings

    def fire(self) -> TriggerPulse:
        """See `Camera`."""
        return self._camera.fire()

    @property
    def counts(self) -> CameraCounts:
        """See `Camera`."""
        return self._camera.counts

    def open(self) -> None:
        """See `Camera`."""
        self._camera.open()

    def start(self) -> None:
        """See `Camera`."""
        self._next_s = 0.0
        self._camera.start()

    def want(self, from_s: float, to_s: float) -> None:
        """See `Camera`."""
        self._camera.want(from_s, to_s)

    def want_all(self) -> None:
        """See `Camera`."""
        self._next_s = float("inf")
        self._camera.want_all()

    def frames(self) -> list[Frame]:
        """See `Camera`."""
        now_s = self._clock.now()
        if now_s >= self._next_s:
            self._next_s = now_s + self.every_s
            self._camera.want(now_s, now_s + _FRAMES * self._period_s)
        found = self._camera.frames()
        if found:
            self._newest = found[-1]
        return found

    def stop(self) -> None:
        """See `Camera`."""
        self._camera.stop()

    def close(self) -> None:
        """See `Camera`."""
        self._camera.close()
