"""Clients that die: what a server leaves as it is, and what a local driver clears."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from nidaqmx.errors import DaqError, RpcError
from nidaqmx.grpc_session_options import SessionInitializationBehavior as Behavior

from sim_hardware.ni import LoopbackWires, NiDeviceServer, PortTakenError
from tests.processes import ended

CLIENT = """
import sys, grpc, nidaqmx
channel = grpc.insecure_channel(sys.argv[1])
def task(name):
    return nidaqmx.Task(name, grpc_options=nidaqmx.GrpcSessionOptions(channel, name))
output, signal = task("labrig-output"), task("labrig-input")
output.ao_channels.add_ao_voltage_chan("PCI6703/ao0", min_val=-2, max_val=2)
output.start()
output.write(2.0)
signal.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
signal.timing.cfg_samp_clk_timing(
    1000, sample_mode=nidaqmx.constants.AcquisitionType.CONTINUOUS, samps_per_chan=100000)
signal.start()
print("driving", flush=True)
signal.read(10**6, timeout=-1)
"""


@pytest.fixture
def start_client() -> Iterator[Callable[[int], Any]]:
    """A process that drives 2 V and acquires until it is killed."""
    with ExitStack() as stack:

        def start(port: int) -> Any:
            client = subprocess.Popen(
                [sys.executable, "-c", CLIENT, f"127.0.0.1:{port}"],
                stdout=subprocess.PIPE,
                text=True,
            )
            stack.callback(client.wait)
            stack.callback(client.kill)
            assert client.stdout is not None
            stack.callback(client.stdout.close)
            assert client.stdout.readline() == "driving\n"
            return client

        yield start


def port_of(ni: Any) -> int:
    return int(ni.server._tcp.port)


@pytest.mark.slow
def test_a_killed_clients_output_stays_until_somebody_attaches_and_writes(
    make_ni: Any, start_client: Any
) -> None:
    ni = make_ni(tcp=True)
    client = start_client(port_of(ni))
    client.kill()
    ended(client)
    with pytest.raises(DaqError, match="-50103"):  # its tasks go on
        ni.output().write(0.0)
    with pytest.raises(DaqError, match="-50103"):
        ni.input().read()
    signal = ni.task("labrig-input", initialization_behavior=Behavior.ATTACH_TO_SERVER_SESSION)
    assert signal.read(100)[-1] == pytest.approx(2.0, abs=2e-3)
    output = ni.task("labrig-output", initialization_behavior=Behavior.ATTACH_TO_SERVER_SESSION)
    output.write(0.0)
    signal.stop()
    assert abs(ni.input().read()) < 2e-3


@pytest.mark.slow
def test_a_reset_frees_a_killed_clients_channel_and_leaves_its_voltage(
    make_ni: Any, start_client: Any
) -> None:
    ni = make_ni(tcp=True)
    start_client(port_of(ni)).kill()
    for device in ni.system.devices:
        device.reset_device()
    assert ni.input().read() == pytest.approx(2.0, abs=2e-3)
    ni.output().write(0.0)
    assert abs(ni.input().read()) < 2e-3


@pytest.mark.slow
def test_with_strict_ownership_tasks_end_with_their_process(
    make_ni: Any, start_client: Any
) -> None:
    ni = make_ni(tcp=True, strict_ownership=True)
    client = start_client(port_of(ni))
    with pytest.raises(RpcError):
        ni.task("labrig-output", initialization_behavior=Behavior.ATTACH_TO_SERVER_SESSION)
    with pytest.raises(DaqError, match="-50103"):
        ni.output().write(0.0)
    client.kill()
    ended(client)
    output = ni.output()
    for _ in range(100):  # a driver needs a moment to notice
        try:
            output.start()
            break
        except DaqError:
            ni.pass_time(0.02)
    assert ni.input().read() == pytest.approx(2.0, abs=2e-3)  # released, and still driven
    output.write(0.0)
    assert abs(ni.input().read()) < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize("tcp", [False, True])
def test_with_strict_ownership_names_belong_to_a_client(make_ni: Any, tcp: bool) -> None:
    ni = make_ni(tcp=tcp, strict_ownership=True)
    first = ni.task("a")
    first.ao_channels.add_ao_voltage_chan("PCI6703/ao0")
    first.start()
    with pytest.raises(DaqError) as fault:
        ni.task("a")
    assert fault.value.error_code == -200089
    ni.channel = ni.new_channel()
    other = ni.task("a")  # another client's: not the same
    assert other.number_of_channels == 0
    other.ao_channels.add_ao_voltage_chan("PCI6703/ao0")
    with pytest.raises(DaqError) as fault:
        other.start()
    assert fault.value.error_code == -50103


def test_with_strict_ownership_a_closed_channel_lets_go(make_ni: Any) -> None:
    ni = make_ni(tcp=False, strict_ownership=True)
    task = ni.output()
    task.start()
    task.write(1.0)
    ni.channel.close()
    with pytest.raises(ValueError, match="closed channel"):
        task.write(0.0)
    ni.channel = ni.new_channel()
    ni.output().start()
    assert ni.input().read() == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("strict", [False, True])
def test_a_port_that_is_taken_is_refused(make_ni: Any, strict: bool) -> None:
    ni = make_ni(tcp=True)
    second = NiDeviceServer(LoopbackWires({}), ni.clock, strict_ownership=strict)
    with pytest.raises(PortTakenError, match=f"port {port_of(ni)} .* choose another"):
        second.listen(port_of(ni))
    second.stop()


def test_a_server_listens_once(make_ni: Any) -> None:
    ni = make_ni(tcp=True)
    with pytest.raises(RuntimeError, match="already"):
        ni.server.listen()
    ni.server.stop()
    ni.server.stop()
