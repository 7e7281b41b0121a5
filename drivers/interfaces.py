"""What the rest of labrig may expect of a piece of hardware, and of time.

Each interface is a `typing.Protocol`: it says when a method is called, how long it may block and
what it may raise. Drivers of real devices fulfil them; the simulator stands behind the drivers, at
the wire, so nothing here knows of it. All quantities are SI: V, N, m, s, rad.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
GreyImage = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]


class DeviceError(Exception):
    """A device did not do what was asked of it.

    The text is one sentence for the operator: which device, what was asked, what came instead, and
    what to do. Drivers raise subclasses of it and nothing else.
    """


class DeviceNotFoundError(DeviceError):
    """The device, its driver or its server is not there, or is of another type."""


class DeviceTimeoutError(DeviceError):
    """The device did not answer in the time that the request can take."""


class LimitError(DeviceError):
    """A value outside the configured limits was asked for; nothing was sent to the device."""


class OverloadError(DeviceError):
    """The load cell is loaded beyond what it stands."""


class OvervoltageError(DeviceError):
    """The sheet has a higher voltage than it may have."""


class LostSamplesError(DeviceError):
    """Samples were overwritten before they were read."""


# --------------------------------------------------------------------------------------- identity


@dataclass(frozen=True, kw_only=True)
class DeviceIdentity:
    """What a device, or its driver, reports of itself. Empty and None: not known."""

    name: str = ""  # as the system or rig.toml calls it, such as PCI6703
    maker: str = ""
    product: str = ""  # product or model, such as PCI-6703
    serial: str = ""
    driver: str = ""  # the driver software and its version, such as NI-DAQmx 26.0.0
    is_simulated: bool | None = None


@runtime_checkable
class Identified(Protocol):
    """A device, or a connection to several, that reports what it is; boards and parts may do so."""

    def identities(self) -> Sequence[DeviceIdentity]:
        """Return what is known of each device. Open; blocks for 1 s at most. Raises DeviceError."""


# ------------------------------------------------------------------------------------------- time


class ThreadHandle(Protocol):
    """A thread started by a clock."""

    def join(self, timeout: float | None = None) -> bool:
        """Wait for the thread's end, at most `timeout` seconds; return whether it has ended."""


class Clock(Protocol):
    """Time, and threads that live in it. The real clock is `RealClock`; the simulator has another.

    Everything that waits does it here, so that a simulated session need not wait.
    """

    def now(self) -> float:
        """Monotonic time in s, from an arbitrary origin."""

    def sleep_until(self, when: float) -> None:
        """Return when `now() >= when`; at once when that has passed."""

    def start_thread(self, target: Callable[[], None], name: str) -> ThreadHandle:
        """Run `target` beside the caller. It may wait only by this clock or by its own device."""


class _RealThread:
    def __init__(self, target: Callable[[], None], name: str) -> None:
        self._thread = threading.Thread(target=target, name=name, daemon=True)
        self._thread.start()

    def join(self, timeout: float | None = None) -> bool:
        self._thread.join(timeout)
        return not self._thread.is_alive()


class RealClock:
    """The computer's monotonic clock."""

    # The operating system wakes a sleeper late by up to a fraction of a millisecond; the last bit
    # is spent in a loop, so that an edge is as punctual as the computer can make it.
    SPIN_S = 3e-4

    def now(self) -> float:
        """See `Clock.now`."""
        return time.perf_counter()

    def sleep_until(self, when: float) -> None:
        """See `Clock.sleep_until`."""
        left = when - time.perf_counter()
        if left > self.SPIN_S:
            time.sleep(left - self.SPIN_S)  # noqa: TID251 - this is the one place that may sleep
        while time.perf_counter() < when:
            pass

    def start_thread(self, target: Callable[[], None], name: str) -> ThreadHandle:
        """See `Clock.start_thread`."""
        return _RealThread(target, name)


# ----------------------------------------------------------------------------------------- output


@dataclass(frozen=True)
class VoltageWrite:
    """One write of the drive voltage: what was sent, and between which two moments."""

    sheet_V: float
    board_V: float
    before_s: float  # clock time just before the request was sent
    after_s: float  # and just after the device confirmed it


@runtime_checkable
class VoltageOutput(Protocol):
    """The voltage at the sheet, through whatever amplifies it.

    The board holds its last value for ever: `close` writes 0 V first, and so must anything else
    that stops using the output.
    """

    @property
    def limit_V(self) -> float:
        """Largest sheet voltage, either sign, that `write` accepts."""

    def open(self) -> None:
        """Take the output and write 0 V. Raises DeviceNotFoundError, DeviceError."""

    def write(self, sheet_V: float) -> VoltageWrite:
        """Put `sheet_V` on the sheet; blocks for one round trip.

        Raises LimitError (nothing was sent) beyond the limit or for NaN, DeviceError otherwise.
        """

    def close(self) -> None:
        """Write 0 V and let go of the output. May be called twice; raises when 0 V was refused."""

    def abandon(self) -> None:
        """Let go without a write: somebody else is going to write 0 V. Never raises."""


@dataclass(frozen=True)
class TimedVoltage:
    """From sample `index` of an acquisition on, `volts` are at an output."""

    index: int
    volts: float


@runtime_checkable
class TimedOutput(Protocol):
    """A `VoltageOutput` that may put out a whole run by the clock of the signal input."""

    @property
    def is_timed(self) -> bool:
        """Whether its board can; known once it is open."""

    def load(self, course: Sequence[TimedVoltage], rate_hz: float) -> Sequence[float]:
        """Give the board the voltages of a run; return those at the board, in the same order.

        Sample 0 is that of the next start of the signal input, which starts the run. Before its
        first voltage the output is at 0 V, and so it is from the last one on, which must be 0 V:
        whatever becomes of this program, the board's buffer ends there and is not put out again.
        `write` ends the run at once. Raises LimitError (nothing was sent), DeviceError (at 0 V).
        """

    def is_done(self) -> bool:
        """Return whether the board has put out all of it; one round trip.

        Raises DeviceError when it has ended before its time: the output may be at any voltage of
        the run, and 0 V is still to be written.
        """


