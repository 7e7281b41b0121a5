"""Reading samples as waveforms, which newer clients can: values with their interval and names.

They carry the time of their first sample where the server's clock has a date: the real one.
"""

from __future__ import annotations

import datetime as dt

import numpy as np
from ni.protobuf.types.precision_timestamp_conversion import bintime_datetime_to_protobuf
from ni.protobuf.types.waveform_pb2 import (
    DigitalWaveform,
    DoubleAnalogWaveform,
    WaveformAttributeValue,
)
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nitypes.bintime import DateTime

from sim_hardware.ni.calls.digital import bits_of
from sim_hardware.ni.calls.packed_doubles import doubles_field
from sim_hardware.ni.calls.reading import ReadSamples, read_samples, read_words
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.names import join_list
from sim_hardware.ni.rpc import Call, Message, raw_enum
from sim_hardware.ni.tasks.channels import Channel, DigitalChannel
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import Task

_TIMING, _NAMES = 1, 2  # constants.WaveformAttributeMode
_Y_DATA = DoubleAnalogWaveform.DESCRIPTOR.fields_by_name["y_data"].number


def read_analog_waveforms(engine: Engine, request: Message, call: Call) -> Message:
    """One waveform for each channel."""
    task = task_of(engine, request, call)
    got = read_samples(engine, task, request.num_samps_per_chan, request.timeout, call)
    mode = raw_enum(request, "waveform_attribute_mode")
    waveforms = []
    for volts, channel in zip(got.samples.volts, task.select(task.channels_to_read), strict=True):
        waveform = DoubleAnalogWaveform()
        waveform.MergeFromString(doubles_field(_Y_DATA, volts))
        _describe(engine, task, waveform, channel, got, mode, NI_UnitDescription="Volts")
        waveforms.append(waveform)
    return pb.ReadAnalogWaveformsResponse(
        status=got.status, waveforms=waveforms, samps_per_chan_read=got.count
    )


def read_digital_waveforms(engine: Engine, request: Message, call: Call) -> Message:
    """One waveform for each channel, a signal for each line: a port begins at its last line."""
    task = task_of(engine, request, call)
    got = read_words(engine, task, request.num_samps_per_chan, request.timeout, call)
    mode = raw_enum(request, "waveform_attribute_mode")
    waveforms = []
    for words, channel in zip(got.samples.codes, task.select(task.channels_to_read), strict=True):
        assert isinstance(channel, DigitalChannel)  # noqa: S101 - `read_words` refuses others
        order = slice(None, None, -1 if channel.by_port else 1)
        bits = bits_of(words.astype(np.uint32), len(channel.lines))[:, order]
        waveform = DigitalWaveform(signal_count=len(channel.lines), y_data=bits.tobytes())
        lines = join_list([f"{channel.device.name}/{line}" for line in channel.lines[order]])
        _describe(engine, task, waveform, channel, got, mode, NI_LineNames=lines)
        waveforms.append(waveform)
    return pb.ReadDigitalWaveformsResponse(
        status=got.status, waveforms=waveforms, samps_per_chan_read=got.count
    )


def _describe(
    engine: Engine,
    task: Task,
    waveform: Message,
    channel: Channel,
    got: ReadSamples,
    mode: int,
    **more: str,
) -> None:
    """Add the attributes that the client wants."""
    plan = task.verify() if mode & _TIMING else None
    if plan is not None:
        waveform.dt = 1.0 / plan.rate_hz
        if got.first_s is not None and engine.epoch_s is not None:
            first = dt.datetime.fromtimestamp(engine.epoch_s + got.first_s, dt.UTC)
            waveform.t0.CopyFrom(bintime_datetime_to_protobuf(DateTime(first)))
    if mode & _NAMES:
        for key, text in {"NI_ChannelName": channel.name, **more}.items():
            waveform.attributes[key].CopyFrom(WaveformAttributeValue(string_value=text))


HANDLERS = {
    "ReadAnalogWaveforms": read_analog_waveforms,
    "ReadDigitalWaveforms": read_digital_waveforms,
}
