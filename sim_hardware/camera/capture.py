"""The simulated camera as an object with the interface of `cv2.VideoCapture`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from drivers.interfaces import FREE, HARDWARE, AcquisitionSettings, Clock
from sim_hardware.camera.faults import CameraFaults
from sim_hardware.camera.stream import FrameStream, TriggeredStream
from sim_hardware.simulated_rig import OpticalSide

# OpenCV's numbers of its properties, which do not change.
POS_MSEC, FRAME_WIDTH, FRAME_HEIGHT, FPS, CONVERT_RGB, BUFFER_SIZE = 0, 3, 4, 5, 16, 38
OPEN_TIMEOUT_MSEC, READ_TIMEOUT_MSEC = 53, 54
_POLL_S = 0.01  # whether something was triggered


class SimulatedCapture:
    """The part of `cv2.VideoCapture` that a driver uses, on any clock.

    `grab` waits for the next frame and only marks it; `retrieve` renders it, so frames that nobody
    wants cost nothing. A reader that comes late finds the last `CAP_PROP_BUFFERSIZE` frames (4), as
    a driver keeps them; older ones are lost. As with OpenCV, images have three channels until
    `CAP_PROP_CONVERT_RGB` is set to 0, which gives grey (rows, columns).

    With a `trigger` of software or hardware it exposes a frame at each `fire`, or each time that
    `triggered` is called with the time of an edge; `grab` then returns False where none came.
    """

    def __init__(
        self,
        scene: OpticalSide,
        clock: Clock,
        *,
        faults: CameraFaults | None = None,
        jitter_s: float = 0.0,
        read_timeout_s: float = 2.0,
        trigger: str = FREE,
        exposure_s: float = 5e-3,
    ) -> None:
        self._scene = scene
        self._clock = clock
        self.faults = faults if faults is not None else CameraFaults()
        self._jitter_s = jitter_s
        self._stream: FrameStream | None = None
        self._number: int | None = None  # of the frame that is grabbed
        self._missed = 0
        rows, columns = scene.frame_shape
        self.settings = AcquisitionSettings(
            exposure_s=exposure_s,
            pixel_format="Mono8",
            region=(0, 0, columns, rows),
            frame_rate_hz=scene.frame_rate_hz if trigger == FREE else None,
            trigger=trigger,
        )
        self._properties = {
            CONVERT_RGB: 1.0,
            BUFFER_SIZE: 4.0,
            OPEN_TIMEOUT_MSEC: read_timeout_s * 1e3,
            READ_TIMEOUT_MSEC: read_timeout_s * 1e3,
        }
        self.open()

    def open(self, *_source: Any) -> bool:
        """Restart the camera, from frame 0; the source that OpenCV would open is ignored."""
        now_s = self._clock.now()
        if self.settings.trigger == FREE:
            self._stream = FrameStream(self._scene, now_s, self.faults, self._jitter_s)
        else:
            exposure_s = self.settings.exposure_s or 0.0
            self._stream = TriggeredStream(self._scene, now_s, self.faults, exposure_s)
        self._next = 0
        self._number = None
        return True

    @property
    def layout(self) -> tuple[int, int, np.dtype[np.uint8]]:
        """Rows, columns and type of a frame, once it is grey."""
        return (*self._scene.frame_shape, np.dtype(np.uint8))

    @property
    def losses(self) -> tuple[int, int]:
        """Frames that came incomplete, and those that never came."""
        return 0, self._missed

    def device_number(self) -> int | None:
        """Return the camera's own number of the frame that was grabbed last."""
        return self._number

    def fire(self) -> None:
        """Begin an exposure now: the software trigger."""
        self._expose(self._clock.now())

    def triggered(self, when_s: float) -> None:
        """Begin an exposure at an edge of the trigger input."""
        if self.settings.trigger == HARDWARE:
            self._expose(when_s)

    def _expose(self, when_s: float) -> None:
        if isinstance(self._stream, TriggeredStream):
            self._stream.trigger(when_s)

    def isOpened(self) -> bool:
        """Return whether the camera was opened and not released."""
        return self._stream is not None

    def release(self) -> None:
        """Stop the camera."""
        self._stream = None
        self._number = None

    def getBackendName(self) -> str:
        """OpenCV's name of what reads the camera."""
        return "SIMULATED"

    def grab(self) -> bool:
        """Wait for the next frame; False when the camera is closed, gone, or delivers nothing."""
        self._number = None
        if self._stream is None:
            return False
        if isinstance(self._stream, TriggeredStream):
            return self._grab_triggered(self._stream)
        wait_until = self._clock.now() + self._properties[READ_TIMEOUT_MSEC] / 1000
        kept = max(1, int(self._properties[BUFFER_SIZE]))
        oldest = self._stream.latest_at(self._clock.now()) - kept + 1
        number = max(self._next, oldest)
        stream = self._stream
        while stream.suffers("drop", number) and not stream.suffers("gone", number):
            if stream.arrival_of(number) > wait_until:
                break
            number += 1
        self._missed += number - self._next if self._next else 0
        self._next = number
        if stream.suffers("gone", number):
            return False
        arrival = stream.arrival_of(number)
        self._clock.sleep_until(min(arrival, wait_until))
        if arrival > wait_until:
            return False
        self._next = number + 1
        self._number = number
        return True

    def _grab_triggered(self, stream: TriggeredStream) -> bool:
        number = self._next
        if number >= stream.taken or stream.suffers("gone", number):
            self._clock.sleep_until(self._clock.now() + _POLL_S)
            return False
        self._next = number + 1
        if stream.suffers("drop", number):
            self._missed += 1
            return False
        self._clock.sleep_until(stream.arrival_of(number))
        self._number = number
        return True

    def retrieve(self) -> tuple[bool, npt.NDArray[np.uint8] | None]:
        """Return whether there is a frame, and the one that was grabbed last."""
        if self._stream is None or self._number is None:
            return False, None
        grey = self._stream.image(self._number)
        if self._properties[CONVERT_RGB]:
            return True, np.repeat(grey[:, :, None], 3, axis=2)
        return True, grey

    def read(self) -> tuple[bool, npt.NDArray[np.uint8] | None]:
        """Grab and retrieve."""
        return self.retrieve() if self.grab() else (False, None)

    def get(self, propId: int) -> float:
        """Return a property; 0 for those that are not known, as OpenCV does."""
        rows, columns = self._scene.frame_shape
        if propId == POS_MSEC:
            if self._stream is None or self._number is None:
                return 0.0
            return (self._stream.time_of(self._number) - self._stream.start_s) * 1000
        known = {
            FRAME_WIDTH: float(columns),
            FRAME_HEIGHT: float(rows),
            FPS: self._scene.frame_rate_hz,
        }
        return known.get(propId, self._properties.get(propId, 0.0))

    def set(self, propId: int, value: float) -> bool:
        """Set a property; False for those that this camera cannot change."""
        if propId not in self._properties:
            return False
        self._properties[propId] = float(value)
        return True
