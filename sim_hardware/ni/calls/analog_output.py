"""Calls that make and write analog outputs.

On demand a write takes effect at once; with a sample clock it fills the buffer.
"""

from __future__ import annotations

import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.calls.analog_input import names_for, refuse_scales
from sim_hardware.ni.calls.buffered_output import write_buffered
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.names import split_some
from sim_hardware.ni.rpc import Call, Message, raw_enum
from sim_hardware.ni.signals.adc import FloatArray
from sim_hardware.ni.signals.timing import TimingType
from sim_hardware.ni.tasks.channels import AnalogOutputChannel, ChannelType
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import Task

BY_CHANNEL = 0  # constants.FillMode.GROUP_BY_CHANNEL


def create_ao_voltage_chan(engine: Engine, request: Message, call: Call) -> Message:
    """Add voltage outputs to a task; their terminals do not change."""
    task = task_of(engine, request, call)
    refuse_scales(raw_enum(request, "units"), request.custom_scale_name)
    physical = split_some(request.physical_channel)
    names = names_for(physical, request.name_to_assign_to_channel)
    for name, full in zip(names, physical, strict=True):
        device, channel = engine.devices.find_channel(full)
        side = device.board.analog_out
        if side is None or not channel.startswith("ao"):
            raise StatusError(Code.WRONG_CHANNEL_TYPE, f"Physical Channel Name: {full}", task.name)
        task.add(
            AnalogOutputChannel(
                name=name,
                device=device,
                side=side,
                physical=channel,
                low_V=request.min_val,
                high_V=request.max_val,
            )
        )
    return pb.CreateAOVoltageChanResponse()


def write_analog_f64(engine: Engine, request: Message, call: Call) -> Message:
    """Write samples, one after the other."""
    task = _output_task(engine, request, call)
    by_channel = raw_enum(request, "data_layout") == BY_CHANNEL
    values = rows_of(
        np.array(request.write_array), task, request.num_samps_per_chan, by_channel=by_channel
    )
    written = _write(engine, task, values, request, call)
    return pb.WriteAnalogF64Response(samps_per_chan_written=written)


def write_analog_scalar_f64(engine: Engine, request: Message, call: Call) -> Message:
    """Write one value to one channel."""
    task = _output_task(engine, request, call)
    values = rows_of(np.array([request.value]), task, 1, by_channel=True)
    _write(engine, task, values, request, call)
    return pb.WriteAnalogScalarF64Response()


def write_analog_waveforms(engine: Engine, request: Message, call: Call) -> Message:
    """Write a waveform to each channel; its interval does not count, the task has a clock."""
    task = _output_task(engine, request, call)
    lengths = {len(waveform.y_data) for waveform in request.waveforms}
    samples = lengths.pop() if len(lengths) == 1 else 0  # of different lengths: refused below
    flat = np.array([value for waveform in request.waveforms for value in waveform.y_data])
    values = rows_of(flat, task, samples, by_channel=True)
    written = _write(engine, task, values, request, call)
    return pb.WriteAnalogWaveformsResponse(samps_per_chan_written=written)


def rows_of(flat: FloatArray, task: Task, samples: int, *, by_channel: bool) -> FloatArray:
    """Return the data as (channels, samples); -200524 when there are too few or too many."""
    channels = len(task.channels)
    if flat.size != channels * samples or samples < 1:
        raise StatusError(
            Code.WRITE_CHANNEL_COUNT,
            f"Values: {flat.size}\nChannels: {channels}\nSamples per channel: {samples}",
            task.name,
            samples_written=0,
        )
    return flat.reshape(channels, samples) if by_channel else flat.reshape(samples, channels).T


def _output_task(engine: Engine, request: Message, call: Call) -> Task:
    task = task_of(engine, request, call)
    if task.type is not ChannelType.ANALOG_OUTPUT:
        raise StatusError(Code.WRITE_NOT_OUTPUT, task=task.name, samples_written=0)
    return task


def _write(engine: Engine, task: Task, values: FloatArray, request: Message, call: Call) -> int:
    """Write (channels, samples); return how many samples of each channel."""
    for channel, row in zip(task.outputs, values, strict=True):
        _check_limits(channel, row, task)
    if task.timing.kind is TimingType.SAMPLE_CLOCK:
        return write_buffered(engine, task, values, request, call)
    started = not task.running
    if started and not request.auto_start:
        raise StatusError(Code.NOT_STARTED, task=task.name, samples_written=0)
    if started:
        engine.start(task)
    for column in values.T:
        for channel, value in zip(task.outputs, column, strict=True):
            volts = channel.converted(float(value))
            engine.write_volts(channel.device.name, channel.physical, volts)
    if started:
        engine.stop(task)
    return int(values.shape[1])


def _check_limits(channel: AnalogOutputChannel, row: FloatArray, task: Task) -> None:
    """-200561 for a value beyond the channel's limits, or none at all; nothing is written then."""
    inside = (row >= channel.low_V) & (row <= channel.high_V)  # so written, NaN is outside
    if not inside.all():
        raise StatusError(
            Code.VALUE_OUT_OF_LIMITS,
            f"Requested Value: {row[~inside][0]:g}\nMaximum Value: {channel.high_V:g}\n"
            f"Minimum Value: {channel.low_V:g}\nChannel Name: {channel.name}",
            task.name,
            samples_written=0,
        )


HANDLERS = {
    "CreateAOVoltageChan": create_ao_voltage_chan,
    "WriteAnalogF64": write_analog_f64,
    "WriteAnalogScalarF64": write_analog_scalar_f64,
    "WriteAnalogWaveforms": write_analog_waveforms,
}
