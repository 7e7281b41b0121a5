"""Calls that make, run and end tasks."""

from __future__ import annotations

import math

from nidaqmx._stubs import nidaqmx_pb2 as pb
from session_pb2 import Session

from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.rpc import Call, Message, raw_enum
from sim_hardware.ni.signals.timing import SampleMode, TimingType
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import ReferenceTrigger, StartTrigger, Task, TaskState

_START, _STOP, _VERIFY, _COMMIT, _RESERVE, _UNRESERVE, _ABORT = range(7)  # constants.TaskMode


def task_of(engine: Engine, request: Message, call: Call) -> Task:
    """Return the task that a request names."""
    return engine.sessions.find(request.task.name, call.client)


def create_task(engine: Engine, request: Message, call: Call) -> Message:
    """Return a new task, or the one that has the name already."""
    behaviour = int(request.initialization_behavior)
    task, new = engine.sessions.create(request.session_name, behaviour, call.client)
    return pb.CreateTaskResponse(task=Session(name=task.name), new_session_initialized=new)


def clear_task(engine: Engine, request: Message, call: Call) -> Message:
    """Abort and forget."""
    engine.clear(task_of(engine, request, call))
    return pb.ClearTaskResponse()


def start_task(engine: Engine, request: Message, call: Call) -> Message:
    """Run."""
    engine.start(task_of(engine, request, call))
    return pb.StartTaskResponse()


def stop_task(engine: Engine, request: Message, call: Call) -> Message:
    """Back to what it was before the start."""
    engine.stop(task_of(engine, request, call))
    return pb.StopTaskResponse()


def task_control(engine: Engine, request: Message, call: Call) -> Message:
    """One step along the states."""
    task = task_of(engine, request, call)
    action = raw_enum(request, "action")
    if action in (_COMMIT, _RESERVE):
        engine.reserve(task, TaskState.COMMITTED if action == _COMMIT else TaskState.RESERVED)
        task.held = True
    elif action == _UNRESERVE:
        task.refuse_while_running(Code.TASK_RUNNING)
        task.held = False
        engine.unreserve(task)
    else:
        steps = {
            _START: engine.start,
            _STOP: engine.stop,
            _VERIFY: engine.verify,
            _ABORT: engine.abort,
        }
        if action not in steps:
            raise StatusError(Code.INVALID_VALUE, f"Task action: {action}", task.name)
        steps[action](task)
    return pb.TaskControlResponse()


def is_task_done(engine: Engine, request: Message, call: Call) -> Message:
    """Return whether there is nothing left to do."""
    task = task_of(engine, request, call)
    return pb.IsTaskDoneResponse(is_task_done=_is_done(engine, task))


def wait_until_task_done(engine: Engine, request: Message, call: Call) -> Message:
    """Wait for the end of a finite acquisition; -200560 when the time is over first."""
    task = task_of(engine, request, call)
    limit_s = math.inf if request.time_to_wait < 0 else engine.now() + request.time_to_wait
    while not _is_done(engine, task):
        timed = task.timed
        total = timed.plan.total if timed else None
        done_s = math.inf if total is None or not timed else timed.time_of(total)
        if engine.now() >= limit_s or not engine.wait_until(min(limit_s, done_s), call):
            raise StatusError(Code.NOT_DONE, task=task.name)
    return pb.WaitUntilTaskDoneResponse()


def cfg_samp_clk_timing(engine: Engine, request: Message, call: Call) -> Message:
    """Note the sample clock; it is checked when the task is verified."""
    task = task_of(engine, request, call)
    task.refuse_while_running()
    timing = task.timing
    timing.kind = TimingType.SAMPLE_CLOCK
    timing.rate_hz = request.rate
    timing.source = request.source
    timing.edge = raw_enum(request, "active_edge")
    timing.mode = sample_mode(raw_enum(request, "sample_mode"))
    timing.samples = request.samps_per_chan
    task.output.clear()
    task.changed()
    return pb.CfgSampClkTimingResponse()


def cfg_dig_edge_start_trig(engine: Engine, request: Message, call: Call) -> Message:
    """Note the trigger; it is checked when the task is verified."""
    task = task_of(engine, request, call)
    task.refuse_while_running()
    edge, again = raw_enum(request, "trigger_edge"), task.trigger.retriggerable
    task.trigger = StartTrigger(request.trigger_source, edge, again)
    task.changed()
    return pb.CfgDigEdgeStartTrigResponse()


def disable_start_trig(engine: Engine, request: Message, call: Call) -> Message:
    """Start at once."""
    task = task_of(engine, request, call)
    task.refuse_while_running()
    task.trigger = StartTrigger()
    task.changed()
    return pb.DisableStartTrigResponse()


def cfg_dig_edge_ref_trig(engine: Engine, request: Message, call: Call) -> Message:
    """Note the reference trigger; it is checked when the task is verified."""
    task = task_of(engine, request, call)
    task.refuse_while_running()
    edge = raw_enum(request, "trigger_edge")
    task.reference = ReferenceTrigger(request.trigger_source, edge, request.pretrigger_samples)
    task.changed()
    return pb.CfgDigEdgeRefTrigResponse()


def disable_ref_trig(engine: Engine, request: Message, call: Call) -> Message:
    """Acquire all samples from the start on."""
    task = task_of(engine, request, call)
    task.refuse_while_running()
    task.reference = ReferenceTrigger()
    task.changed()
    return pb.DisableRefTrigResponse()


def cfg_input_buffer(engine: Engine, request: Message, call: Call) -> Message:
    """Set the size of the buffer for what is acquired."""
    task = task_of(engine, request, call)
    task.refuse_while_running()
    task.timing.buffer = request.num_samps_per_chan
    task.changed()
    return pb.CfgInputBufferResponse()


def cfg_output_buffer(engine: Engine, request: Message, call: Call) -> Message:
    """Set the size of the buffer for what is written."""
    task = task_of(engine, request, call)
    task.refuse_while_running()
    task.output.clear()
    task.output.size = request.num_samps_per_chan or None
    return pb.CfgOutputBufferResponse()


def sample_mode(raw: int) -> SampleMode:
    """Return the enum of a number that a client sent."""
    try:
        return SampleMode(raw)
    except ValueError:
        raise StatusError(
            Code.INVALID_VALUE, f"Property: DAQmx_SampQuant_SampMode\nRequested: {raw}"
        ) from None


def _is_done(engine: Engine, task: Task) -> bool:
    """On demand a started task waits for the next write; it counts as done between them."""
    if not task.running or task.timed is None:
        return True
    return task.timed.is_done(engine.now())


HANDLERS = {
    "CreateTask": create_task,
    "ClearTask": clear_task,
    "StartTask": start_task,
    "StopTask": stop_task,
    "TaskControl": task_control,
    "IsTaskDone": is_task_done,
    "WaitUntilTaskDone": wait_until_task_done,
    "CfgSampClkTiming": cfg_samp_clk_timing,
    "CfgDigEdgeStartTrig": cfg_dig_edge_start_trig,
    "DisableStartTrig": disable_start_trig,
    "CfgDigEdgeRefTrig": cfg_dig_edge_ref_trig,
    "DisableRefTrig": disable_ref_trig,
    "CfgInputBuffer": cfg_input_buffer,
    "CfgOutputBuffer": cfg_output_buffer,
}
