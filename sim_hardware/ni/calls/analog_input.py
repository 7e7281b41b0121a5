"""Calls that make and read analog inputs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.calls.packed_doubles import doubles_field
from sim_hardware.ni.calls.reading import ReadSamples, read_samples
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.errors import Code, NotSimulatedError, StatusError
from sim_hardware.ni.names import split_list, split_some
from sim_hardware.ni.rpc import Call, Message, raw_enum
from sim_hardware.ni.tasks.channels import VOLTS, AnalogInputChannel
from sim_hardware.ni.tasks.engine import Engine

_BY_CHANNEL = 0  # constants.FillMode.GROUP_BY_CHANNEL
_BYTES_PER_CODE = 2
AnyArray = npt.NDArray[np.float64] | npt.NDArray[np.int16]


def names_for(physical: list[str], assigned: str) -> list[str]:
    """Names of virtual channels: as assigned (numbered, if several), else the physical ones."""
    if not assigned:
        return physical
    given = split_list(assigned)
    if len(given) == len(physical):
        return given
    return [f"{assigned}{i}" for i in range(len(physical))]


def create_ai_voltage_chan(engine: Engine, request: Message, call: Call) -> Message:
    """Add voltage inputs to a task."""
    task = task_of(engine, request, call)
    refuse_scales(raw_enum(request, "units"), request.custom_scale_name)
    physical = split_some(request.physical_channel)
    names = names_for(physical, request.name_to_assign_to_channel)
    for name, full in zip(names, physical, strict=True):
        device, channel = engine.devices.find_channel(full)
        side = device.board.analog_in
        if side is None or not channel.startswith("ai"):
            raise StatusError(Code.WRONG_CHANNEL_TYPE, f"Physical Channel Name: {full}", task.name)
        terminals = raw_enum(request, "terminal_config")
        task.add(
            AnalogInputChannel(
                name=name,
                device=device,
                side=side,
                physical=channel,
                low_V=request.min_val,
                high_V=request.max_val,
                asked_terminals=terminals,
            )
        )
    return pb.CreateAIVoltageChanResponse()


def refuse_scales(units: int, scale: str) -> None:
    """Refuse custom scales: they are not simulated."""
    if scale or units != VOLTS:
        raise NotSimulatedError("the simulated boards know no unit but volts")


def read_analog_f64(engine: Engine, request: Message, call: Call) -> Message:
    """Volts, zero-padded to the size of the caller's array."""
    got = _read(engine, request, call)
    values = _laid_out(got.samples.volts, request, request.array_size_in_samps)
    response = pb.ReadAnalogF64Response(status=got.status, samps_per_chan_read=got.count)
    response.MergeFromString(doubles_field(2, values))
    return response


def read_analog_scalar_f64(engine: Engine, request: Message, call: Call) -> Message:
    """One sample of one channel."""
    task = task_of(engine, request, call)
    if len(task.inputs) > 1:
        raise StatusError(Code.ONE_CHANNEL_OF_SEVERAL, task=task.name, samples_read=0)
    got = read_samples(engine, task, 1, request.timeout, call)
    if got.status:
        raise StatusError(got.status, task=task.name)
    return pb.ReadAnalogScalarF64Response(value=float(got.samples.volts[0, 0]))


def read_binary_i16(engine: Engine, request: Message, call: Call) -> Message:
    """Codes of the converter."""
    got = _read(engine, request, call)
    values = _laid_out(got.samples.codes.astype(np.int16), request, request.array_size_in_samps)
    return pb.ReadBinaryI16Response(
        status=got.status, samps_per_chan_read=got.count, read_array=values.tolist()
    )


def read_raw(engine: Engine, request: Message, call: Call) -> Message:
    """Codes as bytes, interleaved as the board delivers them."""
    got = _read(engine, request, call)
    data = np.ascontiguousarray(got.samples.codes.T).astype("<i2").tobytes()
    if len(data) > request.array_size_in_bytes:
        raise StatusError(Code.ARRAY_TOO_SMALL, samples_read=0)
    return pb.ReadRawResponse(
        status=got.status,
        read_array=data.ljust(request.array_size_in_bytes, b"\0"),
        samps_read=got.count,
        num_bytes_per_samp=_BYTES_PER_CODE,
    )


def _read(engine: Engine, request: Message, call: Call) -> ReadSamples:
    task = task_of(engine, request, call)
    return read_samples(engine, task, request.num_samps_per_chan, request.timeout, call)


def _laid_out(rows: AnyArray, request: Message, size: int) -> AnyArray:
    """Fill the caller's flat array. By channel, a row has the room of the samples asked for."""
    channels, count = rows.shape
    room = max(request.num_samps_per_chan, count)
    if channels * room > size:
        raise StatusError(
            Code.ARRAY_TOO_SMALL, f"Needed: {channels * room}\nGiven: {size}", samples_read=0
        )
    flat = np.zeros(size, rows.dtype)
    if raw_enum(request, "fill_mode") == _BY_CHANNEL:
        flat[: channels * room].reshape(channels, room)[:, :count] = rows
    else:
        flat[: channels * count].reshape(count, channels)[:] = rows.T
    return flat


HANDLERS = {
    "CreateAIVoltageChan": create_ai_voltage_chan,
    "ReadAnalogF64": read_analog_f64,
    "ReadAnalogScalarF64": read_analog_scalar_f64,
    "ReadBinaryI16": read_binary_i16,
    "ReadRaw": read_raw,
}
