"""Dataclasses as plain JSON and back, by what their fields are declared as, without loss.

For findings that are kept in a file. Numbers that JSON does not have are null and come back as NaN;
what a newer version added is left out when an older one reads it.
"""

from __future__ import annotations

import types
from collections.abc import Hashable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from labrig.cli.screen import finite

Made = TypeVar("Made")


def to_plain(value: Any) -> Any:
    """Return plain lists, dictionaries, texts, numbers; `to_dict` of an object chooses its form."""
    if hasattr(value, "to_dict"):
        return finite(value.to_dict())
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: to_plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): to_plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(item) for item in value]
    return finite(value)


def from_plain(kind: type[Made], plain: Any) -> Made:
    """Return the object. ValueError, TypeError or KeyError for what `to_plain` never wrote."""
    made: Made = _made(kind, plain)
    return made


def _made(kind: Any, plain: Any) -> Any:
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        return (
            None if plain is None else _made(next(p for p in parts if p is not type(None)), plain)
        )
    if origin is Literal or kind is Any:
        return plain
    if kind is float:
        return float("nan") if plain is None else float(plain)
    if kind in (int, str, bool):
        return kind(plain)
    if origin is np.ndarray:
        return np.array(plain, dtype=float)
    if origin is tuple:
        inner = parts[:1] * len(plain) if parts[-1] is Ellipsis else parts
        return tuple(_made(p, item) for p, item in zip(inner, plain, strict=True))
    if origin is not None and issubclass(origin, Mapping):
        return {_made(parts[0], key): _made(parts[1], item) for key, item in plain.items()}
    return _object(kind, plain)


def _object(kind: type[Any], plain: Any) -> Any:
    if hasattr(kind, "to_dict"):
        several = kind.from_dict.__code__.co_argcount > 1  # some name the place in their errors
        return kind.from_dict(plain, kind.__name__) if several else kind.from_dict(plain)
    named = getattr(kind, "__dataclass_fields__", None)
    if named is None:
        raise TypeError(f"{kind} is not kept in files")
    hints, given = _hints(cast("Hashable", kind)), {}
    for field in named.values():
        if field.name in plain:
            given[field.name] = _made(hints[field.name], plain[field.name])
        elif field.default is MISSING and field.default_factory is MISSING:
            raise KeyError(field.name)
    return kind(**given)


@cache
def _hints(kind: Hashable) -> dict[str, Any]:
    return get_type_hints(kind)
