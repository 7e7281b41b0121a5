"""Faults that a test switches on, and how they look from the client's side."""

from __future__ import annotations

import time
from typing import Any

import grpc
import numpy as np
import pytest
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx._stubs import nidaqmx_pb2_grpc as stubs
from nidaqmx.constants import AcquisitionType
from nidaqmx.errors import DaqError, RpcError


def status_of(ni: Any, timeout: float) -> grpc.StatusCode | None:
    """The status of a call with a time-out of its own; None when it was answered."""
    channel = ni.new_channel()
    stub = stubs.NiDAQmxStub(getattr(channel, "_channel", channel))
    try:
        stub.GetErrorString(pb.GetErrorStringRequest(error_code=-200077), timeout=timeout)
    except grpc.RpcError as fault:
        return fault.code()
    return None


@pytest.mark.slow
def test_a_call_that_hangs_ends_with_its_deadline(ni: Any) -> None:
    ni.server.faults.hang.add("GetErrorString")
    before_s = ni.clock.now()
    assert status_of(ni, 0.2) is grpc.StatusCode.DEADLINE_EXCEEDED
    assert 0.19 < ni.clock.now() - before_s < 1.0
    ni.output().write(1.0)  # others are answered
    ni.server.faults.hang.add("*")
    with pytest.raises(AssertionError):
        assert status_of(ni, 0.05) is None
    ni.server.faults.hang.clear()
    assert status_of(ni, 0.2) is None


@pytest.mark.slow
def test_a_hung_write_is_not_made_up_for_later(make_ni: Any) -> None:
    ni = make_ni(tcp=True)
    task = ni.output()
    task.start()
    ni.server.faults.hang.add("WriteAnalogF64")
    stub = stubs.NiDAQmxStub(ni.new_channel()._channel)
    request = pb.WriteAnalogF64Request(
        task=task._handle, num_samps_per_chan=1, write_array=[3.0], data_layout_raw=0
    )
    with pytest.raises(grpc.RpcError):
        stub.WriteAnalogF64(request, timeout=0.1)
    ni.pass_time(0.3)  # on a busy computer the server hears later that the call is given up
    ni.server.faults.hang.clear()
    ni.pass_time(0.1)
    assert abs(ni.input().read()) < 2e-3


@pytest.mark.slow
def test_a_read_that_outlives_its_deadline_ends_with_it(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(10, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()
    channel = ni.new_channel()
    stub = stubs.NiDAQmxStub(getattr(channel, "_channel", channel))
    request = pb.ReadAnalogF64Request(
        task=task._handle, num_samps_per_chan=50, timeout=9, array_size_in_samps=50
    )
    before_s = ni.clock.now()
    with pytest.raises(grpc.RpcError) as fault:
        stub.ReadAnalogF64(request, timeout=0.3)
    assert fault.value.code() is grpc.StatusCode.DEADLINE_EXCEEDED
    assert 0.29 < ni.clock.now() - before_s < 1.0


@pytest.mark.alone
def test_slow_answers(ni: Any) -> None:
    task = ni.output()
    ni.server.faults.delay_s = 0.05
    before_s = ni.clock.now()
    task.start()
    assert 0.05 <= ni.clock.now() - before_s < 0.2
    ni.server.faults.delay_s = 0.0


def test_a_server_that_is_switched_off(ni: Any) -> None:
    task = ni.output()
    ni.server.faults.unavailable = True
    with pytest.raises(RpcError) as fault:
        task.start()
    assert fault.value.rpc_code is grpc.StatusCode.UNAVAILABLE
    ni.server.faults.unavailable = False
    task.start()


def test_a_call_that_is_refused(ni: Any) -> None:
    task = ni.output()
    ni.server.faults.refuse["StartTask"] = -50103
    with pytest.raises(DaqError) as fault:
        task.start()
    assert fault.value.error_code == -50103
    ni.server.faults.refuse["StartTask"] = -201003  # a code this server knows no text for
    with pytest.raises(DaqError, match="-201003"):
        task.start()


def test_samples_are_lost_after_some_reads(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(10_000, sample_mode=AcquisitionType.CONTINUOUS)
    ni.server.faults.lose_after_reads = 2
    task.read(10)
    task.read(10)
    with pytest.raises(DaqError) as fault:
        task.read(10)
    assert fault.value.error_code == -200279


def test_an_input_that_reads_nan(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai1")
    task.timing.cfg_samp_clk_timing(10_000, samps_per_chan=10)
    ni.server.faults.nan.add("PCI6034E/ai1")
    good, bad = np.array(task.read(10))
    assert np.all(np.isfinite(good))
    assert np.all(np.isnan(bad))


def test_an_output_that_is_stuck(ni: Any) -> None:
    task = ni.output()
    task.write(1.0)
    ni.server.faults.stuck_outputs.add("PCI6703/ao0")
    task.write(0.0)  # confirmed, and not done
    assert ni.input().read() == pytest.approx(1.0, abs=2e-3)


def test_a_server_that_stops_ends_waiting_calls(make_ni: Any) -> None:
    ni = make_ni(tcp=True)
    task = ni.input()
    task.timing.cfg_samp_clk_timing(10, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()

    def stop() -> None:
        ni.pass_time(0.1)
        ni.server.stop()

    thread = ni.clock.start_thread(stop, "stop")
    before = time.perf_counter()
    with pytest.raises(RpcError):
        task.read(100, timeout=10)
    assert time.perf_counter() - before < 3
    assert thread.join(5)
