"""CPU seconds for COUNT readings with labrig: `python -m benchmarks._overhead_labrig COUNT`."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

import numpy as np

from benchmarks._no_wait import (
    HALF_WINDOW_S,
    PULSE_S,
    RATE_HZ,
    SAMPLE_AT_S,
    VOLTAGES_V,
    NoWaitClock,
    NoWaitDevice,
    reading,
)
from drivers.interfaces import (
    FloatArray,
    Prompt,
    SampleClock,
    SignalBlock,
    ThreadHandle,
    VoltageWrite,
)
from drivers.safe_shutdown import Safety, SafetyReport
from protocols import Channel, SafetyLimits
from protocols.execution.devices import Devices
from protocols.execution.events import Event, Outcome, ReadingTaken, RunStarted, RunStopped
from protocols.execution.rules import Rules
from protocols.execution.scheduler import Scheduler
from protocols.execution.stop import StopRequest
from protocols.kinds.pulse_train import PulseTrain
from protocols.planning.loop_timing import LoopTiming
from protocols.planning.schedule import PlannedRun, Purpose, Schedule

CHANNELS = ("force", "current", "drive")


class Clock(NoWaitClock):
    """With the one method that is not needed here."""

    def start_thread(self, target: Callable[[], None], name: str) -> ThreadHandle:
        raise NotImplementedError(f"nothing here starts a thread ({name}, {target})")


class Output:
    """`drivers.interfaces.VoltageOutput`."""

    limit_V = 10.0

    def __init__(self, clock: Clock, device: NoWaitDevice) -> None:
        self._clock, self._device = clock, device

    def open(self) -> None: ...

    def write(self, sheet_V: float) -> VoltageWrite:
        now_s = self._clock.now()
        self._device.write(sheet_V)
        return VoltageWrite(sheet_V, sheet_V, now_s, now_s)

    def close(self) -> None: ...


class Signals:
    """`drivers.interfaces.SignalInput`: all channels read what the output writes."""

    channels = CHANNELS
    ranges_V = (10.0, 10.0, 10.0)

    def __init__(self, clock: Clock, device: NoWaitDevice) -> None:
        self._clock, self._device = clock, device
        self._start_s = 0.0
        self._next = 0

    def open(self) -> None: ...

    def start(self) -> SampleClock:
        self._start_s, self._next = self._clock.now(), 0
        return SampleClock(self._start_s, 0.0, RATE_HZ)

    def read_available(self) -> SignalBlock:
        now_s = self._clock.now()
        count = int((now_s - self._start_s) * RATE_HZ + 1e-6) + 1 - self._next
        volts = np.tile(self._device.samples(self._next, count), (len(CHANNELS), 1))
        self._next += count
        return SignalBlock(self._next - count, volts, now_s)

    def stop(self) -> None: ...

    def measure(self, duration_s: float) -> FloatArray:
        return np.zeros((len(CHANNELS), max(1, int(duration_s * RATE_HZ))))

    def close(self) -> None: ...


class Nobody:
    """A stage and an operator who are never asked."""

    def open(self) -> None: ...
    def close(self) -> None: ...

    def move_to(self, position_m: float) -> bool:
        return position_m == position_m

    def position(self) -> float | None:
        return None

    def ask(self, prompt: Prompt) -> bool:
        return bool(prompt.kind)


def train(count: int) -> Schedule:
    pulses = PulseTrain(
        voltages_V=VOLTAGES_V,
        zero_readings=0,
        pulses_discarded=0,
        readings_per_voltage=count // 2,
        pulse_s=PULSE_S,
        sample_at_s=SAMPLE_AT_S,
        half_window_s=HALF_WINDOW_S,
    )
    steps, readings, duration_s = pulses.steps_and_readings()
    run = PlannedRun(
        index=0,
        configuration="long",
        position_m=None,
        purpose=Purpose.MEASUREMENT,
        mounting=0,
        approach="up",
        moisten=False,
        load_N=None,
        steps=steps,
        readings=readings,
        duration_s=duration_s,
    )
    return Schedule("pulse_train", (run,), 25.0)


def scheduler(count: int, timing: LoopTiming) -> float:
    """CPU seconds between the events RunStarted and RunStopped."""
    clock = Clock()
    device = NoWaitDevice(clock)
    nobody = Nobody()
    times: list[float] = []
    taken = 0

    def emit(event: Event) -> None:
        nonlocal taken
        if isinstance(event, RunStarted | RunStopped):
            times.append(time.process_time())
        taken += isinstance(event, ReadingTaken) and event.valid

    made = Scheduler(
        Devices(
            output=Output(clock, device),
            signals=Signals(clock, device),
            camera=None,
            stage=nobody,
            operator=nobody,
            channels=tuple(
                Channel(name=name, quantity="voltage", unit=unit, range_V=10.0)
                for name, unit in zip(CHANNELS, ("N", "A", "V"), strict=True)
            ),
        ),
        clock,
        emit,
        StopRequest(),
        SafetyLimits(10.0, 1e9),
        lambda: SafetyReport(Safety.SAFE, 0.0, ()),  # after the time that is measured
        rules=Rules(),
        timing=timing,
    )
    outcome = made.run(train(count))
    if outcome is not Outcome.COMPLETED or taken != count:
        raise SystemExit(f"{outcome}: {made.status.text}; {taken} of {count} readings")
    return times[1] - times[0]


def plain(count: int) -> float:
    """No framework at all."""
    clock = Clock()
    device = NoWaitDevice(clock)
    began = time.process_time()
    for k in range(count):
        reading(clock, device, VOLTAGES_V[k % 2])
    return time.process_time() - began


if __name__ == "__main__":
    wanted = int(sys.argv[1])
    found = {
        "plain": plain(wanted),
        "labrig": scheduler(wanted, LoopTiming()),
        "labrig_one_look": scheduler(wanted, LoopTiming(service_s=0.5 * PULSE_S)),
    }
    print(json.dumps(found))
