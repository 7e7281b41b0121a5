"""What the simulated boards put out and read, seen through nidaqmx's public face."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from nidaqmx.constants import AcquisitionType, TerminalConfiguration
from nidaqmx.errors import DaqError, DaqReadError
from nidaqmx.stream_readers import AnalogMultiChannelReader, AnalogSingleChannelReader
from nidaqmx.stream_writers import AnalogMultiChannelWriter, AnalogSingleChannelWriter

CONTINUOUS = AcquisitionType.CONTINUOUS


class Ramp:
    """A bench whose inputs read the time: ai0 in V per s, ai1 too."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, np.ndarray]] = []

    def write(self, device: str, channel: str, volts: float, when: float) -> None:
        pass

    def read(self, device: str, channel: str, times: np.ndarray) -> np.ndarray:
        self.asked.append((channel, times))
        return times


def test_a_written_voltage_is_read_back_through_the_wire(ni: Any) -> None:
    output, signal = ni.output(), ni.input()
    output.write(1.234)
    assert signal.read() == pytest.approx(1.234, abs=2e-3)
    output.write(-5.0)
    assert signal.read() == pytest.approx(-5.0, abs=2e-3)


def test_inputs_that_nothing_is_wired_to_read_zero_volts(ni: Any) -> None:
    assert abs(ni.input("PCI6034E/ai5").read()) < 2e-3


def test_the_output_has_steps_of_16_bits(make_ni: Any) -> None:
    written: list[float] = []

    class Listener(Ramp):
        def write(self, device: str, channel: str, volts: float, when: float) -> None:
            written.append(volts)

    output = make_ni(tcp=False, bench=Listener()).output()
    for volts in (0.0, 1e-4, 2e-4, 10.0, -10.0):
        output.write(volts)
    step = 20 / 2**16
    assert written == [0.0, 0.0, step, 10.0 - step, -10.0]


@pytest.mark.parametrize(
    ("asked", "given"), [(0.03, 0.05), (0.05, 0.05), (0.06, 0.5), (1.0, 5.0), (5.0, 5.0), (7.0, 10)]
)
def test_a_range_is_rounded_up_to_one_that_the_board_has(
    ni: Any, asked: float, given: float
) -> None:
    channel = ni.input(limit=asked).ai_channels[0]
    assert channel.ai_max == given
    assert channel.ai_min == -given
    assert channel.ai_rng_high == given


def test_a_range_that_is_not_symmetric_is_rounded_up_too(ni: Any) -> None:
    task = ni.task()
    channel = task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0", min_val=0.0, max_val=2.0)
    assert (channel.ai_min, channel.ai_max) == (-5.0, 5.0)


def test_an_input_saturates_at_its_range(ni: Any) -> None:
    ni.output().write(3.0)
    samples = np.array(ni.input(limit=0.5).read(50))
    assert np.all(samples == 0.5 - 1.0 / 2**16)  # the highest code
    ni.output().write(-3.0)
    assert ni.input(limit=0.5).read() == -0.5


@pytest.mark.parametrize("range_V", [0.05, 0.5, 5.0, 10.0])
def test_samples_have_16_bits_of_the_range_and_the_boards_noise(ni: Any, range_V: float) -> None:
    task = ni.input(limit=range_V)
    task.timing.cfg_samp_clk_timing(50_000, samps_per_chan=4000)
    codes = np.array(task.read(4000)) / (2 * range_V / 2**16)
    assert np.allclose(codes, np.rint(codes), atol=1e-9)
    noise_V = {0.05: 9.6e-6, 0.5: 19e-6, 5.0: 156e-6, 10.0: 311e-6}[range_V]
    step_V = 2 * range_V / 2**16
    expected = np.hypot(noise_V, step_V / np.sqrt(12))  # noise and quantisation
    assert codes.std() * step_V == pytest.approx(expected, rel=0.06)


def test_noise_is_the_same_every_time_and_does_not_depend_on_the_blocks(make_ni: Any) -> None:
    def samples(blocks: list[int], seed: int = 3) -> np.ndarray:
        task = make_ni(tcp=False, seed=seed).input("PCI6034E/ai0", "PCI6034E/ai3")
        task.timing.cfg_samp_clk_timing(1000, sample_mode=CONTINUOUS)
        task.start()
        return np.hstack([task.read(count) for count in blocks])

    whole = samples([60])
    assert np.array_equal(whole, samples([1, 29, 30]))
    assert not np.array_equal(whole, samples([60], seed=4))
    assert not np.array_equal(whole[0], whole[1])


def test_without_a_seed_there_is_no_noise(make_ni: Any) -> None:
    task = make_ni(tcp=False, seed=None).input()
    task.timing.cfg_samp_clk_timing(1000, samps_per_chan=100)
    assert set(task.read(100)) == {0.0}


def test_a_second_acquisition_has_other_noise(make_ni: Any) -> None:
    task = make_ni(tcp=False).input()
    task.timing.cfg_samp_clk_timing(1000, samps_per_chan=100)
    assert task.read(100) != task.read(100)


