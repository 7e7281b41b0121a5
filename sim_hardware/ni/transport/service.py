"""All calls that the server answers, and the one place where faults become gRPC statuses.

Both transports (a TCP port, a channel in this process) end here. What is not in the table is
UNIMPLEMENTED.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import grpc
import session_pb2
from google.protobuf import message_factory
from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.attributes import channel as attributes_channel
from sim_hardware.ni.attributes import device as attributes_device
from sim_hardware.ni.attributes import output as attributes_output
from sim_hardware.ni.attributes import task as attributes_task
from sim_hardware.ni.attributes import trigger as attributes_trigger
from sim_hardware.ni.calls import analog_input, analog_output, digital, waveforms
from sim_hardware.ni.calls import events as event_calls
from sim_hardware.ni.calls import system as system_calls
from sim_hardware.ni.calls import tasks as task_calls
from sim_hardware.ni.errors import NotSimulatedError, SessionError, StatusError
from sim_hardware.ni.rpc import Call, CallError, Message
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.events import Stream

# A call held up by a test looks this often whether its caller is still there.
_LOOK_S = 0.02


@dataclass(frozen=True, kw_only=True)
class Method:
    """A call by its path on the wire."""

    path: str
    name: str
    request_type: Any
    response_type: Any
    handler: Callable[[Engine, Message, Call], Any]
    streams: bool  # the handler answers a Stream


def methods() -> dict[str, Method]:
    """Every call that is answered, by path."""
    unary = (
        task_calls.HANDLERS
        | analog_input.HANDLERS
        | waveforms.HANDLERS
        | analog_output.HANDLERS
        | digital.HANDLERS
        | event_calls.HANDLERS
        | system_calls.HANDLERS
        | attributes_device.HANDLERS
        | attributes_task.HANDLERS
        | attributes_output.HANDLERS
        | attributes_trigger.HANDLERS
        | attributes_channel.HANDLERS
    )
    daq = pb.DESCRIPTOR.services_by_name["NiDAQmx"]
    sessions = session_pb2.DESCRIPTOR.services_by_name["SessionUtilities"]
    return {
        method.path: method
        for method in (
            *_of_service(daq, unary, streams=False),
            *_of_service(daq, event_calls.STREAM_HANDLERS, streams=True),
            *_of_service(sessions, system_calls.SESSION_HANDLERS, streams=False),
        )
    }


def _of_service(service: Any, handlers: Mapping[str, Any], *, streams: bool) -> list[Method]:
    found = []
    for name, handler in handlers.items():
        method = service.methods_by_name[name]
        request = message_factory.GetMessageClass(method.input_type)
        response = message_factory.GetMessageClass(method.output_type)
        path = f"/{service.full_name}/{name}"
        found.append(
            Method(
                path=path,
                name=name,
                request_type=request,
                response_type=response,
                handler=handler,
                streams=streams,
            )
        )
    return found


def answer(engine: Engine, method: Method, request: Message, call: Call) -> Message | Stream:
    """Return the response; raise CallError for whatever goes wrong."""
    try:
        _suffer_faults(engine, method, call)
        with engine.lock:
            engine.playback.advance()
            return method.handler(engine, request, call)
    except StatusError as fault:
        if not call.is_active():
            raise _too_late() from fault
        raise CallError(grpc.StatusCode.UNKNOWN, str(fault), _trailing(fault)) from fault
    except NotSimulatedError as fault:
        raise CallError(grpc.StatusCode.UNIMPLEMENTED, str(fault)) from fault
    except SessionError as fault:
        status = (
            grpc.StatusCode.ALREADY_EXISTS if fault.exists else grpc.StatusCode.FAILED_PRECONDITION
        )
        raise CallError(status, str(fault)) from fault


def _too_late() -> CallError:
    return CallError(grpc.StatusCode.DEADLINE_EXCEEDED, "Deadline Exceeded")


def _trailing(fault: StatusError) -> tuple[tuple[str, str], ...]:
    entries = [("ni-error", str(fault.code))]
    if fault.samples_read is not None:
        entries.append(("ni-samps-per-chan-read", str(fault.samples_read)))
    if fault.samples_written is not None:
        entries.append(("ni-samps-per-chan-written", str(fault.samples_written)))
    return tuple(entries)


def _suffer_faults(engine: Engine, method: Method, call: Call) -> None:
    """Apply the faults that are switched on; costs nothing while all are off."""
    faults, clock = engine.faults, engine.clock
    if faults.unavailable:
        raise CallError(grpc.StatusCode.UNAVAILABLE, "the simulated server is switched off")
    end_s = clock.now() + faults.delay_s
    while call.is_active() and ((hangs := faults.hangs(method.name)) or clock.now() < end_s):
        look_s = clock.now() + _LOOK_S
        clock.sleep_until(look_s if hangs else min(look_s, end_s))
    if not call.is_active():
        raise _too_late()
    if method.name in faults.refuse:
        raise StatusError(faults.refuse[method.name])
