"""What every batch task must keep to."""

from __future__ import annotations

import inspect
import pickle
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, get_args, get_origin, get_type_hints

from drivers.kinds import call_fault
from labrig.batch.contract import BatchInput, BatchItem, BatchTask, InputKind

_TYPES = (bool, int, float, str, Path)


def faults(task: object) -> list[str]:
    """Return what is wrong with a task, a phrase each; empty for a good one.

    It is a class: `faults(Verify)`. Never raises, but for what the task's own code raises.
    """
    if not (isinstance(task, type) and issubclass(task, BatchTask)):
        return ["it is no subclass of labrig.batch.contract.BatchTask"]
    if inspect.isabstract(task):
        return [f"it does not define {', '.join(sorted(task.__abstractmethods__))}"]
    found = list(_declared(task))
    return found or list(_behaves(task))


def value_type(annotation: Any) -> tuple[Any, bool]:
    """Return the plain type of an option's annotation, and whether it is repeatable."""
    if get_origin(annotation) is tuple:
        return get_args(annotation)[0], True
    if isinstance(annotation, UnionType):
        (annotation,) = (one for one in get_args(annotation) if one is not NoneType)
    return annotation, False


def _declared(task: type[BatchTask]) -> Iterator[str]:
    if not (vars(task).get("__doc__") or "").strip():
        yield "its class has no docstring, which is the command's help"
    if "__dataclass_fields__" not in vars(task):
        yield "it is no dataclass"
    if "<locals>" in task.__qualname__:
        yield "it is defined inside a function, so that no other process can import it"
    takes: frozenset[object] = getattr(task, "takes", frozenset())
    if not takes or not all(isinstance(kind, InputKind) for kind in takes):
        yield "`takes` names no kind of input"
    if isinstance(task.counted, str) or not all(isinstance(one, str) for one in task.counted):
        yield "`counted` must be a tuple of names of columns"
    hints = get_type_hints(task)
    for one in fields(task):
        if "description" not in one.metadata:
            yield f"its field {one.name} is not made by `option`"
        try:
            kind, _ = value_type(hints[one.name])
        except ValueError:
            kind = None
        if kind not in _TYPES:
            yield f"its field {one.name} is no {', '.join(each.__name__ for each in _TYPES)}"
        elif "description" in one.metadata and not _fits(one.default, kind):
            yield f"the default of its field {one.name} is {one.default!r}, no {kind.__name__}"


def _fits(default: object, kind: type) -> bool:
    """Whether a default, or each value of one, is of the option's type; None: there is none."""
    kinds = (int, float) if kind is float else (kind,)
    values = default if isinstance(default, tuple) else (default,)
    return all(value is None or isinstance(value, kinds) for value in values)


def _behaves(task: type[BatchTask]) -> Iterator[str]:
    try:
        made = task()
    except TypeError as error:
        yield f"it cannot be made without options ({error})"
        return
    if fault := call_fault("work", made.work, ("item", "folder")):
        yield fault
    if pickle.loads(pickle.dumps(made)) != made:  # noqa: S301 - what was just written
        yield "it changes on its way to another process"
    if not made.version():
        yield "it has no version"
    kind = min(task.takes)
    source = BatchInput(kind, Path("nowhere") / "x", "nowhere/x")
    items = _names(made, source)
    if len(set(items)) < len(items):
        yield "two of its items of one input have the same name"
    if items != _names(made, source):
        yield "its items differ from one call to the next"


def _names(task: BatchTask, source: BatchInput) -> list[str]:
    """Return the items' names; none where the input would have to be read for them."""
    try:
        found: list[BatchItem] = list(task.items(source))
    except Exception:  # noqa: BLE001 - there is no such file
        return []
    return [item.name for item in found]