def test_channels_are_sampled_one_after_another(make_ni: Any) -> None:
    bench = Ramp()
    task = make_ni(tcp=False, bench=bench).input("PCI6034E/ai0", "PCI6034E/ai1", "PCI6034E/ai2")
    task.timing.cfg_samp_clk_timing(1000, samps_per_chan=3)
    assert task.timing.ai_conv_rate == pytest.approx(1 / 15e-6)
    task.read(3)
    times = [times for _, times in bench.asked]
    assert np.allclose(times[0], [0.0, 1e-3, 2e-3])
    assert np.allclose(times[1] - times[0], 15e-6)
    assert np.allclose(times[2] - times[0], 30e-6)


def test_channels_share_the_sample_period_when_there_is_no_time_to_settle(make_ni: Any) -> None:
    task = make_ni(tcp=False).input("PCI6034E/ai0", "PCI6034E/ai1")
    task.timing.cfg_samp_clk_timing(100_000, samps_per_chan=3)
    assert task.timing.ai_conv_rate == pytest.approx(200_000)
    task.timing.cfg_samp_clk_timing(10_000, samps_per_chan=3)
    task.timing.ai_conv_rate = 100_000
    assert task.timing.ai_conv_rate == pytest.approx(100_000)


def test_the_bench_is_never_asked_for_the_future(make_ni: Any) -> None:
    bench = Ramp()
    rig = make_ni(tcp=False, bench=bench)
    task = rig.input("PCI6034E/ai0", "PCI6034E/ai1")
    task.timing.cfg_samp_clk_timing(3333.3, sample_mode=CONTINUOUS)
    task.start()
    for count in (1, 7, 100, 333):
        task.read(count)
        assert max(times[-1] for _, times in bench.asked) <= rig.clock.now()


def test_a_terminal_that_is_in_the_task_twice_is_asked_in_the_order_of_time(make_ni: Any) -> None:
    bench = Ramp()
    task = make_ni(tcp=False, bench=bench).task()
    for name in ("a", "b"):
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0", name)
    task.timing.cfg_samp_clk_timing(1000, samps_per_chan=5)
    first, second = task.read(5)
    assert all(np.all(np.diff(times) >= 0) for _, times in bench.asked)
    assert np.allclose(first, np.arange(5) * 1e-3, atol=2e-3)
    assert np.allclose(second, first, atol=2e-3)


def test_a_blocking_read_lets_virtual_time_pass(make_ni: Any) -> None:
    rig = make_ni(tcp=False)
    task = rig.input()
    task.timing.cfg_samp_clk_timing(1000, sample_mode=CONTINUOUS)
    start_s = rig.clock.now()
    task.start()
    task.read(501)
    assert rig.clock.now() - start_s == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("board", "asked", "achieved"),
    [
        ("PCI6034E", 1000.0, 1000.0),
        ("PCI6034E", 3000.0, 20e6 / 6666),
        ("X", 3000.0, 100e6 / 33333),
        ("M", 70_000.0, 20e6 / 285),
    ],
)
def test_the_rate_is_what_divides_the_timebase(
    ni: Any, board: str, asked: float, achieved: float
) -> None:
    task = ni.input(f"{board}/ai0")
    task.timing.cfg_samp_clk_timing(asked)
    assert task.timing.samp_clk_rate == pytest.approx(achieved, rel=1e-12)


def test_a_step_arrives_at_the_sample_of_its_time(make_ni: Any) -> None:
    rig = make_ni(tcp=False)
    output, signal = rig.output(), rig.input()
    signal.timing.cfg_samp_clk_timing(1000, sample_mode=CONTINUOUS)
    signal.start()
    rig.pass_time(0.2505)
    output.write(1.0)
    samples = np.array(signal.read(400))
    assert np.all(np.abs(samples[:251]) < 5e-3)
    assert np.all(np.abs(samples[251:] - 1.0) < 5e-3)


def test_several_channels_are_written_and_read_together(ni: Any) -> None:
    output = ni.task()
    output.ao_channels.add_ao_voltage_chan("PCI6703/ao0:1")
    writer = AnalogMultiChannelWriter(output.out_stream, auto_start=True)
    writer.write_one_sample(np.array([1.0, -2.0]))
    signal = ni.input("PCI6034E/ai0:1")
    values = np.empty(2)
    AnalogMultiChannelReader(signal.in_stream).read_one_sample(values)
    assert values == pytest.approx([1.0, -2.0], abs=2e-3)
    assert np.array(signal.read(3)).shape == (2, 3)


def test_single_channel_streams(ni: Any) -> None:
    AnalogSingleChannelWriter(ni.output().out_stream, auto_start=True).write_one_sample(2.5)
    reader = AnalogSingleChannelReader(ni.input().in_stream)
    assert reader.read_one_sample() == pytest.approx(2.5, abs=2e-3)
    values = np.empty(10)
    assert reader.read_many_sample(values, 10) == 10
    assert values == pytest.approx(np.full(10, 2.5), abs=2e-3)


