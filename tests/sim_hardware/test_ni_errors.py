"""Every status code that the boards refuse with, provoked through nidaqmx."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from nidaqmx.constants import AcquisitionType, LineGrouping, TaskMode, TerminalConfiguration
from nidaqmx.errors import DaqError, DaqReadError, DaqWriteError, RpcError
from nidaqmx.stream_readers import AnalogSingleChannelReader
from nidaqmx.stream_writers import AnalogSingleChannelWriter

CONTINUOUS = AcquisitionType.CONTINUOUS


def write_too_much(ni: Any) -> None:
    ni.output(limit=0.25).write(0.26)


def write_nan(ni: Any) -> None:
    ni.output().write(float("nan"))


def output_limits_beyond_the_board(ni: Any) -> None:
    ni.output(limit=10.5).start()


def input_limits_beyond_the_board(ni: Any) -> None:
    ni.input(limit=11).control(TaskMode.TASK_VERIFY)


def input_limits_upside_down(ni: Any) -> None:
    task = ni.task()
    task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0", min_val=1.0, max_val=-1.0)
    task.control(TaskMode.TASK_VERIFY)


def clock_on_a_static_board(ni: Any) -> None:
    task = ni.output()
    task.timing.cfg_samp_clk_timing(1000)
    task.control(TaskMode.TASK_VERIFY)


def differential_on_a_negative_input(ni: Any) -> None:
    ni.input("PCI6034E/ai8", terminal_config=TerminalConfiguration.DIFF).start()


def terminals_the_board_has_not(ni: Any) -> None:
    ni.input(terminal_config=TerminalConfiguration.PSEUDO_DIFF).start()


def rate_above_the_board(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(250e3)
    task.start()


def rate_above_the_board_for_two_channels(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai1")
    task.timing.cfg_samp_clk_timing(150e3)
    print(task.timing.samp_clk_rate)


def rate_of_zero(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(0.0)
    task.start()


def a_clock_from_elsewhere(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(1000, source="/PCI6034E/nowhere")
    task.start()


def a_finite_acquisition_of_one_sample(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(1000, samps_per_chan=1)
    print(task.timing.samp_quant_samp_per_chan)


def conversions_too_slow_for_the_rate(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai1")
    task.timing.cfg_samp_clk_timing(10e3)
    task.timing.ai_conv_rate = 15e3
    task.start()


def no_such_device(ni: Any) -> None:
    ni.input("Dev9/ai0")


def reset_of_no_such_device(ni: Any) -> None:
    ni.system.devices["Dev9"].reset_device()


def no_channel_at_all(ni: Any) -> None:
    ni.task().ao_channels.add_ao_voltage_chan("")


def no_such_channel(ni: Any) -> None:
    ni.input("PCI6034E/ai16")


def output_of_a_board_without(ni: Any) -> None:
    ni.output("PCI6034E/ao0")


def an_input_as_output(ni: Any) -> None:
    ni.output("PCI6034E/ai0")


def a_bad_range_of_channels(ni: Any) -> None:
    ni.input("PCI6034E/ai0:b")


def a_channel_twice(ni: Any) -> None:
    ni.input("PCI6034E/ai0", "PCI6034E/ai0")


def inputs_and_outputs_in_one_task(ni: Any) -> None:
    ni.input("M/ai0").ao_channels.add_ao_voltage_chan("M/ao0")


def a_task_without_channels(ni: Any) -> None:
    ni.task().start()


def a_task_that_was_cleared(ni: Any) -> None:
    task = ni.input()
    other = ni.task(task.name)
    task.close()
    other.start()


def a_write_that_may_not_start(ni: Any) -> None:
    ni.output().write(1.0, auto_start=False)


def a_read_that_may_not_start(ni: Any) -> None:
    task = ni.input()
    task.in_stream.auto_start = False
    task.read()


def a_clocked_read_that_may_not_start(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(1000, sample_mode=CONTINUOUS)
    task.in_stream.auto_start = False
    task.read(10)


def a_negative_count(ni: Any) -> None:
    task = ni.input()
    task._interpreter.read_analog_f64(task._handle, -5, 1.0, 0, np.zeros(10))


def an_array_that_is_too_small(ni: Any) -> None:
    task = ni.input()
    task._interpreter.read_analog_f64(task._handle, 10, 1.0, 0, np.zeros(4))


def a_read_of_an_output(ni: Any) -> None:
    reader = AnalogSingleChannelReader(ni.output().in_stream)
    reader.read_one_sample()


def one_value_of_two_channels(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai1")
    AnalogSingleChannelReader(task.in_stream).read_one_sample()


def a_write_to_an_input(ni: Any) -> None:
    AnalogSingleChannelWriter(ni.input().out_stream, auto_start=True).write_one_sample(1.0)


def too_many_values(ni: Any) -> None:
    task = ni.output()
    task._interpreter.write_analog_f64(task._handle, 1, True, 1.0, 0, np.zeros(3))


def an_unread_buffer(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(100e3, sample_mode=CONTINUOUS)
    task.in_stream.input_buf_size = 1000
    task.start()
    ni.pass_time(0.05)
    task.read(10)


def a_time_out(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(100, sample_mode=CONTINUOUS)
    task.read(10, timeout=0.01)


def a_property_of_another_board(ni: Any) -> None:
    print(ni.system.devices["PCI6703"].ai_max_single_chan_rate)


def a_read_only_line(ni: Any) -> None:
    task = ni.task()
    task.do_channels.add_do_chan("M/port0/line0", line_grouping=LineGrouping.CHAN_PER_LINE)


def lines_that_are_taken(ni: Any) -> None:
    for _ in range(2):
        task = ni.task()
        task.do_channels.add_do_chan("PCI6703/port0/line0")
        task.start()


CASES: list[tuple[Callable[[Any], None], int]] = [
    (write_too_much, -200561),
    (write_nan, -200561),
    (output_limits_beyond_the_board, -200077),
    (input_limits_beyond_the_board, -200077),
    (input_limits_upside_down, -200077),
    (clock_on_a_static_board, -200077),
    (differential_on_a_negative_input, -200077),
    (terminals_the_board_has_not, -200077),
    (rate_above_the_board, -200077),
    (rate_above_the_board_for_two_channels, -200077),
    (rate_of_zero, -200077),
    (a_clock_from_elsewhere, -200254),
    (a_finite_acquisition_of_one_sample, -200077),
    (conversions_too_slow_for_the_rate, -200081),
    (no_such_device, -200220),
    (reset_of_no_such_device, -200220),
    (no_such_channel, -200170),
    (no_channel_at_all, -200170),
    (output_of_a_board_without, -200170),
    (an_input_as_output, -200430),
    (a_read_only_line, -200430),
    (a_bad_range_of_channels, -200498),
    (a_channel_twice, -200489),
    (inputs_and_outputs_in_one_task, -200559),
    (a_task_without_channels, -200478),
    (a_task_that_was_cleared, -200088),
    (a_write_that_may_not_start, -200846),
    (a_read_that_may_not_start, -200846),
    (a_clocked_read_that_may_not_start, -200846),
    (a_negative_count, -200096),
    (an_array_that_is_too_small, -200229),
    (a_read_of_an_output, -200460),
    (one_value_of_two_channels, -200523),
    (a_write_to_an_input, -200459),
    (too_many_values, -200524),
    (an_unread_buffer, -200279),
    (a_time_out, -200284),
    (a_property_of_another_board, -200197),
    (lines_that_are_taken, -50103),
]


@pytest.mark.parametrize(("provoke", "code"), CASES, ids=lambda case: getattr(case, "__name__", ""))
def test_the_driver_refuses(ni: Any, provoke: Callable[[Any], None], code: int) -> None:
    with pytest.raises(DaqError) as fault:
        provoke(ni)
    assert fault.value.error_code == code
    assert len(str(fault.value)) > 20


@pytest.mark.parametrize("value", [0.26, -0.26, 1e9, float("inf")])
def test_nothing_is_written_when_a_value_is_refused(ni: Any, value: float) -> None:
    task = ni.output(limit=0.25)
    task.write(0.1)
    with pytest.raises(DaqWriteError) as fault:
        task.write([0.2, value], auto_start=True)
    assert fault.value.samps_per_chan_written == 0
    assert ni.input(limit=0.5).read() == pytest.approx(0.1, abs=1e-3)


def test_settings_are_checked_late(ni: Any) -> None:
    task = ni.input(limit=99)  # no complaint yet
    task.timing.cfg_samp_clk_timing(1e9)
    with pytest.raises(DaqError, match="AI_Max"):
        print(task.ai_channels[0].ai_max)
    task.ai_channels[0].ai_max, task.ai_channels[0].ai_min = 5, -5
    with pytest.raises(DaqError, match="SampClk_Rate"):
        print(task.timing.samp_clk_rate)
    task.timing.samp_clk_rate = 1000
    assert task.timing.samp_clk_rate == 1000


def test_a_failed_read_tells_how_many_samples_it_got(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(1000, sample_mode=CONTINUOUS)
    task.in_stream.input_buf_size = 50
    task.start()
    ni.pass_time(0.1)
    with pytest.raises(DaqReadError) as fault:
        task.read(10)
    assert fault.value.samps_per_chan_read == 0


@pytest.mark.parametrize(
    "ask",
    [
        lambda ni: ni.input().triggers.reference_trigger.cfg_anlg_edge_ref_trig("APFI0", 9),
        lambda ni: ni.task().ai_channels.add_ai_thrmcpl_chan("PCI6034E/ai0"),
        lambda ni: ni.task().ci_channels.add_ci_count_edges_chan("PCI6034E/ctr0"),
        lambda ni: ni.system.devices["PCI6034E"].ai_current_rngs,
        lambda ni: ni.input().ai_channels[0].ai_lowpass_enable,
        lambda ni: ni.input().timing.samp_clk_timebase_src,
        lambda ni: ni.input("PCI6034E/ai0", "M/ai0").start(),
        lambda ni: ni.task().do_channels.add_do_chan("PCI6703/port0/line0, X/port0/line0"),
    ],
)
def test_what_is_not_simulated_is_not_made_up(ni: Any, ask: Callable[[Any], Any]) -> None:
    with pytest.raises(RpcError) as fault:
        ask(ni)
    assert fault.value.rpc_code.name == "UNIMPLEMENTED"


def test_lines_that_a_clock_writes_are_not_made_up(ni: Any) -> None:
    task = ni.task()
    task.do_channels.add_do_chan("X/port0/line0")
    task.timing.cfg_samp_clk_timing(1000)
    with pytest.raises(RpcError) as fault:
        task.start()
    assert fault.value.rpc_code.name == "UNIMPLEMENTED"


@pytest.mark.parametrize("code", [-200561, -200077, -50103, -200284])
def test_codes_have_texts(ni: Any, code: int) -> None:
    text = ni.task()._interpreter.get_error_string(code)
    assert len(text) > 20
    assert ni.task()._interpreter.get_error_string(-12345).startswith("Error code could not")
