"""The kinds of scripts that NI publishes with its package run unchanged but for the address."""

from __future__ import annotations

import itertools
import threading
from typing import Any

import nidaqmx
import numpy as np
import pytest
from nidaqmx.constants import (
    READ_ALL_AVAILABLE,
    AcquisitionType,
    LineGrouping,
    TerminalConfiguration,
)
from nidaqmx.stream_readers import AnalogMultiChannelReader, AnalogUnscaledReader
from nidaqmx.system import System


def test_one_voltage(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0", min_val=-10.0, max_val=10.0)
        assert task.read() == pytest.approx(0.0, abs=2e-3)


def test_on_demand_in_all_forms(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
        assert isinstance(task.read(), float)
        assert len(task.read(number_of_samples_per_channel=8)) == 8
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai1:3")
        assert len(task.read()) == 4
        assert np.shape(task.read(number_of_samples_per_channel=2)) == (4, 2)


def test_a_finite_number_of_voltages(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
        task.timing.cfg_samp_clk_timing(
            1000.0, sample_mode=AcquisitionType.FINITE, samps_per_chan=50
        )
        data = task.read(READ_ALL_AVAILABLE)
        assert len(data) == 50


@pytest.mark.slow
def test_voltages_without_end(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
        task.timing.cfg_samp_clk_timing(10_000.0, sample_mode=AcquisitionType.CONTINUOUS)
        task.start()
        total = sum(len(task.read(number_of_samples_per_channel=1000)) for _ in range(3))
        task.stop()
        assert total == 3000


@pytest.mark.slow
def test_voltages_without_end_that_are_read_in_a_callback(ni: Any) -> None:
    came = threading.Event()
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        total = 0

        def callback(_handle: object, _kind: int, _count: int, _data: object) -> int:
            nonlocal total
            total += len(task.read(number_of_samples_per_channel=1000))
            if total >= 3000:
                came.set()
            return 0

        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
        task.timing.cfg_samp_clk_timing(20_000.0, sample_mode=AcquisitionType.CONTINUOUS)
        task.register_every_n_samples_acquired_into_buffer_event(1000, callback)
        task.start()
        ni.pass_time(0.2)
        assert came.wait(10)
        task.stop()


def test_one_voltage_out(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ao_channels.add_ao_voltage_chan("PCI6703/ao0", "mychannel", -5, 5)
        task.start()
        value = 2
        task.write(value)
        assert ni.input().read() == pytest.approx(value, abs=2e-3)
        task.stop()


def test_voltages_out_of_two_channels(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ao_channels.add_ao_voltage_chan("PCI6703/ao0:1")
        assert task.write([1.1, 2.2], auto_start=True) == 1
        assert task.write([[1.1, 3.3], [2.2, 4.4]], auto_start=True) == 2
    assert ni.input("PCI6034E/ai0:1").read() == pytest.approx([3.3, 4.4], abs=2e-3)


def test_properties_of_channels(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        first = task.ai_channels.add_ai_voltage_chan("X/ai0", max_val=0.1, min_val=-0.1)
        assert (first.ai_max, first.ai_min) == (0.1, -0.1)
        first.ai_max = 5
        assert (first.ai_max, first.ai_min) == (5.0, -5.0)
        others = task.ai_channels.add_ai_voltage_chan("X/ai1:3", max_val=10, min_val=-10)
        assert (others.ai_max, others.ai_min) == (10.0, -10.0)
        assert task.ai_channels["X/ai2"].physical_channel.name == "X/ai2"
        first.description = "the first"
        assert first.description == "the first"


def test_raw_data(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
        assert task.in_stream.read(number_of_samples_per_channel=8).shape == (8,)
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai1:3")
        assert task.in_stream.read(number_of_samples_per_channel=2).shape == (8,)


def test_unscaled_data(ni: Any) -> None:
    ni.output().write(2.0)
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0", min_val=-10, max_val=10)
        task.timing.cfg_samp_clk_timing(10_000, samps_per_chan=20)
        codes = np.zeros((1, 20), np.int16)
        assert AnalogUnscaledReader(task.in_stream).read_int16(codes, 20) == 20
        offset, gain, *_ = task.ai_channels[0].ai_dev_scaling_coeff
        assert offset + gain * codes[0] == pytest.approx(np.full(20, 2.0), abs=2e-3)


@pytest.mark.slow
def test_waveforms(ni: Any) -> None:
    ni.output().write(2.0)
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0", "force", min_val=-10, max_val=10)
        task.timing.cfg_samp_clk_timing(1000, samps_per_chan=50)
        waveform = task.read_waveform()
        assert waveform.scaled_data == pytest.approx(np.full(50, 2.0), abs=2e-3)
        assert (waveform.channel_name, waveform.units) == ("force", "Volts")
        assert waveform.timing.sample_interval.total_seconds() == pytest.approx(1e-3)
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai2")
        assert [len(wave.scaled_data) for wave in task.read_waveform()] == [50, 50]
        task.timing.cfg_samp_clk_timing(100, sample_mode=AcquisitionType.CONTINUOUS)
        with pytest.raises(nidaqmx.DaqError, match="-200284"):
            task.read_waveform(50, timeout=0.05)


def test_lines_out(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.do_channels.add_do_chan(
            "PCI6703/port0/line0:3", line_grouping=LineGrouping.CHAN_FOR_ALL_LINES
        )
        assert task.write(8, auto_start=True) == 1
        assert task.write([1, 2, 4, 8], auto_start=True) == 4


def test_a_running_light(ni: Any) -> None:
    with nidaqmx.Task(grpc_options=ni.options()) as task:
        task.do_channels.add_do_chan(
            "PCI6703/port0/line0:7", line_grouping=LineGrouping.CHAN_PER_LINE
        )
        task.start()
        for on in range(8):
            task.write([line == on for line in range(8)])
    assert ni.server.lines.level("PCI6703/port0/line7")


def test_the_system_and_its_devices(ni: Any) -> None:
    system = System.remote(grpc_options=ni.options())
    assert system.driver_version.major_version == 26
    assert "PCI6034E" in system.devices
    assert len(system.tasks) == 0
    assert len(system.global_channels) == 0
    for device in system.devices:
        text = f"{device} {device.product_category} {device.product_type}"
        assert device.name in text


@pytest.mark.slow
def test_a_reader_with_a_preallocated_array(ni: Any) -> None:
    with nidaqmx.Task("acquire", grpc_options=ni.options("acquire")) as task:
        for channel, terminals in itertools.product(
            ("PCI6034E/ai1",), (TerminalConfiguration.RSE,)
        ):
            task.ai_channels.add_ai_voltage_chan(channel, terminal_config=terminals)
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai2")
        task.timing.cfg_samp_clk_timing(5000, sample_mode=AcquisitionType.CONTINUOUS)
        reader = AnalogMultiChannelReader(task.in_stream)
        data = np.zeros((2, 500))
        task.start()
        for _ in range(2):
            assert reader.read_many_sample(data, 500, timeout=5) == 500


def test_only_nidaqmx_with_a_name_shares_a_task(ni: Any) -> None:
    with nidaqmx.Task("shared", grpc_options=ni.options("shared")) as first:
        first.ao_channels.add_ao_voltage_chan("PCI6703/ao0")
        with nidaqmx.Task("shared", grpc_options=ni.options("shared")) as second:
            assert second.channel_names == ["PCI6703/ao0"]
        assert first.channel_names == ["PCI6703/ao0"]
