"""Write samples into the buffer of a clocked output."""

from __future__ import annotations

import math

from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.rpc import Call, Message
from sim_hardware.ni.signals.adc import FloatArray
from sim_hardware.ni.signals.generation import Generation
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import Task, TaskState


def write_buffered(
    engine: Engine, task: Task, values: FloatArray, request: Message, call: Call
) -> int:
    """Write (channels, samples), as there is room for them; return how many of each channel.

    Before the start they fill the buffer, and the task takes its board.
    """
    generation = task.generation
    if task.running and generation is not None:
        return _write_running(engine, task, generation, values, request, call)
    engine.reserve(task, TaskState.COMMITTED)
    task.held = True
    task.output.put(task.output.position(0), values)
    if request.auto_start:
        engine.start(task)
    return int(values.shape[1])


def _write_running(
    engine: Engine,
    task: Task,
    generation: Generation,
    values: FloatArray,
    request: Message,
    call: Call,
) -> int:
    buffer, count, done = task.output, int(values.shape[1]), 0
    limit_s = math.inf if request.timeout < 0 else engine.now() + request.timeout
    position = buffer.position(generation.generated(engine.now()))
    while True:
        generation.check(engine.now())
        generated = generation.generated(engine.now())
        room = buffer.length - (position + done - generated)
        take = count - done if buffer.regenerates else min(count - done, max(0, room))
        if take:
            buffer.put(position + done, values[:, done : done + take])
            done += take
        if done == count:
            return count
        due_s = generation.time_of(generated + min(count - done, buffer.length))
        going = engine.now() < limit_s and engine.wait_until(min(due_s, limit_s), call)
        if not going or task.generation is not generation:
            raise StatusError(Code.NO_ROOM_YET, task=task.name, samples_written=done)
