"""Attributes of a task: itself, its timing, its reading and its input buffer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.attributes.common import Attribute, Table, attribute_handlers
from sim_hardware.ni.attributes.output import OUTPUT_BUFFER
from sim_hardware.ni.calls.tasks import sample_mode, task_of
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.names import join_list
from sim_hardware.ni.signals.acquisition import (
    CURRENT_READ_POSITION,
    DO_NOT_OVERWRITE,
    FIRST_PRETRIGGER_SAMPLE,
    FIRST_SAMPLE,
    MOST_RECENT_SAMPLE,
    OVERWRITE,
    REFERENCE_TRIGGER,
    ReadPosition,
)
from sim_hardware.ni.signals.timing import SampleMode, TaskTiming, TimingType
from sim_hardware.ni.tasks.channels import AnalogInputChannel
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import Task

_DEFAULT_NUMBER_TO_READ = 0x31E8  # clients ask for it; the protocol has no name for it


def _plain(kind: str, get: Callable[[Task], Any]) -> Attribute[Task]:
    return Attribute(kind, lambda _, task: get(task))


TASK: Table[Task] = {
    pb.TASK_ATTRIBUTE_NAME: _plain("String", lambda t: t.name),
    pb.TASK_ATTRIBUTE_CHANNELS: _plain("String", lambda t: join_list([c.name for c in t.channels])),
    pb.TASK_ATTRIBUTE_DEVICES: _plain("String", lambda t: join_list(t.device_names)),
    pb.TASK_ATTRIBUTE_NUM_CHANS: _plain("UInt32", lambda t: len(t.channels)),
    pb.TASK_ATTRIBUTE_NUM_DEVICES: _plain("UInt32", lambda t: len(t.device_names)),
    pb.TASK_ATTRIBUTE_COMPLETE: Attribute(
        "Bool", lambda e, t: t.timed is None or t.timed.is_done(e.now())
    ),
}


def _planned(kind: str, get: Callable[[Any], Any], field: str) -> Attribute[Task]:
    """Make a timing value that the board coerces: reading it verifies the task."""

    def ask(_: Engine, task: Task) -> Any:
        plan = task.verify()
        return None if plan is None else get(plan)

    return Attribute(
        kind,
        ask,
        lambda _, task, value: _change(task, field, value),
        lambda _, task: _change(task, field, getattr(TaskTiming(), field)),
    )


def _noted(
    kind: str, field: str, parse: Callable[[Any], Any] = lambda value: value
) -> Attribute[Task]:
    def ask(_: Engine, task: Task) -> Any:
        if task.timing.kind is TimingType.SAMPLE_CLOCK:
            task.verify()  # asking is one of the moments when bad values come to light
        return getattr(task.timing, field)

    return Attribute(
        kind,
        ask,
        lambda _, task, value: _change(task, field, parse(value)),
        lambda _, task: _change(task, field, getattr(TaskTiming(), field)),
    )


def _change(task: Task, field: str, value: Any) -> None:
    task.refuse_while_running()
    setattr(task.timing, field, value)
    task.changed()


def _timing_type(raw: int) -> TimingType:
    try:
        return TimingType(raw)
    except ValueError:
        raise StatusError(
            Code.INVALID_VALUE, f"Property: DAQmx_SampTimingType\nRequested: {raw}"
        ) from None


TIMING: Table[Task] = {
    pb.TIMING_ATTRIBUTE_SAMP_CLK_RATE: _planned("Double", lambda plan: plan.rate_hz, "rate_hz"),
    pb.TIMING_ATTRIBUTE_AI_CONV_RATE: _planned(
        "Double",
        lambda plan: 1.0 / plan.convert_s if getattr(plan, "convert_s", 0.0) else None,
        "convert_rate_hz",
    ),
    pb.TIMING_ATTRIBUTE_SAMP_CLK_MAX_RATE: Attribute("Double", lambda _, t: _max_rate(t)),
    pb.TIMING_ATTRIBUTE_SAMP_TIMING_TYPE: _noted("Int32", "kind", _timing_type),
    pb.TIMING_ATTRIBUTE_SAMP_QUANT_SAMP_MODE: _noted("Int32", "mode", sample_mode),
    pb.TIMING_ATTRIBUTE_SAMP_QUANT_SAMP_PER_CHAN: _noted("UInt64", "samples"),
    pb.TIMING_ATTRIBUTE_SAMP_CLK_ACTIVE_EDGE: _noted("Int32", "edge"),
    pb.TIMING_ATTRIBUTE_SAMP_CLK_SRC: Attribute(
        "String",
        lambda _, t: t.timing.source or _timebase_of(t),
        lambda _, t, value: _change(t, "source", value),
        lambda _, t: _change(t, "source", ""),
    ),
    pb.TIMING_ATTRIBUTE_REF_CLK_SRC: _noted("String", "reference_clock"),
    pb.TIMING_ATTRIBUTE_REF_CLK_RATE: _noted("Double", "reference_clock_hz"),
}


def _timebase_of(task: Task) -> str:
    side = "ao" if task.outputs else "ai"
    return f"/{task.channels[0].device.engine_name}/{side}/SampleClockTimebase"


def _max_rate(task: Task) -> float | None:
    if task.outputs:
        return task.outputs[0].side.max_rate_hz
    if not task.inputs:
        return None
    return task.inputs[0].side.max_rate(len(task.inputs))


def _set(name: str) -> Callable[[Engine, Task, Any], None]:
    return lambda _, task, value: setattr(task, name, value)


def _default(name: str) -> Callable[[Engine, Task], None]:
    return lambda _, task: setattr(task, name, getattr(Task, name))


def _available(engine: Engine, task: Task) -> int:
    return task.acquisition.available(engine.now()) if task.acquisition else 0


def _acquired(engine: Engine, task: Task) -> int:
    return task.acquisition.acquired(engine.now()) if task.acquisition else 0


def _default_count(engine: Engine, task: Task) -> int:
    """Return what `read all available` means; drivers from 24.5 on report it, clients ask."""
    acquisition, timing = task.acquisition, task.timing
    if timing.kind is TimingType.ON_DEMAND:
        return 1
    if timing.mode is SampleMode.FINITE and not task.read_all_available:
        left = acquisition.left if acquisition else None
        if left is not None:
            return left
        done = acquisition.position if acquisition and task.starts_again else 0
        return timing.samples - done % timing.samples
    return _available(engine, task)


def _names_to_read(_: Engine, task: Task) -> str:
    return task.channels_to_read or join_list([channel.name for channel in task.channels])


def _channels_to_read(_: Engine, task: Task, names: str) -> None:
    list(task.select(names))  # refuses names that are not in the task
    task.channels_to_read = names


def _selected(task: Task) -> int:
    return len(list(task.select(task.channels_to_read))) if task.channels else 0


def _of_reads(field: str, allowed: tuple[int, ...] = ()) -> Attribute[Task]:
    """Make a setting of where a read begins; -200077 for a value that it cannot have."""

    def put(_: Engine, task: Task, value: Any) -> None:
        if allowed and value not in allowed:
            raise StatusError(Code.INVALID_VALUE, f"Property: {field}\nRequested: {value}")
        setattr(task.reads, field, value)

    return Attribute(
        "Int32",
        lambda _, task: getattr(task.reads, field),
        put,
        lambda _, task: setattr(task.reads, field, getattr(ReadPosition(), field)),
    )


def _most_lines(task: Task) -> int:
    return max((len(channel.lines) for channel in task.digital), default=0)


READ: Table[Task] = {
    pb.READ_ATTRIBUTE_AUTO_START: Attribute(
        "Bool", lambda _, t: t.auto_start, _set("auto_start"), _default("auto_start")
    ),
    pb.READ_ATTRIBUTE_READ_ALL_AVAIL_SAMP: Attribute(
        "Bool",
        lambda _, t: t.read_all_available,
        _set("read_all_available"),
        _default("read_all_available"),
    ),
    pb.READ_ATTRIBUTE_CHANNELS_TO_READ: Attribute(
        "String", _names_to_read, _channels_to_read, _default("channels_to_read")
    ),
    pb.READ_ATTRIBUTE_NUM_CHANS: _plain("UInt32", _selected),
    pb.READ_ATTRIBUTE_DIGITAL_LINES_BYTES_PER_CHAN: _plain("UInt32", _most_lines),
    pb.READ_ATTRIBUTE_RAW_DATA_WIDTH: _plain("UInt32", lambda t: 2 * len(t.inputs)),
    pb.READ_ATTRIBUTE_AVAIL_SAMP_PER_CHAN: Attribute("UInt32", _available),
    pb.READ_ATTRIBUTE_TOTAL_SAMP_PER_CHAN_ACQUIRED: Attribute("UInt64", _acquired),
    pb.READ_ATTRIBUTE_CURR_READ_POS: _plain(
        "UInt64", lambda t: t.acquisition.position if t.acquisition else 0
    ),
    _DEFAULT_NUMBER_TO_READ: Attribute("UInt32", _default_count),
    pb.READ_ATTRIBUTE_OVERWRITE: _of_reads("overwrite", (OVERWRITE, DO_NOT_OVERWRITE)),
    pb.READ_ATTRIBUTE_RELATIVE_TO: _of_reads(
        "relative_to",
        (
            FIRST_SAMPLE,
            CURRENT_READ_POSITION,
            REFERENCE_TRIGGER,
            FIRST_PRETRIGGER_SAMPLE,
            MOST_RECENT_SAMPLE,
        ),
    ),
    pb.READ_ATTRIBUTE_OFFSET: _of_reads("offset"),
}

BUFFER: Table[Task] = {
    pb.BUFFER_ATTRIBUTE_INPUT_BUF_SIZE: Attribute(
        "UInt32",
        lambda _, t: t.buffer_size(),
        lambda _, t, value: _change(t, "buffer", value),
        lambda _, t: _change(t, "buffer", None),
    ),
    pb.BUFFER_ATTRIBUTE_INPUT_ONBRD_BUF_SIZE: _plain("UInt32", lambda t: _fifo(t.inputs)),
}


def _fifo(inputs: list[AnalogInputChannel]) -> int | None:
    return inputs[0].side.fifo_samples if inputs else None


HANDLERS = (
    attribute_handlers("Task", TASK, task_of)
    | attribute_handlers("Timing", TIMING, task_of)
    | attribute_handlers("Read", READ, task_of)
    | attribute_handlers("Buffer", {**BUFFER, **OUTPUT_BUFFER}, task_of)
)
