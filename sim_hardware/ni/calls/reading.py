"""Read samples of a task: on demand, or from a running acquisition."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.rpc import Call
from sim_hardware.ni.signals.acquisition import Acquisition, Samples
from sim_hardware.ni.signals.timing import TimingType
from sim_hardware.ni.tasks.channels import ChannelType
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import Task

ALL_AVAILABLE = -1


@dataclass(frozen=True)
class ReadSamples:
    """The samples of a read. `status` is -200284 where its time ended before they had all come."""

    samples: Samples
    status: int = 0
    first_s: float | None = None  # clock time of the first one, of a clocked acquisition

    @property
    def count(self) -> int:
        """Samples per channel."""
        return int(self.samples.codes.shape[1])


def read_samples(
    engine: Engine, task: Task, wanted: int, timeout_s: float, call: Call
) -> ReadSamples:
    """Read `wanted` samples per channel (-1: all available) in `timeout_s` (negative: any time)."""
    if wanted < ALL_AVAILABLE:
        raise StatusError(Code.SAMPLE_COUNT, f"Requested: {wanted}", task.name, samples_read=0)
    if task.type is not ChannelType.ANALOG_INPUT:
        raise StatusError(Code.READ_NOT_INPUT, task=task.name, samples_read=0)
    _check_started(task)
    if engine.faults.loses_samples():
        raise StatusError(Code.OVERWRITTEN, task=task.name, samples_read=0)
    if task.timing.kind is TimingType.ON_DEMAND:
        got = _on_demand(engine, task, max(1, wanted), call)
    else:
        got = _buffered(engine, task, wanted, timeout_s, call)
    return _with_faults(engine, task, _selected(task, got))


def read_words(
    engine: Engine, task: Task, wanted: int, timeout_s: float, call: Call
) -> ReadSamples:
    """Read digital channels, one bit of a word for each line."""
    if wanted < ALL_AVAILABLE:
        raise StatusError(Code.SAMPLE_COUNT, f"Requested: {wanted}", task.name, samples_read=0)
    if not task.digital:
        raise StatusError(Code.READ_NOT_INPUT, task=task.name, samples_read=0)
    _check_started(task)
    if task.timing.kind is not TimingType.ON_DEMAND:
        task.verify()  # where the lines are static, this refuses
        return _selected(task, _buffered(engine, task, wanted, timeout_s, call))
    started, count = not task.running, max(1, wanted)
    if started:
        engine.start(task)
    times_s = np.full(count, engine.now())
    samples = engine.line_sampler(task, task.counted).sample(times_s, 0.0, engine.now())
    task.counted += count
    if started:
        engine.stop(task)
    return _selected(task, ReadSamples(samples))


def _check_started(task: Task) -> None:
    if not task.running and not task.auto_start:
        raise StatusError(Code.NOT_STARTED, task=task.name, samples_read=0)


def _on_demand(engine: Engine, task: Task, wanted: int, call: Call) -> ReadSamples:
    """Acquire samples from now on, as fast as the board converts."""
    started = not task.running
    if started:
        engine.start(task)
    convert_s = task.inputs[0].side.min_convert_s
    sample_s = 1.0 / task.inputs[0].side.max_rate(len(task.channels))
    times_s = np.linspace(0.0, sample_s * (wanted - 1), wanted) + engine.now()
    last_s = float(times_s[-1]) + convert_s * (len(task.channels) - 1)
    while wanted > 1 and engine.now() < last_s and engine.wait_until(last_s, call):
        pass
    if task.on_demand is None:
        raise StatusError(Code.NEVER_AVAILABLE, task=task.name, samples_read=0)
    samples = task.on_demand.sample(times_s, convert_s, engine.now())
    if started:
        engine.stop(task)
    return ReadSamples(samples)


def _buffered(engine: Engine, task: Task, wanted: int, timeout_s: float, call: Call) -> ReadSamples:
    if not task.running:
        engine.start(task)
        task.started_by_read = True
    acquisition = task.acquisition
    if acquisition is None:  # its timing was changed to a sample clock while it ran
        raise StatusError(Code.NEVER_AVAILABLE, task=task.name, samples_read=0)
    count = _how_many(engine, task, acquisition, wanted)
    limit_s = math.inf if timeout_s < 0 else engine.now() + timeout_s
    while (ready := acquisition.available(engine.now())) < count:
        if engine.now() >= limit_s:
            return ReadSamples(acquisition.read(ready, engine.now()), int(Code.NOT_YET_AVAILABLE))
        due_s = acquisition.time_of(acquisition.position + count)
        going = engine.wait_until(min(due_s, limit_s), call)
        if not going or task.acquisition is not acquisition:
            raise StatusError(Code.NEVER_AVAILABLE, task=task.name, samples_read=0)
    first_s = acquisition.nominal_s(acquisition.first(engine.now()))
    got = ReadSamples(acquisition.read(count, engine.now()), first_s=first_s)
    if task.started_by_read and acquisition.left == 0:
        engine.stop(task)
    return got


def _how_many(engine: Engine, task: Task, acquisition: Acquisition, wanted: int) -> int:
    """Return how many samples a read gets: of a finite acquisition what is left of it."""
    left = acquisition.left
    if wanted == ALL_AVAILABLE:
        if left is None or task.read_all_available:
            return acquisition.available(engine.now())
        return left
    if left is None:
        return wanted
    if left == 0 and wanted > 0:
        raise StatusError(Code.NEVER_AVAILABLE, task=task.name, samples_read=0)
    return min(wanted, left)


def _selected(task: Task, got: ReadSamples) -> ReadSamples:
    """Only the rows of the channels to be read."""
    if not task.channels_to_read:
        return got
    names = [channel.name for channel in task.channels]
    rows = [names.index(channel.name) for channel in task.select(task.channels_to_read)]
    samples = got.samples
    return replace(got, samples=Samples(samples.codes[rows], samples.volts[rows]))


def _with_faults(engine: Engine, task: Task, got: ReadSamples) -> ReadSamples:
    """NaN where a test asks for it."""
    if engine.faults.nan:
        for row, channel in enumerate(task.select(task.channels_to_read)):
            if f"{channel.device.name}/{channel.physical}" in engine.faults.nan:
                got.samples.volts[row] = np.nan
    return got
