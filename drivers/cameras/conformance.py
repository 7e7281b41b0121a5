"""Whether a camera keeps its contract."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drivers.cameras.capture_camera import CaptureCamera
from drivers.conformance import Checks
from drivers.interfaces import SOFTWARE, AcquisitionSettings, Camera, Clock, Frame

OPEN_S, CLOSE_S = 10.0, 5.5


METHODS = ("open", "start", "want", "want_all", "frames", "stop", "fire", "close")
MOST_FRAMES_PER_S = 2000.0  # that any camera sends
FASTER = 2.0  # times the rate that was asked for; a camera beyond it does not wait for its frames


def camera_faults(
    camera: Camera, clock: Clock, watch_s: float = 1.0, *, rate_hz: float | None = None
) -> list[str]:
    """Return what a camera, not open yet, does against `Camera`; it must send frames by itself.

    Takes about four times `watch_s`, in which a good camera sends at least four frames. `rate_hz`:
    the frames per second that it was made for; None: those of its settings.
    """
    checks = Checks(clock)
    if not checks.has(camera, METHODS):
        return checks.faults
    checks.refuse("start before open", camera.start)
    checks.call("open", camera.open, OPEN_S)
    if not checks.faults:
        checks.identify(camera)
        settings = checks.call("settings", lambda: camera.settings)
        checks.require(
            isinstance(settings, AcquisitionSettings), f"settings are {settings!r}, not of the type"
        )
        if settings is not None and settings.trigger != SOFTWARE:
            checks.refuse("fire of a camera that takes no command", camera.fire)
        _size(checks, camera)
        if rate_hz is None and settings is not None:
            rate_hz = settings.frame_rate_hz
        _watch(checks, camera, watch_s, rate_hz)
        _watch_again(checks, camera, watch_s)
    checks.call("close", camera.close, CLOSE_S)
    checks.call("a second close", camera.close, CLOSE_S)
    checks.refuse("start after close", camera.start)
    return checks.faults


def _size(checks: Checks, camera: Camera) -> None:
    """Compare what a capture states as OpenCV's do, get(3) and get(4), with its first frame."""
    if not isinstance(camera, CaptureCamera):
        return
    (rows, columns), (high, wide) = camera.frame_shape, camera.stated_shape
    if high > 0 and wide > 0:  # else it does not say
        checks.require(
            (high, wide) == (rows, columns),
            f"it states {wide} x {high} pixels (width x height), and its frames have "
            f"{columns} x {rows}",
        )


def _rate(checks: Checks, grabbed: int, took_s: float, rate_hz: float | None) -> None:
    most_hz = MOST_FRAMES_PER_S if rate_hz is None else FASTER * rate_hz
    asked = "no camera is so fast" if rate_hz is None else f"{rate_hz:g} a second were asked for"
    checks.require(
        grabbed <= most_hz * took_s + 2,
        f"{grabbed} frames came in {took_s:.3g} s; {asked}: does `grab` wait for the next one?",
    )


def _watch(checks: Checks, camera: Camera, watch_s: float, rate_hz: float | None) -> None:
    """Keep every frame of a while."""
    shape, dtype = camera.frame_shape, camera.dtype
    if not checks.require(
        len(shape) == 2 and all(size > 0 for size in shape),
        f"frame_shape is {shape}, not rows and columns",
    ):
        return
    checks.require(
        dtype in (np.dtype(np.uint8), np.dtype(np.uint16)), f"dtype is {dtype}, not uint8 or uint16"
    )
    checks.call("start", camera.start)
    began_s = checks.clock.now()
    checks.refuse("a second start", camera.start)
    checks.call("want_all", camera.want_all)
    checks.wait(watch_s)
    frames = checks.call("frames", camera.frames) or []
    checks.require(len(frames) >= 2, f"{len(frames)} frames came in {watch_s:g} s")
    for frame in frames:
        _frame(checks, frame, camera)
    _order(checks, frames, began_s)
    counts = camera.counts
    _rate(checks, counts.grabbed, checks.clock.now() - began_s, rate_hz)
    checks.require(
        counts.grabbed >= len(frames), f"counts.grabbed is {counts.grabbed} of {len(frames)} frames"
    )
    checks.call("stop", camera.stop)
    checks.call("a second stop", camera.stop)
    grabbed = camera.counts.grabbed
    checks.wait(watch_s)
    checks.require(camera.counts.grabbed <= grabbed + 1, "frames are counted after stop")
    checks.call("frames after stop", camera.frames)


def _watch_again(checks: Checks, camera: Camera, watch_s: float) -> None:
    """Begin anew, and keep the frames of a part of the time."""
    checks.call("start after stop", camera.start)
    checks.require(camera.counts.grabbed <= 1, "counts go on after another start")
    began_s = checks.clock.now()
    from_s, to_s = began_s + 0.5 * watch_s, began_s + watch_s
    checks.call("want", lambda: camera.want(from_s, to_s))
    checks.wait(2 * watch_s)
    frames = checks.call("frames", camera.frames) or []
    checks.require(frames, "no frame came that was wanted")
    outside = [frame for frame in frames if not from_s <= frame.time_s <= to_s]
    checks.require(not outside, f"{len(outside)} frames came that nobody wanted")
    checks.require(
        not frames or frames[0].number >= 1, "frames that nobody wanted do not count as frames"
    )
    checks.call("stop", camera.stop)


def _frame(checks: Checks, frame: Frame, camera: Camera) -> None:
    image = frame.image
    if not checks.require(isinstance(image, np.ndarray), f"an image is a {type(image).__name__}"):
        return
    found, wanted = f"{image.shape} {image.dtype}", f"{camera.frame_shape} {camera.dtype}"
    checks.require(found == wanted, f"an image is {found}; frame_shape and dtype are {wanted}")


def _order(checks: Checks, frames: list[Frame], began_s: float) -> None:
    now_s = checks.clock.now()
    for before, after in pairwise(frames):
        checks.require(
            after.number > before.number and after.time_s > before.time_s,
            f"frame {after.number} comes after frame {before.number}",
        )
        checks.require(
            not np.shares_memory(before.image, after.image),
            "frames that follow each other share their memory",
        )
    outside = [frame.number for frame in frames if not began_s <= frame.time_s <= now_s]
    checks.require(not outside, f"times of frames {outside[:3]} lie before start or in the future")
