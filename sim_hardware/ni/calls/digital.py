"""Calls for digital lines: each keeps its level until it is written again."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.calls.analog_input import names_for
from sim_hardware.ni.calls.reading import ReadSamples, read_words
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.devices import Device, DeviceRegistry
from sim_hardware.ni.errors import Code, NotSimulatedError, StatusError
from sim_hardware.ni.names import split_device, split_some
from sim_hardware.ni.rpc import Call, Message, raw_enum
from sim_hardware.ni.tasks.channels import DigitalChannel
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import Task

_ALL_IN_ONE = 1  # constants.LineGrouping.CHAN_FOR_ALL_LINES
_BY_CHANNEL = 0  # constants.FillMode.GROUP_BY_CHANNEL
_PORT = re.compile(r"^port\d+$")
Words = npt.NDArray[np.uint32]  # one bit for each line, or one word for each
Handler = Callable[[Engine, Message, Call], Message]


def create_do_chan(engine: Engine, request: Message, call: Call) -> Message:
    """Add output lines; their levels do not change."""
    _add(engine, request, call, request.name_to_assign_to_lines, output=True)
    return pb.CreateDOChanResponse()


def create_di_chan(engine: Engine, request: Message, call: Call) -> Message:
    """Add input lines."""
    _add(engine, request, call, request.name_to_assign_to_lines, output=False)
    return pb.CreateDIChanResponse()


def _add(engine: Engine, request: Message, call: Call, assigned: str, *, output: bool) -> None:
    task = task_of(engine, request, call)
    groups = [_find(engine.devices, name, output) for name in split_some(request.lines)]
    if raw_enum(request, "line_grouping") == _ALL_IN_ONE:
        device = groups[0][0]
        if any(other is not device for other, _ in groups):
            raise NotSimulatedError("a channel of lines of several boards is not simulated")
        lines = [line for _, group in groups for line in group]
        first, *others = split_some(request.lines)
        name = assigned or (f"{first}..." if others else first)  # as the driver names it
        ports = [
            bool(_PORT.match(split_device(each)[1].lower())) for each in split_some(request.lines)
        ]
        task.add(
            DigitalChannel(
                name=name, device=device, lines=tuple(lines), output=output, by_port=all(ports)
            )
        )
        return
    if any(len(group) > 1 for _, group in groups):
        raise StatusError(Code.PORT_PER_LINE, f"Lines: {request.lines}", task.name)
    single = [(device, line) for device, group in groups for line in group]
    names = names_for([f"{device.name}/{line}" for device, line in single], assigned)
    for name, (device, line) in zip(names, single, strict=True):
        task.add(DigitalChannel(name=name, device=device, lines=(line,), output=output))


def _find(devices: DeviceRegistry, name: str, output: bool) -> tuple[Device, list[str]]:
    """Device and lines of `Dev1/port0/line3`, or of the whole port `Dev1/port0`."""
    device_name, channel = split_device(name)
    device = devices.find(device_name)
    able = [line.partition("/")[2] for line in device.lines(output=output)]
    channel = channel.lower()
    lines = [line for line in able if line == channel]
    if _PORT.match(channel):
        lines = [line for line in able if line.startswith(f"{channel}/")]
    if not lines:
        code = Code.WRONG_CHANNEL_TYPE if device.has(channel) else Code.NO_SUCH_CHANNEL
        raise StatusError(code, f"Physical Channel Name: {channel}\nDevice: {device.name}")
    return device, lines


# ------------------------------------------------------------------------------------- writing


def write_digital_lines(engine: Engine, request: Message, call: Call) -> Message:
    """One byte for each line."""
    task = _written_task(engine, request, call)
    width = max(len(channel.lines) for channel in task.digital)
    flat = np.frombuffer(request.write_array, np.uint8).astype(np.uint32)
    per_line = _rows(flat, task, request, width)
    words = (per_line.astype(bool) << np.arange(width)).sum(axis=-1)
    _write(engine, task, words.astype(np.uint32), request)
    return pb.WriteDigitalLinesResponse(samps_per_chan_written=request.num_samps_per_chan)


def write_digital_scalar_u32(engine: Engine, request: Message, call: Call) -> Message:
    """One value for one channel."""
    task = _written_task(engine, request, call)
    _write(engine, task, np.array([[request.value]], np.uint32), request)
    return pb.WriteDigitalScalarU32Response()


def _word_writer(bits: str) -> Handler:
    def write(engine: Engine, request: Message, call: Call) -> Message:
        task = _written_task(engine, request, call)
        array = request.write_array  # bytes for U8
        flat = np.array(list(array), np.uint32)
        _write(engine, task, _rows(flat, task, request, 1)[..., 0], request)
        response = getattr(pb, f"WriteDigital{bits}Response")
        return response(samps_per_chan_written=request.num_samps_per_chan)

    return write


def _written_task(engine: Engine, request: Message, call: Call) -> Task:
    task = task_of(engine, request, call)
    if not task.digital or not task.digital[0].output:
        raise StatusError(Code.WRITE_NOT_OUTPUT, task=task.name, samples_written=0)
    return task


def _rows(flat: Words, task: Task, request: Message, width: int) -> Words:
    """Return the data as (channels, samples, width)."""
    channels, samples = len(task.channels), request.num_samps_per_chan
    if samples < 1 or flat.size != channels * samples * width:
        raise StatusError(
            Code.LINE_COUNT,
            f"Values: {flat.size}\nChannels: {channels}\nLines: {width}\nSamples: {samples}",
            task.name,
            samples_written=0,
        )
    if raw_enum(request, "data_layout") == _BY_CHANNEL:
        return flat.reshape(channels, samples, width)
    return flat.reshape(samples, channels, width).transpose(1, 0, 2)


def _write(engine: Engine, task: Task, words: Words, request: Message) -> None:
    started = not task.running
    if started and not request.auto_start:
        raise StatusError(Code.NOT_STARTED, task=task.name, samples_written=0)
    if started:
        engine.start(task)
    for sample in words.T:
        for channel, word in zip(task.digital, sample, strict=True):
            for bit, line in enumerate(channel.lines):
                high = bool(int(word) >> bit & 1)
                engine.write_line(f"{channel.device.name}/{line}", high)
    if started:
        engine.stop(task)


# ------------------------------------------------------------------------------------- reading


def read_digital_lines(engine: Engine, request: Message, call: Call) -> Message:
    """One byte for each line."""
    task, got = _read(engine, request, call)
    width = max(len(channel.lines) for channel in task.digital)
    bits = bits_of(_words(got), width)
    data = _flat(bits, request).tobytes()
    if len(data) > request.array_size_in_bytes:
        raise StatusError(Code.ARRAY_TOO_SMALL, task=task.name, samples_read=0)
    return pb.ReadDigitalLinesResponse(
        status=got.status,
        read_array=data.ljust(request.array_size_in_bytes, b"\0"),
        samps_per_chan_read=got.count,
        num_bytes_per_samp=width,
    )


def _word_reader(bits: str) -> Handler:
    """Make the answer of one word for each sample; U8 goes as bytes, the others as numbers."""

    def read(engine: Engine, request: Message, call: Call) -> Message:
        task, got = _read(engine, request, call)
        flat = _flat(_words(got), request)
        if flat.size > request.array_size_in_samps:
            raise StatusError(Code.ARRAY_TOO_SMALL, task=task.name, samples_read=0)
        padded = np.zeros(request.array_size_in_samps, np.uint32)
        padded[: flat.size] = flat
        array = padded.astype(np.uint8).tobytes() if bits == "U8" else padded.tolist()
        response = getattr(pb, f"ReadDigital{bits}Response")
        return response(status=got.status, read_array=array, samps_per_chan_read=got.count)

    return read


def read_digital_scalar_u32(engine: Engine, request: Message, call: Call) -> Message:
    """One sample of one channel."""
    task = task_of(engine, request, call)
    got = read_words(engine, task, 1, request.timeout, call)
    if got.status:
        raise StatusError(got.status, task=task.name)
    return pb.ReadDigitalScalarU32Response(value=int(_words(got)[0, 0]))


def bits_of(words: Words, width: int) -> npt.NDArray[np.uint8]:
    """Return the level of each line: (..., width)."""
    bits: npt.NDArray[np.uint8] = (
        words[..., None] >> np.arange(width, dtype=np.uint32) & 1
    ).astype(np.uint8)
    return bits


def _words(got: ReadSamples) -> Words:
    return got.samples.codes.astype(np.uint32)


def _read(engine: Engine, request: Message, call: Call) -> tuple[Task, ReadSamples]:
    task = task_of(engine, request, call)
    return task, read_words(engine, task, request.num_samps_per_chan, request.timeout, call)


def _flat(rows: npt.NDArray[np.generic], request: Message) -> npt.NDArray[np.generic]:
    """(channels, samples, ...) in the order that the caller wants."""
    if raw_enum(request, "fill_mode") != _BY_CHANNEL:
        rows = rows.swapaxes(0, 1)
    return rows.ravel()


HANDLERS: dict[str, Handler] = {
    "CreateDOChan": create_do_chan,
    "CreateDIChan": create_di_chan,
    "WriteDigitalLines": write_digital_lines,
    "WriteDigitalScalarU32": write_digital_scalar_u32,
    "WriteDigitalU8": _word_writer("U8"),
    "WriteDigitalU16": _word_writer("U16"),
    "WriteDigitalU32": _word_writer("U32"),
    "ReadDigitalLines": read_digital_lines,
    "ReadDigitalU8": _word_reader("U8"),
    "ReadDigitalU16": _word_reader("U16"),
    "ReadDigitalU32": _word_reader("U32"),
    "ReadDigitalScalarU32": read_digital_scalar_u32,
}
