"""A simulated board server with a client: over TCP in real time, in process on a virtual clock."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import grpc
import nidaqmx
import pytest
from nidaqmx.system import System

from drivers.interfaces import Clock, RealClock
from sim_hardware.clock import VirtualClock
from sim_hardware.ni import LoopbackWires, NiDeviceServer

PATIENCE_S = 20.0
WIRES = {"PCI6703/ao0": "PCI6034E/ai0", "PCI6703/ao1": "PCI6034E/ai1", "M/ao0": "M/ai0"}
DEVICES = {"PCI6703": "PCI-6703", "PCI6034E": "PCI-6034E", "X": "PCIe-6363", "M": "USB-6211"}


class _Deadline(grpc.UnaryUnaryClientInterceptor):  # type: ignore[misc]
    """No call of a test may hang."""

    def intercept_unary_unary(self, continuation: Any, details: Any, request: Any) -> Any:
        return continuation(details._replace(timeout=PATIENCE_S), request)


@dataclass
class NiRig:
    """A server, and a client of it that uses nidaqmx's public face only."""

    server: NiDeviceServer
    clock: Clock
    new_channel: Callable[[], Any]
    tcp: bool
    stack: ExitStack
    channel: Any = None

    def options(self, name: str = "", **more: Any) -> nidaqmx.GrpcSessionOptions:
        return nidaqmx.GrpcSessionOptions(self.channel, name, **more)

    def task(self, name: str = "", **more: Any) -> nidaqmx.Task:
        """A task that is cleared at the test's end, if it still is there."""
        task = nidaqmx.Task(name, grpc_options=self.options(name, **more))
        self.stack.callback(_clear, task)
        return task

    def output(self, channel: str = "PCI6703/ao0", limit: float = 10.0) -> nidaqmx.Task:
        task = self.task()
        task.ao_channels.add_ao_voltage_chan(channel, min_val=-limit, max_val=limit)
        return task

    def input(self, *channels: str, limit: float = 10.0, **options: Any) -> nidaqmx.Task:
        task = self.task()
        for channel in channels or ("PCI6034E/ai0",):
            task.ai_channels.add_ai_voltage_chan(channel, min_val=-limit, max_val=limit, **options)
        return task

    @property
    def system(self) -> System:
        return System.remote(self.options())

    def pass_time(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)


def _clear(task: nidaqmx.Task) -> None:
    if task._handle is not None:
        # It may be gone already, or the connection may.
        with contextlib.suppress(nidaqmx.DaqError, nidaqmx.errors.RpcError, ValueError):
            task.close()


@pytest.fixture
def make_ni() -> Iterator[Callable[..., NiRig]]:
    """Make a server and a client; keyword arguments go to the server."""
    with ExitStack() as stack:

        def make(*, tcp: bool, bench: Any = None, **options: Any) -> NiRig:
            clock: Clock = RealClock() if tcp else VirtualClock()
            options.setdefault("devices", DEVICES)
            server = NiDeviceServer(bench or LoopbackWires(WIRES), clock, **options)
            stack.callback(server.stop)
            new_channel: Callable[[], Any] = server.in_process_channel
            if tcp:
                address = f"127.0.0.1:{server.listen()}"

                def new_channel() -> Any:
                    settings = [
                        ("grpc.use_local_subchannel_pool", 1),
                        ("grpc.max_receive_message_length", -1),
                    ]
                    channel = grpc.insecure_channel(address, settings)
                    stack.callback(channel.close)
                    return grpc.intercept_channel(channel, _Deadline())

            rig = NiRig(server, clock, new_channel, tcp, stack)
            rig.channel = new_channel()
            return rig

        yield make


# Over TCP each takes twice as long; what the tests ask is the same.
@pytest.fixture(params=["in process", pytest.param("tcp", marks=pytest.mark.slow)])
def ni(request: pytest.FixtureRequest, make_ni: Callable[..., NiRig]) -> NiRig:
    """The same server, both ways."""
    return make_ni(tcp=request.param == "tcp")
