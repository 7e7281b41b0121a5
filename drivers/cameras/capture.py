"""OpenCV's `VideoCapture` made grey, bounded in time and clear about what is wrong.

A capture of another make has the methods of `VideoCapture` that are used here. It may have more:
`settings` (AcquisitionSettings, as read back), `layout` (rows, columns, type of a frame, known
before the first one), `losses` (frames that came incomplete, and that never came, since it was
opened), `device_number()` and `age_s()` of the frame last grabbed, `fire()` for a software trigger,
and `identity()`.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from drivers.cameras.sources import identity_of_source, is_file, is_url
from drivers.interfaces import (
    FREE,
    AcquisitionSettings,
    Clock,
    DeviceError,
    DeviceIdentity,
    DeviceNotFoundError,
    GreyImage,
)

OPEN_TIMEOUT_S = 5.0
READ_TIMEOUT_S = 2.0
_LOOKS = 3
_METHODS = ("isOpened", "grab", "retrieve", "read", "get", "set", "release")
# OpenCV's numbers for the properties used, so that a capture of another make needs no OpenCV.
POS_MSEC, WIDTH, HEIGHT, FPS = 0, 3, 4, 5
POS_FRAMES, CONVERT_RGB, BUFFER_SIZE, READ_TIMEOUT_MSEC = 1, 16, 38, 54


class OpenedCapture:
    """A capture that has delivered a first frame. `source` is its name in error texts."""

    def __init__(self, capture: Any, source: int | str) -> None:
        self._capture = capture
        self._source = source
        self._is_file = is_file(source)
        free = AcquisitionSettings(trigger=FREE)
        self.settings: AcquisitionSettings = getattr(capture, "settings", free)
        self.shape: tuple[int, int]
        self.dtype: np.dtype[np.uint8] | np.dtype[np.uint16]
        if self.is_triggered:  # no frame comes by itself
            rows, columns, self.dtype = capture.layout
            self.shape = (rows, columns)
        else:
            first = self._first_frame()
            self.shape, self.dtype = (first.shape[0], first.shape[1]), first.dtype

    @property
    def is_triggered(self) -> bool:
        """Whether frames come only when they are triggered."""
        return self.settings.trigger not in (FREE, None)

    @property
    def stated_shape(self) -> tuple[int, int]:
        """Rows and columns of a frame as the capture states them; 0 where it does not."""
        return int(self._capture.get(HEIGHT)), int(self._capture.get(WIDTH))

    @property
    def losses(self) -> tuple[int, int]:
        """Frames since it was opened that came incomplete, and that never came."""
        found: tuple[int, int] = getattr(self._capture, "losses", (0, 0))
        return found

    def grab(self) -> bool:
        """Take the next frame; waits for it. False when none will come, or none was triggered."""
        return bool(self._capture.grab())

    def fire(self) -> None:
        """Begin an exposure by the camera's own command."""
        self._capture.fire()

    def came_s(self, clock: Clock) -> float:
        """Return the clock time at which the frame last grabbed came: now, or before."""
        if not hasattr(self._capture, "age_s"):
            return clock.now()
        found: list[tuple[float, float]] = []
        for _ in range(_LOOKS):  # this thread may stand still between the two clocks
            before_s = clock.now()
            age_s = float(self._capture.age_s())
            after_s = clock.now()
            found.append((after_s - before_s, (before_s + after_s) / 2 - age_s))
        return min(found)[1]

    def device_number(self) -> int | None:
        """Return the camera's own number of the frame last grabbed, where it gives one."""
        ask = getattr(self._capture, "device_number", None)
        found: int | None = None if ask is None else ask()
        return found

    def retrieve(self) -> GreyImage:
        """Return the frame last grabbed, grey."""
        good, raw = self._pair("retrieve", self._capture.retrieve())
        if not good or raw is None:
            raise DeviceError(f"a frame of camera {self._source} could not be decoded")
        image = as_grey(raw, self._source)
        if image.shape != self.shape or image.dtype != self.dtype:
            raise DeviceError(
                f"camera {self._source} sent a frame of {_describe(image)} after frames of "
                f"{self.shape[1]} x {self.shape[0]} {self.dtype}; restart it"
            )
        return image

    def device_time_s(self) -> float | None:
        """Return the time stamp that the camera or stream gave the frame last grabbed."""
        stamp = float(self._capture.get(POS_MSEC))
        return stamp / 1e3 if stamp > 0.0 else None

    def pace(self, clock: Clock) -> Callable[[], None]:
        """Return what is called before each grab: a recording is played at its own rate."""
        if not self._is_file:
            return lambda: None
        rate_hz = float(self._capture.get(FPS)) or 25.0
        frame, began_s = 0, clock.now()

        def wait() -> None:
            nonlocal frame
            frame += 1
            clock.sleep_until(began_s + frame / rate_hz)

        return wait

    def identity(self) -> DeviceIdentity:
        """Return what is known of the camera: by the capture itself, else by the system."""
        if hasattr(self._capture, "identity"):
            found: DeviceIdentity = self._capture.identity()
            return found
        return identity_of_source(self._source, self._capture)

    def release(self) -> None:
        """Let go of the camera."""
        self._capture.release()

    def _first_frame(self) -> npt.NDArray[Any]:
        """One frame, raw where the camera is grey by itself, else converted by OpenCV."""
        capture = self._capture
        capture.set(BUFFER_SIZE, 1)  # where it can be set: no stale frames
        capture.set(READ_TIMEOUT_MSEC, READ_TIMEOUT_S * 1e3)
        capture.set(CONVERT_RGB, 0)
        image = self._read()
        if image.shape[:2] != self.stated_shape or not _is_plain(image):
            capture.set(CONVERT_RGB, 1)  # packed or compressed data: let OpenCV decode it
            image = self._read()
        if self._is_file:
            capture.set(POS_FRAMES, 0)
        return as_grey(image, self._source)

    def _read(self) -> npt.NDArray[Any]:
        good, image = self._pair("read", self._capture.read())
        if not good or image is None:
            raise DeviceNotFoundError(
                f"[camera] source = {self._source}: it opens but sends no frame within "
                f"{READ_TIMEOUT_S:g} s; check that nothing else uses it"
            )
        return np.asarray(image)

    def _pair(self, method: str, answer: object) -> tuple[Any, Any]:
        """Return both parts of what the capture answered, which may be other people's code."""
        if isinstance(answer, tuple | list) and len(answer) == 2:
            return answer[0], answer[1]
        raise DeviceError(
            f"the capture of camera {self._source} returned {type(answer).__name__} from {method}, "
            "not (True, image)"
        )


