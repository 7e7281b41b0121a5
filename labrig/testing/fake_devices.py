"""Small devices in memory on a clock that jumps, of which `fake_rig` is made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from drivers.conformance import CALLING
from drivers.interfaces import (
    FREE,
    AcquisitionSettings,
    CameraCounts,
    DeviceError,
    Frame,
    LimitError,
    Prompt,
    SampleClock,
    SignalBlock,
    ThreadHandle,
    TriggerPulse,
    VoltageWrite,
)
from protocols import Channel, SafetyLimits
from protocols.execution.devices import MOVING

CHANNELS = (
    Channel(name="force", quantity="force", unit="N", range_V=0.05),
    Channel(name="current", quantity="electric current", unit="A", range_V=5.0),
    Channel(name="drive", quantity="voltage", unit="V", range_V=10.0),
)
LIMITS = SafetyLimits(sheet_voltage_V=2.5, time_under_voltage_s=30.0)


def _require(holds: bool, what: str) -> None:
    """Raise AssertionError unless it holds."""
    if not holds:
        raise AssertionError(what)


# What is done in threads of its own, so that a device that hangs or blocks holds up nothing.
THREADS = frozenset({"writing 0 V", "reading the drive voltage back", MOVING, CALLING})


class FakeClock:
    """A clock whose sleep is a jump. `at` holds (time, action) pairs that are called on the way."""

    def __init__(self) -> None:
        self.time_s = 100.0
        self.longest_sleep_s = 0.0
        self.at: list[tuple[float, Callable[[], None]]] = []

    def now(self) -> float:
        """Return the time."""
        return self.time_s

    def sleep_until(self, when: float) -> None:
        """Jump to this time; call what is due on the way."""
        self.longest_sleep_s = max(self.longest_sleep_s, when - self.time_s)
        self.time_s = max(self.time_s, when)
        for entry in [entry for entry in self.at if entry[0] <= self.time_s]:
            self.at.remove(entry)
            entry[1]()

    def start_thread(self, target: Callable[[], None], name: str) -> ThreadHandle:
        """Run the thread's function at once."""
        _require(name in THREADS, f"the thread '{name}' is needed nowhere")
        target()
        return EndedThread()


class EndedThread:
    """A thread that has ended."""

    def join(self, timeout: float | None = None) -> bool:
        """Return True: it has ended."""
        del timeout
        return True


@dataclass
class CallFaults:
    """Count the calls of a device and make those fail whose number `fail_at` names."""

    fail_at: Callable[[int], bool] = lambda _: False
    calls: int = 0
    names: list[str] = field(default_factory=list)

    def call(self, name: str) -> None:
        """Count a call; raise DeviceError if it is to fail."""
        index = self.calls
        self.calls += 1
        self.names.append(name)
        if self.fail_at(index):
            raise DeviceError(f"call {index} ({name}) failed")


class FakeOutput:
    """A voltage output that keeps what was written, with the times."""

    def __init__(self, clock: FakeClock, faults: CallFaults) -> None:
        self.clock, self.faults = clock, faults
        self.limit_V = 3.0
        self.writes: list[tuple[float, float]] = [(0.0, 0.0)]  # (time, sheet volts)
        self.stalls_s: dict[int, float] = {}  # before the n-th write
        self.latency_s = 0.0004

    def open(self) -> None:
        """Do nothing: it is open."""

    def write(self, sheet_V: float) -> VoltageWrite:
        """Write a voltage; it is out half of `latency_s` later."""
        if abs(sheet_V) > self.limit_V:
            raise LimitError("too much")
        self.clock.time_s += self.stalls_s.get(len(self.writes), 0.0)
        self.faults.call("write")
        before_s = self.clock.time_s
        self.writes.append((before_s + self.latency_s / 2, sheet_V))
        self.clock.time_s += self.latency_s
        return VoltageWrite(sheet_V, sheet_V / 10, before_s, self.clock.time_s)

    def close(self) -> None:
        """Write 0 V."""
        self.write(0.0)

    def abandon(self) -> None:
        """See `VoltageOutput.abandon`: nothing is held."""

    @property
    def last_V(self) -> float:
        """Return the voltage that was written last."""
        return self.writes[-1][1]

    def volts_at(self, times_s: np.ndarray) -> np.ndarray:
        """Return the voltage that was out at each time."""
        when = np.array([time_s for time_s, _ in self.writes])
        volts = np.array([sheet_V for _, sheet_V in self.writes])
        return volts[np.searchsorted(when, times_s, side="right") - 1]


