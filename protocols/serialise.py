"""Dataclasses as plain data (for JSON) and back, by the types that their fields declare.

Nothing is lost: numbers that JSON does not have are written as null (NaN) or as a text
("Infinity"), and a float field reads them back. Reading is strict: a value of another type is
refused, and so is a missing key of a field without a default. An unknown key is refused, too,
unless `lenient`: so an older program reads what a newer one has added to. A field declared with
the metadata `OMITTED_AS_DEFAULT` is written only where it differs from its default.

Known types: dataclasses, enumerations, Literal, tuples, lists, mappings, arrays of floats, unions,
float, int, bool, str, None and Any. A class with `to_dict` and `from_dict` writes and reads itself.
"""

from __future__ import annotations

import datetime as dt
import inspect
import math
import types
from collections.abc import Hashable, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from enum import Enum
from functools import cache
from reprlib import repr as short
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

Made = TypeVar("Made")
OMITTED_AS_DEFAULT: Mapping[str, Any] = {"omitted_as_default": True}
_INFINITIES = {"Infinity": math.inf, "-Infinity": -math.inf}


class SerialiseError(ValueError):
    """Plain data that are not what `to_plain` writes; the text names the key."""


def to_plain(value: Any) -> Any:
    """Return dicts, lists, texts, numbers, bools and None that hold the same."""
    if isinstance(value, Enum):
        return value.value
    if hasattr(value, "to_dict"):
        return to_plain(value.to_dict())
    if is_dataclass(value) and not isinstance(value, type):
        return {
            field.name: to_plain(getattr(value, field.name))
            for field in fields(value)
            if not _is_omitted(field, getattr(value, field.name))
        }
    if isinstance(value, Mapping):
        return {str(key): to_plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(item) for item in value]
    if hasattr(value, "tolist"):  # arrays and scalars of NumPy
        return to_plain(value.tolist())
    if isinstance(value, dt.date):
        return value.isoformat()
    return _plain_number(value) if isinstance(value, float) else value


def from_plain(kind: type[Made], plain: Any, where: str = "", *, lenient: bool = False) -> Made:
    """Return the object of a class that `to_plain` was given; `where` names it in errors.

    Raises SerialiseError, or what the class raises for values that it refuses.
    """
    made: Made = _Reader(lenient).read(kind, plain, where or kind.__name__)
    return made


def _is_omitted(field: Field[Any], value: Any) -> bool:
    return bool(field.metadata.get("omitted_as_default")) and bool(value == field.default)


def _plain_number(value: float) -> float | str | None:
    if math.isfinite(value):
        return value
    return None if math.isnan(value) else ("Infinity" if value > 0 else "-Infinity")


@cache
def _hints(kind: Hashable) -> dict[str, Any]:
    return get_type_hints(kind)


