"""What every kind of protocol must keep to: the checks that a new one is put through."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields, is_dataclass, replace
from itertools import islice
from typing import Any, get_args, get_origin, get_type_hints

from drivers.interfaces import is_reserved
from protocols.errors import ScheduleError
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import LARGEST_VOLTAGE_V
from protocols.planning.builder import DECIMALS, StepsAndReadings
from protocols.planning.encoding import run_from_dict, run_to_dict
from protocols.planning.limits import structure_faults
from protocols.planning.schedule import PlannedRun, Purpose, ReadingKind

_TYPES = (float, int, bool, str)
_MAX_FAULTS = 5  # that are worth reporting at once
_BEYOND = {"gt": 0.0, "ge": -1.0, "lt": 0.0, "le": 1.0}  # added to a bound, is out of bounds


def faults(kind: object) -> list[str]:
    """Return what is wrong with a kind of protocol, a phrase each; empty for a good one.

    It is a class: `faults(PulseTrain)`. Never raises, but for what the kind's own code raises other
    than ScheduleError.
    """
    if not (isinstance(kind, type) and issubclass(kind, ProtocolKind)):
        return ["it is no subclass of protocols.kinds.contract.ProtocolKind"]
    found = list(declared_faults(kind, ProtocolKind, "steps_and_readings"))
    if found:
        return found
    try:
        protocol = kind()
        found = list(islice(_run_faults(protocol), _MAX_FAULTS))
    except ScheduleError as error:
        return [f"its defaults are refused: {error}"]
    return found or list(accepted_out_of_bounds(protocol))


def declared_faults(kind: type[Any], contract: type, method: str) -> Iterator[str]:
    """Yield what is wrong with how a class and its fields are declared, the first few faults.

    `method` is what its contract, the class that it derives from, leaves to it.
    """
    found = list(_class_faults(kind, method)) or _field_faults(kind, contract)
    yield from islice(found, _MAX_FAULTS)


def _class_faults(kind: type[Any], method: str) -> Iterator[str]:
    if inspect.isabstract(kind):
        yield f"{method} is not defined"
    parameters = getattr(kind, "__dataclass_params__", None)
    if "__dataclass_fields__" not in vars(kind) or not is_dataclass(kind):
        yield "it is no dataclass"
    elif parameters is None or not parameters.frozen:
        yield "its dataclass is not frozen"
    name: object = getattr(kind, "name", "")
    if not (isinstance(name, str) and re.fullmatch(r"[a-z][a-z0-9_]*", name)):
        yield "its `name` is not made of small letters, digits and _"
    if not inspect.cleandoc(kind.__doc__ or "") or (kind.__doc__ or "").startswith(
        f"{kind.__name__}("
    ):
        yield "it has no docstring"


def _field_faults(kind: type[Any], contract: type) -> Iterator[str]:
    hints = get_type_hints(kind)
    for field in fields(kind):
        if owner := _owner(field.name, contract):
            yield f"its field {field.name} has a name that {owner} uses itself; choose another"
            continue
        hint = hints[field.name]
        if hint not in _TYPES and hint != tuple[float, ...]:
            yield f"{field.name} is neither float, int, bool, str nor tuple[float, ...]"
        if field.default is MISSING:
            yield f"{field.name} has no default"
        if not field.metadata.get("description"):
            yield f"{field.name} has no description"
        yield from _missing_bounds(field, hint)


def _owner(name: str, contract: type) -> str:
    """Return who uses an attribute of this name itself; empty: a field may have it."""
    if name == "name" or hasattr(contract, name):
        return contract.__name__
    return "every table" if is_reserved(name) else ""


def _missing_bounds(field: Field[Any], hint: Any) -> Iterator[str]:
    stated = field.metadata
    if get_origin(hint) is tuple:
        if "max_length" not in stated:
            yield f"{field.name} has no max_length"
        hint, stated = get_args(hint)[0], stated.get("items", {})
    if hint in (float, int) and not (stated.keys() & {"gt", "ge"} and stated.keys() & {"lt", "le"}):
        yield f"{field.name} has no lower or no upper bound"


def planned(parts: StepsAndReadings, **more: Any) -> PlannedRun:
    """Return a measurement of these steps and readings at position 0."""
    steps, readings, duration_s = parts
    run = PlannedRun(
        index=0,
        configuration="long",
        position_m=0.0,
        purpose=Purpose.MEASUREMENT,
        mounting=0,
        approach="up",
        moisten=False,
        load_N=None,
        steps=steps,
        readings=readings,
        duration_s=duration_s,
    )
    return replace(run, **more)


def _run_faults(protocol: ProtocolKind) -> Iterator[str]:
    made: object = protocol.steps_and_readings()
    if not (isinstance(made, tuple) and len(made) == 3):
        yield (
            f"steps_and_readings returned {type(made).__name__}, not the steps, readings and "
            "duration that Builder.finish() returns"
        )
        return
    steps, readings, duration_s = made
    run = planned((steps, readings, duration_s))
    yield from structure_faults(run)
    if not any(reading.kind is ReadingKind.KEPT for reading in readings):
        yield "by default it keeps no reading"
    if not protocol.driven_V:
        yield "by default it applies no voltage"
        return
    largest_V = max(map(abs, protocol.driven_V))
    if largest_V > LARGEST_VOLTAGE_V:
        yield f"by default it drives {largest_V:g} V; at most {LARGEST_VOLTAGE_V:g} V are allowed"
        return
    if run_from_dict(json.loads(json.dumps(run_to_dict(run)))) != run:
        yield "its run is another one after it was written as JSON and read again"
    if protocol.steps_and_readings() != (steps, readings, duration_s):
        yield "its steps differ from one call to the next"
    wholes, halves = protocol.driven_V, protocol.scaled(0.5).driven_V
    if len(wholes) != len(halves) or any(
        abs(whole - 2 * half) > 3 * 10.0**-DECIMALS
        for whole, half in zip(wholes, halves, strict=False)
    ):
        yield 'scaled(0.5) does not halve its voltages; state the unit "V" of each of them'
    protocol.pulses().steps_and_readings()


def accepted_out_of_bounds(protocol: Any) -> Iterator[str]:
    """Yield what it accepts although its own bounds exclude it."""
    for field in fields(protocol):
        is_tuple = isinstance(getattr(protocol, field.name), tuple)
        bounds = field.metadata.get("items", {}) if is_tuple else field.metadata
        for key, beyond in _BEYOND.items():
            if key not in bounds:
                continue
            number = bounds[key] + type(bounds[key])(beyond)
            value = (number,) if is_tuple else number
            try:
                replace(protocol, **{field.name: value})
            except ScheduleError:
                continue
            yield f"it accepts {field.name} = {value}, which its bounds exclude"