@runtime_checkable
class Interlock(Protocol):
    """A signal that the working loop keeps up, for an external interlock.

    See docs/explanation/safety.md.
    """

    def open(self) -> None:
        """Take the line; make no edge yet. Raises DeviceNotFoundError, DeviceError."""

    def beat(self) -> None:
        """Make an edge when one is due; called at least every 50 ms while energised.

        Blocks for one round trip at most. Raises DeviceError.
        """

    def close(self) -> None:
        """Let go of the line: without edges the interlock drops. May be called twice."""


# ------------------------------------------------------------------------------------------ input


@dataclass(frozen=True)
class SignalBlock:
    """Consecutive samples of all channels. `volts` has shape (channels, samples)."""

    first_index: int  # index of the first sample since the acquisition's start
    volts: FloatArray
    read_s: float  # clock time when the block had arrived


@dataclass(frozen=True)
class SampleClock:
    """Sample indices against clock time: sample i was acquired at start_s + i / rate_hz."""

    start_s: float  # clock time of sample 0
    start_uncertainty_s: float  # half the time the start request took
    rate_hz: float  # the rate the device achieved, which is seldom quite the one asked for

    def time_of(self, index: float) -> float:
        """Clock time of a sample index (a fraction counts)."""
        return self.start_s + index / self.rate_hz

    def index_at(self, time_s: float) -> float:
        """Sample index, with its fraction, at a clock time."""
        return (time_s - self.start_s) * self.rate_hz


@runtime_checkable
class SignalInput(Protocol):
    """Hardware-timed, continuous acquisition of named channels."""

    @property
    def channels(self) -> Sequence[str]:
        """Names of the channels in the order of the blocks' rows, such as force, current, drive."""

    @property
    def ranges_V(self) -> Sequence[float]:
        """The device's actual input range (either sign) of each channel."""

    @property
    def rate_hz(self) -> float:
        """Samples per second and channel that the device achieves (after `open`)."""

    def open(self) -> None:
        """Take the device and configure it. Raises DeviceNotFoundError, DeviceError."""

    def start(self) -> SampleClock:
        """Begin to acquire, from sample 0."""

    def read_available(self) -> SignalBlock:
        """All samples that have arrived since the last read (perhaps none); does not wait for more.

        Raises LostSamplesError when samples were overwritten, DeviceTimeoutError, DeviceError.
        """

    def stop(self) -> None:
        """Stop acquiring; may be called when not started."""

    def measure(self, duration_s: float) -> FloatArray:
        """Acquire for `duration_s` and return all samples (channels, samples), acquisition stopped.

        For preflight and read-back; must not be called between `start` and `stop`.
        """

    def close(self) -> None:
        """Let go of the device. May be called twice."""


@runtime_checkable
class ForceSensor(Protocol):
    """A sensor that is asked for one force at a time (a meter on a serial line).

    One thread opens it, another reads it, never two at the same time.
    """

    @property
    def range_N(self) -> float:
        """Largest force, either sign, that it can report."""

    def open(self) -> None:
        """Take the device; blocks for a few exchanges. Raises DeviceNotFoundError, DeviceError."""

    def read_force(self) -> float:
        """Return the force now, in N; blocks for one exchange, and at most for 2 s.

        A run asks again and again, and ends when no reading has come for 1 s.
        Raises OverloadError beyond its range, DeviceTimeoutError, DeviceError.
        """

    def tare(self) -> None:
        """Make the present load the zero; blocks for one exchange. Raises DeviceError."""

    def close(self) -> None:
        """Let go of the device. May be called twice."""


# ----------------------------------------------------------------------------------------- camera


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


# ------------------------------------------------------------------------------- operator and stage


@dataclass(frozen=True, kw_only=True)
class Prompt:
    """Something the operator is asked to do before the run goes on."""

    # move | moisten | mount | free | touch | remount | dead_weight | turn_over | confirm | repeat
    kind: str
    text: str  # one sentence, ready to show
    configuration: str | None = None
    position_m: float | None = None
    load_N: float | None = None
    # After so long without an answer it goes on as if that were yes; None: it waits
    expires_s: float | None = None


class Operator(Protocol):
    """The person at the rig, or what answers in their place.

    What answers for a person who is not there has an attribute `is_present` that is False: the
    session then records that nobody was asked.
    """

    def ask(self, prompt: Prompt) -> bool:
        """Show the prompt and wait for the answer: True, it is done; False, stop the session.

        To `repeat`, True is to go on, and False is to measure the run of the prompt again.
        """


@runtime_checkable
class Positioner(Protocol):
    """Moves the load cell along the arc; by a motor, or by asking the operator."""

    def open(self) -> None:
        """Take the stage; may move it to its reference. Raises DeviceNotFoundError, DeviceError."""

    def move_to(self, position_m: float) -> bool:
        """Move to a position along the arc, at 0 V, and block until it is reached.

        False when the operator declined. A motor takes 300 s at most; a person as long as they
        need. Raises LimitError (it was not moved) outside its range or for NaN,
        DeviceTimeoutError, DeviceError.
        """

    def position(self) -> float | None:
        """Return the position along the arc in m that the stage reports; None: it has no sensor."""

    def close(self) -> None:
        """Let go of the stage. May be called twice."""
