"""Whether a camera keeps its contract."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drivers.conformance import Checks
from drivers.interfaces import SOFTWARE, AcquisitionSettings, Camera, Clock, Frame

OPEN_S, CLOSE_S = 10.0, 5.5


def camera_faults(camera: Camera, clock: Clock, watch_s: float = 1.0) -> list[str]:
    """Return what a camera, not open yet, does against `Camera`; it must send frames by itself.

    Takes about four times `watch_s`, in which a good camera sends at least four frames.
    """
    checks = Checks(clock)
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
        _watch(checks, camera, watch_s)
        _watch_again(checks, camera, watch_s)
    checks.call("close", camera.close, CLOSE_S)
    checks.call("a second close", camera.close, CLOSE_S)
    checks.refuse("start after close", camera.start)
    return checks.faults


def _watch(checks: Checks, camera: Camera, watch_s: float) -> None:
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
        if not (after.number > before.number and after.time_s > before.time_s):
            checks.faults.append(f"frame {after.number} comes after frame {before.number}")
        if np.shares_memory(before.image, after.image):
            checks.faults.append(f"frames {before.number} and {after.number} share their memory")
    outside = [frame.number for frame in frames if not began_s <= frame.time_s <= now_s]
    checks.require(not outside, f"times of frames {outside[:3]} lie before start or in the future")
