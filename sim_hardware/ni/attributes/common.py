"""Attributes: tables of what can be asked and set, turned into the calls that ask and set.

An attribute that is in no table is answered UNIMPLEMENTED, one that does not apply to the board or
task at hand with the driver's -200197.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.errors import Code, NotSimulatedError, StatusError
from sim_hardware.ni.rpc import Call, Message, raw_enum
from sim_hardware.ni.tasks.engine import Engine

Subject = TypeVar("Subject")
Handler = Callable[[Engine, Message, Call], Message]
Find = Callable[[Engine, Message, Call], Subject]


@dataclass(frozen=True)
class Attribute(Generic[Subject]):
    """One attribute of a subject (a device, a task, a channel ...).

    `get` returns None where the attribute does not apply.
    """

    kind: str  # as in the call's name: Double, Int32, String, ...
    get: Callable[[Engine, Subject], Any]
    set: Callable[[Engine, Subject, Any], None] | None = None
    reset: Callable[[Engine, Subject], None] | None = None


Table = Mapping[int, Attribute[Subject]]


def attribute_handlers(
    family: str, table: Table[Subject], find: Find[Subject]
) -> dict[str, Handler]:
    """Get, set and reset calls of a family, such as `GetDeviceAttributeString`."""
    calls: dict[str, Handler] = {}
    for kind in {attribute.kind for attribute in table.values()}:
        calls[f"Get{family}Attribute{kind}"] = _getter(family, kind, table, find)
        if any(attribute.set for attribute in table.values() if attribute.kind == kind):
            calls[f"Set{family}Attribute{kind}"] = _setter(family, kind, table, find)
    if any(attribute.reset for attribute in table.values()):
        calls[f"Reset{family}Attribute"] = _resetter(family, table, find)
    return calls


def _getter(family: str, kind: str, table: Table[Subject], find: Find[Subject]) -> Handler:
    response_type = getattr(pb, f"Get{family}Attribute{kind}Response")
    field = "value_raw" if "value_raw" in response_type.DESCRIPTOR.fields_by_name else "value"

    def get(engine: Engine, request: Message, call: Call) -> Message:
        number = raw_enum(request, "attribute")
        attribute = _look_up(family, kind, table, number)
        value = attribute.get(engine, find(engine, request, call))
        if value is None:
            raise StatusError(Code.NOT_SUPPORTED, f"Property: {family} {number:#x}")
        return response_type(**{field: value})

    return get


def _setter(family: str, kind: str, table: Table[Subject], find: Find[Subject]) -> Handler:
    response_type = getattr(pb, f"Set{family}Attribute{kind}Response")
    request_type = getattr(pb, f"Set{family}Attribute{kind}Request")
    is_enum = "value_raw" in request_type.DESCRIPTOR.fields_by_name

    def put(engine: Engine, request: Message, call: Call) -> Message:
        number = raw_enum(request, "attribute")
        attribute = _look_up(family, kind, table, number)
        if attribute.set is None:
            raise NotSimulatedError(f"setting the {family} attribute {number:#x} is not simulated")
        value = raw_enum(request, "value") if is_enum else request.value
        attribute.set(engine, find(engine, request, call), value)
        return response_type()

    return put


def _resetter(family: str, table: Table[Subject], find: Find[Subject]) -> Handler:
    response_type = getattr(pb, f"Reset{family}AttributeResponse")

    def reset(engine: Engine, request: Message, call: Call) -> Message:
        number = raw_enum(request, "attribute")
        attribute = table.get(number)
        if attribute is None or attribute.reset is None:
            raise NotSimulatedError(
                f"resetting the {family} attribute {number:#x} is not simulated"
            )
        attribute.reset(engine, find(engine, request, call))
        return response_type()

    return reset


def _look_up(family: str, kind: str, table: Table[Subject], number: int) -> Attribute[Subject]:
    attribute = table.get(number)
    if attribute is None or attribute.kind != kind:
        raise NotSimulatedError(f"the {family} attribute {number:#x} ({kind}) is not simulated")
    return attribute