class FakeSignals:
    """Signals that follow the output: force, current and the drive's read-back."""

    channels: Sequence[str] = ("force", "current", "drive")
    ranges_V: Sequence[float] = (0.05, 5.0, 10.0)

    def __init__(self, clock: FakeClock, output: FakeOutput, faults: CallFaults) -> None:
        self.clock, self.output, self.faults = clock, output, faults
        self.rate_hz = 1000.0
        self.running = False
        self.start_s = 0.0
        self.sent = 0
        self.silent = False
        self.spoil: Callable[[np.ndarray, np.ndarray], None] = lambda *_: None
        self.skip: set[int] = set()  # blocks that get lost
        self.cost_s = 0.0
        self.blocks = 0

    def open(self) -> None:
        """Do nothing: it is open."""

    def start(self) -> SampleClock:
        """Start."""
        self.faults.call("start")
        _require(not self.running, "it runs already")
        self.running, self.start_s, self.sent = True, self.clock.time_s, 0
        return SampleClock(self.start_s, 1e-4, self.rate_hz)

    def read_available(self) -> SignalBlock:
        """Return the samples since the last call."""
        self.faults.call("read")
        _require(self.running, "it does not run")
        self.clock.time_s += self.cost_s
        end = int((self.clock.time_s - self.start_s) * self.rate_hz)
        first, self.sent = self.sent, max(self.sent, end)
        self.blocks += 1
        if self.silent:
            first = self.sent
        if self.blocks in self.skip:
            first = self.sent
        index = np.arange(first, self.sent)
        return SignalBlock(
            first, self._volts(self.start_s + index / self.rate_hz), self.clock.time_s
        )

    def stop(self) -> None:
        """Stop."""
        self.faults.call("stop")
        self.running = False

    def measure(self, duration_s: float) -> np.ndarray:
        """Return the volts of a measurement of its own."""
        self.faults.call("measure")
        _require(not self.running, "it runs already")
        times_s = self.clock.time_s + np.arange(int(duration_s * self.rate_hz)) / self.rate_hz
        self.clock.time_s += duration_s
        return self._volts(times_s)

    def close(self) -> None:
        """Do nothing."""

    def _volts(self, times_s: np.ndarray) -> np.ndarray:
        drive = self.output.volts_at(times_s)
        volts = np.stack([1e-3 * drive + 1e-5 * (times_s - 100.0), 1e-3 * drive, drive])
        self.spoil(times_s, volts)
        return volts


class FakeCamera:
    """A camera of 4 x 6 pixels, one frame in 40 ms."""

    frame_shape = (4, 6)
    dtype = np.dtype(np.uint8)

    def __init__(self, clock: FakeClock, faults: CallFaults) -> None:
        self.clock, self.faults = clock, faults
        self.period_s = 0.04
        self.wanted: list[tuple[float, float]] = []
        self.all = False
        self.running = False
        self.start_s = 0.0
        self.sent = 0
        self.start_shift_s = 0.0  # of the first frame
        self.delivery_s = 0.0  # from a frame's time to its arrival
        self.lost: Callable[[float], bool] = lambda _: False

    settings = AcquisitionSettings(trigger=FREE)

    def open(self) -> None:
        """Do nothing: it is open."""

    def fire(self) -> TriggerPulse:
        """Refuse: it runs free."""
        raise DeviceError("the fake camera takes no trigger")

    def start(self) -> None:
        """Start."""
        self.faults.call("start")
        self.running, self.sent = True, 0
        self.start_s = self.clock.time_s + self.start_shift_s
        self.wanted, self.all = [], False

    def want(self, from_s: float, to_s: float) -> None:
        """Keep the frames of this interval."""
        self.faults.call("want")
        self.wanted.append((from_s, to_s))

    def want_all(self) -> None:
        """Keep all frames."""
        self.faults.call("want_all")
        self.all = True

    def frames(self) -> list[Frame]:
        """Return the new frames that are wanted and not lost."""
        self.faults.call("frames")
        count = int((self.clock.time_s - self.delivery_s - self.start_s) / self.period_s)
        numbers, self.sent = range(self.sent, count), max(count, self.sent)
        frames = [self._frame(number) for number in numbers]
        return [f for f in frames if self._is_wanted(f.time_s) and not self.lost(f.time_s)]

    @property
    def counts(self) -> CameraCounts:
        """Return how many frames came and how many were dropped."""
        self.faults.call("counts")
        return CameraCounts(self.sent, 0)

    def stop(self) -> None:
        """Stop."""
        self.faults.call("stop")
        self.running = False

    def close(self) -> None:
        """Do nothing."""

    def _frame(self, number: int) -> Frame:
        image = ((np.arange(24) * 9 + number) % 256).astype(np.uint8).reshape(self.frame_shape)
        return Frame(
            number=number,
            time_s=self.start_s + (number + 1) * self.period_s,
            device_time_s=None,
            image=image,
        )

    def _is_wanted(self, time_s: float) -> bool:
        return self.all or any(low <= time_s <= high for low, high in self.wanted)


class FakeStage:
    """A positioner that is where it was told to go, off by `off_m`."""

    def __init__(self, clock: FakeClock, faults: CallFaults) -> None:
        self.clock, self.faults = clock, faults
        self.moves: list[float] = []
        self.off_m = 0.0
        self.answer = True

    def open(self) -> None:
        """Do nothing: it is open."""

    def move_to(self, position_m: float) -> bool:
        """Move; return whether the operator agrees."""
        self.faults.call("move_to")
        self.clock.time_s += 1.0
        self.moves.append(position_m)
        return self.answer

    def position(self) -> float | None:
        """Return the position that is read back."""
        self.faults.call("position")
        return self.moves[-1] + self.off_m

    def close(self) -> None:
        """Do nothing."""


class FakeOperator:
    """An operator who agrees, unless `declines` says otherwise; asserts that 0 V is out."""

    def __init__(self, clock: FakeClock, output: FakeOutput, faults: CallFaults) -> None:
        self.clock, self.output, self.faults = clock, output, faults
        self.asked: list[Prompt] = []
        self.declines: Callable[[Prompt], bool] = lambda _: False

    def ask(self, prompt: Prompt) -> bool:
        """Return the operator's answer."""
        self.faults.call("ask")
        _require(self.output.last_V == 0.0, "the operator is asked while the sheet is energised")
        self.clock.time_s += 2.0
        self.asked.append(prompt)
        return not self.declines(prompt)
