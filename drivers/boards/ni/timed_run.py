"""A whole run in the buffer of an output, started with the inputs of its board.

Both sample clocks come from the board's one oscillator, and the start of the inputs triggers the
output: sample i of the output and sample i of the inputs are the same moment. The output's clock
is its own, not that of the inputs: where they fail, the output still reaches the end of its buffer.

The buffer holds the whole run, and its last sample is 0 V. It is put out once. So the output ends
at 0 V without anybody's help, whatever becomes of the program that has filled it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from drivers.interfaces import DeviceError, FloatArray, TimedVoltage

WRITE_TIMEOUT_S = 1.0
_SAME_RATE = 1e-9  # relative difference of two rates that divide one oscillator alike
_MOST_SAMPLES = 10_000_000  # 80 MB: far beyond any run


def samples_of(waveform: Sequence[TimedVoltage]) -> FloatArray:
    """Return the samples of a run: 0 V before its first voltage, and 0 V as the last one."""
    indices = [each.index for each in waveform]
    rising = all(first < second for first, second in pairwise(indices))
    if not waveform or indices[0] < 0 or not rising:
        raise DeviceError("the voltages of a run must have sample indices from 0 on that rise")
    if waveform[-1].volts != 0.0:
        raise DeviceError("a run that the board puts out by itself must end at 0 V")
    if indices[-1] >= _MOST_SAMPLES:
        raise DeviceError(f"a run of {indices[-1]} samples is too long for a board's buffer")
    samples = np.zeros(indices[-1] + 2)  # a finite generation needs two samples at least
    for each, after in pairwise(waveform):
        samples[each.index : after.index] = each.volts
    return samples


def load_run(task: Any, samples: FloatArray, rate_hz: float, trigger: str) -> None:
    """Give a task with one output channel its run; it waits for the trigger then."""
    from nidaqmx.constants import AcquisitionType, RegenerationMode
    from nidaqmx.stream_writers import AnalogSingleChannelWriter

    task.timing.cfg_samp_clk_timing(
        rate_hz, sample_mode=AcquisitionType.FINITE, samps_per_chan=len(samples)
    )
    task.triggers.start_trigger.cfg_dig_edge_start_trig(trigger)
    task.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
    rate_of_board_hz = float(task.timing.samp_clk_rate)
    if not abs(rate_of_board_hz / rate_hz - 1.0) <= _SAME_RATE:
        raise DeviceError(
            f"the output's clock would run at {rate_of_board_hz:.9g} Hz and that of the inputs "
            f"at {rate_hz:.9g} Hz; choose another [ni] sample_rate_hz, or timed_output = false"
        )
    writer = AnalogSingleChannelWriter(task.out_stream, auto_start=False)
    writer.write_many_sample(samples, timeout=WRITE_TIMEOUT_S)
    task.start()


def is_clocked(task: Any) -> bool:
    """Return whether a task puts out by a clock: a single value cannot be written to it."""
    from nidaqmx.constants import SampleTimingType

    return bool(task.timing.samp_timing_type == SampleTimingType.SAMPLE_CLOCK)
