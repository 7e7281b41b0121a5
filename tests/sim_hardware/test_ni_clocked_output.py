"""Sample-clocked output, start triggers and shared clocks of the simulated boards."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import nidaqmx
import numpy as np
import pytest
from nidaqmx.constants import AcquisitionType, OverwriteMode, ReadRelativeTo, RegenerationMode
from nitypes.waveform import AnalogWaveform

RATE_HZ = 1000.0
RAMP_V = np.arange(50) / 10  # 0 to 4.9 V, a step each sample


@pytest.fixture
def board(make_ni: Callable[..., Any]) -> Any:
    """A USB-6211 whose output is wired to its input, in process."""
    return make_ni(tcp=False)


def generation(ni: Any, samples: int, mode: AcquisitionType = AcquisitionType.FINITE) -> Any:
    task = ni.output("M/ao0")
    task.timing.cfg_samp_clk_timing(RATE_HZ, sample_mode=mode, samps_per_chan=samples)
    return task


def acquisition(ni: Any, samples: int, channel: str = "M/ai0") -> Any:
    task = ni.input(channel)
    task.timing.cfg_samp_clk_timing(RATE_HZ, samps_per_chan=samples)
    return task


@pytest.mark.parametrize("ppm", [0.0, 100.0, -500.0])
def test_an_output_that_the_inputs_start_is_seen_sample_by_sample(
    make_ni: Callable[..., Any], ppm: float
) -> None:
    ni = make_ni(tcp=False, clock_error_ppm=ppm)
    output, inputs = generation(ni, 50), acquisition(ni, 60)
    output.triggers.start_trigger.cfg_dig_edge_start_trig("/M/ai/StartTrigger")
    output.write(RAMP_V)
    output.start()
    ni.pass_time(1.0)
    assert not output.is_task_done()
    inputs.start()
    seen = inputs.read(60)
    np.testing.assert_allclose(seen[:50], RAMP_V, atol=5e-3)
    np.testing.assert_allclose(seen[50:], RAMP_V[-1], atol=5e-3)  # it keeps its last sample
    assert output.is_task_done()


def test_an_output_can_share_the_sample_clock_of_the_inputs(board: Any) -> None:
    output, inputs = board.output("M/ao0"), acquisition(board, 30)
    output.timing.cfg_samp_clk_timing(RATE_HZ, source="/M/ai/SampleClock", samps_per_chan=50)
    output.write(RAMP_V)
    output.start()
    inputs.start()
    np.testing.assert_allclose(inputs.read(30), RAMP_V[:30], atol=5e-3)
    inputs.stop()
    board.pass_time(1.0)
    assert output.out_stream.total_samp_per_chan_generated == 30  # its clock has stopped
    assert not output.is_task_done()


def test_a_task_waits_for_a_signal_that_no_simulated_source_drives(board: Any) -> None:
    inputs = acquisition(board, 10)
    inputs.triggers.start_trigger.cfg_dig_edge_start_trig("/M/PFI0")
    inputs.start()
    with pytest.raises(nidaqmx.DaqReadError, match="-200284"):
        inputs.read(10, timeout=0.5)


def test_a_terminal_that_the_board_lacks_is_refused(board: Any) -> None:
    inputs = acquisition(board, 10)
    inputs.triggers.start_trigger.cfg_dig_edge_start_trig("/M/nowhere")
    with pytest.raises(nidaqmx.DaqError, match="-200254"):
        inputs.start()


def test_regeneration_repeats_the_buffer_until_the_task_is_stopped(board: Any) -> None:
    output = generation(board, 50, AcquisitionType.CONTINUOUS)
    output.write(RAMP_V, auto_start=True)
    board.pass_time(0.1205)  # 120 periods: the samples 0 to 120
    output.stop()
    board.pass_time(1.0)
    assert board.input("M/ai0").read() == pytest.approx(RAMP_V[120 % 50], abs=5e-3)


def test_without_regeneration_an_output_ends_where_its_samples_do_and_keeps_the_last(
    board: Any,
) -> None:
    output = generation(board, 50, AcquisitionType.CONTINUOUS)
    output.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
    output.write(RAMP_V)
    output.start()
    board.pass_time(0.02)
    output.write(RAMP_V[:10])  # there is room where samples have been put out
    board.pass_time(0.5)
    assert board.input("M/ai0").read() == pytest.approx(RAMP_V[9], abs=5e-3)
    with pytest.raises(nidaqmx.DaqError, match="-200290"):
        output.is_task_done()


def test_a_write_waits_for_room_and_says_when_there_is_none_in_time(board: Any) -> None:
    output = generation(board, 50, AcquisitionType.CONTINUOUS)
    output.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
    output.write(RAMP_V)
    output.start()
    with pytest.raises(nidaqmx.DaqWriteError, match="-200292"):
        output.write(np.zeros(40), timeout=0.01)
    output.write(np.zeros(20), timeout=1.0)


def test_an_empty_buffer_is_not_put_out_and_a_value_out_of_limits_not_taken(board: Any) -> None:
    output = generation(board, 50)
    with pytest.raises(nidaqmx.DaqError, match="-200462"):
        output.start()
    with pytest.raises(nidaqmx.DaqError, match="-200561"):
        output.write([0.0, 11.0])


def test_samples_may_be_read_again_and_old_ones_be_passed_over(board: Any) -> None:
    output, inputs = generation(board, 50), board.input("M/ai0")
    inputs.timing.cfg_samp_clk_timing(
        RATE_HZ, sample_mode=AcquisitionType.CONTINUOUS, samps_per_chan=1000
    )
    output.triggers.start_trigger.cfg_dig_edge_start_trig("/M/ai/StartTrigger")
    output.write(RAMP_V)
    output.start()
    inputs.start()
    first = inputs.read(20)
    stream = inputs.in_stream
    stream.relative_to = ReadRelativeTo.FIRST_SAMPLE
    assert inputs.read(20) == first
    stream.relative_to, stream.offset = ReadRelativeTo.MOST_RECENT_SAMPLE, -5
    board.pass_time(0.0205)
    np.testing.assert_allclose(inputs.read(5), RAMP_V[35:40], atol=5e-3)
    stream.offset = -10_000
    with pytest.raises(nidaqmx.DaqError, match="-200277"):
        inputs.read(5)


def test_a_buffer_that_may_be_overwritten_does_not_end_the_acquisition(board: Any) -> None:
    inputs = board.input("M/ai0")
    inputs.timing.cfg_samp_clk_timing(
        RATE_HZ, sample_mode=AcquisitionType.CONTINUOUS, samps_per_chan=1000
    )
    inputs.in_stream.input_buf_size = 1000
    inputs.in_stream.overwrite = OverwriteMode.OVERWRITE_UNREAD_SAMPLES
    inputs.start()
    board.pass_time(5.0)
    with pytest.raises(nidaqmx.DaqError, match="-200279"):
        inputs.read(10)
    inputs.in_stream.relative_to = ReadRelativeTo.MOST_RECENT_SAMPLE
    inputs.in_stream.offset = -10
    assert len(inputs.read(10)) == 10


@pytest.mark.slow
def test_events_of_an_output_come_with_its_samples(make_ni: Callable[..., Any]) -> None:
    ni = make_ni(tcp=True)
    output, counts, ends = generation(ni, 100), [], []

    def transferred(_task: object, _kind: object, samples: int, _data: object) -> int:
        counts.append(samples)
        return 0

    def done(_task: object, status: int, _data: object) -> int:
        ends.append(status)
        return 0

    output.register_every_n_samples_transferred_from_buffer_event(25, transferred)
    output.register_done_event(done)
    output.write(np.zeros(100))
    output.start()
    output.wait_until_done(5.0)
    ni.pass_time(0.3)
    assert counts == [25] * 4
    assert ends == [0]


def test_waveforms_are_written_a_channel_each(board: Any) -> None:
    output = generation(board, 50)
    output.write(AnalogWaveform.from_array_1d(RAMP_V), auto_start=True)
    board.pass_time(0.0305)
    assert board.input("M/ai0").read() == pytest.approx(RAMP_V[30], abs=5e-3)
