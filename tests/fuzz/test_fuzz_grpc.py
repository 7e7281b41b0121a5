"""A server that answers whatever it likes, in messages of the right type."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import grpc
import numpy as np
import pytest

from drivers.boards.ni.analog_input import InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.rescue import OutputPlace, shut_down
from drivers.interfaces import DeviceError
from sim_hardware.clock import VirtualClock
from sim_hardware.ni import LoopbackWires, NiDeviceServer
from sim_hardware.ni.rpc import CallError
from sim_hardware.ni.transport.in_process import InProcessRpcError
from tests.cases import few
from tests.fuzz.told import small_and_soon

CASES = 60
CHANNELS = [InputChannel("force", "PCI6034E/ai0", 0.05), InputChannel("drive", "PCI6034E/ai2", 5.0)]
INTEGERS = (0, 1, -1, 7, -200088, 2**31 - 1, -(2**31))
LONG = (0, 1, -1, 10**6, 2**40, 2**62)
FLOATS = (0.0, 1.0, -1.0, float("nan"), float("inf"), 1e308, 1e-308)


def odd(message: Any, dice: random.Random) -> Any:
    """The message with some fields made odd."""
    made = type(message)()
    made.CopyFrom(message)
    for field in made.DESCRIPTOR.fields:
        if field.name == "status" and dice.random() < 0.7:
            continue  # else nothing but an error code would ever be looked at
        if dice.random() < 0.5:
            _spoil(made, field, dice)
    return made


def _spoil(message: Any, field: Any, dice: random.Random) -> None:
    kinds = {
        field.CPPTYPE_INT32: INTEGERS,
        field.CPPTYPE_UINT32: (0, 1, 7, 2**32 - 1),
        field.CPPTYPE_INT64: LONG,
        field.CPPTYPE_UINT64: (0, 1, 10**6, 2**40, 2**64 - 1),
        field.CPPTYPE_DOUBLE: FLOATS,
        field.CPPTYPE_BOOL: (True, False),
        field.CPPTYPE_STRING: ("", "x", "Dev1, , ,Dev2", "ü" * 10_000, "\0"),
        field.CPPTYPE_ENUM: (0, 1, 99),
    }
    values = kinds.get(field.cpp_type)
    if values is None:
        message.ClearField(field.name)
    elif hasattr(getattr(message, field.name), "extend"):
        del getattr(message, field.name)[:]
        getattr(message, field.name).extend([dice.choice(values)] * dice.choice((0, 1, 3, 1000)))
    else:
        setattr(message, field.name, dice.choice(values))


def use(channel: Any, clock: Any) -> None:
    """All that a run asks of the boards."""
    connection = NiConnection("in process", channel=channel)
    connection.open()
    connection.devices()
    output = NiVoltageOutput(connection, clock, "PCI6703/ao0", 0.25)
    output.open()
    signals = NiSignalInput(connection, clock, CHANNELS, 1000.0)
    signals.open()
    assert all(np.isfinite(volts) for volts in signals.ranges_V)
    assert np.isfinite(signals.rate_hz)
    signals.measure(0.01)
    signals.start()
    output.write(0.2)
    clock.sleep_until(clock.now() + 0.05)
    block = signals.read_available()
    assert block.volts.shape[0] == len(CHANNELS)
    output.write(0.0)
    signals.close()
    output.close()


Change = Callable[[str, Any], Any]  # of a call's name and its honest reply


def served(change: Change) -> tuple[Any, VirtualClock]:
    """A channel to sound boards whose answers are changed on the way."""
    clock = VirtualClock()
    channel = NiDeviceServer(LoopbackWires([("ao0", "ai2")]), clock).in_process_channel()
    honest = channel._answer  # type: ignore[attr-defined]

    def answer(path: str, request: Any, timeout: float | None) -> Any:
        return change(path.rsplit("/", 1)[-1], honest(path, request, timeout))

    channel._answer = answer  # type: ignore[attr-defined]
    return channel, clock


def refused(change: Change) -> bool:
    """Whether it was refused in words; anything but a DeviceError escapes."""
    channel, clock = served(change)
    said = ""
    with small_and_soon():
        try:
            use(channel, clock)
        except DeviceError as fault:
            said = str(fault)
    assert len(said) < 20_000
    return bool(said)


def test_an_honest_server_is_used() -> None:
    assert not refused(lambda _, reply: reply)


@pytest.mark.slow
def test_nonsense_is_refused_in_words_or_does_no_harm() -> None:
    count = 0
    for seed in range(CASES):
        dice = random.Random(seed)
        count += refused(lambda _, reply, d=dice: odd(reply, d) if d.random() < 0.15 else reply)
    assert count > CASES / 3


METHODS = (
    "CreateTask", "CreateAOVoltageChan", "CreateAIVoltageChan", "CfgSampClkTiming", "StartTask",
    "ReadAnalogF64", "GetReadAttributeUInt32", "GetTimingAttributeDouble", "GetTaskAttributeString",
    "GetTaskAttributeUInt32", "GetChanAttributeDouble", "GetSystemInfoAttributeString",
    "GetSystemInfoAttributeUInt32", "GetDeviceAttributeString", "WriteAnalogF64", "StopTask",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("method", few(METHODS, first=4))
def test_every_call_may_answer_nonsense(method: str) -> None:
    for seed in range(12):
        dice = random.Random(f"{method}{seed}")
        refused(lambda name, reply, d=dice: odd(reply, d) if name == method else reply)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("code", [grpc.StatusCode.INTERNAL, grpc.StatusCode.DATA_LOSS])
def test_every_call_may_fail(method: str, code: grpc.StatusCode) -> None:
    def change(name: str, reply: Any) -> Any:
        if name == method:
            raise InProcessRpcError(CallError(code, "nonsense"))
        return reply

    refused(change)


@pytest.mark.thorough
@pytest.mark.slow
def test_taking_over_from_such_a_server_never_raises() -> None:
    place = OutputPlace(
        address="in process",
        output_channel="PCI6703/ao0",
        drive_channel="PCI6034E/ai2",
        drive_terminals="rse",
    )
    for seed in range(CASES):
        dice = random.Random(seed)
        channel, clock = served(
            lambda _, reply, d=dice: odd(reply, d) if d.random() < 0.1 else reply
        )
        with small_and_soon():
            report = shut_down(NiConnection("in process", channel=channel), clock, place, 0.1)
        assert report.text
