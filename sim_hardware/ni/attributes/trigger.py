"""Attributes of a task's start trigger and reference trigger."""

from __future__ import annotations

from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.attributes.common import Attribute, Table, attribute_handlers
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.errors import Code, NotSimulatedError, StatusError
from sim_hardware.ni.signals.timing import FALLING, RISING
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import NO_SYNC, ReferenceTrigger, StartTrigger, Task

DIGITAL_EDGE, NONE = 10150, 10230  # constants.TriggerType
SYNC_TYPES = (NO_SYNC, 15888, 15889)  # constants.SyncType: NONE, MASTER, SLAVE
_START, _REFERENCE = "trigger", "reference"  # fields of a task
_DEFAULTS: dict[str, type[StartTrigger | ReferenceTrigger]] = {
    _START: StartTrigger,
    _REFERENCE: ReferenceTrigger,
}


def _of_trigger(
    which: str, kind: str, field: str, allowed: tuple[int, ...] = ()
) -> Attribute[Task]:
    """Make a setting of a digital edge trigger; it does not apply to a task without one."""

    def put(_: Engine, task: Task, value: Any) -> None:
        task.refuse_while_running()
        if allowed and value not in allowed:
            raise StatusError(Code.INVALID_VALUE, f"Property: {field}\nRequested: {value}")
        setattr(getattr(task, which), field, value)
        task.changed()

    def get(_: Engine, task: Task) -> Any:
        trigger = getattr(task, which)
        return getattr(trigger, field) if trigger.source else None

    return Attribute(
        kind, get, put, lambda engine, task: put(engine, task, getattr(_DEFAULTS[which](), field))
    )


def _type_of(which: str) -> Attribute[Task]:
    """Make the setting of a trigger's type."""

    def put(_: Engine, task: Task, value: int) -> None:
        task.refuse_while_running()
        if value not in (NONE, DIGITAL_EDGE):
            raise NotSimulatedError("only digital edges trigger a simulated task")
        if value == NONE:
            setattr(task, which, _DEFAULTS[which]())
        task.changed()

    return Attribute(
        "Int32",
        lambda _, task: DIGITAL_EDGE if getattr(task, which).source else NONE,
        put,
        lambda engine, task: put(engine, task, NONE),
    )


def _terminal(signal: str) -> Attribute[Task]:
    """Make the terminal on which a trigger of the task's own can be seen."""

    def get(_: Engine, task: Task) -> str | None:
        side = "ai" if task.inputs else "ao" if task.outputs else None
        return side and f"/{task.channels[0].device.engine_name}/{side}/{signal}"

    return Attribute("String", get)


def _set_sync(_: Engine, task: Task, value: int) -> None:
    task.refuse_while_running()
    if value not in SYNC_TYPES:
        raise StatusError(Code.INVALID_VALUE, f"Property: DAQmx_Trigger_SyncType\n{value}")
    task.sync_type = value


TRIGGER: Table[Task] = {
    pb.TRIGGER_ATTRIBUTE_START_TRIG_TYPE: _type_of(_START),
    pb.TRIGGER_ATTRIBUTE_DIG_EDGE_START_TRIG_SRC: _of_trigger(_START, "String", "source"),
    pb.TRIGGER_ATTRIBUTE_DIG_EDGE_START_TRIG_EDGE: _of_trigger(
        _START, "Int32", "edge", (RISING, FALLING)
    ),
    pb.TRIGGER_ATTRIBUTE_START_TRIG_RETRIGGERABLE: _of_trigger(_START, "Bool", "retriggerable"),
    pb.TRIGGER_ATTRIBUTE_START_TRIG_TERM: _terminal("StartTrigger"),
    pb.TRIGGER_ATTRIBUTE_REF_TRIG_TYPE: _type_of(_REFERENCE),
    pb.TRIGGER_ATTRIBUTE_DIG_EDGE_REF_TRIG_SRC: _of_trigger(_REFERENCE, "String", "source"),
    pb.TRIGGER_ATTRIBUTE_DIG_EDGE_REF_TRIG_EDGE: _of_trigger(
        _REFERENCE, "Int32", "edge", (RISING, FALLING)
    ),
    pb.TRIGGER_ATTRIBUTE_REF_TRIG_PRETRIG_SAMPLES: _of_trigger(
        _REFERENCE, "UInt32", "pretrigger_samples"
    ),
    pb.TRIGGER_ATTRIBUTE_REF_TRIG_TERM: _terminal("ReferenceTrigger"),
    pb.TRIGGER_ATTRIBUTE_TRIGGER_SYNC_TYPE: Attribute(
        "Int32",
        lambda _, task: task.sync_type,
        _set_sync,
        lambda engine, task: _set_sync(engine, task, NO_SYNC),
    ),
}
HANDLERS = attribute_handlers("Trig", TRIGGER, task_of)
