"""A camera behind OpenCV's `VideoCapture`, or anything with its interface.

A thread takes every frame from `open` to `close`, so that no buffer ever holds a stale one, and
decodes only those that are wanted.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from drivers.cameras.capture import OpenedCapture, open_capture
from drivers.cameras.frame_selection import FrameSelection
from drivers.interfaces import (
    SOFTWARE,
    AcquisitionSettings,
    CameraCounts,
    Clock,
    DeviceError,
    DeviceIdentity,
    DeviceTimeoutError,
    Frame,
    ThreadHandle,
    TriggerPulse,
    in_words,
)

STALL_S = 2.0  # a camera that is silent for so long has stopped delivering
_JOIN_S = 5.0
_STEP_S = 1e-6  # between two frames at least, however coarse their times are


class CaptureCamera:
    """A `Camera` on a capture.

    `source`: an index, a device path, a file or a URL, as OpenCV opens it. `capture_factory` makes
    the capture from it; by default that is `cv2.VideoCapture`.
    """

    def __init__(
        self,
        source: int | str,
        clock: Clock,
        capture_factory: Callable[..., Any] | None = None,
        queue_size: int = 64,
        stall_s: float = STALL_S,
    ) -> None:
        self._source = source
        self._clock = clock
        self._factory = capture_factory
        self._queue_size = queue_size
        self._stall_s = stall_s
        self._opened: OpenedCapture | None = None
        self._thread: ThreadHandle | None = None
        self._closing = threading.Event()
        self._take = FrameSelection(queue_size)
        self._running = False
        self._lost = self._lost_before = (0, 0)  # incomplete, missed: at the end, at the start
        self._alive_s = 0.0  # when the last frame came
        self._fault: str | None = None
        self._cause: BaseException | None = None  # of the fault, where the capture raised it

    def open(self) -> None:
        """See `Camera.open`; waits for one frame, to know what frames look like."""
        if self._opened is not None:
            return
        opened = open_capture(self._source, self._factory)
        self._opened = opened
        self._fault = self._cause = None
        self._closing.clear()
        self._alive_s = self._clock.now()
        self._thread = self._clock.start_thread(lambda: self._grab_all(opened), "camera")

    def identities(self) -> tuple[DeviceIdentity, ...]:
        """See `Identified.identities`."""
        return (self._taken().identity(),)

    @property
    def frame_shape(self) -> tuple[int, int]:
        """See `Camera.frame_shape`."""
        return self._taken().shape

    @property
    def dtype(self) -> np.dtype[np.uint8] | np.dtype[np.uint16]:
        """See `Camera.dtype`."""
        return self._taken().dtype

    @property
    def stated_shape(self) -> tuple[int, int]:
        """Rows and columns of a frame as the capture states them; 0 where it does not."""
        return self._taken().stated_shape

    @property
    def settings(self) -> AcquisitionSettings:
        """See `Camera.settings`."""
        return self._taken().settings

    def fire(self) -> TriggerPulse:
        """See `Camera.fire`."""
        opened = self._taken()
        if opened.settings.trigger != SOFTWARE:
            raise DeviceError(f"the camera {self._source} takes no software trigger as it is set")
        before_s = self._clock.now()
        opened.fire()
        return TriggerPulse(before_s, self._clock.now())

    @property
    def counts(self) -> CameraCounts:
        """See `Camera.counts`."""
        lost = self._opened.losses if self._running and self._opened else self._lost
        incomplete, missed = (
            now - before for now, before in zip(lost, self._lost_before, strict=True)
        )
        return replace(self._take.counts, incomplete=incomplete, missed=missed)

    def start(self) -> None:
        """See `Camera.start`; DeviceError when it has stopped delivering meanwhile."""
        opened = self._taken()
        if self._running:
            raise DeviceError(f"the camera {self._source} is running already")
        self._check_delivery()
        self._take = FrameSelection(self._queue_size, self._clock.now())
        self._lost = self._lost_before = opened.losses
        self._running = True

    def want(self, from_s: float, to_s: float) -> None:
        """See `Camera.want`."""
        self._take.want(from_s, to_s)

    def want_all(self) -> None:
        """See `Camera.want_all`."""
        self._take.want_all()

    def frames(self) -> list[Frame]:
        """See `Camera.frames`."""
        kept = self._take.frames()
        if not kept and self._running:
            self._check_delivery()
        return kept

    def stop(self) -> None:
        """See `Camera.stop`. Frames that were kept can still be fetched."""
        if self._running and self._opened is not None:
            self._lost = self._opened.losses
        self._running = False

    def close(self) -> None:
        """See `Camera.close`."""
        self.stop()
        opened, self._opened = self._opened, None
        thread, self._thread = self._thread, None
        self._closing.set()
        if thread is not None and not thread.join(_JOIN_S):
            # Its thread is still inside the capture, which must not be released under it.
            raise DeviceTimeoutError(
                f"the camera {self._source} did not end its last frame in {_JOIN_S:g} s; check its "
                "connection, and restart labrig before using it again"
            )
        if opened is not None:
            opened.release()

    def _taken(self) -> OpenedCapture:
        if self._opened is None:
            raise DeviceError(f"the camera {self._source} is not open")
        return self._opened

    def _check_delivery(self) -> None:
        if self._fault is not None:
            text = f"the camera {self._source} has stopped delivering: {self._fault}"
            raise DeviceError(text) from self._cause
        if self._opened is not None and self._opened.is_triggered:
            return  # it is silent until it is triggered; whoever does that counts the frames
        silent_s = self._clock.now() - self._alive_s
        if silent_s > self._stall_s:
            raise DeviceTimeoutError(
                f"the camera {self._source} has sent no frame for {silent_s:.1f} s; check its "
                "cable and power"
            )

    def _grab_all(self, opened: OpenedCapture) -> None:
        """Run the camera's thread; what ends it is kept, for whoever asks for frames."""
        try:
            self._grab_until_closed(opened)
        except BaseException as fault:  # noqa: BLE001 - a thread has nobody to raise to
            self._fault, self._cause = in_words(fault), fault

    def _grab_until_closed(self, opened: OpenedCapture) -> None:
        pace = opened.pace(self._clock)
        came_s = float("-inf")
        while not self._closing.is_set():
            pace()
            if not opened.grab():
                if opened.is_triggered:
                    continue
                self._fault = "no further frame came (unplugged, or the stream has ended)"
                return
            self._alive_s = self._clock.now()
            came_s = max(opened.came_s(self._clock), came_s + _STEP_S)
            if self._running:
                self._take.on_frame(opened, came_s)
