"""A time-out for every call to a gRPC server, so that a server that hangs cannot hang us.

NI's package sets none. The deadline is what the request itself may take (a read waits for its
samples) plus what the slowest healthy server needs for that kind of call.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import grpc

QUICK_S = 1.0  # reads, writes and attributes: about 1 ms each on a healthy network
# Of a server that has just let a call run out of time: it may have recovered, and else it must not
# take that time again with each call of a shutdown. One that answers has its full time again.
HURRIED_QUICK_S, HURRIED_SLOW_S = 0.5, 1.0
SLOW_S = 10.0  # making, starting, clearing a task: an old driver may load itself first
_SLOW_CALLS = frozenset(
    {"CreateTask", "ClearTask", "StartTask", "StopTask", "TaskControl", "ResetDevice"}
)
_SELF_TEST_S = 60.0
_WAIT_FIELDS = ("timeout", "time_to_wait")


def deadline_s(method: str, request: object, *, hurried: bool = False) -> float:
    """Seconds after which the call `method` (as /service/Name) with `request` has failed."""
    name = method.rsplit("/", 1)[-1]
    if name == "SelfTestDevice":
        return _SELF_TEST_S
    quick_s, slow_s = (HURRIED_QUICK_S, HURRIED_SLOW_S) if hurried else (QUICK_S, SLOW_S)
    base = slow_s if name in _SLOW_CALLS else quick_s
    waits = [float(getattr(request, field, 0.0)) for field in _WAIT_FIELDS]
    return base + max(0.0, *waits)  # a wait "for ever" is -1: it gets the base only


@dataclass(frozen=True, kw_only=True)
class _CallDetails(grpc.ClientCallDetails):  # type: ignore[misc] # grpc is untyped
    method: str
    timeout: float | None
    metadata: Any
    credentials: Any
    wait_for_ready: bool | None
    compression: Any


class DeadlineInterceptor(grpc.UnaryUnaryClientInterceptor):  # type: ignore[misc] # grpc is untyped
    """Gives every call without a time-out its deadline. One for each channel."""

    def __init__(self) -> None:
        self._hurried = False  # the last call ran out of time

    def intercept_unary_unary(
        self, continuation: Callable[[Any, Any], Any], client_call_details: Any, request: Any
    ) -> Any:
        """See grpc.UnaryUnaryClientInterceptor."""
        details = client_call_details
        if details.timeout is None:
            details = _CallDetails(
                method=details.method,
                timeout=deadline_s(details.method, request, hurried=self._hurried),
                metadata=details.metadata,
                credentials=details.credentials,
                wait_for_ready=details.wait_for_ready,
                compression=details.compression,
            )
        call = continuation(details, request)
        call.add_done_callback(self._note)
        return call

    def _note(self, call: Any) -> None:
        self._hurried = call.code() is grpc.StatusCode.DEADLINE_EXCEEDED


def channel_to(target: str) -> Any:
    """Open a gRPC channel to host:port with our deadlines and a TCP connection of its own."""
    options = [
        ("grpc.max_receive_message_length", 256 * 2**20),  # 4 MB hold 0.5 M samples only
        ("grpc.max_send_message_length", 256 * 2**20),
        ("grpc.use_local_subchannel_pool", 1),  # else two channels share one connection
        ("grpc.enable_http_proxy", 0),  # a rig's server is never behind the web's proxy
    ]
    return with_deadlines(grpc.insecure_channel(target, options=options))


def with_deadlines(channel: Any) -> Any:
    """Return the same channel, every call of which ends in time."""
    return grpc.intercept_channel(channel, DeadlineInterceptor())