def test_samples_written_on_demand_follow_each_other(ni: Any) -> None:
    output = ni.output()
    assert output.write([1.0, 2.0, 3.0], auto_start=True) == 3
    assert ni.input().read() == pytest.approx(3.0, abs=2e-3)


def test_only_chosen_channels_are_read(ni: Any) -> None:
    ni.output("PCI6703/ao1").write(4.0)
    signal = ni.input("PCI6034E/ai0", "PCI6034E/ai1", "PCI6034E/ai2")
    signal.in_stream.channels_to_read = signal.ai_channels["PCI6034E/ai1"]
    assert signal.read() == pytest.approx(4.0, abs=2e-3)
    signal.in_stream.channels_to_read = signal.ai_channels.all
    assert len(signal.read()) == 3


def test_a_time_out_hands_over_what_has_come(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai1")
    task.timing.cfg_samp_clk_timing(1000, sample_mode=CONTINUOUS)
    task.start()
    values = np.full((2, 400), 7.0)
    with pytest.raises(DaqReadError) as fault:
        AnalogMultiChannelReader(task.in_stream).read_many_sample(values, 400, timeout=0.1)
    assert fault.value.error_code == -200284
    count = fault.value.samps_per_chan_read
    assert 80 <= count <= 250
    assert np.all(np.abs(values[:, :count]) < 2e-3)
    assert np.all(values[:, count:] == 0.0)  # padded


def test_a_read_that_may_not_wait_returns_at_once(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(10, sample_mode=CONTINUOUS)
    task.start()
    with pytest.raises(DaqError) as fault:
        task.read(5, timeout=0)
    assert fault.value.error_code == -200284


def test_a_finite_read_of_more_than_was_acquired_returns_fewer(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(10_000, samps_per_chan=50)
    assert len(task.read(80)) == 50


def test_all_available_of_a_finite_acquisition_is_all_of_it(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai1")
    task.timing.cfg_samp_clk_timing(1000, samps_per_chan=50)
    task.start()
    assert np.array(task.read(-1)).shape == (2, 50)


def test_all_available_of_a_continuous_acquisition_does_not_wait(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(1000, sample_mode=CONTINUOUS)
    task.start()
    ni.pass_time(0.1)
    count = len(task.read(-1))
    assert 100 <= count <= 200
    assert task.in_stream.curr_read_pos == count


@pytest.mark.slow
def test_unread_samples_are_counted_and_then_overwritten(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(10_000, sample_mode=CONTINUOUS)
    task.in_stream.input_buf_size = 1000
    task.start()
    ni.pass_time(0.02)
    assert 200 <= task.in_stream.avail_samp_per_chan <= 1000
    ni.pass_time(0.15)
    for _ in range(2):  # and it stays so
        with pytest.raises(DaqError) as fault:
            task.read(1)
        assert fault.value.error_code == -200279
    assert task.in_stream.total_samp_per_chan_acquired >= 1700
    task.stop()
    task.start()
    assert len(task.read(10)) == 10


def test_a_reader_that_keeps_up_loses_nothing(make_ni: Any) -> None:
    rig = make_ni(tcp=False, bench=Ramp())
    task = rig.input(limit=10)
    task.timing.cfg_samp_clk_timing(10_000, sample_mode=CONTINUOUS)
    task.start()
    blocks = [task.read(999) for _ in range(60)]
    assert np.allclose(np.hstack(blocks), np.arange(999 * 60) / 10_000, atol=2e-3)


def test_raw_samples_are_the_codes(ni: Any) -> None:
    ni.output().write(2.0)
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai2", limit=10)
    assert task.in_stream.raw_data_width == 4
    raw = task.in_stream.read(5).reshape(5, 2)
    assert raw.dtype == np.int16
    assert np.allclose(raw[:, 0] * (20 / 2**16), 2.0, atol=3e-3)
    assert np.all(np.abs(raw[:, 1]) < 10)


def test_terminals_are_differential_where_they_can_be(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai9")
    assert task.ai_channels["PCI6034E/ai0"].ai_term_cfg is TerminalConfiguration.DIFF
    assert task.ai_channels["PCI6034E/ai9"].ai_term_cfg is TerminalConfiguration.RSE
    chosen = ni.input("PCI6034E/ai0", terminal_config=TerminalConfiguration.NRSE)
    assert chosen.ai_channels[0].ai_term_cfg is TerminalConfiguration.NRSE


@pytest.mark.slow
def test_a_large_block_comes_in_one_piece(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0", "PCI6034E/ai1")
    task.timing.cfg_samp_clk_timing(100_000, samps_per_chan=40_000)
    values = np.empty((2, 40_000))
    task.start()
    assert AnalogMultiChannelReader(task.in_stream).read_many_sample(values, 40_000) == 40_000
    assert 0 < values.std() < 1e-3
