"""Calls that register for events and answer with a stream of them."""

from __future__ import annotations

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.rpc import Call, Message, raw_enum
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.event_threads import (
    ACQUIRED_INTO_BUFFER,
    TRANSFERRED_FROM_BUFFER,
)
from sim_hardware.ni.tasks.events import EveryNSamples, Stream
from sim_hardware.ni.tasks.task import Task


def register_every_n_samples_event(engine: Engine, request: Message, call: Call) -> Stream:
    """Register for an event after every n samples."""
    task = task_of(engine, request, call)
    _check_type(task, request)
    task.refuse_while_running(Code.EVENT_WHILE_RUNNING)
    if request.n_samples == 0:
        raise StatusError(Code.EVENT_INTERVAL_ZERO, task=task.name)
    if task.events.every_n is not None and not task.events.every_n.stream.closed:
        raise StatusError(Code.EVENT_TWICE, task=task.name)
    task.events.every_n = EveryNSamples(
        request.n_samples, Stream(), raw_enum(request, "every_n_samples_event_type")
    )
    return task.events.every_n.stream


def register_done_event(engine: Engine, request: Message, call: Call) -> Stream:
    """Register for the end of an acquisition."""
    task = task_of(engine, request, call)
    task.refuse_while_running(Code.EVENT_WHILE_RUNNING)
    if task.events.done is not None and not task.events.done.closed:
        raise StatusError(Code.DONE_EVENT_TWICE, task=task.name)
    task.events.done = Stream()
    return task.events.done


def unregister_every_n_samples_event(engine: Engine, request: Message, call: Call) -> Message:
    """End the stream."""
    task = _stopped_task(engine, request, call)
    _check_type(task, request)
    if task.events.every_n is not None:
        task.events.every_n.stream.close()
        task.events.every_n = None
    return pb.UnregisterEveryNSamplesEventResponse()


def unregister_done_event(engine: Engine, request: Message, call: Call) -> Message:
    """End the stream."""
    task = _stopped_task(engine, request, call)
    if task.events.done is not None:
        task.events.done.close()
        task.events.done = None
    return pb.UnregisterDoneEventResponse()


def _stopped_task(engine: Engine, request: Message, call: Call) -> Task:
    task = task_of(engine, request, call)
    task.refuse_while_running(Code.EVENT_UNREGISTER_RUNNING)
    return task


def _check_type(task: Task, request: Message) -> None:
    """Refuse events that the task cannot have: inputs fill buffers, clocked outputs empty them."""
    kind = raw_enum(request, "every_n_samples_event_type")
    if kind == ACQUIRED_INTO_BUFFER:
        if task.channels and not task.inputs:
            raise StatusError(Code.EVENT_ACQUIRED_UNSUPPORTED, task=task.name)
    elif kind != TRANSFERRED_FROM_BUFFER or not task.outputs or not task.outputs[0].side.clocked:
        raise StatusError(Code.EVENT_TRANSFERRED_UNSUPPORTED, task=task.name)


STREAM_HANDLERS = {
    "RegisterEveryNSamplesEvent": register_every_n_samples_event,
    "RegisterDoneEvent": register_done_event,
}
HANDLERS = {
    "UnregisterEveryNSamplesEvent": unregister_every_n_samples_event,
    "UnregisterDoneEvent": unregister_done_event,
}
