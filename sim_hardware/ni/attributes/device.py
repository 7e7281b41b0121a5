"""Attributes of the system, of a device and of a physical channel: what the boards can do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.attributes.common import Attribute, Table, attribute_handlers
from sim_hardware.ni.boards.contract import AnalogInputs, AnalogOutputs, Terminals
from sim_hardware.ni.devices import Device
from sim_hardware.ni.names import join_list, split_some
from sim_hardware.ni.rpc import Call, Message
from sim_hardware.ni.signals.timing import SampleMode
from sim_hardware.ni.tasks.engine import Engine

_VOLTAGE_MEASUREMENT, _VOLTAGE_OUTPUT = 10322, 10322  # constants.UsageTypeAI, UsageTypeAO: VOLTAGE
_TERMINAL_BITS = {Terminals.RSE: 1, Terminals.NRSE: 2, Terminals.DIFFERENTIAL: 4}


def _system(kind: str, get: Callable[[Engine], Any]) -> Attribute[Engine]:
    return Attribute(kind, lambda engine, _: get(engine))


SYSTEM: Table[Engine] = {
    pb.SYSTEM_ATTRIBUTE_NIDAQ_MAJOR_VERSION: _system("UInt32", lambda e: e.driver_version[0]),
    pb.SYSTEM_ATTRIBUTE_NIDAQ_MINOR_VERSION: _system("UInt32", lambda e: e.driver_version[1]),
    pb.SYSTEM_ATTRIBUTE_NIDAQ_UPDATE_VERSION: _system("UInt32", lambda e: e.driver_version[2]),
    pb.SYSTEM_ATTRIBUTE_DEV_NAMES: _system(
        "String", lambda e: join_list([device.name for device in e.devices])
    ),
    pb.SYSTEM_ATTRIBUTE_TASKS: _system("String", lambda _: ""),  # none is saved on disk
    pb.SYSTEM_ATTRIBUTE_GLOBAL_CHANS: _system("String", lambda _: ""),
    pb.SYSTEM_ATTRIBUTE_SCALES: _system("String", lambda _: ""),
}


def _device(kind: str, get: Callable[[Device], Any]) -> Attribute[Device]:
    return Attribute(kind, lambda _, device: get(device))


def _input(kind: str, get: Callable[[AnalogInputs], Any]) -> Attribute[Device]:
    return _device(kind, lambda d: get(d.board.analog_in) if d.board.analog_in else None)


def _output(kind: str, get: Callable[[AnalogOutputs], Any]) -> Attribute[Device]:
    return _device(kind, lambda d: get(d.board.analog_out) if d.board.analog_out else None)


def _both_signs(ranges_V: tuple[float, ...]) -> list[float]:
    return [bound for range_V in ranges_V for bound in (-range_V, range_V)]


DEVICE: Table[Device] = {
    pb.DEVICE_ATTRIBUTE_PRODUCT_TYPE: _device("String", lambda d: d.board.product_type),
    pb.DEVICE_ATTRIBUTE_PRODUCT_NUM: _device("UInt32", lambda d: d.board.product_number),
    pb.DEVICE_ATTRIBUTE_PRODUCT_CATEGORY: _device("Int32", lambda d: d.board.category.value),
    pb.DEVICE_ATTRIBUTE_BUS_TYPE: _device("Int32", lambda d: d.board.bus.value),
    pb.DEVICE_ATTRIBUTE_SERIAL_NUM: _device("UInt32", lambda d: d.serial_number),
    pb.DEVICE_ATTRIBUTE_IS_SIMULATED: _device("Bool", lambda _: True),
    pb.DEVICE_ATTRIBUTE_ANLG_TRIG_SUPPORTED: _device("Bool", lambda _: False),
    pb.DEVICE_ATTRIBUTE_DIG_TRIG_SUPPORTED: _device("Bool", lambda _: False),
    pb.DEVICE_ATTRIBUTE_AI_PHYSICAL_CHANS: _device("String", lambda d: join_list(d.inputs())),
    pb.DEVICE_ATTRIBUTE_AO_PHYSICAL_CHANS: _device("String", lambda d: join_list(d.outputs())),
    pb.DEVICE_ATTRIBUTE_DI_LINES: _device("String", lambda d: join_list(d.lines(output=False))),
    pb.DEVICE_ATTRIBUTE_DO_LINES: _device("String", lambda d: join_list(d.lines(output=True))),
    pb.DEVICE_ATTRIBUTE_DI_PORTS: _device("String", lambda d: join_list(d.ports(output=False))),
    pb.DEVICE_ATTRIBUTE_DO_PORTS: _device("String", lambda d: join_list(d.ports(output=True))),
    pb.DEVICE_ATTRIBUTE_CI_PHYSICAL_CHANS: _device("String", lambda _: ""),  # no counters
    pb.DEVICE_ATTRIBUTE_CO_PHYSICAL_CHANS: _device("String", lambda _: ""),
    pb.DEVICE_ATTRIBUTE_AI_MAX_SINGLE_CHAN_RATE: _input("Double", lambda ai: ai.max_rate_hz),
    pb.DEVICE_ATTRIBUTE_AI_MAX_MULTI_CHAN_RATE: _input("Double", lambda ai: ai.max_multi_rate_hz),
    pb.DEVICE_ATTRIBUTE_AI_MIN_RATE: _input("Double", lambda ai: ai.min_rate_hz),
    pb.DEVICE_ATTRIBUTE_AI_SIMULTANEOUS_SAMPLING_SUPPORTED: _input(
        "Bool", lambda ai: ai.simultaneous
    ),
    pb.DEVICE_ATTRIBUTE_AI_VOLTAGE_RNGS: _input("DoubleArray", lambda ai: _both_signs(ai.ranges_V)),
    pb.DEVICE_ATTRIBUTE_AI_SUPPORTED_MEAS_TYPES: _input(
        "Int32Array", lambda _: [_VOLTAGE_MEASUREMENT]
    ),
    pb.DEVICE_ATTRIBUTE_AI_SAMP_MODES: _input(
        "Int32Array", lambda _: [SampleMode.FINITE, SampleMode.CONTINUOUS]
    ),
    pb.DEVICE_ATTRIBUTE_AO_VOLTAGE_RNGS: _output(
        "DoubleArray", lambda ao: _both_signs(ao.ranges_V)
    ),
    pb.DEVICE_ATTRIBUTE_AO_SUPPORTED_OUTPUT_TYPES: _output(
        "Int32Array", lambda _: [_VOLTAGE_OUTPUT]
    ),
    pb.DEVICE_ATTRIBUTE_AO_SAMP_CLK_SUPPORTED: _output("Bool", lambda ao: ao.clocked),
    pb.DEVICE_ATTRIBUTE_COMPACT_DAQ_CHASSIS_DEV_NAME: _device(
        "String", lambda d: d.chassis and d.chassis[0]
    ),
    pb.DEVICE_ATTRIBUTE_COMPACT_DAQ_SLOT_NUM: _device(
        "UInt32", lambda d: d.chassis and d.chassis[1]
    ),
    pb.DEVICE_ATTRIBUTE_CHASSIS_MODULE_DEV_NAMES: Attribute(
        "String",
        lambda engine, d: (
            join_list([m.name for m in engine.devices.modules(d)]) if d.board.slots else None
        ),
    ),
    pb.DEVICE_ATTRIBUTE_AO_MAX_RATE: _output("Double", lambda ao: ao.max_rate_hz),
}


PhysicalChannel = tuple[Device, str]


def _physical_input(
    kind: str, get: Callable[[AnalogInputs, int], Any]
) -> Attribute[PhysicalChannel]:
    def of(_: Engine, place: PhysicalChannel) -> Any:
        device, channel = place
        side = device.board.analog_in
        return get(side, int(channel[2:])) if side and channel.startswith("ai") else None

    return Attribute(kind, of)


def _terminal_bits(side: AnalogInputs, number: int) -> int:
    return sum(_TERMINAL_BITS[terminals] for terminals in side.terminals_of(number))


PHYSICAL: Table[PhysicalChannel] = {
    pb.PHYSICALCHANNEL_ATTRIBUTE_PHYSICAL_CHAN_AI_TERM_CFGS: _physical_input(
        "Int32", _terminal_bits
    ),
    pb.PHYSICALCHANNEL_ATTRIBUTE_PHYSICAL_CHAN_AI_SUPPORTED_MEAS_TYPES: _physical_input(
        "Int32Array", lambda _side, _number: [_VOLTAGE_MEASUREMENT]
    ),
    pb.PHYSICALCHANNEL_ATTRIBUTE_PHYSICAL_CHAN_AI_INPUT_SRCS: _physical_input(
        "String", lambda _side, _number: "_external_channel"
    ),
    pb.PHYSICALCHANNEL_ATTRIBUTE_PHYSICAL_CHAN_AO_SUPPORTED_OUTPUT_TYPES: Attribute(
        "Int32Array", lambda _, place: [_VOLTAGE_OUTPUT] if place[1].startswith("ao") else None
    ),
}


def _find_device(engine: Engine, request: Message, _call: Call) -> Device:
    return engine.devices.find(request.device_name)


def _find_physical(engine: Engine, request: Message, _call: Call) -> PhysicalChannel:
    return engine.devices.find_channel(split_some(request.physical_channel)[0])


HANDLERS = (
    attribute_handlers("SystemInfo", SYSTEM, lambda engine, _request, _call: engine)
    | attribute_handlers("Device", DEVICE, _find_device)
    | attribute_handlers("PhysicalChan", PHYSICAL, _find_physical)
)
