"""Reading samples as waveforms, which newer clients can: values with their interval and names.

They carry no time of their first sample: the server's clock has no date.
"""

from __future__ import annotations

from ni.protobuf.types.waveform_pb2 import DoubleAnalogWaveform, WaveformAttributeValue
from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.calls.packed_doubles import doubles_field
from sim_hardware.ni.calls.reading import read_samples
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.rpc import Call, Message, raw_enum
from sim_hardware.ni.signals.adc import FloatArray
from sim_hardware.ni.tasks.channels import Channel
from sim_hardware.ni.tasks.engine import Engine

_TIMING, _NAMES = 1, 2  # constants.WaveformAttributeMode
_Y_DATA = DoubleAnalogWaveform.DESCRIPTOR.fields_by_name["y_data"].number


def read_analog_waveforms(engine: Engine, request: Message, call: Call) -> Message:
    """One waveform for each channel."""
    task = task_of(engine, request, call)
    got = read_samples(engine, task, request.num_samps_per_chan, request.timeout, call)
    mode = raw_enum(request, "waveform_attribute_mode")
    plan = task.verify() if mode & _TIMING else None
    interval_s = 0.0 if plan is None else 1.0 / plan.rate_hz
    waveforms = [
        _waveform(volts, interval_s, channel if mode & _NAMES else None)
        for volts, channel in zip(
            got.samples.volts, task.select(task.channels_to_read), strict=True
        )
    ]
    return pb.ReadAnalogWaveformsResponse(
        status=got.status, waveforms=waveforms, samps_per_chan_read=got.count
    )


def _waveform(volts: FloatArray, interval_s: float, channel: Channel | None) -> Message:
    waveform = DoubleAnalogWaveform(dt=interval_s)
    waveform.MergeFromString(doubles_field(_Y_DATA, volts))
    if channel is not None:
        for key, text in (("NI_ChannelName", channel.name), ("NI_UnitDescription", "Volts")):
            waveform.attributes[key].CopyFrom(WaveformAttributeValue(string_value=text))
    return waveform


HANDLERS = {"ReadAnalogWaveforms": read_analog_waveforms}
