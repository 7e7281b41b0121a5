"""Attributes of a task's start trigger."""

from __future__ import annotations

from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.attributes.common import Attribute, Table, attribute_handlers
from sim_hardware.ni.calls.tasks import task_of
from sim_hardware.ni.errors import Code, NotSimulatedError, StatusError
from sim_hardware.ni.signals.timing import FALLING, RISING
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.tasks.task import StartTrigger, Task

DIGITAL_EDGE, NONE = 10150, 10230  # constants.TriggerType


def _of_trigger(kind: str, field: str, allowed: tuple[int, ...] = ()) -> Attribute[Task]:
    """Make a setting of a digital edge trigger; it does not apply to a task without one."""

    def put(_: Engine, task: Task, value: Any) -> None:
        task.refuse_while_running()
        if allowed and value not in allowed:
            raise StatusError(Code.INVALID_VALUE, f"Property: {field}\nRequested: {value}")
        setattr(task.trigger, field, value)
        task.changed()

    return Attribute(
        kind,
        lambda _, task: getattr(task.trigger, field) if task.trigger.source else None,
        put,
        lambda engine, task: put(engine, task, getattr(StartTrigger(), field)),
    )


def _set_type(_: Engine, task: Task, value: int) -> None:
    task.refuse_while_running()
    if value not in (NONE, DIGITAL_EDGE):
        raise NotSimulatedError("only digital edges start a simulated task")
    if value == NONE:
        task.trigger = StartTrigger()
    task.changed()


def _terminal(_: Engine, task: Task) -> str | None:
    """Return the terminal on which the task's own start can be seen."""
    side = "ai" if task.inputs else "ao" if task.outputs else None
    return side and f"/{task.channels[0].device.name}/{side}/StartTrigger"


TRIGGER: Table[Task] = {
    pb.TRIGGER_ATTRIBUTE_START_TRIG_TYPE: Attribute(
        "Int32",
        lambda _, task: DIGITAL_EDGE if task.trigger.source else NONE,
        _set_type,
        lambda engine, task: _set_type(engine, task, NONE),
    ),
    pb.TRIGGER_ATTRIBUTE_DIG_EDGE_START_TRIG_SRC: _of_trigger("String", "source"),
    pb.TRIGGER_ATTRIBUTE_DIG_EDGE_START_TRIG_EDGE: _of_trigger("Int32", "edge", (RISING, FALLING)),
    pb.TRIGGER_ATTRIBUTE_START_TRIG_TERM: Attribute("String", _terminal),
}
HANDLERS = attribute_handlers("Trig", TRIGGER, task_of)