def open_capture(source: int | str, factory: Callable[..., Any] | None = None) -> OpenedCapture:
    """Open a camera and take its first frame. Raises DeviceNotFoundError in bounded time."""
    capture = _video_capture(source) if factory is None else factory(source)
    missing = [name for name in _METHODS if not callable(getattr(capture, name, None))]
    try:
        if missing:
            kind, names = type(capture).__name__, ", ".join(missing)
            raise DeviceError(f"the capture of camera {source} ({kind}) has no {names}")
        if not capture.isOpened():
            raise DeviceNotFoundError(f"[camera] source = {source}: {_why_not(source)}")
        return OpenedCapture(capture, source)
    except BaseException:
        if "release" not in missing:
            capture.release()
        raise


def as_grey(image: npt.NDArray[Any], source: int | str) -> GreyImage:
    """Rows x columns, 8 or 16 bit, in memory of its own order."""
    if image.dtype not in (np.uint8, np.uint16):
        raise DeviceError(f"camera {source} sends {image.dtype} pixels; 8 or 16 bit are needed")
    if image.ndim == 3 and image.shape[2] in (3, 4):
        import cv2

        to_grey = cv2.COLOR_BGR2GRAY if image.shape[2] == 3 else cv2.COLOR_BGRA2GRAY
        image = cv2.cvtColor(image, to_grey)
    elif image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim != 2:
        raise DeviceError(f"camera {source} sends frames of shape {image.shape}; no image")
    return np.ascontiguousarray(image)


def _is_plain(image: npt.NDArray[Any]) -> bool:
    return image.ndim == 2 or (image.ndim == 3 and image.shape[2] in (1, 3, 4))


def _describe(image: npt.NDArray[Any]) -> str:
    return f"{image.shape[1]} x {image.shape[0]} {image.dtype}"


def _video_capture(source: int | str) -> Any:
    # We say ourselves what is wrong, also of a stream that ends later. FFmpeg writes by itself, and
    # is configured before it is first used.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    import cv2

    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    if is_url(source):
        limits = [
            cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, int(OPEN_TIMEOUT_S * 1e3),
            cv2.CAP_PROP_READ_TIMEOUT_MSEC, int(READ_TIMEOUT_S * 1e3),
        ]  # fmt: skip
        return cv2.VideoCapture(source, cv2.CAP_FFMPEG, limits)
    return cv2.VideoCapture(source)


def _why_not(source: int | str) -> str:
    if is_url(source):
        return (
            f"nobody sends an image there (waited {OPEN_TIMEOUT_S:g} s at most); check the "
            "address, and that the camera's server runs"
        )
    if isinstance(source, int):
        return "there is no camera of this number, or another program uses it"
    if is_file(source):
        return "the file holds no video that can be read"
    if _is_pipeline(source):
        return (
            "this is a GStreamer pipeline, and the OpenCV that is installed is built without "
            "GStreamer (pip's always is); docs/howto/cameras.md says how one can be had"
        )
    return "no camera or file of this name can be opened; correct it in rig.toml"


def _is_pipeline(source: str) -> bool:
    """Whether a source is a GStreamer pipeline that this OpenCV cannot read."""
    import cv2

    return "!" in source and not cv2.videoio_registry.hasBackend(cv2.CAP_GSTREAMER)
