"""What a call to the simulated boards costs: in this process, and over TCP.

Run: python -m benchmarks.wire_latency
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import grpc
import nidaqmx
import numpy as np
from nidaqmx.constants import AcquisitionType
from nidaqmx.stream_readers import AnalogMultiChannelReader
from nidaqmx.stream_writers import AnalogSingleChannelWriter

from drivers.interfaces import RealClock
from sim_hardware.ni import LoopbackWires, NiDeviceServer

CALLS = 300
FAST_HZ = 100_000
WAITING_S = 1.0
BLOCK = 10_000


@dataclass(frozen=True)
class Wire:
    """Median times of one way to the boards, s."""

    write_s: float  # one round trip
    read_s: float  # one sample by Task.read
    task_s: float  # make and clear a task
    most_hz: float  # samples per second of each of two channels that can be fetched


def median_s(call: Callable[[], Any], times: int = CALLS) -> float:
    """Median duration of a call."""
    taken = []
    for _ in range(times):
        before = time.perf_counter()
        call()
        taken.append(time.perf_counter() - before)
    return float(np.median(taken))


def measure(channel: Any) -> Wire:
    """All figures of one channel."""
    with ExitStack() as stack:

        def task() -> nidaqmx.Task:
            options = nidaqmx.GrpcSessionOptions(channel, "")
            return stack.enter_context(nidaqmx.Task(grpc_options=options))

        output, signal = task(), task()
        output.ao_channels.add_ao_voltage_chan("PCI6703/ao0")
        output.start()
        writer = AnalogSingleChannelWriter(output.out_stream, auto_start=False)
        signal.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
        write_s = median_s(lambda: writer.write_one_sample(0.1))
        read_s = median_s(signal.read)

        def make_and_clear() -> None:
            nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(channel, "")).close()

        task_s = median_s(make_and_clear, 50)
        return Wire(write_s, read_s, task_s, fetch_hz(task()))


def fetch_hz(task: nidaqmx.Task) -> float:
    """How fast samples that wait in the buffer come: more than FAST_HZ keeps up with FAST_HZ."""
    task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0:1")
    task.timing.cfg_samp_clk_timing(
        FAST_HZ, sample_mode=AcquisitionType.CONTINUOUS, samps_per_chan=10**6
    )
    reader = AnalogMultiChannelReader(task.in_stream)
    values = np.empty((2, BLOCK))
    task.start()
    blocks = int(WAITING_S * FAST_HZ / BLOCK)
    RealClock().sleep_until(time.perf_counter() + WAITING_S)
    before = time.perf_counter()
    for _ in range(blocks):
        reader.read_many_sample(values, BLOCK)
    return blocks * BLOCK / (time.perf_counter() - before)


def wire_latency() -> dict[str, Wire]:
    """Both ways to the same kind of server."""
    bench = LoopbackWires({"ao0": "ai0"})
    server = NiDeviceServer(bench, RealClock())
    inside = measure(server.in_process_channel())
    port = server.listen()
    try:
        with grpc.insecure_channel(
            f"127.0.0.1:{port}", [("grpc.max_receive_message_length", -1)]
        ) as channel:
            return {"in process": inside, "tcp": measure(channel)}
    finally:
        server.stop()


def main() -> None:
    wires = wire_latency()
    inside, tcp = wires["in process"], wires["tcp"]
    print(f"{'':24}{'in process':>12}{'tcp':>12}{'ratio':>8}")
    for name in ("write_s", "read_s", "task_s"):
        fast, slow = getattr(inside, name), getattr(tcp, name)
        print(f"{name[:-2]:24}{fast * 1e6:9.1f} us{slow * 1e6:9.1f} us{slow / fast:8.1f}")
    print(f"{'2 channels fetched':24}{inside.most_hz / 1e3:7.0f} kS/s{tcp.most_hz / 1e3:7.0f} kS/s")


if __name__ == "__main__":
    main()
