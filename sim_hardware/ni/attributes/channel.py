"""Attributes of the virtual channels of a task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.attributes.common import Attribute, Table, attribute_handlers
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.names import join_list
from sim_hardware.ni.rpc import Call, Message
from sim_hardware.ni.tasks.channels import (
    VOLTS,
    AnalogInputChannel,
    AnalogOutputChannel,
    Channel,
    DigitalChannel,
)
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import Task

_VOLTAGE = 10322  # constants.UsageTypeAI.VOLTAGE, UsageTypeAO.VOLTAGE
_DC = 10050  # constants.Coupling.DC
_RAW_BITS = 16  # a code is sent in so many, whatever the converter's resolution
_RIGHT_JUSTIFIED = 10279  # constants.DataJustification.RIGHT
_BITS_UNIT = 10109  # constants.ResolutionType.BITS


@dataclass(frozen=True)
class Selection:
    """The channels of a task that a request names."""

    task: Task
    channels: list[Channel]


def _of(kind: str, cls: type[Any], get: Callable[[Any], Any]) -> Attribute[Selection]:
    """Read-only, of one type of channel; the value must be the same for all that are named."""

    def ask(_: Engine, selection: Selection) -> Any:
        return _same([get(c) if isinstance(c, cls) else None for c in selection.channels])

    return Attribute(kind, ask)


def _same(values: list[Any]) -> Any:
    if any(value != values[0] for value in values):
        raise StatusError(Code.NOT_SUPPORTED, "The channels do not agree; ask for one at a time.")
    return values[0]


def _limit(
    cls: type[Any], get: Callable[[Any], Any], field: str, default: float | None
) -> Attribute[Selection]:
    def put(_: Engine, selection: Selection, value: Any) -> None:
        _change(selection, cls, field, value)

    return Attribute(
        "Double",
        _of("Double", cls, get).get,
        put,
        lambda _, selection: _change(selection, cls, field, default),
    )


def _change(selection: Selection, cls: type[Any], field: str, value: Any) -> None:
    selection.task.refuse_while_running()
    for channel in selection.channels:
        if not isinstance(channel, cls):
            raise StatusError(Code.NOT_SUPPORTED, f"Channel Name: {channel.name}")
        setattr(channel, field, value)
    selection.task.changed()


_AI, _AO, _DIGITAL = AnalogInputChannel, AnalogOutputChannel, DigitalChannel
_ANY = object


def _physical_names(channel: Channel) -> str:
    if isinstance(channel, DigitalChannel):
        return join_list([f"{channel.device.name}/{line}" for line in channel.lines])
    return f"{channel.device.name}/{channel.physical}"


def _all_physical(_: Engine, selection: Selection) -> str:
    return join_list([_physical_names(channel) for channel in selection.channels])


CHANNEL: Table[Selection] = {
    pb.CHANNEL_ATTRIBUTE_CHAN_TYPE: _of("Int32", _ANY, lambda c: c.type),
    pb.CHANNEL_ATTRIBUTE_PHYSICAL_CHAN_NAME: Attribute("String", _all_physical),
    pb.CHANNEL_ATTRIBUTE_CHAN_DESCR: Attribute(
        "String",
        lambda _, s: _same([channel.description for channel in s.channels]),
        lambda _, s, value: _change(s, object, "description", value),
        lambda _, s: _change(s, object, "description", ""),
    ),
    pb.CHANNEL_ATTRIBUTE_CHAN_IS_GLOBAL: _of("Bool", _ANY, lambda _: False),
    pb.CHANNEL_ATTRIBUTE_AI_MAX: _limit(_AI, lambda c: c.verified_range(), "high_V", 5.0),
    pb.CHANNEL_ATTRIBUTE_AI_MIN: _limit(_AI, lambda c: -c.verified_range(), "low_V", -5.0),
    pb.CHANNEL_ATTRIBUTE_AI_RNG_HIGH: _limit(
        _AI, lambda c: c.verified_range(), "range_high_V", None
    ),
    pb.CHANNEL_ATTRIBUTE_AI_RNG_LOW: _limit(
        _AI, lambda c: -c.verified_range(), "range_low_V", None
    ),
    pb.CHANNEL_ATTRIBUTE_AI_TERM_CFG: Attribute(
        "Int32",
        _of("Int32", _AI, lambda c: c.terminals).get,
        lambda _, s, value: _change(s, AnalogInputChannel, "asked_terminals", value),
        lambda _, s: _change(s, AnalogInputChannel, "asked_terminals", -1),
    ),
    pb.CHANNEL_ATTRIBUTE_AI_MEAS_TYPE: _of("Int32", _AI, lambda _: _VOLTAGE),
    pb.CHANNEL_ATTRIBUTE_AI_VOLTAGE_UNITS: _of("Int32", _AI, lambda _: VOLTS),
    pb.CHANNEL_ATTRIBUTE_AI_COUPLING: _of("Int32", _AI, lambda _: _DC),
    pb.CHANNEL_ATTRIBUTE_AI_RESOLUTION: _of("Double", _AI, lambda c: float(c.side.resolution_bits)),
    pb.CHANNEL_ATTRIBUTE_AI_RESOLUTION_UNITS: _of("Int32", _AI, lambda _: _BITS_UNIT),
    pb.CHANNEL_ATTRIBUTE_AI_RAW_SAMP_SIZE: _of("UInt32", _AI, lambda _: _RAW_BITS),
    pb.CHANNEL_ATTRIBUTE_AI_RAW_SAMP_JUSTIFICATION: _of("Int32", _AI, lambda _: _RIGHT_JUSTIFIED),
    pb.CHANNEL_ATTRIBUTE_AI_DEV_SCALING_COEFF: _of(
        "DoubleArray",
        _AI,
        lambda c: [0.0, 2 * c.verified_range() / 2.0**c.side.resolution_bits, 0.0, 0.0],
    ),
    pb.CHANNEL_ATTRIBUTE_AI_CUSTOM_SCALE_NAME: _of("String", _AI, lambda _: ""),
    pb.CHANNEL_ATTRIBUTE_AO_MAX: _limit(_AO, lambda c: c.high_V, "high_V", 10.0),
    pb.CHANNEL_ATTRIBUTE_AO_MIN: _limit(_AO, lambda c: c.low_V, "low_V", -10.0),
    pb.CHANNEL_ATTRIBUTE_AO_DAC_RNG_HIGH: _of("Double", _AO, lambda c: c.verified_range()),
    pb.CHANNEL_ATTRIBUTE_AO_DAC_RNG_LOW: _of("Double", _AO, lambda c: -c.verified_range()),
    pb.CHANNEL_ATTRIBUTE_AO_OUTPUT_TYPE: _of("Int32", _AO, lambda _: _VOLTAGE),
    pb.CHANNEL_ATTRIBUTE_AO_VOLTAGE_UNITS: _of("Int32", _AO, lambda _: VOLTS),
    pb.CHANNEL_ATTRIBUTE_AO_RESOLUTION: _of("Double", _AO, lambda c: float(c.side.resolution_bits)),
    pb.CHANNEL_ATTRIBUTE_AO_RESOLUTION_UNITS: _of("Int32", _AO, lambda _: _BITS_UNIT),
    pb.CHANNEL_ATTRIBUTE_DO_NUM_LINES: _of("UInt32", _DIGITAL, lambda c: len(c.lines)),
    pb.CHANNEL_ATTRIBUTE_DI_NUM_LINES: _of("UInt32", _DIGITAL, lambda c: len(c.lines)),
}


def _find(engine: Engine, request: Message, call: Call) -> Selection:
    task = task_of(engine, request, call)
    return Selection(task, list(task.select(request.channel)))


HANDLERS = attribute_handlers("Chan", CHANNEL, _find)
