"""The server on a TCP port."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent import futures
from typing import Any

import grpc

from sim_hardware.ni.rpc import CallError, Message
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.events import Stream
from sim_hardware.ni.transport.service import Method, answer
from sim_hardware.ni.transport.tcp_relay import ByteRelay
from sim_hardware.port_taken import PortTakenError

HOST = "127.0.0.1"
# Every open event stream and every waiting read holds a worker; threads are made when needed.
_WORKERS = 1000
_OPTIONS = (
    ("grpc.so_reuseport", 0),  # a second server on a port must fail, not answer half the calls
    ("grpc.max_receive_message_length", -1),
    ("grpc.max_send_message_length", -1),
)


class TcpServer:
    """Answers the calls of one engine on a port of this computer."""

    def __init__(
        self, engine: Engine, methods: dict[str, Method], port: int, *, watch_clients: bool
    ) -> None:
        """`watch_clients`: notify the engine when a client's connection closes."""
        self._server = grpc.server(
            futures.ThreadPoolExecutor(_WORKERS, "ni-server"), options=_OPTIONS
        )
        self._server.add_generic_rpc_handlers((_Handlers(engine, methods),))
        self._relay: ByteRelay | None = None
        inner = _bind(self._server, 0 if watch_clients else port)
        self._server.start()
        self.port = inner
        if watch_clients:
            try:
                self._relay = ByteRelay(HOST, port, inner, engine.client_gone)
            except OSError as fault:
                self._server.stop(None)
                raise PortTakenError(_taken(port)) from fault
            self.port = self._relay.port

    def stop(self) -> None:
        """Cut all connections. May be called twice."""
        if self._relay is not None:
            self._relay.stop()
        self._server.stop(None).wait()


def _bind(server: Any, port: int) -> int:
    try:
        bound = int(server.add_insecure_port(f"{HOST}:{port}"))
    except RuntimeError as fault:
        raise PortTakenError(_taken(port)) from fault
    if bound == 0:
        raise PortTakenError(_taken(port))
    return bound


def _taken(port: int) -> str:
    return f"port {port} of {HOST} cannot be taken: something else listens on it; choose another"


class _Call:
    def __init__(self, context: grpc.ServicerContext) -> None:
        self.client: str = context.peer()
        self.is_active: Callable[[], bool] = context.is_active


class _Handlers(grpc.GenericRpcHandler):  # type: ignore[misc] # grpc is untyped
    def __init__(self, engine: Engine, methods: dict[str, Method]) -> None:
        self._handlers = {path: _handler(engine, method) for path, method in methods.items()}

    def service(self, handler_call_details: grpc.HandlerCallDetails) -> Any:
        """Return the handler of a path; None, and so UNIMPLEMENTED, when there is none."""
        return self._handlers.get(handler_call_details.method)


def _handler(engine: Engine, method: Method) -> grpc.RpcMethodHandler:
    def unary(request: Message, context: grpc.ServicerContext) -> Message:
        return _answer(engine, method, request, context)

    def streaming(request: Message, context: grpc.ServicerContext) -> Iterator[Message]:
        stream: Stream = _answer(engine, method, request, context)
        if not context.add_callback(stream.close):
            stream.close()  # the client has gone already
        context.send_initial_metadata(())  # notifies the client that it is registered
        yield from stream

    make = (
        grpc.unary_stream_rpc_method_handler
        if method.streams
        else (grpc.unary_unary_rpc_method_handler)
    )
    return make(
        streaming if method.streams else unary,
        request_deserializer=method.request_type.FromString,
        response_serializer=method.response_type.SerializeToString,
    )


def _answer(engine: Engine, method: Method, request: Message, context: grpc.ServicerContext) -> Any:
    try:
        return answer(engine, method, request, _Call(context))
    except CallError as fault:
        context.set_trailing_metadata(fault.trailing)
        context.abort(fault.status, fault.details)
        raise  # not reached: abort raises
