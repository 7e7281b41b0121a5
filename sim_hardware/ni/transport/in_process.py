"""A gRPC channel that leads to the server in this process: no socket, no thread, the caller works.

It is what a session on a virtual clock needs, and makes tests quick.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, Self

import grpc

from sim_hardware.ni.rpc import CallError, Message
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.events import Stream
from sim_hardware.ni.transport.service import Method, answer

_numbers = itertools.count()


class _Entry(NamedTuple):
    """One entry of trailing metadata."""

    key: str
    value: str


class _ChannelCall:
    """The call as the server sees it; its time-out runs on the server's clock."""

    def __init__(self, engine: Engine, client: str, timeout: float | None) -> None:
        self.client = client
        self._clock = engine.clock
        self._end_s = None if timeout is None else engine.clock.now() + timeout

    def is_active(self) -> bool:
        """See `rpc.Call`."""
        return self._end_s is None or self._clock.now() < self._end_s


class _Outcome:
    """The part of grpc.Call and grpc.Future for a call that has succeeded."""

    def __init__(self, value: Any = None) -> None:
        self._value = value

    def result(self, timeout: float | None = None) -> Any:  # noqa: ARG002 - grpc.Future has it
        """Return the response."""
        return self._value

    def exception(self, timeout: float | None = None) -> Exception | None:  # noqa: ARG002
        """None."""
        return None

    def done(self) -> bool:
        """Return True."""
        return True

    def cancel(self) -> bool:
        """Too late."""
        return False

    def add_done_callback(self, callback: Callable[[Any], None]) -> None:
        """Call back at once."""
        callback(self)

    def code(self) -> grpc.StatusCode:
        """Return the status."""
        return grpc.StatusCode.OK

    def details(self) -> str:
        """Return the status in words."""
        return ""

    def initial_metadata(self) -> tuple[_Entry, ...]:
        """None."""
        return ()

    def trailing_metadata(self) -> tuple[_Entry, ...]:
        """None."""
        return ()


class InProcessRpcError(grpc.RpcError, _Outcome):  # type: ignore[misc] # grpc is untyped
    """A call that the server has refused."""

    def __init__(self, fault: CallError) -> None:
        super().__init__(fault.details)
        self._fault = fault

    def result(self, timeout: float | None = None) -> Any:  # noqa: ARG002
        """Raise the error."""
        raise self

    def exception(self, timeout: float | None = None) -> Exception:  # noqa: ARG002
        """Return the error."""
        return self

    def code(self) -> grpc.StatusCode:
        """Return the status."""
        return self._fault.status

    def details(self) -> str:
        """Return the status in words."""
        return self._fault.details

    def trailing_metadata(self) -> tuple[_Entry, ...]:
        """Return where NI's status code is."""
        return tuple(_Entry(key, value) for key, value in self._fault.trailing)


class _UnaryUnary(grpc.UnaryUnaryMultiCallable):  # type: ignore[misc] # grpc is untyped
    def __init__(self, channel: InProcessChannel, path: str) -> None:
        self._channel = channel
        self._path = path

    def __call__(self, request: Message, timeout: float | None = None, **_: Any) -> Message:
        return self._channel._answer(self._path, request, timeout)

    def with_call(
        self, request: Message, timeout: float | None = None, **_: Any
    ) -> tuple[Message, _Outcome]:
        response = self(request, timeout)
        return response, _Outcome(response)

    def future(self, request: Message, timeout: float | None = None, **_: Any) -> _Outcome:
        try:
            return _Outcome(self(request, timeout))
        except InProcessRpcError as error:
            return error


class _Events(_Outcome):
    """A stream of events, as the client sees it."""

    def __init__(self, stream: Stream) -> None:
        super().__init__()
        self._stream = stream
        self._iterator = iter(stream)

    def __iter__(self) -> Iterator[Message]:
        return self._iterator

    def __next__(self) -> Message:
        return next(self._iterator)

    def done(self) -> bool:
        """Return whether it has ended."""
        return self._stream.closed

    def cancel(self) -> bool:
        """End it."""
        self._stream.close()
        return True


class _UnaryStream(grpc.UnaryStreamMultiCallable):  # type: ignore[misc] # grpc is untyped
    def __init__(self, channel: InProcessChannel, path: str) -> None:
        self._channel = channel
        self._path = path

    def __call__(self, request: Message, timeout: float | None = None, **_: Any) -> _Events:
        return _Events(self._channel._answer(self._path, request, timeout))


class InProcessChannel(grpc.Channel):  # type: ignore[misc] # grpc is untyped
    """One client's connection."""

    def __init__(self, engine: Engine, methods: dict[str, Method]) -> None:
        self._engine = engine
        self._methods = methods
        self._client = f"in-process:{next(_numbers)}"
        self._closed = False

    def _answer(self, path: str, request: Message, timeout: float | None) -> Any:
        if self._closed:
            raise ValueError("Cannot invoke RPC on closed channel!")  # gRPC's own words
        method = self._methods.get(path)
        try:
            if method is None:
                raise CallError(grpc.StatusCode.UNIMPLEMENTED, "Method not found!")
            return answer(
                self._engine, method, request, _ChannelCall(self._engine, self._client, timeout)
            )
        except CallError as fault:
            raise InProcessRpcError(fault) from fault

    def unary_unary(self, method: str, *_: Any, **__: Any) -> _UnaryUnary:
        """See grpc.Channel; requests are handed over as they are."""
        return _UnaryUnary(self, method)

    def unary_stream(self, method: str, *_: Any, **__: Any) -> _UnaryStream:
        """See grpc.Channel."""
        return _UnaryStream(self, method)

    def stream_unary(self, method: str, *_: Any, **__: Any) -> None:
        """Not needed: NI's service has no such call. nidaqmx asks for none."""

    def stream_stream(self, method: str, *_: Any, **__: Any) -> None:
        """Not needed: NI's service has no such call. nidaqmx asks for none."""

    def subscribe(
        self,
        callback: Callable[[grpc.ChannelConnectivity], None],
        try_to_connect: bool | None = None,  # noqa: ARG002 - grpc.Channel has it
    ) -> None:
        """Report that it is connected, as it always is."""
        callback(grpc.ChannelConnectivity.READY)

    def unsubscribe(self, callback: Callable[[grpc.ChannelConnectivity], None]) -> None:
        """Nothing to do: nothing changes."""

    def close(self) -> None:
        """End the connection. With strict ownership its tasks go with it."""
        if not self._closed:
            self._closed = True
            self._engine.client_gone(self._client)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
