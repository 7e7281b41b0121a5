"""Time for readings with Bluesky, with PyMeasure and with no framework; in the peers' environment.

`python _overhead_peers.py COUNT`: prints a JSON object, name -> CPU seconds for COUNT readings, of
all threads: nothing is waited for, so that this is the time it takes on a computer with nothing
else to do.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import bluesky.plan_stubs as bps
import bluesky.preprocessors as bpp
from _no_wait import PULSE_S, SAMPLE_AT_S, VOLTAGES_V, NoWaitClock, NoWaitDevice, reading
from bluesky import RunEngine
from pymeasure.experiment import IntegerParameter, Procedure, Results, Worker


def plain(count: int) -> float:
    clock = NoWaitClock()
    device = NoWaitDevice(clock)
    began = time.process_time()
    for k in range(count):
        reading(clock, device, VOLTAGES_V[k % 2])
    return time.process_time() - began


class Done:
    """A status of Bluesky's that is done from the beginning."""

    done = success = True

    def add_callback(self, callback: Callable[[Any], None]) -> None:
        callback(self)

    def exception(self, timeout: float | None = 0.0) -> None:
        del timeout


class Output:
    """`bluesky.protocols.Movable`: setting it writes the voltage and waits for the pulse's end."""

    name = "drive"
    parent = None

    def __init__(self, clock: NoWaitClock, device: NoWaitDevice) -> None:
        self._clock, self._device = clock, device
        self.written_s = 0.0

    def set(self, volts: float) -> Done:
        self.written_s = self._clock.now()
        self._device.write(volts)
        self._clock.sleep_until(self.written_s + PULSE_S)
        return Done()


class Force:
    """`bluesky.protocols.Readable`."""

    name = "force"
    parent = None

    def __init__(self, output: Output, device: NoWaitDevice) -> None:
        self._output, self._device = output, device

    def read(self) -> dict[str, Any]:
        value = self._device.filtered_force(self._output.written_s + SAMPLE_AT_S)
        return {"force": {"value": value, "timestamp": self._output.written_s}}

    def describe(self) -> dict[str, Any]:
        return {"force": {"source": "no-wait", "dtype": "number", "shape": []}}


def bluesky(count: int) -> float:
    clock = NoWaitClock()
    device = NoWaitDevice(clock)
    output = Output(clock, device)
    force = Force(output, device)
    times: list[float] = []

    @bpp.run_decorator()
    def plan() -> Iterator[Any]:
        times.append(time.process_time())
        for k in range(count):
            yield from bps.mv(output, VOLTAGES_V[k % 2])
            yield from bps.trigger_and_read([force])
        times.append(time.process_time())

    RunEngine({})(plan())
    return times[1] - times[0]


class Train(Procedure):
    """The pulses as a Procedure of PyMeasure's."""

    count = IntegerParameter("Count", default=1)
    DATA_COLUMNS = ("volts", "force")

    def startup(self) -> None:
        self.clock = NoWaitClock()
        self.device = NoWaitDevice(self.clock)

    def execute(self) -> None:
        self.began = time.process_time()
        for k in range(self.count):
            if self.should_stop():
                break
            volts = VOLTAGES_V[k % 2]
            self.emit("results", {"volts": volts, "force": reading(self.clock, self.device, volts)})
        self.took = time.process_time() - self.began


def pymeasure_alone(count: int) -> float:
    """The Procedure called as a Worker calls it, its results dropped."""
    train = Train()
    train.count = count
    train.should_stop = lambda: False
    train.emit = lambda _topic, _record: None
    train.startup()
    train.execute()
    train.shutdown()
    return float(train.took)


def pymeasure_worker(count: int) -> float:
    """The Procedure run by PyMeasure's Worker, which records to a CSV file in another thread."""
    train = Train()
    train.count = count
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        worker = Worker(Results(train, str(Path(folder) / "results.csv")))
        worker.start()
        worker.join(120.0)
        return time.process_time() - began


if __name__ == "__main__":
    ways = (plain, bluesky, pymeasure_alone, pymeasure_worker)
    print(json.dumps({way.__name__: way(int(sys.argv[1])) for way in ways}))
