"""Inputs of the simulated boards: ranges that are set, lines by a clock, signals without a wire."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from typing import Any

import nidaqmx
import numpy as np
import pytest
from nidaqmx.constants import LineGrouping
from nidaqmx.stream_readers import AnalogUnscaledReader


@pytest.fixture
def board(make_ni: Callable[..., Any]) -> Any:
    """Boards on which nothing is wired, and inputs show signals."""
    return make_ni(tcp=False, is_wired=lambda _device, _channel: False)


def lines(ni: Any, names: str) -> Any:
    task = ni.task()
    task.di_channels.add_di_chan(names, line_grouping=LineGrouping.CHAN_FOR_ALL_LINES)
    return task


def test_a_range_that_is_set_is_the_converters_whatever_the_limits(board: Any) -> None:
    task = board.input("X/ai0", limit=0.05)
    channel = task.ai_channels[0]
    assert channel.ai_rng_high == 0.1
    channel.ai_rng_high, channel.ai_rng_low = 10.0, -10.0
    assert (channel.ai_rng_high, channel.ai_rng_low) == (10.0, -10.0)
    codes = np.zeros((1, 50), np.int16)
    task.timing.cfg_samp_clk_timing(1000.0, samps_per_chan=50)
    AnalogUnscaledReader(task.in_stream).read_int16(codes, 50)
    assert abs(codes).max() == pytest.approx(0.05 / 10.0 * 2**15, abs=5)
    channel.ai_rng_high = 11.0
    with pytest.raises(nidaqmx.DaqError, match="-200077"):
        task.start()


def test_an_input_without_a_wire_shows_a_sine_between_its_limits(board: Any) -> None:
    task = board.task()
    task.ai_channels.add_ai_voltage_chan("X/ai3", min_val=1.0, max_val=2.0)
    task.timing.cfg_samp_clk_timing(1000.0, samps_per_chan=200)
    volts = np.array(task.read(200))
    assert volts.min() == pytest.approx(1.0, abs=2e-3)
    assert volts.max() == pytest.approx(2.0, abs=2e-3)


def test_lines_that_nobody_writes_count_the_samples_of_a_task(board: Any) -> None:
    task = lines(board, "X/port1/line0:7")
    assert [task.read() for _ in range(5)] == [0, 1, 2, 3, 4]
    assert task.read(3) == [5, 6, 7]


@pytest.mark.parametrize("tcp", [False, True])
def test_a_port_with_a_clock_is_sampled_at_its_rate(make_ni: Callable[..., Any], tcp: bool) -> None:
    ni = make_ni(tcp=tcp, is_wired=lambda _device, _channel: False)
    task = lines(ni, "X/port0/line0:3")
    task.timing.cfg_samp_clk_timing(1000.0, samps_per_chan=20)
    waveform = task.read_waveform(20)
    assert [int(sample @ [1, 2, 4, 8]) for sample in waveform.data] == [k % 16 for k in range(20)]
    assert waveform.timing.sample_interval.total_seconds() == pytest.approx(1e-3)
    assert waveform.signals[0].name == "X/port0/line3"
    assert waveform.timing.has_timestamp is tcp  # a virtual clock has no date
    if tcp:
        age = dt.datetime.now(dt.UTC) - waveform.timing.timestamp
        assert -1.0 < age.total_seconds() < 120.0


def test_a_line_that_was_written_is_sampled_at_its_level(board: Any) -> None:
    output = board.task()
    output.do_channels.add_do_chan("X/port0/line8")
    output.write(True)
    output.close()
    task = lines(board, "X/port0/line8")
    task.timing.cfg_samp_clk_timing(1000.0, samps_per_chan=20)
    assert task.read(20) == [True] * 20
