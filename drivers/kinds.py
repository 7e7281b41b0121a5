"""What the kinds of part of all folders have in common: a name, help, and settings."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator, Mapping, Sequence

from drivers.interfaces import is_reserved


def call_fault(name: str, function: object, arguments: Sequence[str]) -> str:
    """Return why a function cannot be called with these arguments by position; empty: it can."""
    if not callable(function):
        return f"its {name} cannot be called"
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # a function of C that does not say
        return ""
    try:
        signature.bind(*arguments)
    except TypeError as error:
        return f"its {name} cannot be called as {name}({', '.join(arguments)}): {error}"
    return ""


def kind_faults(
    part: object,
    contract: type,
    calls: Mapping[str, Sequence[str]],
    needed: tuple[str, ...] = (),
) -> Iterator[str]:
    """Yield what is wrong with a kind: a sentence for each fault.

    A kind is an object of the folder's dataclass, with `kind`, `help` and `settings`. `calls`: the
    arguments of its functions (each None where the contract has None as a default); `needed`:
    fields of its settings.
    """
    if not isinstance(part, contract):
        yield f"it is of type {type(part).__name__}, not a {contract.__name__}"
        return
    kind, text, settings = (getattr(part, name, None) for name in ("kind", "help", "settings"))
    if not (isinstance(kind, str) and kind.isidentifier()):
        yield f"its kind is {kind!r} where a name such as my_part is needed"
    if not (isinstance(text, str) and text and "\n" not in text):
        yield "its help is not one line of text"
    for name, arguments in calls.items():
        function = getattr(part, name)
        if function is None is getattr(contract, name, 0):
            continue
        if fault := call_fault(name, function, arguments):
            yield fault
    if not (isinstance(settings, type) and dataclasses.is_dataclass(settings)):
        yield "its settings are not a dataclass"
        return
    fields = {field.name: field for field in dataclasses.fields(settings)}
    missing = [name for name in needed if name not in fields]
    if missing:
        yield f"its settings have no field {', '.join(missing)}"
    for name, field in fields.items():
        if name == "kind" or is_reserved(name) or _is_method(settings, name):
            yield f"its setting {name} has a name that every table uses itself; choose another"
        elif name not in needed and not field.metadata.get("description"):
            yield f'its setting {name} has no metadata "description"'


def _is_method(settings: type, name: str) -> bool:
    """Whether a base of the settings has a method or property of this name."""
    return any(
        callable(found) or isinstance(found, property)
        for base in settings.__mro__[1:]
        if (found := vars(base).get(name)) is not None
    )
