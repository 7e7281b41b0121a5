"""Images, and what begins their exposures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

GreyImage = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]


FREE, SOFTWARE, HARDWARE = "free", "software", "hardware"  # what begins an exposure


@dataclass(frozen=True, kw_only=True)
class AcquisitionSettings:
    """How a camera takes images. None: as the camera has it, or not known."""

    exposure_s: float | None = None
    gain: float | None = None  # in the camera's own unit, dB on most
    pixel_format: str | None = None  # as GenICam names it: Mono8, Mono12p, BayerRG8
    region: tuple[int, int, int, int] | None = None  # left, top, width, height in pixels
    frame_rate_hz: float | None = None  # where the camera runs free
    trigger: str | None = None  # free, software or hardware


@dataclass(frozen=True)
class TriggerPulse:
    """A trigger was given between these clock times."""

    before_s: float
    after_s: float

    @property
    def middle_s(self) -> float:
        """The time at which it counts as given."""
        return (self.before_s + self.after_s) / 2


class FrameTrigger(Protocol):
    """Begins exposures one by one: a digital line of the boards, or the camera's own command."""

    def open(self) -> None:
        """Take the line; nothing is triggered. Raises DeviceNotFoundError, DeviceError."""

    def fire(self) -> TriggerPulse:
        """Begin one exposure; may block as long as a write of the voltage. Raises DeviceError."""

    def close(self) -> None:
        """Let go of the line. May be called twice."""


@runtime_checkable
class TriggersFrames(Protocol):
    """Boards with a digital line that can trigger a camera; a `BoardConnection` may be one."""

    def frame_trigger(self, line: str) -> FrameTrigger:
        """Return the line, not open yet. A rising edge of it begins an exposure."""


@dataclass(frozen=True, kw_only=True)
class Frame:
    """One image of a camera: `image` (rows, columns), grey, 8 or 16 bit."""

    number: int  # counts every frame since `start`, those not kept too
    time_s: float  # clock time at which the frame was complete on this computer
    device_time_s: float | None  # the camera's own time stamp where it gives one
    image: GreyImage
    # how much later it came than its time stamp and those before it let expect; 0: not known
    late_s: float = 0.0
    device_number: int | None = None  # the camera's own number of it, where it gives one
    trigger_s: float | None = None  # clock time of the trigger that began it, where there was one


@dataclass(frozen=True)
class CameraCounts:
    """Frames since `start`. Each frame that the camera took is in one of these, but `dropped`."""

    grabbed: int  # arrived whole
    dropped: int  # of these: wanted, but lost because the queue was full
    incomplete: int = 0  # arrived with a part missing; not handed over
    missed: int = 0  # never arrived: the camera's own numbers have a gap


@runtime_checkable
class Camera(Protocol):
    """A camera that hands over the frames that were asked for.

    It runs by itself, or exposes a frame each time that it is triggered (`settings.trigger`).

    The order of calls is `open`, then any number of times `start`, `want` or `want_all`, `frames`,
    `stop`, then `close`. The thread that runs the experiment calls all of them: only `open` and
    `close` may block. Every method raises DeviceError, or a subclass of it, and nothing else.
    """

    def open(self) -> None:
        """Take the camera; after it `frame_shape` and `dtype` are known. Blocks for 10 s at most.

        Raises DeviceNotFoundError.
        """

    @property
    def frame_shape(self) -> tuple[int, int]:
        """Rows and columns of a frame."""

    @property
    def dtype(self) -> np.dtype[np.uint8] | np.dtype[np.uint16]:
        """Type of a frame's pixels."""

    @property
    def settings(self) -> AcquisitionSettings:
        """What the camera has set, read back from it by `open`; None where it cannot be asked."""

    def fire(self) -> TriggerPulse:
        """Begin one exposure, where `settings.trigger` is software. Raises DeviceError."""

    def start(self) -> None:
        """Begin to count frames from 0; returns within 50 ms, as do all methods below.

        Raises DeviceError when it is running already, or has stopped delivering.
        """

    def want(self, from_s: float, to_s: float) -> None:
        """Keep the frames completed between two clock times; others are only counted."""

    def want_all(self) -> None:
        """Keep every frame until `stop`."""

    def frames(self) -> list[Frame]:
        """Return the kept frames that have arrived since the last call, oldest first.

        Does not wait. An image is an array of its own, of `frame_shape` and `dtype`. Raises
        DeviceError once the camera has stopped delivering and every kept frame was returned.
        """

    @property
    def counts(self) -> CameraCounts:
        """Frames arrived and lost since `start`; none that is late counts as lost."""

    def stop(self) -> None:
        """Stop taking frames; may be called when not started."""

    def close(self) -> None:
        """Stop and let go of the camera; blocks for 5 s at most. May be called twice."""