class _Reader:
    """Read plain data by declared types."""

    def __init__(self, lenient: bool) -> None:
        self._lenient = lenient

    def read(self, kind: Any, plain: Any, where: str) -> Any:
        """Return `plain` as a value of type `kind`."""
        origin = get_origin(kind)
        if kind is Any:
            return plain
        if origin in (Union, types.UnionType):
            return self._union(get_args(kind), plain, where)
        if origin is Literal:
            return _one_of(get_args(kind), plain, where)
        if origin is np.ndarray:
            return _array(plain, where)
        if origin is tuple or origin is list:
            return self._sequence(origin, get_args(kind), plain, where)
        if origin is not None:
            return self._mapping(origin, get_args(kind), plain, where)
        return self._plain_kind(kind, plain, where)

    def _plain_kind(self, kind: Any, plain: Any, where: str) -> Any:
        if hasattr(kind, "to_dict"):
            return _own_form(kind, plain, where)
        if is_dataclass(kind):
            return self._dataclass(kind, plain, where)
        if isinstance(kind, type) and issubclass(kind, Enum):
            return _enumerated(kind, plain, where)
        return _scalar(kind, plain, where)

    def _dataclass(self, kind: Any, plain: Any, where: str) -> Any:
        if not isinstance(plain, dict):
            raise SerialiseError(f"{where}: a table is wanted, not {short(plain)}")
        known = {field.name: field for field in fields(kind) if field.init}
        for name in plain:
            if name not in known and not self._lenient:
                raise SerialiseError(f"{where}: the key {name!r} is not known")
        for name, field in known.items():
            if name not in plain and not _has_default(field):
                raise SerialiseError(f"{where}: the key {name!r} is missing")
        hints = _hints(kind)
        return kind(
            **{
                name: self.read(hints[name], plain[name], f"{where}.{name}")
                for name in known
                if name in plain
            }
        )

    def _union(self, parts: tuple[Any, ...], plain: Any, where: str) -> Any:
        if plain is None and type(None) in parts:
            return None
        wanted = [part for part in parts if part is not type(None)]
        for part in wanted[:-1]:
            try:
                return self.read(part, plain, where)
            except SerialiseError:
                continue
        return self.read(wanted[-1], plain, where)

    def _sequence(self, origin: Any, parts: tuple[Any, ...], plain: Any, where: str) -> Any:
        if not isinstance(plain, list):
            raise SerialiseError(f"{where}: a list is wanted, not {short(plain)}")
        if origin is tuple and parts[-1] is not Ellipsis:
            if len(parts) != len(plain):
                raise SerialiseError(f"{where}: {len(parts)} values are wanted, not {len(plain)}")
            kinds = parts
        else:
            kinds = parts[:1] * len(plain)
        return origin(
            self.read(part, item, f"{where}[{i}]")
            for i, (part, item) in enumerate(zip(kinds, plain, strict=True))
        )

    def _mapping(self, origin: Any, parts: tuple[Any, ...], plain: Any, where: str) -> Any:
        if not issubclass(origin, Mapping):
            raise SerialiseError(f"{where}: a {origin.__name__} cannot be read from plain data")
        if not isinstance(plain, dict):
            raise SerialiseError(f"{where}: a table is wanted, not {short(plain)}")
        return {
            _key(parts[0], key, where): self.read(parts[1], item, f"{where}.{key}")
            for key, item in plain.items()
        }


def _has_default(field: Field[Any]) -> bool:
    return field.default is not MISSING or field.default_factory is not MISSING


def _own_form(kind: Any, plain: Any, where: str) -> Any:
    """Let a class read itself; some name the place in their errors."""
    several = len(inspect.signature(kind.from_dict).parameters) > 1
    return kind.from_dict(plain, where) if several else kind.from_dict(plain)


def _one_of(allowed: tuple[Any, ...], plain: Any, where: str) -> Any:
    if plain not in allowed:
        raise SerialiseError(f"{where}: {short(plain)} is none of {', '.join(map(str, allowed))}")
    return plain


def _enumerated(kind: type[Enum], plain: Any, where: str) -> Enum:
    try:
        return kind(plain)
    except ValueError:
        allowed = ", ".join(str(each.value) for each in kind)
        raise SerialiseError(f"{where}: {short(plain)} is none of {allowed}") from None


def _array(plain: Any, where: str) -> np.ndarray[Any, Any]:
    try:
        return np.array(_numbers(plain), dtype=np.float64)
    except (TypeError, ValueError):
        raise SerialiseError(f"{where}: numbers are wanted, not {short(plain)}") from None


def _numbers(plain: Any) -> Any:
    """Nested lists of floats. Raises TypeError for anything else in them."""
    if isinstance(plain, list):
        return [_numbers(item) for item in plain]
    return _number(plain)


def _number(plain: Any) -> float:
    if plain is None:
        return math.nan
    if isinstance(plain, str) and plain in _INFINITIES:
        return _INFINITIES[plain]
    if isinstance(plain, bool) or not isinstance(plain, int | float):
        raise TypeError
    return float(plain)


def _key(kind: Any, key: str, where: str) -> Any:
    """Return a mapping's key from its text: JSON has no other keys."""
    if kind in (int, float):
        try:
            return kind(key)
        except ValueError:
            raise SerialiseError(f"{where}: the key {key!r} is no {kind.__name__}") from None
    return key


def _scalar(kind: Any, plain: Any, where: str) -> Any:
    if kind is float:
        try:
            return _number(plain)
        except (TypeError, OverflowError):
            raise SerialiseError(f"{where}: a float is wanted, not {short(plain)}") from None
    if kind is type(None) and plain is None:
        return None
    if kind not in (int, bool, str):
        raise SerialiseError(f"{where}: {kind} cannot be read from plain data")
    if type(plain) is not kind:  # a bool is no int here
        raise SerialiseError(f"{where}: a {kind.__name__} is wanted, not {short(plain)}")
    return plain
