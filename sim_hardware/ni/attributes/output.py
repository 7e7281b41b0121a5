"""Attributes of writing and of the output buffer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.attributes.common import Attribute, Table, attribute_handlers
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.signals.generation import (
    ALLOW_REGENERATION,
    CURRENT_WRITE_POSITION,
    DONT_ALLOW_REGENERATION,
    FIRST_SAMPLE,
    OutputBuffer,
)
from sim_hardware.ni.signals.timing import TimingType
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import Task

_BYTES_PER_CODE = 2


def _of_buffer(
    field: str, allowed: tuple[int, ...] = (), *, while_running: bool = True
) -> Attribute[Task]:
    """Make a setting of the output buffer; -200077 for a value that it cannot have."""

    def put(_: Engine, task: Task, value: Any) -> None:
        if not while_running:
            task.refuse_while_running()
        if allowed and value not in allowed:
            raise StatusError(Code.INVALID_VALUE, f"Property: {field}\nRequested: {value}")
        setattr(task.output, field, value)

    return Attribute(
        "Int32",
        lambda _, task: getattr(task.output, field),
        put,
        lambda _, task: setattr(task.output, field, getattr(OutputBuffer(), field)),
    )


def _set_size(_: Engine, task: Task, value: int) -> None:
    task.refuse_while_running()
    task.output.clear()
    task.output.size = value or None


def _size(_: Engine, task: Task) -> int | None:
    if not task.outputs and not task.digital:
        return None
    return task.output.size or task.output.length


def _generated(engine: Engine, task: Task) -> int:
    return task.generation.generated(engine.now()) if task.generation else 0


def _room(engine: Engine, task: Task) -> int:
    """Return the samples per channel that can be written now."""
    if task.timing.kind is TimingType.ON_DEMAND:
        return 0
    size = task.output.size or task.output.length
    return max(0, size - (task.output.written - _generated(engine, task)))


def _plain(kind: str, get: Callable[[Task], Any]) -> Attribute[Task]:
    return Attribute(kind, lambda _, task: get(task))


def _most_lines(task: Task) -> int:
    return max((len(channel.lines) for channel in task.digital), default=0)


def _fifo(task: Task) -> int | None:
    return (task.outputs[0].side.fifo_samples or None) if task.outputs else None


WRITE: Table[Task] = {
    pb.WRITE_ATTRIBUTE_NUM_CHANS: _plain("UInt32", lambda t: len(t.channels)),
    pb.WRITE_ATTRIBUTE_DIGITAL_LINES_BYTES_PER_CHAN: _plain("UInt32", _most_lines),
    pb.WRITE_ATTRIBUTE_RAW_DATA_WIDTH: _plain("UInt32", lambda t: _BYTES_PER_CODE * len(t.outputs)),
    pb.WRITE_ATTRIBUTE_CURR_WRITE_POS: _plain("UInt64", lambda t: t.output.next),
    pb.WRITE_ATTRIBUTE_TOTAL_SAMP_PER_CHAN_GENERATED: Attribute("UInt64", _generated),
    pb.WRITE_ATTRIBUTE_SPACE_AVAIL: Attribute("UInt32", _room),
    pb.WRITE_ATTRIBUTE_OFFSET: _of_buffer("offset"),
    pb.WRITE_ATTRIBUTE_RELATIVE_TO: _of_buffer(
        "relative_to", (FIRST_SAMPLE, CURRENT_WRITE_POSITION)
    ),
    pb.WRITE_ATTRIBUTE_REGEN_MODE: _of_buffer(
        "regeneration", (ALLOW_REGENERATION, DONT_ALLOW_REGENERATION), while_running=False
    ),
}
OUTPUT_BUFFER: Table[Task] = {
    pb.BUFFER_ATTRIBUTE_OUTPUT_BUF_SIZE: Attribute(
        "UInt32", _size, _set_size, lambda engine, task: _set_size(engine, task, 0)
    ),
    pb.BUFFER_ATTRIBUTE_OUTPUT_ONBRD_BUF_SIZE: _plain("UInt32", _fifo),
}
HANDLERS = attribute_handlers("Write", WRITE, task_of)
